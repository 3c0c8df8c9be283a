"""What the commands of the tracker mean in the state the window is in."""

from stereotrack_core.body.pose import Pose
from stereotrack_core.parameters import value_text
from stereotrack_core.recording.description import Recording
from stereotrack_core.tracking.frame import TrackedFrame
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.run_spec import FirstPose
from stereotrack_core.tracking.tuning.stages import changed_names

from ..widgets.forms.message import Message
from .document import DocumentPresenter
from .edits import EditStack, WindowEdit
from .runs import RunEntry, RunList
from .tracking import Chosen, TrackPresenter
from .view_state import ViewState

FIRST_POSES: dict[str, tuple[str, str]] = {
    "tpose": ("T pose", "Start with the person facing north, both arms stretched out sideways."),
    "auto": ("Found automatically", "Start with whatever pose the person has in the first frame."),
    **{
        f"auto {degrees}": (
            f"Found automatically, facing {way}",
            f"Start with whatever pose the person has in the first frame, facing {way} "
            f"(the world's {axis}).",
        )
        for degrees, way, axis in (
            (0, "north", "y axis"),
            (90, "east", "x axis"),
            (180, "south", "negative y axis"),
            (270, "west", "negative x axis"),
        )
    },
}
"""Where a run's first pose may come from, as a title and a sentence."""


class TrackControl:
    """Run, step, iterate, from here, a selection; follows the tracker with the views."""

    def __init__(
        self,
        document: DocumentPresenter,
        runs: RunList,
        track: TrackPresenter,
        view_state: ViewState,
        edits: EditStack,
    ) -> None:
        self._edits = edits
        self._document, self._runs, self._track = document, runs, track
        self._despite_errors: Recording | None = None
        self._view_state = view_state
        self.first_pose: FirstPose = "auto"
        """Where the first pose comes from when no run has one: a key of :data:`FIRST_POSES`, or a
        pose."""
        self.follow = True

    def run(self) -> None:
        """Go on with a run that is paused, or begin one; settings that have changed apply."""
        self._go_on_or_begin(float("inf"))

    def step(self) -> None:
        self._go_on_or_begin(1)

    def run_from_here(self) -> None:
        self._begin(range(self._document.frame, self._document.frame_count), float("inf"))

    def run_selection(self) -> None:
        if self._view_state.selection:
            self._begin(self._view_state.selection, float("inf"))

    # ---- what the next run is tracked with: edits of the window

    def use(self, settings: Settings, words: str = "") -> None:
        track = self._track
        self.take(Chosen(track.preset, track.base, settings), words)

    def take(self, chosen: Chosen, words: str = "") -> None:
        """Use other settings, perhaps of another preset; `words` say what that is."""
        before = self._track.chosen
        if chosen == before:  # nothing is another, but it is asked for again
            self._track.take(chosen)
            return
        names = changed_names(before.settings, chosen.settings)
        alone = len(names) == 1 and not words
        self._edits.do(
            WindowEdit(
                words or _words(chosen, names), self._track.take, before, chosen,
                "tune", "parameters", slot=("parameter", *names) if alone else None,
            )
        )  # fmt: skip

    def toggle_run(self) -> None:
        active = self._runs.active
        if active is not None:
            self._runs.show(active, visible=not active.visible)

    def activate_next_run(self) -> None:
        entries, active = self._runs.entries, self._runs.active
        if active is not None:
            self._runs.activate(entries[(entries.index(active) + 1) % len(entries)])

    def _go_on_or_begin(self, allowed: float) -> None:
        self._document.pause()
        track = self._track
        if track.entry is None:
            self._begin(range(self._document.frame_count), allowed)
        elif track.stale:
            # settings belong to a run as a whole: what follows is another one
            wanted, done = track.entry.wanted, track.entry.frames
            pose = done[max(done)].pose if done else None
            self._begin(wanted[len(done) :] or range(wanted.stop), allowed, pose)
        else:
            track.go_on(allowed)

    def _begin(self, frames: range, allowed: float, pose: Pose | None = None) -> RunEntry | None:
        recording = self._document.recording
        if recording is None or not len(frames):
            return None
        if self._told_of(recording, frames, allowed, pose):
            return None
        start = pose if pose is not None else self._known_pose(frames.start)
        self._document.pause()
        init = start if start is not None else self.first_pose
        return self._track.begin(recording, frames, init, allowed=allowed)

    def _told_of(
        self, recording: Recording, frames: range, allowed: float, pose: Pose | None
    ) -> bool:
        """Say once why a recording should not be tracked; whether that was done now."""
        found = self._document.hindrances()
        if not found or self._despite_errors is recording:
            return False

        def nevertheless() -> None:
            self._despite_errors = recording
            if self._document.recording is recording:
                self._begin(frames, allowed, pose)

        first, button = found[0], "Track nevertheless"
        what = f"it would not be tracked correctly: {first.what}"
        self._track.tell(Message("error", what, first.where, first.remedy, button, nevertheless))
        return True

    def _known_pose(self, frame: int) -> Pose | None:
        """Pose of the active run just before a frame, or at it; the first frame starts anew."""
        active = self._runs.active
        if active is None or frame == 0:
            return None
        for known in (frame - 1, frame):
            tracked = active.at(known)
            if tracked is not None and tracked.pose is not None:
                return tracked.pose
        return None

    def on_tracked(self, tracked: TrackedFrame) -> None:
        """Show the newest frame where the views follow the tracker."""
        if self.follow:
            self._document.go_to(tracked.frame)


def _words(chosen: Chosen, names: tuple[str, ...]) -> str:
    """``set loss_scale to 0.03``, for these parameters that have another value then."""
    if len(names) == 1:
        return f"set {names[0]} to {value_text(chosen.settings.values()[names[0]])}"
    if chosen.settings == chosen.base:
        return "revert all parameters"
    return f"set {len(names)} parameters"

"""The film strip of a failure: blink runs and reference, correct a point by a click in a cell."""

from functools import partial

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QComboBox, QLabel, QWidget

from stereotrack_core.annotation.click import Click, ClickKey
from stereotrack_core.body.limbs import LIMB_ENDS
from stereotrack_core.evaluation.failure_segments.film import Film, FilmCell, film_frames
from stereotrack_core.evaluation.failure_segments.segment import FailureSegment, limbs_words
from stereotrack_core.project.clicks import place
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory
from stereotrack_core.recording.reader import FrameReader

from ...context import Context
from ...services.actions import Command, Menu
from ...session.changes import RECORDING, Part
from ...session.document import Shared
from ...session.jobs import LatestOnly
from ...session.runs import RunEntry
from ...session.session import Snapshot
from ...widgets.camera.film_view import FilmView
from ...widgets.style.building import choice, hbox, label, vbox

_RETRACK = "annotate-retrack"
_CLICKED_MS = 1500  # pause after the last click, until tracking starts again
_BUSY_MS = 500
_EMPTY = (
    "Select a failure to see its frames in every view. A click in a cell corrects a point, and the "
    "tracker starts again around it."
)


def _cells(
    recording: Recording,
    entries: tuple[RunEntry, ...],
    reference: LandmarkTrajectory | None,
    failure: FailureSegment,
    frames: tuple[int, ...],
    shared: Shared[FrameReader],
) -> tuple[FilmCell, ...]:
    """Draw a strip."""
    runs = tuple(run for entry in entries if (run := entry.run()) is not None)
    with shared.used() as reader:
        return Film(recording, runs, reference, tuple(failure.limbs), frames).cells(reader)


class FilmStrip:
    """Shows the chosen failure, and keeps showing its frames when the run is corrected there."""

    def __init__(self, context: Context) -> None:
        self._context, self._session = context, context.session
        self.view = FilmView(self._on_clicked)
        self.words, self._empty = label("", wraps=False), label(_EMPTY, "muted")
        self.landmark = choice("Click corrects", tip="The landmark that a click in a cell places")
        self.landmark.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToContents)
        self._failure: FailureSegment | None = None
        self._known: object = None
        self._layers: tuple[str, ...] = ()
        self._layer = 0
        panel, head = QWidget(), QWidget()
        head.setLayout(hbox((self.words, 1), QLabel("Click corrects"), self.landmark))
        self._empty.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self._parts = head, self.view
        panel.setLayout(vbox(head, (self.view, 1), (self._empty, 1), margins=(6, 4, 6, 4)))
        context.docks.add("strip", "Film strip", panel)
        self._drawing = LatestOnly(
            context.tasks, lambda draw: draw(), "draw a film strip",
            lambda _draw, cells: self.view.show_cells(cells),
        )  # fmt: skip
        context.tasks.watch(self._drawing.settled)
        self._soon = context.session.later(self._track_again, _CLICKED_MS)
        facts = Part.FAILURES | Part.ACTIVE_RUN | Part.RUNS | Part.TRUTH | Part.EDIT | Part.FRAME
        context.show(facts | RECORDING, self._show, "strip")
        context.session.changes.watch(Part.LEAVING, self._forget)

    # ---- showing

    def _show(self, now: Snapshot) -> None:
        chosen, reader = self._session.failures.chosen, self._session.document.reader
        if chosen is not None and not self._is_shown(chosen):
            self._failure = chosen
        failure, active, recording = self._failure, self._session.finished_run, now.recording
        there = failure is not None and active is not None
        self._empty.setVisible(not there)
        for part in self._parts:
            part.setVisible(there)
        if failure is None or active is None or recording is None or reader is None:
            return
        before = self._session.runs.before
        runs = (active, *([before] if before is not None and before.frames else []))
        frames = film_frames(failure, recording.fps, now.frame_count)
        reference = None if now.truth is None else now.truth.trajectory
        stands = [(one, len(one.frames), one.begun) for one in runs]
        if (failure.limbs, frames, stands, reference) != self._known:
            self._known = failure.limbs, frames, stands, reference
            self._offer_landmarks(failure)
            names = tuple(one.name for one in runs)
            self._layers = (*names, *([now.truth.words] if now.truth is not None else []))
            copies = tuple(one.now() for one in runs)
            known = recording, copies, reference, failure, frames, reader
            self._drawing.ask(partial(_cells, *known))
        self._show_layer()
        self.view.show_marks(now.frame, self._marks(frames))

    def _is_shown(self, failure: FailureSegment) -> bool:
        """Whether it is what is left of the failure that is shown, found in a corrected run."""
        old = self._failure
        return old is not None and old.found == failure.found and old.overlaps(failure)

    def _offer_landmarks(self, failure: FailureSegment) -> None:
        """The limbs' ends first, the outermost chosen; then all others."""
        limbs = reversed(failure.limbs)
        own = [one for limb in limbs for end in LIMB_ENDS[limb][::-1] for one in end]
        names, before = dict.fromkeys((*own, *LANDMARKS)), self.landmark.currentData()
        self.landmark.clear()
        for name in names:
            self.landmark.addItem(name.replace("_", " "), name)
        self.landmark.setCurrentIndex(
            max(self.landmark.findData(before if before in own else ""), 0)
        )

    def _marks(self, frames: tuple[int, ...]) -> dict[tuple[str, int], list[tuple[float, float]]]:
        """Clicks of the project by camera and frame."""
        project = self._session.project.project
        marks = dict[tuple[str, int], list[tuple[float, float]]]()
        for frame in () if project is None else frames:
            for click in () if project is None else project.clicks.at(frame):
                if click.position is not None:
                    marks.setdefault((click.camera, frame), []).append(click.position)
        return marks

    def _show_layer(self) -> None:
        layer = self._layer % max(len(self._layers), 1)
        self.view.show_layer(layer)
        if self._failure is not None and self._layers:
            keys = self._context.actions.shortcut("strip_blink")
            others = f" ({keys} blinks)" if len(self._layers) > 1 else ""
            self.words.setText(f"{limbs_words(self._failure.limbs)}: {self._layers[layer]}{others}")

    def _forget(self) -> None:
        self._soon.stop()
        self._drawing.close()
        self._failure, self._known, self._layers = None, None, ()
        self.view.show_cells(())

    # ---- what a person does

    def blink(self) -> None:
        """Show the next of the runs and the reference."""
        self._layer = (self._layer + 1) % max(len(self._layers), 1)
        self._show_layer()

    def why_not(self) -> str:
        return "" if self._layers else "Select a failure, and bring the film strip to the front."

    def _on_clicked(self, cell: FilmCell, pixel: tuple[float, float]) -> None:
        self._session.document.visit(cell.frame)
        if why_not := self._session.no_edit():
            self._context.notifier.say(why_not, 6000)
            return
        key = ClickKey(cell.frame, cell.camera, str(self.landmark.currentData()))
        self._session.project.apply(place(Click(*key, pixel)))
        said = f"{key.landmark.replace('_', ' ')} placed in frame {cell.frame}, view {cell.view}"
        self._context.notifier.say(f"{said}. The tracker starts again around it.", 6000)
        self._soon.start()

    def _track_again(self) -> None:
        self._context.actions.refresh()
        action = self._context.actions.action(_RETRACK)
        if action.isEnabled():
            action.trigger()
        elif self._session.tasks.tasks:  # such as the stretch before, which is still tracked
            self._soon.start(_BUSY_MS)
        else:
            self._context.notifier.say(action.statusTip(), 8000)


def strip_command(strip: FilmStrip) -> Command:
    """Command of the menu Review."""
    return Menu("&Review", strip.why_not).command(
        "strip_blink", "Blink film strip", "Show the next of the active run, the run before it and "
        "the reference in the film strip.", strip.blink, "\\", "compare",
    )  # fmt: skip

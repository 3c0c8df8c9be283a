"""Track: the tracker, its runs, and how they compare."""

from functools import partial

from ...context import Context
from ...services.actions import Command, Menu
from ...services.layout import Workspace
from ...session.judgement import Against
from ...session.session import Session, unless
from ...session.tracker import FIRST_POSES
from .controller import RunsController

_REFERENCES: dict[Against, tuple[str, str]] = {
    "recording": (
        "Recording's reference",
        "Measure errors against the reference that comes with the recording.",
    ),
    "project": (
        "Project's reference",
        "Measure errors against the trajectory fitted to the clicks, and state its accuracy.",
    ),
}


def register(context: Context) -> RunsController:
    """Offer the workspace Track, its panels and its commands."""
    runs = RunsController(context)
    space = Workspace(
        "track", "Track", "Run the tracker and watch it: views, 3-D scene, settings and runs.",
        "run-tracker",
        side=(("scene",), ("runs", "parameters", "numbers", "inside", "findings")),
        bottom=("plot", "timeline"), side_share=0.37, bottom_shares=(0.15, 0.17),
        side_heights=(2, 1), why_not=context.session.not_tracked,
    )  # fmt: skip
    context.docks.add_workspace(space)
    context.actions.add(_commands(context, runs))
    return runs


def _commands(context: Context, runs: RunsController) -> list[Command]:
    session = context.session
    track, tracker, keypoints = session.track, session.tracker, session.keypoints

    def idle() -> str:
        return session.not_tracked() or session.tracker_works()

    def begins_with(name: str) -> bool:
        return tracker.first_pose == name

    def toggle_follow() -> None:
        tracker.follow = not tracker.follow

    command = Menu("&Track").command
    first_poses = [
        Menu("&Track/Initial pose", session.no_depth).command(
            f"first_pose_{name.replace(' ', '_')}", title, tip,
            partial(setattr, tracker, "first_pose", name), checked=partial(begins_with, name),
        )
        for name, (title, tip) in FIRST_POSES.items()
    ]  # fmt: skip
    return [
        command("run", "Run", "Track the recording from the first frame, or resume a paused run.",
                tracker.run, "F8", "run-tracker", why_not=idle),
        command("pause", "Pause", "Pause the tracker after the current frame.", track.pause,
                "Shift+F8", "pause",
                why_not=lambda: unless(track.running, "The tracker is not running.")),
        command("step", "Track one frame", "Track one frame, then pause.", tracker.step, "F10",
                "step-tracker", why_not=idle),
        command("stop", "Stop run", "Stop the run in progress and keep the frames tracked so far.",
                track.stop, "Ctrl+.", "stop",
                why_not=lambda: unless(track.entry, "No run is in progress.")),
        command("run_here", "Run from current frame", "Start a new run at this frame, from the "
                "pose of the active run if it has one here.", tracker.run_from_here, "Ctrl+F8",
                "next", why_not=idle, section=True),
        command("run_selection", "Run on selection", "Track the selected frames as a new run.",
                tracker.run_selection, "Ctrl+Shift+F8", "selection",
                why_not=lambda: idle() or unless(context.view_state.selection, "No frames are "
                "selected. Select some in the timeline with Shift+drag.")),
        *first_poses,
        command("use_keypoints", "Use keypoints", "Track the next run with the keypoints that a "
                "detector has predicted, beside the point cloud or, in mono views, in its place.",
                keypoints.toggle, why_not=lambda: session.no_project() or keypoints.why_none(),
                checked=lambda: keypoints.wanted),
        command("follow", "Follow tracker", "Show each frame as soon as it is tracked.",
                toggle_follow, "F", checked=lambda: tracker.follow),
        command("hide_run", "Show active run", "Show or hide the model and the curves of the "
                "active run.", tracker.toggle_run, "H", "model", why_not=session.no_run,
                section=True),
        command("next_run", "Next run", "Make the next run the active one.",
                tracker.activate_next_run, "T", "compare", why_not=lambda: session.no_run()
                or unless(len(session.runs.entries) > 1, "There is only one run.")),
        command("keep_run", "Store run in project", "Store a run that was opened from a file in "
                "the project. Runs tracked here are stored automatically.",
                partial(runs.with_active, runs.keeper.keep), icon="save",
                why_not=lambda: session.no_run() or session.no_edit() or runs.why_not_keep()),
        command("remove_run", "Remove run", "Remove the active run from the list and from the "
                "project; Restore run brings it back. Files are not deleted.",
                partial(runs.with_active, runs.keeper.remove), "Ctrl+Del", "delete",
                why_not=lambda: session.no_run() or unless(
                    session.runs.active is not track.entry,
                    "This run is in progress. Stop it first.")),
        command("restore_run", "Restore run", "Bring back the run that was removed last from the "
                "project.", runs.keeper.restore, icon="undo",
                why_not=lambda: session.no_edit() or unless(
                    runs.keeper.removed, "No run was removed from the project.")),
        *_against(session, runs),
    ]  # fmt: skip


def _against(session: Session, runs: RunsController) -> list[Command]:
    def why_not(against: Against) -> str:
        if session.no_recording() or session.judging.has(against):
            return session.no_recording()
        if against == "recording":
            return "This recording has no reference."
        return "The whole recording has not been fitted yet. Choose Fit whole recording first."

    def measured(against: Against) -> bool:
        return session.judging.truth is not None and session.judging.truth.against == against

    command = Menu("&Track/Errors against").command
    return [
        command(f"errors_against_{against}", text, tip, partial(runs.judge_against, against),
                icon="reference", why_not=partial(why_not, against),
                checked=partial(measured, against))
        for against, (text, tip) in _REFERENCES.items()
    ]  # fmt: skip

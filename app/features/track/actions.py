"""Commands that run the tracker."""

from __future__ import annotations

from functools import partial

from ...context import Context
from ...services.actions import Command
from ...session.session import Session
from ...session.tracker import FIRST_POSES
from ...session.truth import Against
from .controller import RunsController

_MENU = "&Track"


def commands(context: Context, runs: RunsController) -> list[Command]:
    """Commands of the menu Track."""
    session = context.session
    track, tracker = session.track, session.tracker

    def idle() -> str:
        return session.no_depth() or session.tracker_works()

    def no_selection() -> str:
        return (
            ""
            if context.view_state.selection
            else "Select frames in the timeline first (Shift+drag)."
        )

    def in_progress() -> str:
        active = session.runs.active is track.entry
        return "This run is in progress; end it first." if active else ""

    return [
        Command(
            "run", _MENU, "Run", "Track the recording from its first frame, or go on with a run "
            "that is paused.", tracker.run, "F8", "run-tracker", idle,
        ),
        Command(
            "pause", _MENU, "Pause", "Hold the tracker after the frame in work.", track.pause,
            "Shift+F8", "pause",
            lambda: "" if track.running else "The tracker is not running.",
        ),
        Command(
            "step", _MENU, "Step one frame", "Track one frame and hold.", tracker.step,
            "F10", "step-tracker", idle,
        ),
        Command(
            "stop", _MENU, "End the run", "End the run in progress; it keeps what it has.",
            track.stop, "Ctrl+.", "stop",
            lambda: "" if track.entry is not None else "No run is in progress.",
        ),
        Command(
            "run_here", _MENU, "Run from here", "Begin a new run at this frame, from the active "
            "run's pose where it has one.", tracker.run_from_here, "Ctrl+F8", "next",
            idle, section=True,
        ),
        Command(
            "run_selection", _MENU, "Run the selection", "Track the selected frames as a new run.",
            tracker.run_selection, "Ctrl+Shift+F8", "selection",
            lambda: idle() or no_selection(),
        ),
        *(
            Command(
                f"first_pose_{name}", f"{_MENU}/First pose", title, tip,
                partial(tracker.choose_first_pose, name), why_not=session.no_depth,
                checked=partial(tracker.begins_with, name),
            )
            for name, (title, tip) in FIRST_POSES.items()
        ),
        Command(
            "follow", _MENU, "Follow the tracker", "Show each frame as it is tracked.",
            tracker.toggle_follow, "F", checked=lambda: tracker.follow,
        ),
        Command(
            "hide_run", _MENU, "Show or hide the active run",
            "Switch the active run's model and curves on or off.", tracker.toggle_run,
            "H", "model", session.no_run, section=True,
        ),
        Command(
            "next_run", _MENU, "Next run", "Make the next run the active one.",
            tracker.activate_next_run, "T", "compare",
            lambda: session.no_run()
            or ("" if len(session.runs.entries) > 1 else "There is only one run."),
        ),
        Command(
            "repeat_run", _MENU, "Repeat this run", "Track it again with everything that it says "
            "about itself, and say whether it comes out equal.", runs.repeat_active,
            "Alt+F8", "redo",
            lambda: session.no_run() or session.tracker_works() or runs.why_not_repeat(),
        ),
        Command(
            "run_details", _MENU, "Details of the run …", "All that the active run was made with, "
            "beside another run.", runs.show_details, "Alt+Return", "settings",
            session.no_run,
        ),
        Command(
            "keep_run", _MENU, "Keep the run in the project", "Put a run that was opened from a "
            "file into the project; runs that are tracked here are kept by themselves.",
            runs.keep_active, icon="save",
            why_not=lambda: session.no_run() or session.no_edit() or runs.why_not_keep(),
        ),
        Command(
            "remove_run", _MENU, "Remove the active run",
            "Take the active run from the list; one that the project keeps is deleted there, "
            "which can be undone. Files stay.", runs.remove_active, "Ctrl+Del",
            "delete", lambda: session.no_run() or in_progress(),
        ),
        *_against(session, runs),
    ]  # fmt: skip


def _against(session: Session, runs: RunsController) -> list[Command]:
    """What errors of runs are measured against."""

    def why_not(against: Against) -> str:
        if session.no_recording() or session.judging.has(against):
            return session.no_recording()
        if against == "recording":
            return "This recording has no reference of its own."
        return "Fit the whole recording first."

    def measured(against: Against) -> bool:
        return session.judging.truth is not None and session.judging.truth.against == against

    rows: tuple[tuple[Against, str, str], ...] = (
        ("recording", "The recording's reference", "Measure errors of runs against the reference "
         "that came with the recording."),
        ("project", "The project's reference", "Measure errors of runs against the trajectory "
         "fitted to the clicks, and state how good that is."),
    )  # fmt: skip
    return [
        Command(
            f"errors_against_{against}", f"{_MENU}/Errors against", text, tip,
            partial(runs.judge_against, against), icon="reference",
            why_not=partial(why_not, against), checked=partial(measured, against),
        )
        for against, text, tip in rows
    ]  # fmt: skip

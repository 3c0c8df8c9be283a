"""Commands that run the tracker."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from ...services.actions import Command
from ...session.track_control import FIRST_POSES
from ...session.truth import Against
from ...shell.reasons import no_depth, no_edit, no_recording, no_run, running
from ..inspect import inside_menu

if TYPE_CHECKING:
    from ...shell.main_window import MainWindow

_MENU = "&Track"


def commands(w: MainWindow) -> list[Command]:
    """Commands of the menu Track."""

    def idle() -> str:
        return no_depth(w) or running(w)

    def no_selection() -> str:
        return "" if w.timeline.selection else "Select frames in the timeline first (Shift+drag)."

    return [
        Command(
            "run", _MENU, "Run", "Track the recording from its first frame, or go on with a run "
            "that is paused.", w.tracker.run, "F8", "run-tracker", idle,
        ),
        Command(
            "pause", _MENU, "Pause", "Hold the tracker after the frame in work.", w.track.pause,
            "Shift+F8", "pause",
            lambda: "" if w.track.running else "The tracker is not running.",
        ),
        Command(
            "step", _MENU, "Step one frame", "Track one frame and hold.", w.tracker.step,
            "F10", "step-tracker", idle,
        ),
        Command(
            "iterate", _MENU, "Step inside the next frame",
            "Show step by step what the tracker in progress does in its next frame; after the "
            "last step, track it.", w.tracker.iterate, "F11", "iterate", idle,
        ),
        Command(
            "stop", _MENU, "End the run", "End the run in progress; it keeps what it has.",
            w.track.stop, "Ctrl+.", "stop",
            lambda: "" if w.track.entry is not None else "No run is in progress.",
        ),
        Command(
            "run_here", _MENU, "Run from here", "Begin a new run at this frame, from the active "
            "run's pose where it has one.", w.tracker.run_from_here, "Ctrl+F8", "next",
            idle, section=True,
        ),
        Command(
            "run_selection", _MENU, "Run the selection", "Track the selected frames as a new run.",
            w.tracker.run_selection, "Ctrl+Shift+F8", "selection",
            lambda: idle() or no_selection(),
        ),
        *(
            Command(
                f"first_pose_{name}", f"{_MENU}/First pose", title, tip,
                partial(w.tracker.choose_first_pose, name), why_not=lambda: no_depth(w),
                checked=partial(w.tracker.begins_with, name),
            )
            for name, (title, tip) in FIRST_POSES.items()
        ),
        Command(
            "follow", _MENU, "Follow the tracker", "Show each frame as it is tracked.",
            w.tracker.toggle_follow, "F", checked=lambda: w.tracker.follow,
        ),
        Command(
            "hide_run", _MENU, "Show or hide the active run",
            "Switch the active run's model and curves on or off.", w.tracker.toggle_run,
            "H", "model", lambda: no_run(w), section=True,
        ),
        Command(
            "next_run", _MENU, "Next run", "Make the next run the active one.",
            w.tracker.activate_next_run, "T", "compare",
            lambda: no_run(w) or ("" if len(w.runs.entries) > 1 else "There is only one run."),
        ),
        Command(
            "repeat_run", _MENU, "Repeat this run", "Track it again with everything that it says "
            "about itself, and say whether it comes out equal.", w.run_work.repeat_active,
            "Alt+F8", "redo",
            lambda: no_run(w) or running(w) or w.run_work.why_not_repeat(),
        ),
        Command(
            "run_details", _MENU, "Details of the run …", "All that the active run was made with, "
            "beside another run.", w.run_work.show_details, "Alt+Return", "settings",
            lambda: no_run(w),
        ),
        Command(
            "keep_run", _MENU, "Keep the run in the project", "Put a run that was opened from a "
            "file into the project; runs that are tracked here are kept by themselves.",
            w.run_work.keep_active, icon="save",
            why_not=lambda: no_run(w) or no_edit(w) or w.run_work.why_not_keep(),
        ),
        Command(
            "remove_run", _MENU, "Remove the active run",
            "Take the active run from the list; one that the project keeps is deleted there, "
            "which can be undone. Files stay.", w.run_work.remove_active, "Ctrl+Del",
            "delete", lambda: no_run(w) or (
                "This run is in progress; end it first." if w.runs.active is w.track.entry else ""
            ),
        ),
        *inside_menu.commands(w),
        *_against(w),
    ]  # fmt: skip


def _against(w: MainWindow) -> list[Command]:
    """What errors of runs are measured against."""

    def why_not(against: Against) -> str:
        if no_recording(w) or w.judging.has(against):
            return no_recording(w)
        if against == "recording":
            return "This recording has no reference of its own."
        return "Fit the whole recording first."

    def measured(against: Against) -> bool:
        return w.judging.truth is not None and w.judging.truth.against == against

    rows: tuple[tuple[Against, str, str], ...] = (
        ("recording", "The recording's reference", "Measure errors of runs against the reference "
         "that came with the recording."),
        ("project", "The project's reference", "Measure errors of runs against the trajectory "
         "fitted to the clicks, and state how good that is."),
    )  # fmt: skip
    return [
        Command(
            f"errors_against_{against}", f"{_MENU}/Errors against", text, tip,
            partial(w.annotation_work.judge_against, against), icon="reference",
            why_not=partial(why_not, against), checked=partial(measured, against),
        )
        for against, text, tip in rows
    ]  # fmt: skip

"""Commands of annotation besides clicking itself: the selection, the fit, trust, setup, files."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from PySide6.QtWidgets import QInputDialog

from stereotrack_core.project.edit import Edit
from stereotrack_core.project.project import Project

from ...services.actions import ActionRegistry, Command
from ...session.counting import frames_in_words
from .clicking.blind_repeats import USUAL_SHARE
from .dialogs import AnnotationDialogs
from .filling.predicting import PredictionWork, prediction_commands
from .panels import AnnotationPanels
from .selection import (
    Selection,
    clear_clicks,
    flag_frames,
    keyframes_done,
    keyframes_every,
    mark_gap,
    no_keyframes,
    unflag_frames,
    unmark_gap,
)

_MENU = "&Annotate"
_SELECTION = f"{_MENU}/&Selection"
_TRUST = f"{_MENU}/&Quality check"
_FILE = "&File"

_IN_THE_MENU = (
    *("annotate-interpolate", "", "annotate-follow"),
    *("annotate-fill-fit", "annotate-fill-run", "annotate-fill-neighbours", ""),
    *("annotate-accept", "annotate-accept-fit", "annotate-accept-run"),
    *("annotate-accept-neighbours", ""),
    *("annotate-clear", "annotate-gap", "annotate-no-gap", ""),
    *("annotate-flag", "annotate-unflag", ""),
    *("annotate-keyframes", "annotate-done", "annotate-not-done", "annotate-no-keyframes", ""),
    "annotate-export-selection",
)
"""Commands that the timeline offers for its selection; empty ones separate."""


def add_commands(
    actions: ActionRegistry,
    panels: AnnotationPanels,
    dialogs: AnnotationDialogs,
    predicting: PredictionWork,
) -> None:
    """Add all commands , and those of the selection to the timeline's menu."""
    actions.add(commands(panels, dialogs, predicting))
    panels.changed.connect(actions.refresh)
    panels.bar.set_selection_actions(
        [actions.action(name) if name else None for name in _IN_THE_MENU]
    )


def commands(
    panels: AnnotationPanels, dialogs: AnnotationDialogs, predicting: PredictionWork
) -> list[Command]:
    """All of them, in the order of their menus."""
    return [
        *_going(panels),
        *_fitting(panels),
        *_selection(panels, predicting),
        *_keyframes(panels),
        *_trust(panels, dialogs),
        *_setup(panels, dialogs),
        *_files(panels, dialogs),
    ]


def _no_project(p: AnnotationPanels) -> str:
    return "" if p.project is not None else "No project is open. Open or create one first."


def _no_edit(p: AnnotationPanels) -> str:
    if p.project is not None and p.project.read_only:
        return "The project is open read-only."
    return _no_project(p)


def _going(p: AnnotationPanels) -> list[Command]:
    def nothing_next() -> str:
        if why := _no_project(p):
            return why
        return (
            ""
            if p.next_panel.model.rowCount()
            else "The whole recording has not been fitted yet. Choose Fit whole recording first."
        )

    return [
        Command(
            "annotate-next", _MENU, "Go to best suggested click",
            "Go to the frame, view and landmark where a click is expected to reduce the "
            "uncertainty most.", p.next_panel.go_to_next, "J",
            "next", nothing_next, section=True,
        ),
        Command(
            "annotate-next-flagged", _MENU, "Next flagged frame",
            "Go to the next frame with a flag.", p.go_to_flagged, "Ctrl+J", "next-episode",
            lambda: _no_project(p),
        ),
        Command(
            "annotate-previous-flagged", _MENU, "Previous flagged frame",
            "Go to the previous frame with a flag.", lambda: p.go_to_flagged(backwards=True),
            "Ctrl+Shift+J", "previous-episode", lambda: _no_project(p),
        ),
    ]  # fmt: skip


def _fitting(p: AnnotationPanels) -> list[Command]:
    def not_fitting() -> str:
        return "" if p.reference.fitting else "No fit is running."

    return [
        Command(
            "annotate-fit", _MENU, "Fit whole recording",
            "Fit the body model to all clicks, interpolate the frames between them, and store the "
            "result as the project's reference.",
            lambda: p.reference.fit(), icon="fit", why_not=p.reference.why_not, section=True,
        ),
        Command(
            "annotate-fit-stop", _MENU, "Stop fit", "Stop the running fit and keep the "
            "present reference.", p.reference.cancel, icon="stop", why_not=not_fitting,
        ),
    ]  # fmt: skip


def _selection(p: AnnotationPanels, predicting: PredictionWork) -> list[Command]:
    def command(
        name: str, text: str, tip: str, make: Callable[[Project, Selection], Edit], icon: str = ""
    ) -> Command:
        def run() -> None:
            project = p.project
            if project is not None:
                chosen = p.selection()
                p.do(lambda: make(project, chosen), frames=len(chosen.frames))

        return Command(
            f"annotate-{name}", _SELECTION, text, tip, run, icon=icon, why_not=lambda: _no_edit(p)
        )

    return [
        Command(
            "annotate-interpolate", _SELECTION, "Interpolate",
            "Fill the selected frames by keyframe interpolation of the joint angles. Gaps are "
            "never interpolated.",
            lambda: p.reference.fit(p.selection().frames), icon="fit", why_not=p.reference.why_not,
        ),
        *prediction_commands(predicting, _SELECTION),
        command("clear", "Clear clicks", "Delete the clicks of the selected landmarks in the "
        "selected frames. You can undo this.", clear_clicks, "delete"),
        command("gap", "Mark as gap", "Exclude the selected frames from interpolation.",
                lambda _project, chosen: mark_gap(chosen)),
        command("no-gap", "Clear gap", "Allow interpolation in the selected frames again.",
                unmark_gap),
        command("flag", "Flag for review", "Flag the selected landmarks and frames so that you "
        "can come back to them.",
                lambda _project, chosen: flag_frames(chosen), "warning"),
        command("unflag", "Clear flags", "Remove the flags from the selected landmarks and "
        "frames.",
                unflag_frames),
    ]  # fmt: skip


def _keyframes(p: AnnotationPanels) -> list[Command]:
    def ask_step() -> None:
        chosen = p.selection()
        where = frames_in_words(chosen.frames)
        if not p.timeline.selection and p.frame_count:
            chosen, where = Selection(range(p.frame_count)), "the whole recording"
        dialog = QInputDialog(p.window)
        dialog.setWindowTitle("Keyframes")
        dialog.setLabelText(f"Frames between keyframes in {where}:")
        dialog.setInputMode(QInputDialog.InputMode.IntInput)
        dialog.setIntRange(1, 100_000)
        dialog.setIntValue(10)
        dialog.intValueSelected.connect(lambda step: p.do(lambda: keyframes_every(chosen, step)))
        dialog.open()

    def edit(make: Callable[[Project, Selection], Edit]) -> None:
        project = p.project
        if project is not None:
            chosen = p.selection()
            p.do(lambda: make(project, chosen), frames=len(chosen.frames))

    return [
        Command(
            "annotate-keyframes", _SELECTION, "Set keyframes …",
            "Choose at regular steps which of the selected frames, or of all frames, are to be "
            "annotated.", ask_step, why_not=lambda: _no_edit(p),
            section=True,
        ),
        Command(
            "annotate-done", _SELECTION, "Mark keyframes as done",
            "Mark the selected keyframes, or the current one, as done.",
            partial(edit, keyframes_done), "K",
            "accept", lambda: _no_edit(p),
        ),
        Command(
            "annotate-not-done", _SELECTION, "Mark keyframes as not done",
            "Mark the selected keyframes as incomplete.",
            partial(edit, partial(keyframes_done, done=False)), why_not=lambda: _no_edit(p),
        ),
        Command(
            "annotate-no-keyframes", _SELECTION, "Clear keyframes",
            "Remove the keyframes in the selected frames. Clicks are kept.",
            partial(edit, no_keyframes),
            why_not=lambda: _no_edit(p),
        ),
    ]  # fmt: skip


def _trust(p: AnnotationPanels, dialogs: AnnotationDialogs) -> list[Command]:
    def weaving() -> bool:
        return p.repeats is not None and p.repeats.share > 0

    def weave() -> None:
        if p.repeats is not None:
            p.repeats.switch(0.0 if weaving() else USUAL_SHARE)

    def no_repeat() -> str:
        active = p.repeats is not None and p.repeats.active is not None
        return "" if active else "No blind repeat is in progress."

    return [
        Command(
            "annotate-repeats", _TRUST, "Schedule blind repeats",
            "Ask for 5 percent of the finished keyframes again, with their clicks hidden, to "
            "measure how precise the clicks are.",
            weave, why_not=lambda: _no_edit(p), checked=weaving,
        ),
        Command(
            "annotate-repeat-now", _TRUST, "Repeat this frame blind",
            "Hide the clicks of this frame and annotate it a second time.",
            lambda: p.begin_repeat(p.frame), why_not=lambda: _no_edit(p),
        ),
        Command(
            "annotate-repeat-finish", _TRUST, "Finish blind repeat",
            "Show all clicks of the frame again. Both passes are kept.",
            p.finish_repeat, "Ctrl+Return", "accept", no_repeat,
        ),
        Command(
            "annotate-agreement", _TRUST, "Agreement …", "Show how far the first and second "
            "passes, or two annotators' projects, agree.", dialogs.show_agreement, icon="compare",
            why_not=lambda: _no_project(p), section=True,
        ),
        Command(
            "annotate-merge", _TRUST, "Merge with project …",
            "Compare another annotator's clicks with yours and choose which to use.",
            dialogs.ask_to_merge,
            why_not=lambda: _no_edit(p),
        ),
    ]  # fmt: skip


def _setup(p: AnnotationPanels, dialogs: AnnotationDialogs) -> list[Command]:
    return [
        Command(
            "annotate-subject", _MENU, "Subject …", "Edit the subject's segment lengths, or "
            "measure them from clicks.",
            dialogs.show_subjects, icon="ruler", why_not=lambda: _no_project(p),
            section=True,
        ),
        Command(
            "annotate-landmarks", _MENU, "Landmarks …", "Edit the set of landmarks: names, "
            "colours, limbs, positions on the body.", dialogs.show_landmarks, icon="clicks",
            why_not=lambda: _no_project(p),
        ),
    ]  # fmt: skip


def _files(p: AnnotationPanels, dialogs: AnnotationDialogs) -> list[Command]:
    def no_reference() -> str:
        return (
            ""
            if p.reference.now is not None
            else "The whole recording has not been fitted yet. Choose Fit whole recording first."
        )

    return [
        Command(
            "annotate-import", _FILE, "Import clicks …", "Import clicks, labels of other tools or "
            "a reference. New and conflicting clicks are shown before anything is written.",
            dialogs.ask_to_import, icon="open", why_not=lambda: _no_edit(p), section=True,
        ),
        Command(
            "annotate-export", _FILE, "Export clicks …", "Write the project's clicks to a file.",
            lambda: dialogs.export(None), icon="export", why_not=lambda: _no_project(p),
        ),
        Command(
            "annotate-export-reference", _FILE, "Export the reference …",
            "Write the trajectory fitted to the clicks, in the format of a recording or with its "
            "uncertainty.",
            dialogs.ask_to_export_reference, icon="export", why_not=no_reference,
        ),
        Command(
            "annotate-export-selection", _SELECTION, "Export selected clicks …",
            "Write the selected clicks to a file.",
            lambda: dialogs.export(p.selection()), icon="export",
            why_not=lambda: _no_project(p), section=True,
        ),
    ]  # fmt: skip

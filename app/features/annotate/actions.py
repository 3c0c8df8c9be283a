"""Commands of annotation besides clicking itself: the selection, the fit, trust, setup, files."""

from collections.abc import Callable
from functools import partial

from stereotrack_core.counting import frames_in_words
from stereotrack_core.project.edit import Edit
from stereotrack_core.project.marks import GAP, SetKeyframes
from stereotrack_core.project.project import Project
from stereotrack_core.project.selection import (
    Selection,
    clear_clicks,
    clear_flags,
    set_flags,
    set_keyframes,
)

from ...services.actions import ActionRegistry, Command, Menu
from ...session.session import unless
from ...widgets.forms.form_dialog import ask_for_number
from ...widgets.forms.numbers import WholeNumberField
from .dialogs import AnnotationDialogs
from .filling.predicting import NO_FIT, PredictionWork, prediction_commands
from .panels import AnnotationPanels

_MENU = "&Annotate"
_SELECTION = f"{_MENU}/&Selection"

_IN_THE_MENU = (
    *("annotate-interpolate", "", "annotate-propose"),
    *("annotate-fill-fit", "annotate-fill-run", "annotate-fill-detector"),
    *("annotate-detect", ""),
    *("annotate-accept", "annotate-accept-fit", "annotate-accept-run"),
    *("annotate-accept-detector", ""),
    *("annotate-clear", "annotate-gap", "annotate-no-gap", ""),
    *("annotate-flag", "annotate-unflag", ""),
    *("annotate-keyframes", "annotate-done", "annotate-not-done", "annotate-no-keyframes"),
)
"""Commands that the timeline offers for its selection; empty ones separate."""


def add_commands(
    actions: ActionRegistry,
    panels: AnnotationPanels,
    dialogs: AnnotationDialogs,
    predicting: PredictionWork,
) -> None:
    """Add all commands, in the order of their menus, and those of the selection to the timeline."""
    actions.add(_going(panels))
    actions.add(_selection(panels, predicting))
    actions.add(_trust(panels, dialogs))
    actions.add(_setup_and_files(panels, dialogs))
    for name in _IN_THE_MENU:
        if name:
            panels.bar.selection_menu.addAction(actions.action(name))
        else:
            panels.bar.selection_menu.addSeparator()


def _going(p: AnnotationPanels) -> list[Command]:
    command = Menu(_MENU, p.no_project).command
    return [
        command("annotate-next", "Go to best suggested click", "Go to the frame, view and "
                "landmark where a click is expected to reduce the uncertainty most. The recording "
                "is fitted first where that is missing.", p.next_panel.go_to_next, "J", "next",
                section=True),
        command("annotate-next-flagged", "Next flagged frame", "Go to the next frame with a flag.",
                p.go_to_flagged, "Ctrl+J", "next-failure"),
        command("annotate-previous-flagged", "Previous flagged frame", "Go to the previous frame "
                "with a flag.", partial(p.go_to_flagged, backwards=True), "Ctrl+Shift+J",
                "previous-failure"),
        command("annotate-fit", "Fit whole recording", "Fit the body model to all clicks, "
                "interpolate the frames between them, and store the result as the project's "
                "reference.", p.reference.fit, icon="fit", why_not=p.reference.why_not,
                section=True),
    ]  # fmt: skip


def _selection(p: AnnotationPanels, predicting: PredictionWork) -> list[Command]:
    def edit(make: Callable[[Project, Selection], Edit]) -> Callable[[], None]:
        return lambda: p.edit_selection(make)

    def keyframes(state: str) -> Callable[[], None]:
        return edit(lambda project, chosen: set_keyframes(project, chosen, state))

    command = Menu(_SELECTION, p.no_edit).command
    return [
        command("annotate-interpolate", "Interpolate", "Fill the selected frames by keyframe "
                "interpolation of the joint angles. Gaps are never interpolated.",
                lambda: p.reference.fit(p.selection().frames), icon="fit",
                why_not=p.reference.why_not),
        *prediction_commands(predicting, _SELECTION),
        command("annotate-clear", "Clear clicks", "Delete the clicks of the selected landmarks in "
                "the selected frames. You can undo this.", edit(clear_clicks), icon="delete"),
        command("annotate-gap", "Mark as gap", "Exclude the selected frames from interpolation.",
                edit(partial(set_flags, kind=GAP))),
        command("annotate-no-gap", "Clear gap", "Allow interpolation in the selected frames "
                "again.", edit(partial(clear_flags, kind=GAP))),
        command("annotate-flag", "Flag for review", "Flag the selected landmarks and frames so "
                "that you can come back to them.", edit(set_flags), icon="warning"),
        command("annotate-unflag", "Clear flags", "Remove the flags from the selected landmarks "
                "and frames.", edit(clear_flags)),
        command("annotate-keyframes", "Set keyframes …", "Choose at regular steps which of the "
                "selected frames, or of all frames, are to be annotated.",
                partial(_ask_for_keyframes, p), section=True),
        command("annotate-done", "Mark keyframes as done", "Mark the selected keyframes, or the "
                "current one, as done.", keyframes("done"), "K", "accept"),
        command("annotate-not-done", "Mark keyframes as not done", "Mark the selected keyframes "
                "as incomplete.", keyframes("wanted")),
        command("annotate-no-keyframes", "Clear keyframes", "Remove the keyframes in the selected "
                "frames. Clicks are kept.", keyframes("none")),
    ]  # fmt: skip


def _ask_for_keyframes(p: AnnotationPanels) -> None:
    chosen = p.selection()
    where = frames_in_words(chosen.frames)
    if not p.timeline.selection and p.frame_count:
        chosen, where = Selection(range(p.frame_count)), "the whole recording"

    def take(step: int) -> None:
        p.edit_selection(lambda _project, all_: SetKeyframes(tuple(all_.frames[::step])), chosen)

    field = WholeNumberField(minimum=1, maximum=100_000, value=10)
    ask_for_number(p.window, "Keyframes", f"Frames between keyframes in {where}:", field, take)


def _trust(p: AnnotationPanels, dialogs: AnnotationDialogs) -> list[Command]:
    command = Menu(f"{_MENU}/&Quality check", p.no_edit).command
    return [
        command("annotate-repeat-now", "Repeat this frame blind", "Hide the clicks of this frame "
                "and annotate it again, to measure how precise the clicks are.",
                lambda: p.begin_repeat(p.frame)),
        command("annotate-repeat-finish", "Finish blind repeat", "Show all clicks of the frame "
                "again. Both passes are kept.", p.finish_repeat, "Ctrl+Return", "accept",
                why_not=lambda: unless(p.repeats is not None and p.repeats.active is not None,
                                       "No blind repeat is in progress.")),
        command("annotate-agreement", "Agreement …", "Show how far the first and second passes, "
                "or two annotators' projects, agree.", dialogs.show_agreement, icon="compare",
                why_not=p.no_project, section=True),
        command("annotate-merge", "Merge with project …", "Compare another annotator's clicks "
                "with yours and choose which to use.", dialogs.ask_to_merge),
    ]  # fmt: skip


def _setup_and_files(p: AnnotationPanels, dialogs: AnnotationDialogs) -> list[Command]:
    setup, file = Menu(_MENU, p.no_project).command, Menu("&File", p.no_project).command
    return [
        setup("annotate-subject", "Subject …", "Edit the subject's segment lengths, or measure "
              "them from clicks.", dialogs.show_subjects, icon="ruler", section=True),
        file("annotate-import", "Import clicks …", "Import clicks, labels of other tools or a "
             "reference. New and conflicting clicks are shown before anything is written.",
             dialogs.ask_to_import, icon="open", why_not=p.no_edit, section=True),
        file("annotate-export", "Export clicks …", "Write the project's clicks as a table, or as "
             "labels of COCO, SLEAP, DeepLabCut, DLTdv, Argus or XMALab.",
             partial(dialogs.ask_to_export, "clicks"), icon="export"),
        file("annotate-export-reference", "Export the reference …", "Write the trajectory fitted "
             "to the clicks: with its uncertainty, or in the format of another program.",
             partial(dialogs.ask_to_export, "reference"), icon="export",
             why_not=lambda: unless(p.reference.now, NO_FIT)),
        file("annotate-import-predictions", "Import predictions …", "Import the keypoints of a "
             "2-D detector. What is taken and what is left out is shown before anything is "
             "written.", dialogs.ask_to_import_predictions, icon="prediction", why_not=p.no_edit),
        file("annotate-export-predictions", "Export predictions …", "Write the keypoints of all "
             "detectors as a table or as COCO results.",
             partial(dialogs.ask_to_export, "keypoints"), icon="export",
             why_not=dialogs.why_no_predictions),
        file("annotate-remove-predictions", "Remove predictions …", "Remove the keypoints and "
             "proposals of a detector. You can undo this.", dialogs.ask_to_remove_predictions,
             icon="delete", why_not=dialogs.why_no_predictions),
    ]  # fmt: skip

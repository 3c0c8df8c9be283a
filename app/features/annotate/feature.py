"""Annotate: landmarks by clicks, the body fitted to them, and all commands of both."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import chain

from stereotrack_core.annotation.click import UNCERTAIN, Visibility
from stereotrack_core.counting import frames_in_words
from stereotrack_core.project.edit import Edit
from stereotrack_core.project.marks import GAP, mark_keyframes
from stereotrack_core.project.project import Project
from stereotrack_core.project.selection import (
    Selection,
    clear_clicks,
    clear_flags,
    set_flags,
    set_keyframes,
)

from ...context import Context
from ...services.actions import ActionRegistry, Command, Menu
from ...services.docks import Workspace
from ...session.session import Session, unless
from ...widgets.forms.form_dialog import ask_for_number
from ...widgets.forms.numbers import WholeNumberField
from .cameras import CAMERA_COMMANDS, camera_commands
from .clicking.choosing import ADVANCES, Advance
from .clicking.controller import ClickController
from .dialogs import AnnotationDialogs
from .filling.predicting import NO_FIT, PredictionWork, prediction_commands
from .filling.retracking import (
    ClickedFrames,
    Personalising,
    Retracking,
    personal_command,
    retrack_command,
)
from .panels import AnnotationPanels
from .scenarios import scenario_commands

_MENU = "&Annotate"
_KEYS = 9
_STEPS = {
    "fine": (0.1, 1.0, "Ctrl+Alt+"), "": (0.5, 8.0, "Alt+"), "coarse": (1.0, 40.0, "Alt+Shift+"),
}  # fmt: skip
"""Pixels that a click moves by, pixels of the screen that the crosshair does, and keys."""

_WAYS = {"left": (-1, 0), "right": (1, 0), "up": (0, -1), "down": (0, 1)}


def commands(session: Session, annotate: ClickController) -> list[Command]:
    """Commands of the menu Annotate."""
    kinds = (_choosing, _placing, _marking, _nudging)
    return [*chain(*(make(annotate) for make in kinds)), *_switches(session, annotate)]


def _no_click(annotate: ClickController) -> str:
    chosen = annotate.annotating.choice.landmark.replace("_", " ")
    none = f"The {chosen} has no click in this view. Click it first."
    return annotate.why_no_annotating() or unless(annotate.annotating.at_hand(), none)


def _choosing(annotate: ClickController) -> list[Command]:
    annotating = annotate.annotating

    def names() -> tuple[str, ...]:
        return annotating.landmark_set.names

    def says(place: int) -> str:
        known = place < len(names())
        return names()[place].replace("_", " ").capitalize() if known else f"Landmark {place + 1}"

    def why_not(place: int) -> str:
        few = f"There are only {len(names())} landmarks."
        return annotate.why_no_annotating() or unless(place < len(names()), few)

    def is_chosen(place: int) -> bool:
        return place < len(names()) and names()[place] == annotating.choice.landmark

    command = Menu(f"{_MENU}/Landmark", annotate.why_no_annotating).command
    by_key = [
        command(
            f"landmark_{place + 1}", f"Landmark {place + 1}", f"Select landmark {place + 1} for "
            "the next click.", partial(annotating.choose_place, place), str(place + 1),
            why_not=partial(why_not, place), checked=partial(is_chosen, place),
            says=partial(says, place),
        )
        for place in range(_KEYS)
    ]  # fmt: skip
    return [
        *by_key,
        command("next_landmark", "Next landmark", "Select the next landmark.",
                partial(annotating.choose_next, 1), "PgDown", section=True),
        command("previous_landmark", "Previous landmark", "Select the previous landmark.",
                partial(annotating.choose_next, -1), "PgUp"),
    ]  # fmt: skip


def _placing(annotate: ClickController) -> list[Command]:
    annotating = annotate.annotating

    def nothing_sure(everywhere: bool) -> str:
        where = "this frame" if everywhere else "this view"
        none = f"Nothing is predicted in {where}. Click landmarks in another frame first."
        no_view = annotate.why_no_annotating() or ("" if everywhere else annotate.why_no_camera())
        return no_view or unless(annotate.predicted(everywhere=everywhere), none)

    command = Menu(_MENU, annotate.why_no_annotating).command
    return [
        command("accept_frame", "Accept what is sure in this frame", "Turn all predictions of this "
                "frame that are certain enough into clicks, as one edit, and show the doubtful "
                "ones, one after the other. Drag what is wrong first.",
                partial(annotate.accept, everywhere=True), "Q", "accept",
                why_not=partial(nothing_sure, True)),
        command("accept_view", "Accept what is sure in this view", "Turn all predictions in the "
                "view under the cursor that are certain enough into clicks, as one edit.",
                partial(annotate.accept, everywhere=False), "Shift+Q", "accept",
                why_not=partial(nothing_sure, False)),
        command("confirm", "Confirm and go on", "Accept the doubtful prediction that is shown, or "
                "place the landmark at the crosshair, and go to the next one. Alt+arrows move the "
                "crosshair. Where neither is shown, show it.", annotate.walk.confirm, "Return"),
        command("wanted_accuracy", "Wanted accuracy …", "Set the error of a frame's landmarks, in "
                "millimetres, up to which clicks are asked for.",
                annotate.ask_wanted),
        command("accept_limit", "Limit for accepting …", "Set up to which standard deviation "
                "predictions are accepted. What is less certain is drawn fainter, "
                "with a dashed circle, and stays open.", annotate.ask_accepted_sigma),
        command("delete_click", "Clear click", "Delete the last click, or the click of the "
                "selected landmark in this view.", annotating.delete, "Del", "delete",
                why_not=partial(_no_click, annotate), section=True),
        command("delete_everywhere", "Clear clicks in all views", "Delete the clicks of the "
                "landmark in all views of this frame.", annotating.delete_everywhere, "Shift+Del",
                "delete"),
    ]  # fmt: skip


def _marking(annotate: ClickController) -> list[Command]:
    annotating = annotate.annotating

    def seen_as(visibility: Visibility) -> bool:
        click = annotating.at_hand()
        return click is not None and click.visibility == visibility

    def doubted() -> bool:
        click = annotating.at_hand()
        return click is not None and click.flag == UNCERTAIN

    command = Menu(f"{_MENU}/Mark as", partial(_no_click, annotate)).command
    return [
        command("mark_seen", "Seen", "The landmark is visible.",
                partial(annotating.mark, Visibility.SEEN), "I",
                checked=partial(seen_as, Visibility.SEEN)),
        command("mark_guessed", "Guessed", "The landmark is occluded and its position is "
                "estimated. Shift+click places a click this way.",
                partial(annotating.mark, Visibility.GUESSED), "B",
                checked=partial(seen_as, Visibility.GUESSED)),
        command("mark_outside", "Outside the image", "The selected click, or the next one to be "
                "placed, lies outside this image.", partial(annotating.mark, Visibility.OUTSIDE),
                "X", why_not=lambda: annotate.why_no_annotating() or annotate.why_no_camera(),
                checked=partial(seen_as, Visibility.OUTSIDE)),
        command("mark_uncertain", "Uncertain", "You are not certain of this click. It gets less "
                "weight in fits.", annotating.toggle_doubt, "U", "warning", checked=doubted,
                section=True),
        command("mark_sigma", "Set click uncertainty …", "Set the standard deviation of this "
                "click's position, in pixels.", annotate.ask_sigma, "Shift+U", "ruler"),
    ]  # fmt: skip


def _nudging(annotate: ClickController) -> list[Command]:
    annotating = annotate.annotating

    def not_held() -> str:
        none = "No click is in hand. Click on one, or press E; Return shows a crosshair."
        there = annotating.held() or annotate.walk.aimed() is not None
        return annotate.why_no_annotating() or unless(there, none)

    command = Menu(f"{_MENU}/Nudge", not_held).command
    nudges = [
        command(
            f"nudge_{way}{'_' if name else ''}{name}", f"Move by {step:g} px {way}",
            f"Move the last click, or the selected one, by {step:g} px {way}; where the crosshair "
            f"is shown, move that by {far:g} px of the screen.",
            partial(annotate.nudge, by, step, far), f"{modifier}{way.capitalize()}",
            section=way == "left", goes_first=True,
        )
        for name, (step, far, modifier) in _STEPS.items()
        for way, by in _WAYS.items()
    ]  # fmt: skip
    return [
        command("pick_click", "Select click", "Select the last click, or the one of the selected "
                "landmark, to move it with Alt+arrows.", annotate.pick_last, "E", "clicks",
                why_not=partial(_no_click, annotate)),
        command("let_go", "Deselect click", "Have no click in hand, hide the crosshair, and end "
                "going through doubtful predictions.", annotate.let_go, "Esc", goes_first=True),
        *nudges,
    ]  # fmt: skip


def _switches(session: Session, annotate: ClickController) -> list[Command]:
    after = Menu(f"{_MENU}/After a click", session.no_recording).command

    def advances(name: Advance) -> bool:
        return annotate.annotating.advance == name

    def no_depth() -> str:
        none = "No view of this recording provides depth."
        return annotate.why_no_annotating() or unless(session.clouds.available, none)

    return [
        *(after(f"advance_{name}", text, tip, partial(annotate.choose_advance, name),
                checked=partial(advances, name))
          for name, (text, tip) in ADVANCES.items()),
        after("advance_frame", "Go to the next frame", "When every landmark has a click in all "
              "visible views, show the next keyframe that is not done, or the next frame where no "
              "keyframes are set.", annotate.toggle_going_on,
              checked=lambda: annotate.annotating.goes_on, section=True),
        Menu(_MENU, annotate.why_no_annotating).command(
            "detect_landmarks", "Detect landmarks automatically", "Let the installed pose detector "
            "look at the frame that is shown, and at the next ones once you click. What it sees is "
            "predicted before the first click; nothing is stored.", annotate.detections.toggle,
            why_not=lambda: annotate.why_no_annotating() or annotate.detections.why_not(),
            checked=lambda: annotate.detections.on, section=True,
        ),
        Menu(_MENU, no_depth).command(
            "fit_depth", "Fit to clicks and depth", "Fit the body to the measured points as well "
            "as to the clicks, where the recording has depth.", annotate.toggle_depth, "Shift+D",
            "fit", checked=lambda: annotate.facts.use_depth,
        ),
    ]  # fmt: skip


_SELECTION = f"{_MENU}/&Selection"


def add_commands(
    actions: ActionRegistry,
    panels: AnnotationPanels,
    dialogs: AnnotationDialogs,
    predicting: PredictionWork,
) -> None:
    """Add all commands, in the order of their menus, and those of the selection to the timeline."""
    actions.add(_going(panels))
    actions.add(_selection(panels, predicting))
    actions.add(camera_commands(panels))
    actions.add(_trust(panels, dialogs))
    actions.add(_setup_and_files(panels, dialogs))
    for command in actions.commands:
        if command.menu == _SELECTION:
            if command.section:
                panels.bar.selection_menu.addSeparator()
            panels.bar.selection_menu.addAction(actions.action(command.id))


def _going(p: AnnotationPanels) -> list[Command]:
    command = Menu(_MENU, p.no_project).command
    return [
        command("annotate-next", "Go to best suggested click", "Go to the frame, view and "
                "landmark where a click is expected to reduce the uncertainty most. The clicked "
                "frames are fitted first if needed.", p.next_panel.go_to_next, "J", "next",
                section=True),
        command("annotate-next-flagged", "Next flagged frame", "Go to the next frame with a flag.",
                p.go_to_flagged, "Ctrl+J", "next-failure"),
        command("annotate-previous-flagged", "Previous flagged frame", "Go to the previous frame "
                "with a flag.", partial(p.go_to_flagged, backwards=True), "Ctrl+Shift+J",
                "previous-failure"),
        command("annotate-fit", "Fit whole recording", "Fit the body model to all clicks, "
                "interpolate the frames between them, and store the result as the project's "
                "reference.", p.reference.fit, icon="fit", why_not=p.reference.why_not,
                section=True, says=lambda: f"Fit whole recording ({p.reference.how_long()})"),
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
                "the selected frames. You can undo this.", edit(clear_clicks), icon="delete",
                section=True),
        command("annotate-gap", "Mark as gap", "Exclude the selected frames from interpolation.",
                edit(partial(set_flags, kind=GAP))),
        command("annotate-no-gap", "Clear gap", "Allow interpolation in the selected frames "
                "again.", edit(partial(clear_flags, kind=GAP))),
        command("annotate-flag", "Flag for review", "Flag the selected landmarks and frames so "
                "that you can come back to them.", edit(set_flags), icon="warning",
                section=True),
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
        *scenario_commands(p, _SELECTION),
    ]  # fmt: skip


def _ask_for_keyframes(p: AnnotationPanels) -> None:
    chosen = p.selection()
    where = frames_in_words(chosen.frames)
    if not p.timeline.selection and p.frame_count:
        chosen, where = Selection(range(p.frame_count)), "the whole recording"

    def take(step: int) -> None:
        p.edit_selection(lambda _project, all_: mark_keyframes(tuple(all_.frames[::step])), chosen)

    field = WholeNumberField(minimum=1, maximum=100_000, value=10)
    ask_for_number(p.window, "Keyframes", f"Frames between keyframes in {where}:", field, take)


def _trust(p: AnnotationPanels, dialogs: AnnotationDialogs) -> list[Command]:
    command = Menu(f"{_MENU}/&Quality check", p.no_edit).command
    return [
        command("annotate-check", "Check clicks in the images", "Follow every click to the clicked "
                "frames before and after it, and list those that lie somewhere else. Sides that "
                "were exchanged and landmarks that were skipped are always listed.", p.check,
                icon="warning", why_not=lambda: p.no_project() or p.next.why_not_check()),
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
             "labels of COCO, SLEAP or DeepLabCut.",
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
             "predictions of a detector. You can undo this.", dialogs.ask_to_remove_predictions,
             icon="delete", why_not=dialogs.why_no_predictions),
    ]  # fmt: skip


@dataclass(frozen=True)
class Annotate:
    """Parts of the feature."""

    clicking: ClickController
    panels: AnnotationPanels
    predicting: PredictionWork
    dialogs: AnnotationDialogs
    retracking: Retracking


def register(context: Context) -> Annotate:
    """Offer the workspace Annotate, its panels and its commands."""
    clicking = ClickController(context)
    panels = AnnotationPanels(context, clicking)
    predicting = PredictionWork(panels)
    dialogs = AnnotationDialogs(panels)
    context.docks.add("next", "Suggested clicks", panels.next_panel)
    context.docks.timeline_column.insertWidget(0, panels.bar)
    context.docks.below_views.addWidget(panels.repeat_bar)
    context.tasks.watch(panels.settled)
    clicked = ClickedFrames(context.session)
    personalising = Personalising(context, clicked, lambda: panels.reference.settings)
    retracking = Retracking(context, clicked, clicking.body)
    space = Workspace(
        "annotate", "Annotate",
        "Click landmarks in all views. The body is fitted to the clicks as you go.", "clicks",
        side=(("landmarks",), ("body", "next", "scene")), bottom=("timeline",),
        side_share=0.26, bottom_shares=(0.24,), side_heights=(10, 14), tall_side=True,
        why_not=context.session.no_recording,
    )  # fmt: skip
    context.docks.add_workspace(space)
    context.actions.add(commands(context.session, clicking))
    add_commands(context.actions, panels, dialogs, predicting)
    context.actions.add([retrack_command(retracking), personal_command(personalising)])
    clicking.body.cameras.add([context.actions.action(name) for name in CAMERA_COMMANDS])
    names = "annotate-detect", "annotate-personalise", "annotate-retrack"
    clicking.body.add_action_buttons([context.actions.action(name) for name in names])
    return Annotate(clicking, panels, predicting, dialogs, retracking)

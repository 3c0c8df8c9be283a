"""Commands about landmarks and clicks."""

from __future__ import annotations

from functools import partial

from stereotrack_core.annotation.click import UNCERTAIN, Visibility

from ....services.actions import Command
from .choosing import ADVANCES
from .controller import ClickController

_MENU = "&Annotate"
_KEYS = 9
_STEPS = {
    "fine": (0.1, "0.1 px", "Ctrl+"), "": (0.5, "0.5 px", ""), "coarse": (1.0, "1 px", "Shift+"),
}  # fmt: skip
_WAYS = {"left": (-1, 0), "right": (1, 0), "up": (0, -1), "down": (0, 1)}


def commands(annotate: ClickController) -> list[Command]:
    """Commands of the menu Annotate."""
    return [
        *_choosing(annotate),
        *_placing(annotate),
        *_marking(annotate),
        *_nudging(annotate),
        *_switches(annotate),
    ]


def no_click(annotate: ClickController) -> str:
    """There is no click that keys could act on."""
    reason = annotate.why_no_annotating()
    if reason:
        return reason
    chosen = annotate.annotating.choice.landmark.replace("_", " ")
    there = annotate.annotating.at_hand() is not None
    return "" if there else f"The {chosen} has no click in this view. Click it first."


def _choosing(annotate: ClickController) -> list[Command]:
    annotating = annotate.annotating

    def names() -> tuple[str, ...]:
        return annotating.landmark_set.names

    def choose(place: int) -> None:
        annotating.choose(names()[place])

    def says(place: int) -> str:
        known = place < len(names())
        return names()[place].replace("_", " ").capitalize() if known else f"Landmark {place + 1}"

    def why_not(place: int) -> str:
        few = f"There are only {len(names())} landmarks."
        return annotate.why_no_annotating() or ("" if place < len(names()) else few)

    def is_chosen(place: int) -> bool:
        return place < len(names()) and names()[place] == annotating.choice.landmark

    by_key = [
        Command(
            f"landmark_{place + 1}", f"{_MENU}/Landmark", f"Landmark {place + 1}",
            f"Select landmark {place + 1} for the next click.", partial(choose, place),
            str(place + 1), why_not=partial(why_not, place), checked=partial(is_chosen, place),
            says=partial(says, place),
        )
        for place in range(_KEYS)
    ]  # fmt: skip
    return [
        *by_key,
        Command(
            "next_landmark", f"{_MENU}/Landmark", "Next landmark", "Select the next landmark.",
            partial(annotating.choose_next, 1), "PgDown", why_not=annotate.why_no_annotating,
            section=True,
        ),
        Command(
            "previous_landmark", f"{_MENU}/Landmark", "Previous landmark",
            "Select the previous landmark.", partial(annotating.choose_next, -1), "PgUp",
            why_not=annotate.why_no_annotating,
        ),
    ]  # fmt: skip


def _placing(annotate: ClickController) -> list[Command]:

    def nothing_predicted(everywhere: bool) -> str:
        reason = annotate.why_no_annotating() or ("" if everywhere else annotate.why_no_camera())
        if reason:
            return reason
        found = annotate.predictions_everywhere() if everywhere else annotate.predictions_here()
        if found:
            return ""
        where = "in any view" if everywhere else "in this view"
        return f"No unclicked landmark has a prediction {where}."

    return [
        Command(
            "accept", _MENU, "Accept prediction", "Turn the predicted point of the selected "
            "landmark in the view under the cursor into a click.",
            annotate.accept_here, "A", "accept",
            partial(nothing_predicted, False),
        ),
        Command(
            "accept_everywhere", _MENU, "Accept prediction in all views",
            "Turn the predicted points of the selected landmark into clicks in all views that "
            "have none.",
            annotate.accept_everywhere, "Shift+A", "accept", partial(nothing_predicted, True),
        ),
        Command(
            "delete_click", _MENU, "Clear click", "Delete the last click, or the click of the "
            "selected landmark in this view.", annotate.annotating.delete, "Del",
            "delete", lambda: no_click(annotate), section=True,
        ),
        Command(
            "delete_everywhere", _MENU, "Clear clicks in all views",
            "Delete the clicks of the landmark in all views of this frame.",
            annotate.annotating.delete_everywhere,
            "Shift+Del", "delete", annotate.why_no_annotating,
        ),
    ]  # fmt: skip


def _marking(annotate: ClickController) -> list[Command]:
    annotating = annotate.annotating

    def seen_as(visibility: Visibility) -> bool:
        click = annotating.at_hand()
        return click is not None and click.visibility == visibility

    def doubted() -> bool:
        click = annotating.at_hand()
        return click is not None and click.flag == UNCERTAIN

    rows = [
        (Visibility.SEEN, "Seen", "I", "The landmark is visible.", no_click),
        (Visibility.GUESSED, "Guessed", "B", "The landmark is occluded and its position is "
        "estimated. Shift+click places a click this way.", no_click),
        (Visibility.OUTSIDE, "Outside the image", "X", "The selected click, or the next one to be "
        "placed, lies outside this image.",
         lambda annotate: annotate.why_no_annotating() or annotate.why_no_camera()),
    ]  # fmt: skip
    marks = [
        Command(
            f"mark_{visibility.name.lower()}", f"{_MENU}/Mark as", text, tip,
            partial(annotating.mark, visibility), keys, why_not=partial(why_not, annotate),
            checked=partial(seen_as, visibility),
        )
        for visibility, text, keys, tip, why_not in rows
    ]  # fmt: skip
    return [
        *marks,
        Command(
            "mark_uncertain", f"{_MENU}/Mark as", "Uncertain",
            "You are not certain of this click. It gets less weight in fits.",
            annotating.toggle_doubt, "U", "warning", lambda: no_click(annotate),
            doubted, section=True,
        ),
        Command(
            "mark_sigma", f"{_MENU}/Mark as", "Set click uncertainty …",
            "Set the standard deviation of this click's position, in pixels.",
            annotate.ask_sigma, "Shift+U", "ruler", lambda: no_click(annotate),
        ),
    ]  # fmt: skip


def _nudging(annotate: ClickController) -> list[Command]:
    annotating = annotate.annotating

    def not_held() -> str:
        reason = annotate.why_no_annotating()
        held = annotating.held() is not None
        return reason or ("" if held else "No click is selected. Click on one, or press E.")

    nudges = [
        Command(
            f"nudge_{way}{'_' if name else ''}{name}", f"{_MENU}/Nudge", f"Move by {words} {way}",
            f"Move the selected click by {words} {way}.",
            partial(annotate.nudge, x * step, y * step), f"{modifier}{way.capitalize()}",
            why_not=not_held, section=way == "left", local=True,
        )
        for name, (step, words, modifier) in _STEPS.items()
        for way, (x, y) in _WAYS.items()
    ]  # fmt: skip
    return [
        Command(
            "pick_click", f"{_MENU}/Nudge", "Select click",
            "Select the last click, or the one of the selected landmark, to move it with the "
            "arrow keys.", annotate.pick_last,
            "E", "clicks", lambda: no_click(annotate),
        ),
        Command(
            "let_go", f"{_MENU}/Nudge", "Deselect click",
            "Let the arrow keys step through frames again.",
            annotating.let_go, "Esc", why_not=not_held, local=True,
        ),
        *nudges,
    ]  # fmt: skip


def _switches(annotate: ClickController) -> list[Command]:
    advances = [
        Command(
            f"advance_{name}", f"{_MENU}/After a click", text, tip,
            partial(annotate.choose_advance, name), why_not=annotate.no_recording,
            checked=partial(annotate.advances_to, name),
        )
        for name, (text, tip) in ADVANCES.items()
    ]  # fmt: skip
    return [
        *advances,
        Command(
            "fit_depth", _MENU, "Fit to clicks and depth", "Fit the body to the measured points "
            "as well as to the clicks, where the recording has depth.",
            annotate.toggle_depth, "Shift+D", "fit",
            lambda: annotate.why_no_annotating() or (
                "" if annotate.depth_available() else "No view of this recording provides depth."
            ),
            lambda: annotate.facts.use_depth, section=True,
        ),
    ]  # fmt: skip

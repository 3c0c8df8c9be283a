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
    return "" if there else f"There is no click of the {chosen} in this view."


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
            f"Let the next click place landmark {place + 1}.", partial(choose, place),
            str(place + 1), why_not=partial(why_not, place), checked=partial(is_chosen, place),
            says=partial(says, place),
        )
        for place in range(_KEYS)
    ]  # fmt: skip
    return [
        *by_key,
        Command(
            "next_landmark", f"{_MENU}/Landmark", "Next landmark", "Choose the next landmark.",
            partial(annotating.choose_next, 1), "PgDown", why_not=annotate.why_no_annotating,
            section=True,
        ),
        Command(
            "previous_landmark", f"{_MENU}/Landmark", "Previous landmark",
            "Choose the landmark before.", partial(annotating.choose_next, -1), "PgUp",
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
        return f"Nothing is predicted {where} where nobody has clicked."

    return [
        Command(
            "accept", _MENU, "Accept the prediction", "Let the predicted point of the chosen "
            "landmark in the view at the cursor be a click.", annotate.accept_here, "A", "accept",
            partial(nothing_predicted, False),
        ),
        Command(
            "accept_everywhere", _MENU, "Accept the prediction in all views", "Let the predicted "
            "points of the chosen landmark be clicks in all views that have none.",
            annotate.accept_everywhere, "Shift+A", "accept", partial(nothing_predicted, True),
        ),
        Command(
            "delete_click", _MENU, "Clear here", "Take away the click that was placed last, or "
            "else the chosen landmark's in this view.", annotate.annotating.delete, "Del",
            "delete", lambda: no_click(annotate), section=True,
        ),
        Command(
            "delete_everywhere", _MENU, "Clear in all views", "Take away the clicks of the "
            "landmark in all views of this frame.", annotate.annotating.delete_everywhere,
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
        (Visibility.SEEN, "Seen", "I", "The landmark is in sight.", no_click),
        (Visibility.GUESSED, "Guessed", "B", "The landmark is behind something and its place "
         "guessed; Shift+click places it so at once.", no_click),
        (Visibility.OUTSIDE, "Outside the image", "X", "What the next click would place, or "
         "the click in hand, is not in this image.",
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
            "mark_uncertain", f"{_MENU}/Mark as", "Uncertain", "You doubt this click yourself; "
            "it counts less.", annotating.toggle_doubt, "U", "warning", lambda: no_click(annotate),
            doubted, section=True,
        ),
        Command(
            "mark_sigma", f"{_MENU}/Mark as", "Good to so many pixels …", "Say how sure the place "
            "of this click is.", annotate.ask_sigma, "Shift+U", "ruler", lambda: no_click(annotate),
        ),
    ]  # fmt: skip


def _nudging(annotate: ClickController) -> list[Command]:
    annotating = annotate.annotating

    def not_held() -> str:
        reason = annotate.why_no_annotating()
        held = annotating.held() is not None
        return reason or ("" if held else "Take a click in hand first: click on it, or press E.")

    nudges = [
        Command(
            f"nudge_{way}{'_' if name else ''}{name}", f"{_MENU}/Nudge", f"{words} {way}",
            f"Move the click in hand {words} {way}.",
            partial(annotate.nudge, x * step, y * step), f"{modifier}{way.capitalize()}",
            why_not=not_held, section=way == "left", local=True,
        )
        for name, (step, words, modifier) in _STEPS.items()
        for way, (x, y) in _WAYS.items()
    ]  # fmt: skip
    return [
        Command(
            "pick_click", f"{_MENU}/Nudge", "Take the click in hand", "Let the arrow keys move "
            "the click that was placed last, or the chosen landmark's.", annotate.pick_last,
            "E", "clicks", lambda: no_click(annotate),
        ),
        Command(
            "let_go", f"{_MENU}/Nudge", "Let go", "Give the arrow keys back to the frames.",
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
            "fit_depth", _MENU, "Fit with measured depth", "Fit the body to the measured points "
            "too, where the recording has depth.", annotate.toggle_depth, "Shift+D", "fit",
            lambda: annotate.why_no_annotating() or (
                "" if annotate.depth_available() else "No view of this recording gives depth."
            ),
            lambda: annotate.facts.use_depth, section=True,
        ),
    ]  # fmt: skip

"""Commands about landmarks and clicks."""

from functools import partial
from itertools import chain

from stereotrack_core.annotation.click import UNCERTAIN, Visibility

from ....services.actions import Command, Menu
from ....session.session import Session, unless
from .choosing import ADVANCES, Advance
from .controller import ClickController

_MENU = "&Annotate"
_KEYS = 9
_STEPS = {
    "fine": (0.1, "0.1 px", "Ctrl+"), "": (0.5, "0.5 px", ""), "coarse": (1.0, "1 px", "Shift+"),
}  # fmt: skip
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

    def no_view(everywhere: bool) -> str:
        return annotate.why_no_annotating() or ("" if everywhere else annotate.why_no_camera())

    def nothing_predicted(everywhere: bool) -> str:
        where = "any view" if everywhere else "this view"
        none = f"No unclicked landmark has a prediction in {where}."
        return no_view(everywhere) or unless(annotate.predictions(everywhere=everywhere), none)

    def nothing_proposed(everywhere: bool) -> str:
        where = "this frame" if everywhere else "this view"
        none = f"Nothing is proposed in {where}. Click landmarks in another frame first."
        return no_view(everywhere) or unless(annotate.proposed(everywhere=everywhere), none)

    command = Menu(_MENU, annotate.why_no_annotating).command
    return [
        command("accept", "Accept prediction", "Turn the predicted point of the selected landmark "
                "in the view under the cursor into a click.",
                partial(annotate.accept, everywhere=False), "A", "accept",
                why_not=partial(nothing_predicted, False)),
        command("accept_everywhere", "Accept prediction in all views", "Turn the predicted points "
                "of the selected landmark into clicks in all views that have none.",
                partial(annotate.accept, everywhere=True), "Shift+A", "accept",
                why_not=partial(nothing_predicted, True)),
        command("accept_view", "Accept all proposals in this view", "Turn everything that is "
                "proposed in the view under the cursor and certain enough into clicks. Drag what "
                "is wrong first.",
                partial(annotate.accept_proposals, everywhere=False), "Q", "accept",
                why_not=partial(nothing_proposed, False)),
        command("accept_frame", "Accept all proposals in this frame", "Turn everything that is "
                "proposed in all views of this frame and certain enough into clicks, as one edit.",
                partial(annotate.accept_proposals, everywhere=True), "Shift+Q", "accept",
                why_not=partial(nothing_proposed, True)),
        command("accept_limit", "Limit for accepting …", "Set up to which standard deviation "
                "proposals and predictions are accepted. What is less certain is drawn fainter, "
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
        none = "No click is in hand. Click on one, or press E."
        return annotate.why_no_annotating() or unless(annotating.held(), none)

    command = Menu(f"{_MENU}/Nudge", not_held).command
    nudges = [
        command(
            f"nudge_{way}{'_' if name else ''}{name}", f"Move by {words} {way}",
            f"Move the last click, or the selected one, by {words} {way}.",
            partial(annotate.nudge, x * step, y * step), f"{modifier}{way.capitalize()}",
            section=way == "left", goes_first=True,
        )
        for name, (step, words, modifier) in _STEPS.items()
        for way, (x, y) in _WAYS.items()
    ]  # fmt: skip
    return [
        command("pick_click", "Select click", "Select the last click, or the one of the selected "
                "landmark, to move it with the arrow keys.", annotate.pick_last, "E", "clicks",
                why_not=partial(_no_click, annotate)),
        command("let_go", "Deselect click", "Let the arrow keys step through frames again.",
                annotating.let_go, "Esc", goes_first=True),
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
        Menu(_MENU, session.no_recording).command(
            "ask_for_clicks", "Ask for clicks of uncertain landmarks", "Propose nothing for an "
            "uncertain landmark in the view where a click tells most. Takes more clicks and keeps "
            "accepted proposals closer to what you see.", annotate.toggle_asking,
            checked=lambda: annotate.proposals.asks, section=True,
        ),
        Menu(_MENU, no_depth).command(
            "fit_depth", "Fit to clicks and depth", "Fit the body to the measured points as well "
            "as to the clicks, where the recording has depth.", annotate.toggle_depth, "Shift+D",
            "fit", checked=lambda: annotate.facts.use_depth, section=True,
        ),
    ]  # fmt: skip

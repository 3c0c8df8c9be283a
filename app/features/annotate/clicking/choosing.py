"""Which landmark the next click is: what the person chose, else what a view has not yet."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

from stereotrack_core.annotation.click import ClickKey

Advance: TypeAlias = Literal["landmark", "view", "none"]
ADVANCES: dict[Advance, tuple[str, str]] = {
    "landmark": (
        "Advance to the next landmark",
        "A click places the first landmark that has no click yet in the view under the cursor.",
    ),
    "view": (
        "Advance when all views are clicked",
        "Keep the landmark until it has a click in every visible view.",
    ),
    "none": (
        "Stay on the landmark",
        "Keep the landmark selected, to click it in frame after frame.",
    ),
}
"""What happens to the choice after a click was placed, as a title and a sentence."""


@dataclass(frozen=True)
class Choice:
    """What keys and clicks are about."""

    landmark: str  # the landmark that keys act on, and clicks as far as `next_landmark` says
    touched: ClickKey | None = None
    """The click in hand: placed, picked or moved last, until another landmark is chosen."""
    picked: bool = False
    """The person has picked it, so that keys stay with its landmark wherever the mouse goes."""
    asked: bool = False
    """The person has chosen the landmark: the next click places it, clicked already or not."""
    again: ClickKey | None = None
    """A click that was taken away: the next click there places it again."""


@dataclass(frozen=True)
class Annotated:
    """What the choice depends on."""

    names: Sequence[str]  # all landmarks, in the person's order
    clicks: Collection[ClickKey]
    """What a person has said of a frame; also that something is outside an image."""
    frame: int
    cameras: Sequence[str]

    def missing(self, landmark: str, cameras: Sequence[str]) -> bool:
        return any(ClickKey(self.frame, camera, landmark) not in self.clicks for camera in cameras)

    def complete(self, landmarks: Sequence[str]) -> bool:
        return not any(self.missing(landmark, self.cameras) for landmark in landmarks)


def landmark_at_hand(choice: Choice, advance: Advance, known: Annotated, camera: str) -> str | None:
    """The landmark that is under way while an image is at hand; None where all is clicked."""
    if advance == "none" or choice.asked:
        return choice.landmark
    again = choice.again
    if again is not None and again not in known.clicks and again[:2] == (known.frame, camera):
        return again.landmark
    one_view = advance == "landmark"
    # the landmark that was begun goes through all views
    names = known.names if one_view else (choice.landmark, *known.names)
    cameras = (camera,) if one_view else (camera, *known.cameras)
    return next((name for name in names if known.missing(name, cameras)), None)


def next_landmark(choice: Choice, advance: Advance, known: Annotated, camera: str) -> str | None:
    """The landmark that the next click in an image places; None where it would place nothing.

    Only a landmark that the person has chosen is placed where it has a click already.
    """
    landmark = landmark_at_hand(choice, advance, known, camera)
    if landmark is None or advance == "none" or choice.asked:
        return landmark
    return landmark if known.missing(landmark, (camera,)) else None

"""What the landmarks panel shows of each landmark."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

CellState: TypeAlias = Literal["clicked", "guessed", "doubted", "outside", "predicted", "missing"]

CELL_WORDS: dict[CellState, str] = {
    "clicked": "clicked",
    "guessed": "occluded, position estimated",
    "doubted": "clicked, flagged as uncertain",
    "outside": "outside the image",
    "predicted": "not clicked; a prediction is available",
    "missing": "not clicked",
}
"""States of a landmark in one camera, in words."""


@dataclass(frozen=True)
class LandmarkRow:
    """One landmark at the frame that is shown.

    Attributes
    ----------
    key : str
        What chooses it; empty beyond the ninth.
    landmark, label, colour : str
    chosen : bool
    cells : tuple of CellState
        For each camera of the panel.
    residual : str
        How far the clicks are from the fitted model, px; empty while not known.
    distance : str
        How far the clicked point is from the model's, mm.
    bad : bool
        Whether the fit takes a click of it for a gross mistake.
    """

    key: str
    landmark: str
    label: str
    colour: str
    chosen: bool
    cells: tuple[CellState, ...]
    residual: str = ""
    distance: str = ""
    bad: bool = False


@dataclass(frozen=True)
class BodyRow:
    """A limb or a length in the body panel.

    Attributes
    ----------
    limb : str
        One of the limbs, for its colour; empty for a length.
    label, value, words : str
    doubtful : bool
    """

    limb: str
    label: str
    value: str
    words: str = ""
    doubtful: bool = False

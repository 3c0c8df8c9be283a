"""What the comparison panel shows, row by row."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class ComparedCell:
    """A value of one run, of which less is better."""

    value: float
    """NaN where not known."""
    difference: float = math.nan
    """From the first run; NaN for that itself."""
    low: float = math.nan
    high: float = math.nan
    """`low` and `high`: 95 % interval of the difference; NaN where the frames are too few."""
    differs: bool = False
    """Whether the interval leaves 0 out."""
    verdict: str = ""
    """What that comes to, in words."""


@dataclass(frozen=True)
class ComparedRow:
    """A measure: its limb (empty for none), its label with the unit, and a cell for each run."""

    limb: str
    label: str
    cells: tuple[ComparedCell, ...]

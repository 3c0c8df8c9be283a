"""What the panel of a frame's inside shows of one step; nothing of it is worked out there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from stereotrack_core.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class HeatMap:
    """Numbers with a sign as colours."""

    title: str
    rows: tuple[str, ...]
    """Names of the rows."""
    groups: tuple[tuple[str, str, int], ...]
    """Groups of successive columns: name, limb (empty for none) and how many."""
    values: FloatArray
    """(R, C) float64. -1 to 1: how strong the colour is."""
    words: Callable[[int, int], str]
    """From row and column to what is said about the number under the mouse."""
    ends: tuple[str, ...]
    """What the colours at both ends mean, with units: one line or more for each scale."""


@dataclass(frozen=True, eq=False)
class Histogram:
    """How often residuals of each size occur."""

    title: str
    edges: FloatArray
    """(B + 1,) float64. In the unit."""
    counts: FloatArray
    """(B,) float64."""
    shades: FloatArray
    """(B,) float64. -1 to 1: colour of each bar."""
    unit: str
    words: str
    """What is to be said about all of them."""
    sides: tuple[str, str] = ("", "")
    """What negative and positive numbers mean."""


@dataclass(frozen=True)
class Table:
    """Words and numbers in rows."""

    title: str
    headings: tuple[str, ...]
    """The first column is words, all others numbers."""
    rows: tuple[tuple[str, ...], ...]
    limbs: tuple[str, ...] = ()
    """Limb of each row, whose colour stands before it; empty for none."""
    strong: tuple[int, ...] = ()
    """Rows that are chosen."""
    tips: tuple[str, ...] = ()
    """What each heading means; as many as there are headings, or none."""


@dataclass(frozen=True, eq=False)
class StepContent:
    """One step in words and numbers."""

    title: str
    words: str
    """One or two plain sentences."""
    source: str
    """Where the thesis has it, or what it takes the place of."""
    maps: tuple[HeatMap, ...] = ()
    """Ways to see the same, the first one first."""
    histogram: Histogram | None = None
    tables: tuple[Table, ...] = ()


@dataclass(frozen=True)
class StepName:
    """A step in the list."""

    title: str
    heading: str = ""
    """Written before the first step of an iteration or stage; empty elsewhere."""

"""What the panel of a frame's inside shows of one step; nothing of it is worked out there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from stereotrack_core.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class HeatMap:
    """Numbers with a sign as colours.

    Attributes
    ----------
    title : str
    rows : tuple of str
        Names of the rows.
    groups : tuple of (str, str, int)
        Groups of successive columns: name, limb (empty for none) and how many.
    values : (R, C) float64
        -1 to 1: how strong the colour is.
    words : callable
        From row and column to what is said about the number under the mouse.
    ends : tuple of str
        What the colours at both ends mean, with units: one line or more for each scale.
    """

    title: str
    rows: tuple[str, ...]
    groups: tuple[tuple[str, str, int], ...]
    values: FloatArray
    words: Callable[[int, int], str]
    ends: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Histogram:
    """How often residuals of each size occur.

    Attributes
    ----------
    title : str
    edges : (B + 1,) float64
        In the unit.
    counts : (B,) float64
    shades : (B,) float64
        -1 to 1: colour of each bar.
    unit : str
    words : str
        What is to be said about all of them.
    sides : tuple of str
        What negative and positive numbers mean.
    """

    title: str
    edges: FloatArray
    counts: FloatArray
    shades: FloatArray
    unit: str
    words: str
    sides: tuple[str, str] = ("", "")


@dataclass(frozen=True)
class Table:
    """Words and numbers in rows.

    Attributes
    ----------
    title : str
    headings : tuple of str
        The first column is words, all others numbers.
    rows : tuple of tuple of str
    limbs : tuple of str
        Limb of each row, whose colour stands before it; empty for none.
    strong : tuple of int
        Rows that are chosen.
    tips : tuple of str
        What each heading means; as many as there are headings, or none.
    """

    title: str
    headings: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    limbs: tuple[str, ...] = ()
    strong: tuple[int, ...] = ()
    tips: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class StepContent:
    """One step in words and numbers.

    Attributes
    ----------
    title : str
    words : str
        One or two plain sentences.
    source : str
        Where the thesis has it, or what it takes the place of.
    maps : tuple of HeatMap
        Ways to see the same, the first one first.
    histogram : Histogram or None
    tables : tuple of Table
    """

    title: str
    words: str
    source: str
    maps: tuple[HeatMap, ...] = ()
    histogram: Histogram | None = None
    tables: tuple[Table, ...] = ()


@dataclass(frozen=True)
class StepName:
    """A step in the list.

    Attributes
    ----------
    title : str
    heading : str
        Written before the first step of an iteration or stage; empty elsewhere.
    """

    title: str
    heading: str = ""

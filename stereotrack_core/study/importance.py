"""Which parameters matter for a measure, over runs in which they differ.

The main effect of a parameter is the share of the measure's variance that its values explain, one
parameter at a time, corrected for what as many values would explain by chance (omega squared, Hays
1963). What is left belongs to seeds and to parameters acting together. PED-ANOVA, which looks at
the best tenth of the runs, needs hundreds of them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.study.store import AVERAGED, RunTable, is_number

_MOST_GROUPS = 6  # of numbers with more values, neighbours are put together
_LEAST_SHARE = 0.01


@dataclass(frozen=True)
class Effect:
    """Main effect of a parameter on a measure."""

    name: str
    share: float  # of the measure's variance, 0 to 1; NaN if every run has a value of its own
    low: float
    high: float  # `low` and `high`: least and greatest mean of the runs with the same value


def effects_of(table: RunTable, measure: str) -> tuple[Effect, ...]:
    """Effects of what a table varies, the largest first, with recordings taken for equally hard."""
    values, recordings = table.numbers(measure), np.array(table.cells("recording"))
    mean = np.nanmean(values) if np.isfinite(values).any() else 0.0
    for recording in np.unique(recordings[np.isfinite(values)]):
        own = recordings == recording
        values[own] += mean - np.nanmean(values[own])
    names = [name for name in table.varied if name not in AVERAGED]
    return effects({name: table.cells(name) for name in names}, values)


def effects(factors: Mapping[str, Sequence[str]], values: FloatArray) -> tuple[Effect, ...]:
    """Effects of factors, each with its value in R runs, on a measure (R,), the largest first."""
    known = np.isfinite(values)
    found = []
    for name, cells in factors.items():
        own = [cell for cell, there in zip(cells, known, strict=True) if there]
        if len(set(own)) > 1:
            found.append(_effect(name, _groups(own), values[known]))
    return tuple(sorted(found, key=lambda one: -np.nan_to_num(one.share, nan=-1.0)))


def _groups(cells: Sequence[str]) -> IntArray:
    """Group (R,) of each run: its value, or of many numbers one of equally large parts."""
    values, groups = np.unique(np.array(cells), return_inverse=True)
    if len(values) > _MOST_GROUPS and all(map(is_number, cells)):
        numbers = np.array(cells, dtype=np.float64)
        edges = np.quantile(numbers, np.linspace(0.0, 1.0, _MOST_GROUPS + 1)[1:-1])
        groups = np.digitize(numbers, np.unique(edges))
    return np.asarray(groups, dtype=np.int64)


def _effect(name: str, groups: IntArray, values: FloatArray) -> Effect:
    counts = np.bincount(groups)
    means = np.bincount(groups, values)[counts > 0] / counts[counts > 0]
    count, m = len(values), len(means)
    total = float(np.square(values - values.mean()).sum())
    between = float((counts[counts > 0] * np.square(means - values.mean())).sum())
    share = float("nan")
    if count > m and total > 0.0:
        within = (total - between) / (count - m)
        share = max(0.0, (between - (m - 1) * within) / (total + within))
    return Effect(name, share, float(means.min()), float(means.max()))


def effects_words(effects: Sequence[Effect], unit: str) -> str:
    """``arms apart 41 % (8.1 to 9.9 deg), iterations none``; empty if nothing can be said."""
    told = [
        f"{one.name.replace('_', ' ')} none"
        if one.share < _LEAST_SHARE
        else f"{one.name.replace('_', ' ')} {100.0 * one.share:.0f} % "
        f"({one.low:.1f} to {one.high:.1f} {unit})".replace(" )", ")")
        for one in effects
        if np.isfinite(one.share)
    ]
    together = sum(one.share for one in effects if np.isfinite(one.share)) > 1.0
    return ", ".join(told) + ("; some were changed together, and share it" if together else "")

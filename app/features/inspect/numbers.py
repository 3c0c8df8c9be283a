"""Names and units of the states, their deviations, and the cross-covariance over them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import IntArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.skeleton import PARTS, limb_of_part
from stereotrack_core.tracking.state import Belief
from stereotrack_core.tracking.trace import Correction

from ...widgets.plots.inside_panel import Table
from ...widgets.plots.step_plots import HeatMap
from ...widgets.style.limb_colours import limb_words

_GREEK = {"alpha": "α", "beta": "β", "gamma": "γ"}
_TURNS = {"rx": "turn x", "ry": "turn y", "rz": "turn z", "tx": "turn x", "ty": "turn y"}


@dataclass(frozen=True)
class State:
    """One number of the state."""

    label: str
    short: str
    limb: str
    unit: str
    """Either "mm" or "°"."""
    factor: float
    """From metres or radians to the unit."""


def states_of(names: tuple[str, ...]) -> tuple[State, ...]:
    """Labels and units of states by their names; the first three are positions."""
    found = []
    for index, name in enumerate(names):
        limb, _, axis = name.rpartition("_")
        said = _GREEK.get(axis, _TURNS.get(axis, axis))
        label = f"{limb_words(limb)} {said}"
        short = label if index < 6 else label.replace("turn ", "")
        for whole, part in (("left ", "L "), ("right ", "R "), ("upper arm", "upper")):
            short = short.replace(whole, part)
        short = short.replace("forearm", "fore")
        unit, factor = ("mm", 1e3) if index < 3 else ("°", float(np.degrees(1.0)))
        found.append(State(label, short, limb if limb in LIMBS else "", unit, factor))
    return tuple(found)


def part_words(part: int) -> str:
    """Name of a part as a person reads it."""
    return limb_words(PARTS[part]) if part >= 0 else "none"


def groups_of(part: IntArray) -> tuple[tuple[str, str, int], ...]:
    """Groups of successive columns of one part: name, limb and how many."""
    present, counts = np.unique(part, return_counts=True)
    return tuple(
        (part_words(p), limb_of_part(p), int(n))
        for p, n in zip(present.tolist(), counts.tolist(), strict=True)
    )


def cross_map(correction: Correction, names: tuple[str, ...]) -> HeatMap:
    """The cross-covariance as correlations; a cell's words have it in its own units."""
    states, P_xz = states_of(names), correction.P_xz
    spread = np.outer(correction.before.sigma, np.sqrt(np.maximum(correction.P_zz, 0.0)))
    known = spread > 0.0
    correlation = np.where(known, P_xz / np.where(known, spread, 1.0), 0.0)
    points, groups = correction.points, groups_of(correction.points.part)

    def words(row: int, column: int) -> str:
        state = states[row]
        value = P_xz[row, column] * state.factor * 1e3
        unit = "mm²" if state.unit == "mm" else "° mm"
        return (
            f"{state.label}, point {column + 1} on the {part_words(points.part[column])}: "
            f"P_xz {_number(value)} {unit}, correlation {correlation[row, column]:+z.2f}, "
            f"residual {1e3 * points.residual[column]:.0f} mm, "
            f"gain {correction.gain[row, column] * state.factor / 1e3:.3g} {state.unit} per mm"
        )

    rows = tuple(state.short for state in states)
    return HeatMap(rows, groups, correlation, words)


def deviations_table(
    before: Belief, after: Belief, names: tuple[str, ...], headings: tuple[str, str]
) -> Table:
    """Standard deviations of all states before and after."""
    states, rows = states_of(names), []
    for state, a, b in zip(states, before.sigma, after.sigma, strict=True):
        change = f"{100.0 * (b / a - 1.0):+z.0f} %" if a > 0.0 else ""
        values = (f"{value * state.factor:.2f} {state.unit}" for value in (a, b))
        rows.append((state.label, *values, change))
    limbs = tuple(state.limb for state in states)
    return Table("Standard deviations", ("State", *headings, "Change"), tuple(rows), limbs)


def _number(value: float) -> str:
    """Three digits, without exponents where they can be done without."""
    return f"{value:.0f}" if abs(value) >= 1000.0 else f"{value:.3g}"

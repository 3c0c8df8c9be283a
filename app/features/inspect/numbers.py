"""Names and units of the states, and maps of matrices over them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.skeleton import PARTS, limb_of_part
from stereotrack_core.tracking.estimate import Correspondences
from stereotrack_core.tracking.state import Belief
from stereotrack_core.tracking.trace import Correction

from ...widgets.plots.inside_panel import Table
from ...widgets.plots.step_plots import HeatMap, Histogram
from ...widgets.style.limb_colours import limb_words

_GREEK = {"alpha": "α", "beta": "β", "gamma": "γ"}
_TURNS = {"rx": "turn x", "ry": "turn y", "rz": "turn z", "tx": "turn x", "ty": "turn y"}
_BARS = 24
_FULL = 0.06


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


def cross_maps(correction: Correction, names: tuple[str, ...]) -> tuple[HeatMap, ...]:
    """The cross-covariance as correlations, and in its own units."""
    states, P_xz = states_of(names), correction.P_xz
    spread = np.outer(correction.before.sigma, np.sqrt(np.maximum(correction.P_zz, 0.0)))
    known = spread > 0.0
    correlation = np.where(known, P_xz / np.where(known, spread, 1.0), 0.0)
    strongest = [_largest(P_xz[:3]), _largest(P_xz[3:])]
    scaled = np.concatenate([P_xz[:3] / strongest[0], P_xz[3:] / strongest[1]])
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
    ends = (
        f"{_number(1e6 * strongest[0])} mm² (positions)",
        f"{_number(1e3 * float(np.degrees(strongest[1])))} ° mm (angles)",
    )
    return (
        HeatMap("Correlation", rows, groups, correlation, words, ("correlation 1",)),
        HeatMap("Covariance", rows, groups, scaled, words, ends),
    )


def covariance_maps(
    before: Belief, after: Belief, names: tuple[str, ...], titles: tuple[str, str]
) -> tuple[HeatMap, ...]:
    """Correlations of the states after and before something."""
    return _covariance_map(after, names, titles[1]), _covariance_map(before, names, titles[0])


def _covariance_map(belief: Belief, names: tuple[str, ...], title: str) -> HeatMap:
    states, correlation, sigma = states_of(names), belief.correlation, belief.sigma
    groups: list[tuple[str, str, int]] = [("position", "torso", 3), ("rotation", "torso", 3)]
    groups += [
        (limb_words(name.rpartition("_")[0]), states[i].limb, 2)
        for i, name in enumerate(names)
        if i >= 6 and i % 2 == 0
    ]

    def words(row: int, column: int) -> str:
        a, b = states[row], states[column]
        if row == column:
            return f"{a.label}: standard deviation {sigma[row] * a.factor:.2f} {a.unit}"
        return f"{a.label} and {b.label}: correlation {correlation[row, column]:+z.2f}"

    rows = tuple(state.short for state in states)
    return HeatMap(title, rows, tuple(groups), correlation, words, ("correlation 1",))


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


def residual_histogram(points: Correspondences, words: str, sides: tuple[str, str]) -> Histogram:
    """Residuals in millimetres; beyond the ends of the scale they are in the last bars."""
    residual = 1e3 * points.residual
    signed = bool(len(residual)) and float(residual.min()) < -1.0
    high = max(20.0, float(np.ceil(np.percentile(np.abs(residual), 98) / 20.0) * 20.0))
    edges = np.linspace(-high if signed else 0.0, high, _BARS + 1)
    counts, _ = np.histogram(np.clip(residual, edges[0], edges[-1]), edges)
    middles = 0.5 * (edges[1:] + edges[:-1])
    shades = np.clip(middles / (1e3 * _FULL), -1.0, 1.0)
    title, heights = "Residuals of the correspondences", counts.astype(np.float64)
    return Histogram(title, edges, heights, shades, "mm", words, sides)


def _number(value: float) -> str:
    """Three digits, without exponents where they can be done without."""
    return f"{value:.0f}" if abs(value) >= 1000.0 else f"{value:.3g}"


def _largest(values: FloatArray) -> float:
    return max(float(np.abs(values).max(initial=0.0)), 1e-12)

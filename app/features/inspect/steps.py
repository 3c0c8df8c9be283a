"""The steps of one frame's correction in the method's words, and its states and covariances."""

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.skeleton import PARTS
from stereotrack_core.tracking.state import Belief
from stereotrack_core.tracking.trace import Correction, StepTrace

from ...widgets.plots.inside_panel import Table
from ...widgets.style.colours import limb_words

StepKind: TypeAlias = Literal[
    "predict", "points", "pairs", "sigma", "cross", "correct", "settle", "search", "collisions",
    "result",
]  # fmt: skip


@dataclass(frozen=True, eq=False)
class Step:
    """One step."""

    kind: StepKind
    title: str
    words: str  # what happens, for somebody who learns the method
    source: str  # where the thesis has it, or what it takes the place of
    heading: str = ""  # of the first step of an iteration; empty elsewhere
    correction: int = -1  # index into the trace's corrections; -1 for steps that belong to none


_THESIS: dict[StepKind, tuple[str, str, str]] = {
    "predict": (
        "Predict",
        "The motion is unknown, so the body is predicted to stay where it was. Only the "
        "uncertainty grows: the process noise Q is added to the covariance P.",
        "Section 3.2.1 and figure 3.8: x[k+1|k] = x[k|k], P[k+1|k] = P[k|k] + Q",
    ),
    "points": (
        "Sample",
        "The same number of points is sampled from each cone of the model. Points inside another "
        "cone and points that no camera can see are dropped, because nothing can be measured "
        "there.",
        "Equation (3.4), figure 3.5",
    ),
    "pairs": (
        "Correspondences",
        "Each model point is paired with its nearest measured point. Both are projected on the "
        "line that joins them, so each pair gives one number: the distance between them.",
        "Section 2.3, equations (3.5) to (3.8), figures 3.6 and 3.10",
    ),
    "sigma": (
        "Sigma points",
        "A few poses represent the estimate and its uncertainty: the estimate itself and, for "
        "each uncertain direction, one pose on either side (thin outlines).",
        "Equations (2.12) to (2.14), figure 3.9",
    ),
    "cross": (
        "Cross-covariance",
        "P_xz: how a change of each state goes along with the residual of each pair. The table has "
        "the strongest correlation of a state (row) with the pairs of a part (column); at 0 the "
        "part says nothing about the state.",
        "Equations (2.9) and (2.18), figure 3.14",
    ),
    "correct": (
        "Correct",
        "The residual, weighted by the gain K = P_xz P_νν⁻¹, corrects the state, and the "
        "covariance shrinks. Thin outlines: the model before the correction.",
        "Section 3.2.3: x + Kν and P − K P_νν Kᵀ with P_νν = P_zz + R",
    ),
    "collisions": (
        "Collisions",
        "After the last iteration, arms that are too close to the torso or bent too far are moved "
        "to the minimum distance or angle. Thin outlines: the model before.",
        "Section 3.2.4, figure 3.15",
    ),
    "result": (
        "Result",
        "The pose of this frame. The next frame starts from it and from its covariance.",
        "Section 3.2.3: x[k+1|k+1], P[k+1|k+1]",
    ),
}

_MANIFOLD: dict[StepKind, tuple[str, str, str]] = {
    "predict": (
        "Predict",
        "The body is predicted to stay. The uncertainty grows by the process noise Q.",
        "Section 3.2.1, figure 3.8; rotation states are small rotation vectors, free of "
        "singularities",
    ),
    "points": (
        "Measure",
        "Points are sampled from the cloud. They are assigned to the model (data-to-model), where "
        "the thesis assigns model points to the cloud. A misplaced arm therefore still has data "
        "that attract it.",
        "Replaces equation (3.4)",
    ),
    "pairs": (
        "Correspondences",
        "Each measured point is assigned to the nearest cone and compared along the surface "
        "normal there. Its weight falls with distance and is zero beyond the maximum "
        "correspondence distance.",
        "Replaces equations (3.5) to (3.8)",
    ),
    "sigma": (
        "Sigma points",
        "Poses that represent the estimate and its uncertainty (thin outlines). This tracker "
        "linearises by derivatives; the poses only illustrate its uncertainty.",
        "Equations (2.12) to (2.14), figure 3.9",
    ),
    "cross": (*_THESIS["cross"][:2], "Equation (2.11), P_xz = P Hᵀ; figure 3.14"),
    "correct": (
        "Correct",
        "The prediction is corrected by all correspondences at once, linearised at the start of "
        "the iteration. Joint limits, other sensors and the prediction itself contribute as well.",
        "Section 3.2.3, iterated by posterior linearisation (DOI 10.1109/TSP.2015.2454485)",
    ),
    "settle": (
        "Fit pose",
        "This method finds the pose without a cross-covariance. Thin outlines: the prediction.",
        "Named in the thesis as an alternative; used here as a baseline",
    ),
    "search": (
        "Arm search",
        "Many other positions of both arms are scored and the best pairs are refined. One of them "
        "is chosen if it explains the frame clearly better. Thin outlines: rejected pairs.",
        "Not in the thesis, whose section 3.2.4 describes arms that stay caught on other parts",
    ),
    "result": _THESIS["result"],
}
_KEYPOINTS: dict[StepKind, tuple[str, str, str]] = {
    **_MANIFOLD,
    "pairs": (
        "Measure",
        "There is no cloud. Each keypoint is compared with the picture of the point of the body "
        "that it names, and contours with those of the body. The weight of a keypoint falls with "
        "its distance; where three cameras agree, what contradicts them is left out.",
        "Not in the thesis; docs/keypoints.md",
    ),
    "correct": (
        "Correct",
        "The prediction is corrected by all keypoints and contours at once, linearised at the "
        "start of the iteration. Joint limits and the prediction itself contribute as well.",
        _MANIFOLD["correct"][2],
    ),
}
_IN_ITERATION: tuple[StepKind, ...] = ("points", "pairs", "sigma", "cross", "correct")
_OF_POINTS = frozenset[StepKind]({"points", "cross"})
"""Stages that are about points of a cloud alone."""


def steps_of(trace: StepTrace) -> tuple[Step, ...]:
    """All steps of a frame in their order."""
    cloudless = bool(trace.corrections) and not any(len(c.points.part) for c in trace.corrections)
    texts = _THESIS if trace.method == "thesis" else _KEYPOINTS if cloudless else _MANIFOLD
    steps = [_step("predict", texts, heading="Prediction")]
    kinds = [kind for kind in _IN_ITERATION if not cloudless or kind not in _OF_POINTS]
    for index, correction in enumerate(trace.corrections):
        for kind in kinds:
            heading = _heading_of(correction) if kind == kinds[0] else ""
            steps.append(_step(kind, texts, heading, index))
    if trace.measured:
        steps.append(_step("pairs", texts, "Estimate"))
        steps.append(_step("settle", texts))
    if trace.search is not None:
        steps.append(_step("search", texts, "After the iterations"))
    if trace.jump is not None:
        steps.append(_step("collisions", texts, "After the iterations"))
    steps.append(_step("result", texts, "" if len(steps) > 1 else "After the iterations"))
    return tuple(steps)


def _heading_of(correction: Correction) -> str:
    again = ", with prior inflation" if correction.stage == "again" else ""
    return f"Iteration {correction.iteration}{again}"


def name_of(step: Step, trace: StepTrace) -> str:
    """A step with its iteration: ``Iteration 2: Correct``."""
    if step.correction < 0:
        return step.title
    return f"{_heading_of(trace.corrections[step.correction])}: {step.title}"


def same_step(steps: tuple[Step, ...], like: Step) -> int:
    """Index of the step of another frame that corresponds to this one, or the nearest."""
    alike = ((one.kind, one.correction) == (like.kind, like.correction) for one in steps)
    return next((index for index, same in enumerate(alike) if same), len(steps) - 1)


def _step(
    kind: StepKind,
    texts: dict[StepKind, tuple[str, str, str]],
    heading: str = "",
    correction: int = -1,
) -> Step:
    title, words, source = texts[kind]
    return Step(kind, title, words, source, heading, correction)


_GREEK = {"alpha": "α", "beta": "β", "gamma": "γ"}
_TURNS = {"rx": "turn x", "ry": "turn y", "rz": "turn z", "tx": "turn x", "ty": "turn y"}


@dataclass(frozen=True)
class State:
    """One number of the state."""

    label: str
    limb: str
    unit: str
    factor: float


def states_of(names: tuple[str, ...]) -> tuple[State, ...]:
    """Labels and units of states by their names; the first three are positions."""
    found = []
    for index, name in enumerate(names):
        limb, _, axis = name.rpartition("_")
        said = _GREEK.get(axis, _TURNS.get(axis, axis))
        label = f"{limb_words(limb)} {said}"
        unit, factor = ("mm", 1e3) if index < 3 else ("°", float(np.degrees(1.0)))
        found.append(State(label, limb if limb in LIMBS else "", unit, factor))
    return tuple(found)


def part_words(part: int) -> str:
    """Name of a part as a person reads it."""
    return limb_words(PARTS[part]) if part >= 0 else "none"


def correlations_table(correction: Correction, names: tuple[str, ...]) -> Table:
    """For each state and part the strongest correlation with a pair of that part."""
    spread = np.outer(correction.before.sigma, np.sqrt(np.maximum(correction.P_zz, 0.0)))
    known = spread > 0.0
    correlation = np.where(known, correction.P_xz / np.where(known, spread, 1.0), 0.0)
    part, states = correction.points.part, states_of(names)
    parts = np.unique(part).tolist()
    strongest = [
        [row[part == one][np.abs(row[part == one]).argmax()] for one in parts]
        for row in correlation
    ]
    rows = tuple(
        (state.label, *(f"{value:+z.2f}" for value in values))
        for state, values in zip(states, strongest, strict=True)
    )
    title = "Strongest correlation of a state with a pair of each part"
    limbs = tuple(state.limb for state in states)
    words = [part_words(one) for one in parts]
    brief = (one.replace("left ", "L ").replace("right ", "R ") for one in words)
    tips = ("", *(f"Pairs of the {one}" for one in words))
    return Table(title, ("State", *brief), rows, limbs, tips=tips)


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

"""The steps of one frame's correction, in the method's words."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

from stereotrack_core.tracking.trace import Correction, StepTrace

StepKind: TypeAlias = Literal[
    "predict", "points", "pairs", "sigma", "cross", "correct", "settle", "search", "collisions",
    "result",
]  # fmt: skip


@dataclass(frozen=True, eq=False)
class Step:
    """One step.

    Attributes
    ----------
    kind : str
    title : str
    heading : str
        Of the first step of an iteration; empty elsewhere.
    words : str
        What happens, for somebody who learns the method.
    source : str
        Where the thesis has it, or what it takes the place of.
    correction : int
        Index into the trace's corrections; -1 for steps that belong to none.
    """

    kind: StepKind
    title: str
    words: str
    source: str
    heading: str = ""
    correction: int = -1


_THESIS: dict[StepKind, tuple[str, str, str]] = {
    "predict": (
        "Predict",
        "Nobody knows how the body will move, so it is expected to stay where it was. Only the "
        "uncertainty grows: the process noise Q is added to the covariance P.",
        "Section 3.2.1 and figure 3.8: x[k+1|k] = x[k|k], P[k+1|k] = P[k|k] + Q",
    ),
    "points": (
        "Sample",
        "Points are drawn from the cones of the model, as many from each. Those inside another "
        "cone and those that no camera can see are dropped, for nothing could be measured there.",
        "Equation (3.4), figure 3.5",
    ),
    "pairs": (
        "Correspondences",
        "Each model point looks for the nearest measured point. Both are projected on the line "
        "that joins them, so each pair gives one number: how far they are apart.",
        "Section 2.3, equations (3.5) to (3.8), figures 3.6 and 3.10",
    ),
    "sigma": (
        "Sigma points",
        "A few poses stand for the estimate and its uncertainty: the estimate itself and, for "
        "each direction in which it is uncertain, one pose on either side (thin outlines).",
        "Equations (2.12) to (2.14), figure 3.9",
    ),
    "cross": (
        "Cross-covariance",
        "P_xz: how a change of each state (rows) goes along with the number of each pair "
        "(columns). Orange: they grow together; blue: one grows as the other falls; none: that "
        "pair says nothing about that state.",
        "Equations (2.9) and (2.18), figure 3.14",
    ),
    "correct": (
        "Correct",
        "The residual, weighted by the gain K = P_xz P_νν⁻¹, corrects the state, and the "
        "covariance shrinks. Thin outlines: the model before.",
        "Section 3.2.3: x + Kν and P − K P_νν Kᵀ with P_νν = P_zz + R",
    ),
    "collisions": (
        "Collisions",
        "After the last iteration arms that came too near to the torso, or were folded too far, "
        "are set to where they keep the least distances. Thin outlines: the model before.",
        "Section 3.2.4, figure 3.15",
    ),
    "result": (
        "Result",
        "The pose of this frame. The next frame begins with it and with its covariance.",
        "Section 3.2.3: x[k+1|k+1], P[k+1|k+1]",
    ),
}

_MANIFOLD: dict[StepKind, tuple[str, str, str]] = {
    "predict": (
        "Predict",
        "The body is expected to stay, or to repeat a share of its last movement, and the "
        "uncertainty grows by the process noise Q.",
        "Section 3.2.1, figure 3.8; the states are small turns that no pose makes ambiguous",
    ),
    "points": (
        "Measure",
        "Measured points are drawn from the cloud. They look for the model, and not the model for "
        "them as in the thesis: a lost arm then has data that pull at it.",
        "In the place of equation (3.4)",
    ),
    "pairs": (
        "Correspondences",
        "Each measured point is given to the nearest cone and compared along the normal of the "
        "surface there. The farther it is, the less it counts; beyond the reach it counts nothing.",
        "In the place of equations (3.5) to (3.8)",
    ),
    "sigma": (
        "Sigma points",
        "Poses that stand for the estimate and its uncertainty (thin outlines). This tracker "
        "linearises by them, around the pose that the iteration begins with.",
        "Equations (2.12) to (2.14), figure 3.9",
    ),
    "cross": (
        "Cross-covariance",
        "P_xz: how a change of each state (rows) goes along with the number of each pair "
        "(columns). Orange: they grow together; blue: one grows as the other falls; none: that "
        "pair says nothing about that state.",
        "Equation (2.11), P_xz = P Hᵀ; figure 3.14",
    ),
    "correct": (
        "Correct",
        "The frame's prediction is corrected by all pairs at once, linearised where the iteration "
        "began; limits of joints, other sensors and the prediction itself pull as well.",
        "Section 3.2.3, iterated by posterior linearisation (DOI 10.1109/TSP.2015.2454485)",
    ),
    "settle": (
        "Settle",
        "This tracker finds its pose in a way of its own, without a cross-covariance. Thin "
        "outlines: the prediction.",
        "Named in the thesis as another way; measured against for comparison",
    ),
    "search": (
        "Search for the arms",
        "Many other places for both arms are scored, the best pairs are refined, and one of them "
        "is taken if it explains the frame clearly better. Thin outlines: pairs not taken.",
        "Not in the thesis, whose section 3.2.4 tells of arms that stay caught at other parts",
    ),
    "result": (
        "Result",
        "The pose of this frame. The next frame begins with it and with its covariance.",
        "Section 3.2.3: x[k+1|k+1], P[k+1|k+1]",
    ),
}
_PICTURED = (
    "Poses that stand for the estimate and its uncertainty (thin outlines). This tracker "
    "linearises by derivatives instead; they only picture what it is uncertain about."
)
_IN_ITERATION: tuple[StepKind, ...] = ("points", "pairs", "sigma", "cross", "correct")


def steps_of(trace: StepTrace) -> tuple[Step, ...]:
    """All steps of a frame in their order."""
    texts = _THESIS if trace.method == "thesis" else _MANIFOLD
    steps = [_step("predict", texts, heading="Prediction")]
    for index, correction in enumerate(trace.corrections):
        heading = heading_of(correction)
        for kind in _IN_ITERATION:
            steps.append(_step(kind, texts, heading, index, pictured=_pictures(correction)))
            heading = ""
    if trace.measured:
        steps.append(_step("pairs", texts, "Estimate"))
        steps.append(_step("settle", texts))
    if trace.search is not None:
        steps.append(_step("search", texts, "After the iterations"))
    if trace.jump is not None:
        steps.append(_step("collisions", texts, "After the iterations"))
    steps.append(_step("result", texts, "" if len(steps) > 1 else "After the iterations"))
    return tuple(steps)


def heading_of(correction: Correction) -> str:
    """Name of an iteration."""
    again = ", from a wider prior" if correction.stage == "again" else ""
    return f"Iteration {correction.iteration}{again}"


def name_of(step: Step, trace: StepTrace) -> str:
    """A step with its iteration: ``Iteration 2: Correct``."""
    if step.correction < 0:
        return step.title
    return f"{heading_of(trace.corrections[step.correction])}: {step.title}"


def same_step(steps: tuple[Step, ...], like: Step) -> int:
    """Index of the step of another frame that corresponds to this one, or the nearest."""
    for index, step in enumerate(steps):
        if (step.kind, step.correction) == (like.kind, like.correction):
            return index
    return len(steps) - 1


def _pictures(correction: Correction) -> bool:
    return not correction.sigma_points.used


def _step(
    kind: StepKind,
    texts: dict[StepKind, tuple[str, str, str]],
    heading: str = "",
    correction: int = -1,
    *,
    pictured: bool = False,
) -> Step:
    title, words, source = texts[kind]
    if kind == "sigma" and pictured:
        words = _PICTURED
    return Step(kind, title, words, source, heading, correction)

"""How accurate a run is against a reference, and how good that is by its own account."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from stereotrack_core.annotation.reference import Reference
from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.body.limbs import LIMB_ENDS, LIMBS
from stereotrack_core.evaluation.summary import (
    Doubts,
    LimbErrors,
    Sigmas,
    Summary,
    doubts_against,
    errors_against,
    points_at,
    root_mean,
    summarise,
    summarise_segments,
)
from stereotrack_core.recording.description import Segment
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory
from stereotrack_core.tracking.frame import Run


@dataclass(frozen=True)
class Accuracy:
    """Errors against a reference."""

    errors: LimbErrors
    summary: Summary
    segments: tuple[Summary, ...]  # of every segment
    quality: Mapping[str, float]  # how good the reference is, as far as it says
    doubts: Doubts | None  # whether limbs taken for lost are lost; None if it does not say


def accuracy_of(
    found: Run | LandmarkTrajectory,
    reference: LandmarkTrajectory,
    states: Reference | None = None,
    segments: Sequence[Segment] = (),
    frames: range | None = None,
    *,
    weigh: bool = False,
) -> Accuracy:
    """Measure a run, or landmarks alone; `states` is the reference with its uncertainty.

    With `weigh` errors count by that uncertainty; see :func:`summarise`.
    """
    run, trajectory = (found, found.trajectory()) if isinstance(found, Run) else (None, found)
    errors = errors_against(trajectory, reference)
    if frames is not None:
        errors = errors.between(frames.start, frames.stop)
    sigmas = None
    if states is not None:
        sigmas = stated_sigmas(states, errors.frame, points_at(reference, errors.frame))
    doubts = None if run is None else doubts_against(run.frame, run.limb_lost, errors)
    return Accuracy(
        errors=errors,
        summary=summarise(errors, sigmas=sigmas if weigh else None),
        segments=summarise_segments(errors, segments, sigmas if weigh else None),
        quality=_root_means(sigmas or {}),
        doubts=doubts if doubts is not None and doubts.judged else None,
    )


_ARMS = ("left_upper_arm", "right_upper_arm", "left_forearm", "right_forearm")
_OF_LIMBS: dict[str, tuple[str, ...]] = {
    "torso_long": ("torso",),
    "upper_arms": _ARMS[:2],
    "forearms": _ARMS[2:],
    **{arm: (arm,) for arm in _ARMS},
}
"""Limbs whose stated angle belongs to a measure."""


def arms_good_to(quality: Mapping[str, float]) -> float:
    """Root mean square over the four arm segments, degrees; NaN where it is not known."""
    squares = [quality[arm] ** 2 for arm in _ARMS if arm in quality]
    return float(np.sqrt(np.mean(squares))) if squares else float("nan")


def reference_quality(reference: Reference, frames: IntArray) -> dict[str, float]:
    """Root mean square error that the reference states for itself in some frames, by measure.

    Of :func:`stated_sigmas`.
    """
    there = frames[np.isin(frames, reference.frame)]
    points = points_at(reference.trajectory(), there)
    return _root_means(stated_sigmas(reference, there, points))


def _root_means(sigmas: Sigmas) -> dict[str, float]:
    values = {measure: root_mean(np.square(own)) for measure, own in sigmas.items()}
    return {measure: value for measure, value in values.items() if np.isfinite(value)}


def stated_sigmas(reference: Reference, frames: IntArray, points: FloatArray) -> Sigmas:
    """Errors (F, k) that the reference states for itself, by measure; NaN where not known.

    `points` (F, 9, 3) are its landmarks in these frames of it, NaN if they shall not count.
    Millimetres for ``torso_position``, degrees else; shoulders are taken for independent.
    """
    rows = np.searchsorted(reference.frame, frames)
    known = np.asarray(np.isfinite(points).all(axis=2))
    sigmas: dict[str, FloatArray] = {}
    if reference.covariance is not None:
        covariance = reference.of_the_nine(reference.covariance[rows])
        covariance[~known] = np.nan
        hips = covariance[:, _places("hip")].mean(axis=1)
        sigmas["torso_position"] = 1000.0 * np.sqrt(np.trace(hips, axis1=1, axis2=2))
        left, right = _places("shoulder")
        axis = points[:, right] - points[:, left]
        length = np.linalg.norm(axis, axis=1)
        unit = axis / np.where(length > 0, length, np.nan)[:, None]
        both = covariance[:, left] + covariance[:, right]
        across = np.trace(both, axis1=1, axis2=2) - np.einsum("fi,fij,fj->f", unit, both, unit)
        sigmas["torso_cross"] = np.degrees(np.sqrt(across / np.square(length)))
    if reference.limb_sigma_deg is not None:
        sigma = reference.limb_sigma_deg[rows]
        for i, limb in enumerate(LIMBS):
            ends = [LANDMARKS.index(name) for end in LIMB_ENDS[limb] for name in end]
            sigma[~known[:, ends].all(axis=1), i] = np.nan
        for measure, limbs in _OF_LIMBS.items():
            sigmas[measure] = sigma[:, [LIMBS.index(limb) for limb in limbs]]
    return sigmas


def stated_means(accuracy: Accuracy) -> list[str]:
    """``forearms 5.6 deg, of which the reference's own is 1.1`` and so on, of main measures."""
    return [
        f"{one.label} {stated(one.statistics.mean, one.unit, accuracy.quality, one.name)}"
        for one in accuracy.summary.measures
        if one.name in ("torso_long", "torso_cross", "upper_arms", "forearms")
    ]


def stated(error: float, unit: str, quality: Mapping[str, float], measure: str) -> str:
    """``5.6 deg, of which the reference's own is 1.1``; without that if it does not say."""
    text = f"{error:.1f} {unit}" if np.isfinite(error) else f"- {unit}"
    good = quality.get(measure)
    return text if good is None else f"{text}, of which the reference's own is {good:.1f}"


def _places(joint: str) -> list[int]:
    return [LANDMARKS.index(f"{side}_{joint}") for side in ("left", "right")]


def accuracy_facts(accuracy: Accuracy) -> dict[str, Any]:
    """The accuracy for JSON."""
    facts = error_facts(accuracy.summary)
    for name, good in accuracy.quality.items():
        facts["measures"][name]["reference_good_to"] = good
    if (doubts := accuracy.doubts) is not None:
        told = {"judged": doubts.judged, "lost": doubts.lost, "called_lost": doubts.called}
        facts["lost_limbs"] = {**told, "precision": doubts.precision, "recall": doubts.recall}
    return facts


def error_facts(summary: Summary) -> dict[str, Any]:
    """Errors of one stretch for JSON."""
    return {
        "name": summary.name,
        "frames": summary.frames,
        "not_tracked": summary.not_tracked,
        "lost_percent": 100.0 * summary.lost,
        "measures": {
            measure.name: {"unit": measure.unit, **asdict(measure.statistics)}
            for measure in summary.measures
        },
    }

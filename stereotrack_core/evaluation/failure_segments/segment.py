"""Failures: stretches of frames in which limbs fail, how they are found, their probable causes.

A value is high with hysteresis, bridged gaps and a least length.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations
from types import MappingProxyType
from typing import Literal, TypeAlias

import numpy as np
import scipy
from numpy.lib.stride_tricks import sliding_window_view

from stereotrack_core.arrays import FloatArray, IntArray, stretches_of
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.skeleton import FOREARMS, TORSO, UPPER_ARMS
from stereotrack_core.evaluation.failure_segments import coefficients
from stereotrack_core.evaluation.failure_segments.reasons import Reason
from stereotrack_core.evaluation.limbs import limb_ends
from stereotrack_core.evaluation.summary import LimbErrors
from stereotrack_core.geometry.rotation import angle_between
from stereotrack_core.parameters import ParameterGroup, Value, parameter
from stereotrack_core.tracking.failure.features import NEIGHBOUR
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.parameters import TrackingParameters

Cause: TypeAlias = Literal[
    "crossing", "torso", "fast", "hidden", "hole", "neighbour", "calibration", "initialisation",
    "unclear",
]  # fmt: skip
Found: TypeAlias = Literal["truth", "signs"]
Measure: TypeAlias = Literal["error", "chance"]

CAUSE_WORDS: MappingProxyType[Cause, str] = MappingProxyType(
    {
        "crossing": "arms crossing",
        "torso": "arm close to the torso",
        "fast": "arm moving too fast",
        "hidden": "occluded in the views",
        "hole": "hole in the cloud of a view",
        "neighbour": "points of another object nearby",
        "calibration": "a view inconsistent with the others",
        "initialisation": "wrong initialisation",
        "unclear": "no clear cause",
    }
)
"""Every cause, as a person reads it."""

_ARMS = ("search_proposals", "second_look", "picture_cost")
_POINTS_TO: MappingProxyType[Cause, tuple[str, ...]] = MappingProxyType(
    {
        "crossing": (*_ARMS, "arms_apart", "keypoint_cost"),
        "torso": ("clearance", "loss_scale", "picture_cost"),
        "fast": ("sigma_joint", "prior_inflation_above", "iterations"),
        "hidden": ("silhouette_sigma", "second_look", "keypoint_cost"),
        "hole": ("background_threshold", "speckle_size", "max_correspondence_distance"),
        "neighbour": ("max_correspondence_distance", "outlier_distance"),
        "calibration": ("leave_out_views", "sigma_measurement"),
        "initialisation": ("fit_shape", *_ARMS),
        "unclear": (*_ARMS, "sigma_joint"),
    }
)
"""Parameters that a cause points to."""


def idle_parameters(stated: Mapping[str, Value]) -> frozenset[str]:
    """Parameters of what these values switch off, of those that causes and reasons point to."""
    idle = set[str]() if stated.get("measure_silhouettes", True) else {"silhouette_sigma"}
    searches = stated.get("search_arms", True) and stated.get("estimator") in (None, "iterated")
    thesis = stated.get("matching") == "model_to_data"  # has only what the thesis decides
    for row in TrackingParameters.rows():
        left_open = not row.thesis or row.thesis == "off"
        if (row.group == "Arm search" and not searches) or (thesis and left_open):
            idle.add(row.name)
    return frozenset(idle)


FOUND_WORDS: MappingProxyType[Found, str] = MappingProxyType(
    {"truth": "by error", "signs": "by failure probability"}
)


@dataclass(frozen=True)
class Evidence:
    """One thing that speaks for a cause."""

    cause: Cause
    strength: float  # from 0, nothing, to 1, as much as it can
    value: float  # the measurement, in `unit`
    unit: str
    words: str  # the same as a sentence with its number


@dataclass(frozen=True)
class Verdict:
    """The probable cause of a failure."""

    cause: Cause
    confidence: float  # strength of its evidence over that of all causes and of not knowing
    evidence: tuple[Evidence, ...] = ()  # for all causes, the strongest first

    @property
    def words(self) -> str:
        """The cause in words, with what speaks most for it."""
        reason = next((e.words for e in self.evidence if e.cause == self.cause), "")
        return f"{CAUSE_WORDS[self.cause]}: {reason}" if reason else CAUSE_WORDS[self.cause]


UNCLEAR = Verdict("unclear", 0.0)


@dataclass(frozen=True)
class FailureSegment:
    """A stretch of frames in which limbs fail."""

    first: int
    last: int  # `first` and `last`: frames, both included
    limbs: tuple[str, ...]  # names in ``LIMBS``, in their order
    found: Found  # whether it was found by errors against a reference or without one
    measure: Measure  # of `peak`: degrees, or the probability that the limb is lost
    peak: float
    peak_frame: int
    peak_limb: str
    error_deg: float | None = None  # largest error of its limbs, where a reference is known
    chance: float | None = None  # largest probability that one of them is lost, where known
    verdict: Verdict = field(default=UNCLEAR)
    reason: Reason | None = None  # what the search did where it begins; None if nobody has looked
    idle: frozenset[str] = frozenset()  # parameters that do nothing in the run's settings

    @property
    def frames(self) -> range:
        """Frame numbers from the first to the last one."""
        return range(self.first, self.last + 1)

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of parameters that its reason and its cause point to, the likeliest first."""
        own = () if self.reason is None else self.reason.parameters
        names = dict.fromkeys((*own, *_POINTS_TO[self.verdict.cause]))
        return tuple(name for name in names if name not in self.idle)

    @property
    def peak_words(self) -> str:
        """``62°`` or ``93 %``."""
        return f"{self.peak:.0f}°" if self.measure == "error" else f"{100.0 * self.peak:.0f} %"

    def overlaps(self, other: FailureSegment) -> bool:
        """Whether both share a frame and a limb."""
        together = self.first <= other.last and other.first <= self.last
        return together and not set(self.limbs).isdisjoint(other.limbs)


def limbs_words(limbs: tuple[str, ...]) -> str:
    """``left arm, right forearm``: both halves of an arm are an arm."""
    words = []
    for limb in sorted(limbs, key=LIMBS.index):
        side, _, part = limb.partition("_")
        if part == "upper_arm" and f"{side}_forearm" in limbs:
            words.append(f"{side} arm")
        elif not (part == "forearm" and f"{side}_upper_arm" in limbs):
            words.append(limb.replace("_", " "))
    return ", ".join(words)


FAILURE_COLUMNS = (
    *("frames", "seconds", "limbs", "detected by", ">error [deg]", ">probability [%]"),
    *("cause", ">sure [%]", "why", "description"),
)


def failure_rows(failures: Sequence[FailureSegment], fps: float) -> list[tuple[str, ...]]:
    """Cells of failures under :data:`FAILURE_COLUMNS`; what is not known is empty."""
    return [
        (
            f"{e.first}-{e.last}",
            f"{e.first / fps:.1f}-{(e.last + 1) / fps:.1f}",
            limbs_words(e.limbs),
            e.found,
            "" if e.error_deg is None else f"{e.error_deg:.0f}",
            "" if e.chance is None else f"{100.0 * e.chance:.0f}",
            e.verdict.cause,
            f"{100.0 * e.verdict.confidence:.0f}" if e.verdict.confidence else "",
            "" if e.reason is None else e.reason.brief,
            e.verdict.words,
        )
        for e in failures
    ]


_GROUP = "Failures"


@dataclass(frozen=True)
class FailureRules(ParameterGroup):
    """From which error, for how long, and what is taken together."""

    episode_error: float = parameter(45.0, _GROUP, (1.0, 180.0), unit="deg")(
        "Error of a limb's direction at which a failure begins."
    )
    episode_chance: float = parameter(0.55, _GROUP, (0.01, 0.99))(
        "Failure probability of a limb at which a failure begins, if there is no reference."
    )
    episode_least: float = parameter(0.3, _GROUP, (0.0, 60.0), unit="s")(
        "Minimum duration of a failure."
    )
    episode_bridge: float = parameter(0.5, _GROUP, (0.0, 60.0), unit="s")(
        "Gaps within a failure that are shorter than this are bridged."
    )


@dataclass(frozen=True)
class Stretch:
    """Frames from the first to the last one, both included, and where the value is highest."""

    first: int
    last: int
    peak: float
    peak_frame: int


def high_stretches(
    frame: IntArray, value: FloatArray, enter: float, leave: float, least: int, bridge: int
) -> list[Stretch]:
    """Stretches of at least `least` frames (F,) in which a value is high; NaN is not.

    One begins above `enter`, reaches to where it falls below `leave`, and is joined to the next one
    over gaps of at most `bridge` frames.
    """
    with np.errstate(invalid="ignore"):
        seed, high = value > enter, value > leave
    found: list[range] = []
    for run in stretches_of(high, frame):
        if seed[run.start : run.stop].any():
            close = found and frame[run[0]] - frame[found[-1][-1]] - 1 <= bridge
            found.append(range(found.pop().start, run.stop) if close else run)
    stretches = []
    for first, last in ((run[0], run[-1]) for run in found):
        if frame[last] - frame[first] + 1 >= least:
            peak = first + int(np.nanargmax(value[first : last + 1]))
            ends = int(frame[first]), int(frame[last])
            stretches.append(Stretch(*ends, float(value[peak]), int(frame[peak])))
    return stretches


_ENDS_BELOW_ERROR, _ENDS_BELOW_CHANCE = 0.75, 0.5  # share of the beginning's value at which it ends
_TOGETHER = 0.5  # share of common frames from which stretches of different arms are one failure


def joined(
    stretches: Mapping[str, Sequence[Stretch]], found: Found, measure: Measure
) -> tuple[FailureSegment, ...]:
    """Failures of stretches by limb, in the order of their first frames.

    Stretches of one arm are one failure where they share a frame, others where they share half.
    """
    every = [(limb, stretch) for limb in LIMBS for stretch in stretches.get(limb, ())]
    both = combinations(enumerate(every), 2)
    pairs = [(i, j) for (i, one), (j, other) in both if _belong(one, other)]
    links = np.array(pairs, dtype=np.int64).reshape(-1, 2).T
    size = (len(every),) * 2
    graph = scipy.sparse.coo_array((np.ones(len(pairs)), (links[0], links[1])), shape=size)
    grouped = scipy.sparse.csgraph.connected_components
    count, label = grouped(graph, directed=False) if every else (0, [])
    failures = [
        _failure([each for each, own in zip(every, label, strict=True) if own == k], found, measure)
        for k in range(count)
    ]
    return tuple(sorted(failures, key=lambda e: (e.first, e.last, e.limbs)))


def _belong(one: tuple[str, Stretch], other: tuple[str, Stretch]) -> bool:
    (limb, a), (other_limb, b) = one, other
    shared = min(a.last, b.last) - max(a.first, b.first) + 1
    if shared <= 0 or limb == other_limb:
        return False
    if _arm(limb) is not None and _arm(limb) == _arm(other_limb):
        return True
    either = a.last - a.first + b.last - b.first + 2 - shared
    return shared >= _TOGETHER * either


def _arm(limb: str) -> str | None:
    side, _, part = limb.partition("_")
    return side if part in {"upper_arm", "forearm"} else None


def _failure(
    members: Sequence[tuple[str, Stretch]], found: Found, measure: Measure
) -> FailureSegment:
    limb, worst = max(members, key=lambda member: member[1].peak)
    return FailureSegment(
        first=min(stretch.first for _, stretch in members),
        last=max(stretch.last for _, stretch in members),
        limbs=tuple(name for name in LIMBS if any(name == own for own, _ in members)),
        found=found,
        measure=measure,
        peak=worst.peak,
        peak_frame=worst.peak_frame,
        peak_limb=limb,
    )


def _of_limbs(
    frame: IntArray, value: FloatArray, levels: tuple[float, float], fps: float, rules: FailureRules
) -> dict[str, list[Stretch]]:
    """High stretches of values (F, 6), which begin at a level and end at a share of it."""
    enter, share = levels
    least, bridge = round(rules.episode_least * fps), round(rules.episode_bridge * fps)
    limits = (enter, share * enter, max(1, least), bridge)
    return {limb: high_stretches(frame, value[:, i], *limits) for i, limb in enumerate(LIMBS)}


def failures_by_error(
    errors: LimbErrors, fps: float, rules: FailureRules | None = None
) -> tuple[FailureSegment, ...]:
    """Stretches in which the error of a limb's direction exceeds the threshold long enough."""
    rules = rules or FailureRules()
    levels = rules.episode_error, _ENDS_BELOW_ERROR
    stretches = _of_limbs(errors.frame, errors.degrees, levels, fps, rules)
    return joined(stretches, "truth", "error")


SIGNS: tuple[str, ...] = (
    *("turned before", "turns after"),
    *("lost around", "lost most around", "lost of the neighbour"),
)
"""Signs of a limb, in the order of the coefficients."""

_AROUND = 0.35  # seconds before and after a frame that count as around it
_ENDS = 1.0  # seconds before and after a frame within which a limb that goes astray turns abruptly


def failure_signs(run: Run, fps: float) -> FloatArray:
    """Signs (F, 6, S) of the limbs in each frame of a run, in the order of :data:`SIGNS`.

    Logarithms of the largest turn of the limb within a second before and after, as it goes astray
    abruptly; mean and largest logit of being lost around, and the neighbour's mean. NaN in frames
    that are not tracked, and for torso and head.
    """
    around, ends = 2 * max(1, round(_AROUND * fps)) + 1, max(1, round(_ENDS * fps))
    turn = np.log1p(np.nan_to_num(turns(run.frame.astype(np.float64), run.landmarks)))
    chance = np.clip(np.nan_to_num(run.limb_lost, nan=0.5), 1e-3, 1.0 - 1e-3)
    lost = np.log(chance / (1.0 - chance))
    mean = scipy.ndimage.uniform_filter1d(lost, around, axis=0, mode="nearest")
    largest = scipy.ndimage.maximum_filter1d(lost, around, axis=0, mode="nearest")
    before, after = _largest_before(turn, ends), _largest_before(turn[::-1], ends)[::-1]
    signs = np.stack([before, after, mean, largest, mean[:, list(NEIGHBOUR)]], axis=-1)
    signs[~run.tracked] = np.nan
    signs[:, [i for i in range(len(LIMBS)) if i not in (*UPPER_ARMS, *FOREARMS)]] = np.nan
    return signs


def _largest_before(values: FloatArray, frames: int) -> FloatArray:
    """Largest of each value (F, 6) and of the `frames` before it; none is below 0."""
    padded = np.pad(values, ((frames, 0), (0, 0)))
    return np.asarray(sliding_window_view(padded, frames + 1, axis=0).max(axis=-1))


ARM_HALVES: MappingProxyType[str, tuple[int, ...]] = MappingProxyType(
    {"UPPER_ARM": UPPER_ARMS, "FOREARM": FOREARMS}
)
"""Limbs that are judged alike, by the name of their coefficients."""

Coefficients: TypeAlias = Mapping[str, Sequence[float]]  # a constant and a slope per sign
_FITTED: Coefficients = MappingProxyType({half: getattr(coefficients, half) for half in ARM_HALVES})


def has_signs(run: Run) -> bool:
    """Whether a run says how likely its limbs are lost; one of mono views does not."""
    return bool(np.isfinite(run.limb_lost[run.tracked]).any())


def lost_chances(run: Run, fps: float, fitted: Coefficients = _FITTED) -> FloatArray:
    """Probability (F, 6) that each limb is in a failure by its error, by a run's own signs.

    A logistic regression over :func:`failure_signs`, fitted on simulated recordings by
    ``tools/fit_failures.py``. Unlike ``Run.limb_lost`` it looks at what is before and after. In
    frames that are not tracked all limbs fail; NaN for torso and head elsewhere, and in runs
    without signs.
    """
    signs = failure_signs(run, fps)
    result: FloatArray = np.full((len(run.frame), len(LIMBS)), np.nan)
    for half, limbs in ARM_HALVES.items() if has_signs(run) else ():
        constant, *slopes = fitted[half]
        own = list(limbs)
        result[:, own] = scipy.special.expit(constant + signs[:, own] @ np.array(slopes))
    for limb in (TORSO, *UPPER_ARMS, *FOREARMS):
        result[~run.tracked, limb] = 1.0
    return result


def failures_by_signs(
    run: Run, fps: float, rules: FailureRules | None = None, fitted: Coefficients | None = None
) -> tuple[FailureSegment, ...]:
    """Stretches in which a limb probably fails, or is not tracked, by :func:`lost_chances`."""
    rules = rules or FailureRules()
    chance = lost_chances(run, fps) if fitted is None else lost_chances(run, fps, fitted)
    levels = rules.episode_chance, _ENDS_BELOW_CHANCE
    stretches = _of_limbs(run.frame, chance, levels, fps, rules)
    return joined(stretches, "signs", "chance")


def turns(frame: FloatArray, points: FloatArray) -> FloatArray:
    """Degrees (F, 6) by which limbs of landmarks (F, 9, 3) turned since the frame before."""
    start, end = np.moveaxis(limb_ends(points), 2, 0)
    axis = end - start
    result: FloatArray = np.zeros(axis.shape[:2])
    if len(axis) > 1:
        turned = np.degrees(angle_between(axis[1:], axis[:-1]))
        result[1:] = np.where((np.diff(frame) == 1)[:, None], turned, 0.0)
    return result

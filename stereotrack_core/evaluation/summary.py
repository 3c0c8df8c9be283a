"""Errors pooled over frames: mean, median, 95th percentile, share of lost arm segments."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.body.skeleton import FOREARMS, UPPER_ARMS
from stereotrack_core.evaluation.errors import LimbErrors, errors_against
from stereotrack_core.recording.description import Segment
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.tracking.frame import Run

LOST_ANGLE = np.deg2rad(45.0)
"""An arm segment farther off than this is lost."""


ERROR_MEASURES: tuple[tuple[str, str, str], ...] = (
    ("torso_position", "torso position", "mm"),
    ("torso_long", "torso long axis", "deg"),
    ("torso_cross", "torso cross axis", "deg"),
    ("upper_arms", "upper arms", "deg"),
    ("forearms", "forearms", "deg"),
    ("left_upper_arm", "left upper arm", "deg"),
    ("right_upper_arm", "right upper arm", "deg"),
    ("left_forearm", "left forearm", "deg"),
    ("right_forearm", "right forearm", "deg"),
)
"""Name, label for people and unit of all that errors are told in."""


@dataclass(frozen=True)
class Statistics:
    """Mean, median and 95th percentile of one measure; NaN where nothing was scored."""

    mean: float
    median: float
    p95: float
    count: int


@dataclass(frozen=True)
class Measure:
    """One row of the error table."""

    name: str
    """Key, for example ``"left_forearm"``."""
    label: str
    """Name for people."""
    unit: str
    """``"mm"`` or ``"deg"``: tables are what a person reads."""
    statistics: Statistics
    """In `unit`."""


@dataclass(frozen=True)
class Summary:
    """Errors of one stretch of frames."""

    name: str
    """The segment, or ``"all"``."""
    frames: int
    """Frames that the reference knows."""
    not_tracked: int
    """Frames among them in which the run has no landmark."""
    measures: tuple[Measure, ...]
    """Torso position, long axis, cross axis, upper arms, forearms, then each arm alone."""
    lost: float
    """Share (0 to 1) of arm segments more than 45 degrees off; NaN where none was scored."""

    def measure(self, name: str) -> Measure:
        """Return the measure of that name; KeyError where there is none."""
        return {measure.name: measure for measure in self.measures}[name]


def evaluate(
    found: Run | LandmarkTrajectory, reference: LandmarkTrajectory, frames: range | None = None
) -> Summary:
    """Errors of a run against a reference, as the thesis measures them.

    Frames of the reference that the run lacks, or in which it has no pose, count 90 degrees and
    500 mm.

    Parameters
    ----------
    reference : LandmarkTrajectory
        Taken as truth; what it does not know is not scored.
    frames : range, optional
        Frames that count; all when not given.

    Examples
    --------
    >>> recording = open_recording(Path("recording"))
    >>> summary = evaluate(read_run(Path("run.npz")), recording.reference)
    >>> summary.measure("forearms").statistics.mean  # degrees
    9.1
    """
    trajectory = found.trajectory() if isinstance(found, Run) else found
    errors = errors_against(trajectory, reference)
    return summarise(errors if frames is None else errors.between(frames.start, frames.stop))


def summarise(errors: LimbErrors, name: str = "all") -> Summary:
    """Pool the errors over all frames, both arms together and each alone."""
    values, arms = values_of(errors), errors.arm_segments
    return Summary(
        name=name,
        frames=len(errors.frame),
        not_tracked=int(np.count_nonzero(~errors.tracked)),
        measures=tuple(
            Measure(key, label, unit, statistics(values[key]))
            for key, label, unit in ERROR_MEASURES
        ),
        lost=statistics(np.where(np.isnan(arms), np.nan, arms > LOST_ANGLE)).mean,
    )


def values_of(errors: LimbErrors) -> dict[str, FloatArray]:
    """Values (F,), or (F, 2) of both sides, of all :data:`ERROR_MEASURES` in their units."""
    upper, fore = np.rad2deg(errors.upper_arm), np.rad2deg(errors.forearm)
    return {
        "torso_position": 1000.0 * errors.torso_position,
        "torso_long": np.rad2deg(errors.torso_long),
        "torso_cross": np.rad2deg(errors.torso_cross),
        "upper_arms": upper,
        "forearms": fore,
        "left_upper_arm": upper[:, 0],
        "right_upper_arm": upper[:, 1],
        "left_forearm": fore[:, 0],
        "right_forearm": fore[:, 1],
    }


def summarise_segments(errors: LimbErrors, segments: Sequence[Segment]) -> tuple[Summary, ...]:
    """One summary for each named stretch, in their order."""
    return tuple(summarise(errors.between(s.first, s.end), s.name) for s in segments)


def statistics(values: FloatArray) -> Statistics:
    """Statistics of the values that are not NaN."""
    known = values[~np.isnan(values)]
    if not known.size:
        return Statistics(np.nan, np.nan, np.nan, 0)
    median, p95 = np.percentile(known, [50, 95])
    return Statistics(float(known.mean()), float(median), float(p95), int(known.size))


@dataclass(frozen=True)
class Spread:
    """Mean over runs, seeds or recordings, and the standard deviation; NaN where not known."""

    mean: float = float("nan")
    deviation: float = float("nan")

    @staticmethod
    def of(values: Iterable[float]) -> Spread:
        """Of the values that are finite; a single one has no deviation."""
        known = np.array([value for value in values if np.isfinite(value)])
        if not known.size:
            return Spread()
        return Spread(float(known.mean()), float(known.std(ddof=1)) if known.size > 1 else np.nan)

    def text(self, digits: int = 1) -> str:
        """``32.1 ± 0.8``."""
        if not np.isfinite(self.mean):
            return "-"
        deviation = f" ± {self.deviation:.{digits}f}" if np.isfinite(self.deviation) else ""
        return f"{self.mean:.{digits}f}{deviation}"


def root_mean(squares: FloatArray) -> float:
    """Root of the mean of the squares that are not NaN; NaN where there is none."""
    return float(np.sqrt(statistics(squares).mean))


CALLED = 0.5
"""Probability above which a limb is called lost."""


@dataclass(frozen=True)
class Doubts:
    """Counts of arm segments of tracked frames."""

    judged: int
    """Arm segments of which both the error and the run's own judgement are known."""
    lost: int
    called: int
    both: int
    """`lost`, `called` and `both`: really lost, called lost by the run, and both."""

    @property
    def precision(self) -> float:
        """Share of those called lost that are lost; NaN where none is called lost."""
        return self.both / self.called if self.called else float("nan")

    @property
    def recall(self) -> float:
        """Share of those lost that are called lost; NaN where none is lost."""
        return self.both / self.lost if self.lost else float("nan")


def doubts_against(frame: IntArray, limb_lost: FloatArray, errors: LimbErrors) -> Doubts:
    """Compare a run's own judgement with its errors.

    Parameters
    ----------
    frame : (F,) int64
        Of the run.
    limb_lost : (F, 6) float64
        Probabilities in the order of ``LIMBS``; NaN where not known.
    errors : LimbErrors
        Of the same run.
    """
    _, own, other = np.intersect1d(frame, errors.frame, return_indices=True)
    chance = limb_lost[own][:, [*UPPER_ARMS, *FOREARMS]]
    angle = errors.arm_segments[other]
    known = np.isfinite(chance) & np.isfinite(angle)
    lost, called = (angle > LOST_ANGLE) & known, (chance > CALLED) & known
    counts = (np.count_nonzero(rows) for rows in (known, lost, called, lost & called))
    return Doubts(*(int(count) for count in counts))


ALL_ARMS = "all_arm_segments"
"""Name of the row that pools both upper arms and both forearms."""


@dataclass(frozen=True)
class LimbStatistics(Statistics):
    """Numbers of one limb; NaN where nothing is known. In the unit of the values."""

    limb: str
    """A limb, or :data:`ALL_ARMS`."""
    maximum: float
    above: float
    """Share (0 to 1) of them above the threshold."""
    lost: float
    """Share (0 to 1) of them in which the limb is lost; NaN where that is not known."""


def limb_statistics(
    values: Mapping[str, FloatArray], lost: Mapping[str, FloatArray], threshold: float
) -> tuple[LimbStatistics, ...]:
    """Statistics of every limb, and of all arm segments together as the last row.

    Parameters
    ----------
    values : mapping from limb to (F,) float64
        Errors, or standard deviations; NaN where not known.
    lost : mapping from limb to (F,) float64
        1 where the limb is lost, 0 where not, NaN where that is not known; limbs may be missing.
    """
    rows = [_limb_row(limb, own, lost.get(limb), threshold) for limb, own in values.items()]
    arms = [limb for limb in values if limb.endswith(("upper_arm", "forearm"))]
    if arms:
        gone = [lost[limb] for limb in arms if limb in lost]
        pooled = np.concatenate(gone) if len(gone) == len(arms) else None
        rows.append(
            _limb_row(ALL_ARMS, np.concatenate([values[a] for a in arms]), pooled, threshold)
        )
    return tuple(rows)


def _limb_row(
    limb: str, values: FloatArray, lost: FloatArray | None, threshold: float
) -> LimbStatistics:
    known = values[np.isfinite(values)]
    nan = float("nan")
    gone = np.empty(0) if lost is None else lost[np.isfinite(lost)]
    return LimbStatistics(
        **vars(statistics(known)),
        limb=limb,
        maximum=float(known.max()) if len(known) else nan,
        above=float(np.mean(known > threshold)) if len(known) else nan,
        lost=float(np.mean(gone)) if len(gone) else nan,
    )

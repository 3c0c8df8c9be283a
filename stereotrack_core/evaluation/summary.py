"""Errors pooled over frames: mean, median, 95th percentile, share of lost arm segments."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray
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
    """One row of the error table.

    Attributes
    ----------
    name : str
        Key, for example ``"left_forearm"``.
    label : str
        Name for people.
    unit : str
        ``"mm"`` or ``"deg"``: tables are what a person reads.
    statistics : Statistics
        In `unit`.
    """

    name: str
    label: str
    unit: str
    statistics: Statistics


@dataclass(frozen=True)
class Summary:
    """Errors of one stretch of frames.

    Attributes
    ----------
    name : str
        The segment, or ``"all"``.
    frames : int
        Frames that the reference knows.
    not_tracked : int
        Frames among them in which the run has no landmark.
    measures : tuple of Measure
        Torso position, long axis, cross axis, upper arms, forearms, then each arm alone.
    lost : float
        Share (0 to 1) of arm segments more than 45 degrees off; NaN where none was scored.
    """

    name: str
    frames: int
    not_tracked: int
    measures: tuple[Measure, ...]
    lost: float

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
    found : Run or LandmarkTrajectory
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
    values = values_of(errors)
    return Summary(
        name=name,
        frames=len(errors.frame),
        not_tracked=int(np.count_nonzero(~errors.tracked)),
        measures=tuple(
            Measure(key, label, unit, statistics(values[key]))
            for key, label, unit in ERROR_MEASURES
        ),
        lost=lost_share(errors),
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


def root_mean(squares: FloatArray) -> float:
    """Root of the mean of the squares that are not NaN; NaN where there is none."""
    return float(np.sqrt(statistics(squares).mean))


def lost_share(errors: LimbErrors) -> float:
    """Share (0 to 1) of scored upper arms and forearms more than 45 degrees off."""
    angles = errors.arm_segments
    known = angles[~np.isnan(angles)]
    return float((known > LOST_ANGLE).mean()) if known.size else float("nan")

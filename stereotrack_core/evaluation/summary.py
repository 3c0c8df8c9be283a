"""Errors of a trajectory against a reference on the thesis's axes, and pooled over frames.

Torso position is the hip midpoint, the long axis runs from hip midpoint to shoulder midpoint, the
cross axis from left to right shoulder, an upper arm from shoulder to elbow and a forearm from elbow
to hand (thesis, chapter 4).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import TypeAlias

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.skeleton import FOREARMS, UPPER_ARMS
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.rotation import angle_between
from stereotrack_core.recording.description import Recording, Segment
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory
from stereotrack_core.tracking.frame import Run

NOT_TRACKED_ANGLE = np.pi / 2  # error of an axis that the run does not know, radians
NOT_TRACKED_POSITION = 0.5  # error of a torso position that the run does not know, metres


@dataclass(frozen=True, eq=False)
class LimbErrors:
    """Errors per frame of the reference; NaN where the reference does not know."""

    frame: IntArray  # (F,). Frames in which the reference knows at least one landmark.
    torso_position: FloatArray  # (F,), metres
    torso_long: FloatArray
    torso_cross: FloatArray  # `torso_long` and `torso_cross`: (F,), radians
    upper_arm: FloatArray
    forearm: FloatArray  # `upper_arm` and `forearm`: (F, 2), radians; left, right
    tracked: BoolArray  # (F,). Whether the trajectory knows at least one landmark of the frame.

    def between(self, first: int, end: int) -> LimbErrors:
        """Return the frames of a half-open stretch."""
        return self.chosen(np.asarray((self.frame >= first) & (self.frame < end)))

    def chosen(self, rows: BoolArray) -> LimbErrors:
        """Return the frames of these rows (F,)."""
        return LimbErrors(*(getattr(self, field.name)[rows] for field in fields(self)))

    @property
    def arm_segments(self) -> FloatArray:
        """Errors (F, 4) in radians: left and right upper arm, left and right forearm."""
        return np.column_stack([self.upper_arm, self.forearm])

    @property
    def degrees(self) -> FloatArray:
        """Angular errors (F, 6) of the limbs, degrees; the torso's long axis, NaN for the head."""
        head = np.full(len(self.frame), np.nan)
        return np.asarray(np.degrees(np.column_stack([self.torso_long, head, self.arm_segments])))


def truth_of(recording: Recording) -> LandmarkTrajectory:
    """The recording's own reference. Raises InputError where it has none."""
    if recording.reference is None:
        what = "the recording has no reference to measure against"
        remedy = "Choose recordings with a reference.csv; see `stereotrack info`."
        raise InputError(what, recording.folder, remedy)
    return recording.reference


def none_of_the_frames(where: str) -> InputError:
    """The error for a reference without any of the frames."""
    what = "the reference contains none of the frames"
    return InputError(what, where, "Choose frames that it contains.")


def at_frames(trajectory: LandmarkTrajectory, frames: IntArray) -> LandmarkTrajectory:
    """The part of a trajectory that lies in some frames."""
    inside = np.isin(trajectory.frame, frames)
    return LandmarkTrajectory(trajectory.frame[inside], trajectory.points[inside])


def errors_against(trajectory: LandmarkTrajectory, reference: LandmarkTrajectory) -> LimbErrors:
    """Errors of `trajectory` in every frame of `reference`, which is taken as truth.

    What it lacks counts 90 degrees and 500 mm; what the reference does not know is not scored.
    """
    known = knows_something(reference)
    frame = reference.frame[known]
    truth = _whole_landmarks(reference.points[known])
    found = _whole_landmarks(points_at(trajectory, frame))
    axes, true_axes = _axes(found), _axes(truth)
    angles = {name: _angles(axis, true_axes[name]) for name, axis in axes.items()}
    hips, true_hips = (_both(points, "hip").mean(axis=1) for points in (found, truth))
    distance = np.linalg.norm(hips - true_hips, axis=-1)
    missed = np.where(np.isnan(distance), NOT_TRACKED_POSITION, distance)
    return LimbErrors(
        frame=frame,
        torso_position=np.where(np.isnan(true_hips).any(axis=-1), np.nan, missed),
        **angles,
        tracked=np.asarray(np.isfinite(found).any(axis=(1, 2))),
    )


def knows_something(trajectory: LandmarkTrajectory) -> BoolArray:
    """Frames (F,) in which at least one landmark is known."""
    return np.asarray(np.isfinite(trajectory.points).all(axis=-1).any(axis=-1))


def _whole_landmarks(points: FloatArray) -> FloatArray:
    return np.where(np.isfinite(points).all(axis=-1, keepdims=True), points, np.nan)


def points_at(trajectory: LandmarkTrajectory, frame: IntArray) -> FloatArray:
    """Landmarks (F, 9, 3) of the frames (F,) asked for; NaN in frames that it does not have."""
    points: FloatArray = np.full((len(frame), len(LANDMARKS), 3), np.nan)
    _, asked, own = np.intersect1d(frame, trajectory.frame, return_indices=True)
    points[asked] = trajectory.points[own]
    return points


def _both(points: FloatArray, joint: str) -> FloatArray:
    """Left and right landmark (F, 2, 3) of a joint."""
    return points[:, [LANDMARKS.index(f"{side}_{joint}") for side in ("left", "right")]]


def _axes(points: FloatArray) -> dict[str, FloatArray]:
    """Axes of the torso (F, 3), and of arms (F, 2, 3) with left and right, in metres."""
    hip, shoulder, elbow, hand = (_both(points, j) for j in ("hip", "shoulder", "elbow", "hand"))
    long, cross = shoulder.mean(axis=1) - hip.mean(axis=1), shoulder[:, 1] - shoulder[:, 0]
    arms = {"upper_arm": elbow - shoulder, "forearm": hand - elbow}
    return {"torso_long": long, "torso_cross": cross, **arms}


def _angles(axis: FloatArray, true_axis: FloatArray) -> FloatArray:
    angle = angle_between(axis, true_axis)
    scored = (true_axis != 0).any(axis=-1) & np.isfinite(true_axis).all(axis=-1)
    missed = np.where(np.isnan(angle), NOT_TRACKED_ANGLE, angle)
    return np.where(scored, missed, np.nan)


LOST_ANGLE = np.deg2rad(45.0)  # an arm segment farther off than this is lost


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

    name: str  # key, for example ``"left_forearm"``
    label: str
    unit: str  # ``"mm"`` or ``"deg"``
    statistics: Statistics


@dataclass(frozen=True)
class Summary:
    """Errors of one stretch of frames."""

    name: str  # the segment, or ``"all"``
    frames: int  # frames that the reference knows
    not_tracked: int  # frames among them in which the run has no landmark
    measures: tuple[Measure, ...]  # torso, both arms together, then each alone
    lost: float  # share (0 to 1) of arm segments more than 45 degrees off; NaN if unknown

    def measure(self, name: str) -> Measure:
        """Return the measure of that name; KeyError where there is none."""
        return {measure.name: measure for measure in self.measures}[name]


def evaluate(
    found: Run | LandmarkTrajectory, reference: LandmarkTrajectory, frames: range | None = None
) -> Summary:
    """Errors of a run against a reference, as the thesis measures them.

    Frames of the reference that the run lacks, or in which it has no pose, count 90 degrees and
    500 mm. What the reference does not know is not scored. `frames`: those that count, else all.

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


Sigmas: TypeAlias = Mapping[str, FloatArray]
"""Standard deviations (F, k) of the reference by measure, in its unit; NaN where not stated."""


def summarise(errors: LimbErrors, name: str = "all", sigmas: Sigmas | None = None) -> Summary:
    """Pool the errors over all frames, both arms together and each alone.

    With `sigmas`, errors count by how well the reference is known: weights are 1 / (s^2 + sigma^2),
    s the median error. What the run lacks has the weight that the reference has there.
    """
    values, arms = values_of(errors), errors.arm_segments
    weights = {key: _weights(values[key], own) for key, own in (sigmas or {}).items()}
    return Summary(
        name=name,
        frames=len(errors.frame),
        not_tracked=int(np.count_nonzero(~errors.tracked)),
        measures=tuple(
            Measure(key, label, unit, statistics(values[key], weights.get(key)))
            for key, label, unit in ERROR_MEASURES
        ),
        lost=statistics(np.where(np.isnan(arms), np.nan, arms > LOST_ANGLE)).mean,
    )


def _weights(values: FloatArray, sigma: FloatArray) -> FloatArray | None:
    """Weights of errors; where the reference states no sigma its median counts, None without."""
    known, scale = sigma[np.isfinite(sigma)], statistics(values).median
    if not known.size or not np.isfinite(scale):
        return None
    variance = np.square(np.where(np.isfinite(sigma), sigma, np.median(known)))
    floor = max(scale**2, np.finfo(np.float64).tiny)
    return np.asarray(1.0 / (floor + variance.reshape(values.shape)))


def values_of(errors: LimbErrors) -> dict[str, FloatArray]:
    """Values (F,), or (F, 2) of both sides, of all :data:`ERROR_MEASURES` in their units."""
    return {
        "torso_position": 1000.0 * errors.torso_position,
        "torso_long": np.rad2deg(errors.torso_long),
        "torso_cross": np.rad2deg(errors.torso_cross),
        "upper_arms": np.rad2deg(errors.upper_arm),
        "forearms": np.rad2deg(errors.forearm),
        **dict(zip(LIMBS[2:], errors.degrees[:, 2:].T, strict=True)),
    }


def summarise_segments(
    errors: LimbErrors, segments: Sequence[Segment], sigmas: Sigmas | None = None
) -> tuple[Summary, ...]:
    """One summary for each name; stretches of the same name count together."""
    found = []
    for name in dict.fromkeys(segment.name for segment in segments):
        inside = within([one for one in segments if one.name == name], errors.frame)
        own = None if sigmas is None else {key: sigma[inside] for key, sigma in sigmas.items()}
        found.append(summarise(errors.chosen(inside), name, own))
    return tuple(found)


def within(segments: Iterable[Segment], frame: IntArray) -> BoolArray:
    """Whether frames (F,) lie in any of some segments."""
    inside: BoolArray = np.zeros(len(frame), dtype=np.bool_)
    for one in segments:
        inside |= (frame >= one.first) & (frame < one.end)
    return inside


def statistics(values: FloatArray, weights: FloatArray | None = None) -> Statistics:
    """Statistics of the values that are not NaN; each may have a weight."""
    there = ~np.isnan(values)
    known = values[there]
    if not known.size:
        return Statistics(np.nan, np.nan, np.nan, 0)
    if weights is None:
        median, p95 = np.percentile(known, [50, 95])
        return Statistics(float(known.mean()), float(median), float(p95), int(known.size))
    own, order = weights[there], np.argsort(known)
    # equal weights give the percentiles of NumPy, between whose ends values are interpolated
    middle = np.cumsum(own[order]) - 0.5 * own[order]
    share = (middle - middle[0]) / max(middle[-1] - middle[0], np.finfo(np.float64).tiny)
    median, p95 = np.interp([0.5, 0.95], share, known[order])
    mean = np.average(known, weights=own)
    return Statistics(float(mean), float(median), float(p95), int(known.size))


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


CALLED = 0.5  # probability above which a limb is called lost


@dataclass(frozen=True)
class Doubts:
    """Counts of arm segments of tracked frames."""

    judged: int  # arm segments of which both the error and the run's own judgement are known
    lost: int
    called: int
    both: int  # `lost`, `called` and `both`: really lost, called lost by the run, and both

    @property
    def precision(self) -> float:
        """Share of those called lost that are lost; NaN where none is called lost."""
        return self.both / self.called if self.called else float("nan")

    @property
    def recall(self) -> float:
        """Share of those lost that are called lost; NaN where none is lost."""
        return self.both / self.lost if self.lost else float("nan")


def doubts_against(frame: IntArray, limb_lost: FloatArray, errors: LimbErrors) -> Doubts:
    """Compare a run's probabilities (F, 6) at frames (F,) that limbs are lost with its errors."""
    _, own, other = np.intersect1d(frame, errors.frame, return_indices=True)
    chance = limb_lost[own][:, [*UPPER_ARMS, *FOREARMS]]
    angle = errors.arm_segments[other]
    known = np.isfinite(chance) & np.isfinite(angle)
    lost, called = (angle > LOST_ANGLE) & known, (chance > CALLED) & known
    counts = (np.count_nonzero(rows) for rows in (known, lost, called, lost & called))
    return Doubts(*(int(count) for count in counts))

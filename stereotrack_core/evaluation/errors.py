"""Errors of a trajectory against a reference, frame by frame, on the thesis's axes.

Torso position is the hip midpoint, the long axis runs from hip midpoint to shoulder midpoint,
the cross axis from left to right shoulder, an upper arm from shoulder to elbow and a forearm
from elbow to hand (thesis, chapter 4).
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.rotation import angle_between
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory

NOT_TRACKED_ANGLE = np.pi / 2
"""What an axis counts that the run does not know, radians."""

NOT_TRACKED_POSITION = 0.5
"""What a torso position counts that the run does not know, metres."""


@dataclass(frozen=True, eq=False)
class LimbErrors:
    """Errors per frame of the reference; NaN where the reference does not know."""

    frame: IntArray
    """(F,). Frames in which the reference knows at least one landmark."""
    torso_position: FloatArray
    """(F,), metres."""
    torso_long: FloatArray
    torso_cross: FloatArray
    """`torso_long` and `torso_cross`: (F,), radians."""
    upper_arm: FloatArray
    forearm: FloatArray
    """`upper_arm` and `forearm`: (F, 2), radians. The person's own left, then right."""
    tracked: BoolArray
    """(F,). Whether the trajectory knows at least one landmark of the frame."""

    def between(self, first: int, end: int) -> LimbErrors:
        """Return the frames of a half-open stretch."""
        inside = (self.frame >= first) & (self.frame < end)
        return LimbErrors(*(getattr(self, field.name)[inside] for field in fields(self)))

    def followed_by(self, later: LimbErrors) -> LimbErrors:
        """Return these frames and later ones together."""
        pairs = ((getattr(self, f.name), getattr(later, f.name)) for f in fields(self))
        return LimbErrors(*(np.concatenate(pair) for pair in pairs))

    @property
    def arm_segments(self) -> FloatArray:
        """Errors (F, 4) in radians: left and right upper arm, left and right forearm."""
        return np.column_stack([self.upper_arm, self.forearm])

    def of_limb(self, limb: str) -> FloatArray:
        """Angular error (F,) in radians of one limb; the torso's is its long axis.

        The head enters no measure, so its row is NaN throughout. Raises KeyError for a name that is
        not a limb.
        """
        nothing: FloatArray = np.full(len(self.frame), np.nan)
        return {
            "torso": self.torso_long,
            "head": nothing,
            "left_upper_arm": self.upper_arm[:, 0],
            "right_upper_arm": self.upper_arm[:, 1],
            "left_forearm": self.forearm[:, 0],
            "right_forearm": self.forearm[:, 1],
        }[limb]


def truth_of(recording: Recording) -> LandmarkTrajectory:
    """The recording's own reference. Raises InputError where it has none."""
    if recording.reference is None:
        raise InputError(
            "the recording has no reference to measure against",
            where=str(recording.folder),
            remedy="Choose recordings with a reference.csv; see `stereotrack info`.",
        )
    return recording.reference


def reference_within(recording: Recording, frames: range) -> LandmarkTrajectory:
    """What the recording's reference has of some frames. Raises InputError where it knows none."""
    reference = truth_of(recording)
    inside = (reference.frame >= frames.start) & (reference.frame < frames.stop)
    if not np.any(inside & knows_something(reference)):
        raise none_of_the_frames(str(recording.folder))
    return LandmarkTrajectory(reference.frame[inside], reference.points[inside])


def none_of_the_frames(where: str) -> InputError:
    """What is wrong with a reference that says nothing about what is measured."""
    return InputError(
        "the reference contains none of the frames",
        where=where,
        remedy="Choose frames that it contains.",
    )


def at_frames(trajectory: LandmarkTrajectory, frames: IntArray) -> LandmarkTrajectory:
    """What a trajectory has of some frames."""
    inside = np.isin(trajectory.frame, frames)
    return LandmarkTrajectory(trajectory.frame[inside], trajectory.points[inside])


def errors_against(trajectory: LandmarkTrajectory, reference: LandmarkTrajectory) -> LimbErrors:
    """Errors of `trajectory` in every frame of `reference`, which is taken as truth.

    A frame or landmark that the trajectory lacks counts 90 degrees and 500 mm. What the reference
    does not know is not scored (NaN), nor is an axis of it that has no length.
    """
    known = knows_something(reference)
    frame = reference.frame[known]
    truth = _whole_landmarks(reference.points[known])
    found = _whole_landmarks(points_at(trajectory, frame))
    axes, true_axes = _axes(found), _axes(truth)
    angles = {name: _angles(axis, true_axes[name]) for name, axis in axes.items()}
    return LimbErrors(
        frame=frame,
        torso_position=_distances(
            _both(found, "hip").mean(axis=1), _both(truth, "hip").mean(axis=1)
        ),
        **angles,
        tracked=np.asarray(np.isfinite(found).any(axis=(1, 2))),
    )


def knows_something(trajectory: LandmarkTrajectory) -> BoolArray:
    """Frames (F,) in which at least one landmark is known."""
    return np.asarray(np.isfinite(trajectory.points).all(axis=-1).any(axis=-1))


def _whole_landmarks(points: FloatArray) -> FloatArray:
    """Blank landmarks of which only some coordinates are known."""
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
    return {
        "torso_long": shoulder.mean(axis=1) - hip.mean(axis=1),
        "torso_cross": shoulder[:, 1] - shoulder[:, 0],
        "upper_arm": elbow - shoulder,
        "forearm": hand - elbow,
    }


def _angles(axis: FloatArray, true_axis: FloatArray) -> FloatArray:
    angle = angle_between(axis, true_axis)
    scored = (true_axis != 0).any(axis=-1) & np.isfinite(true_axis).all(axis=-1)
    missed = np.where(np.isnan(angle), NOT_TRACKED_ANGLE, angle)
    result: FloatArray = np.where(scored, missed, np.nan)
    return result


def _distances(found: FloatArray, truth: FloatArray) -> FloatArray:
    distance = np.linalg.norm(found - truth, axis=-1)
    missed = np.where(np.isnan(distance), NOT_TRACKED_POSITION, distance)
    result: FloatArray = np.where(np.isnan(truth).any(axis=-1), np.nan, missed)
    return result

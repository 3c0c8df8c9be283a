"""One tracked frame, and a run made of many.

A tracker's limbs have a turn about their own axis that no state keeps, and its covariance is about
the axes of limbs turned so. A run keeps it about the axes of the chain that its state stands for
(:func:`pose_of_state`), so that both fit together.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from operator import attrgetter
from typing import Any

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.body.angles import THESIS_JOINTS, pose_of_state, state_names
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.skeleton import PARENTS, PARTS, TORSO
from stereotrack_core.depth.cloud import Cloud, PointCounts
from stereotrack_core.recording.frame_times import stated_fps
from stereotrack_core.recording.keypoints import Keypoints, joined_keypoints
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory
from stereotrack_core.tracking.estimate import Estimate
from stereotrack_core.tracking.run_spec import RunSpec

LOOKED_AGAIN = "looked_again"  # key in a run's meta: stretches that a second look changed
DETECTED_SCENES = "detected_scenes"  # key in a run's meta: views whose empty scene was detected


@dataclass(frozen=True, eq=False)
class Run:
    """What tracking gave, frame by frame; F frames, n states, S stages."""

    frame: IntArray  # (F,). Frame numbers of the recording.
    landmarks: FloatArray  # (F, 9, 3), world, metres. NaN where not tracked; as ``LANDMARKS``
    x: FloatArray  # (F, n). State; NaN where not tracked. Metres and radians, see `state_names`.
    P: FloatArray  # (F, n, n). Covariance of the error state.
    state_names: tuple[str, ...]
    tracked: BoolArray  # (F,)
    unexplained_fraction: FloatArray  # (F,), 0 is best; ``coverage`` in the run file
    residual: FloatArray  # (F,), metres. Weighted root mean square after the last correction
    innovation: FloatArray  # (F,). Of the first correction, normalised; see :class:`Estimate`
    limb_sigma_deg: FloatArray  # (F, 6). Standard deviation of each limb's direction
    limb_lost: FloatArray  # (F, 6). Probability of more than 45 deg error; NaN where not known
    seconds: FloatArray  # (F, S). Wall time of each stage.
    stage_names: tuple[str, ...]
    meta: Mapping[str, Any]  # JSON-serialisable: version, parameters, seed, recording, subject
    landmark_names: tuple[str, ...] = LANDMARKS
    keypoints: Keypoints | None = None  # given, or seen by the pose detector

    def seen(self, frame: int) -> Keypoints | None:
        """What the pose detector saw in a frame; None if none looked, or the run does not say."""
        stated = self.keypoints is not None and self.meta.get("detector")
        return self.keypoints.of_frame(frame) if self.keypoints is not None and stated else None

    def stating(self, **facts: Any) -> Run:
        """The run, whose meta states these facts as well."""
        return replace(self, meta={**self.meta, **facts})

    def within(self, frames: range) -> Run:
        """The part of the run that lies in some frames."""
        inside, every = np.isin(self.frame, frames), vars(self).items()
        arrays: dict[str, Any] = {k: v[inside] for k, v in every if isinstance(v, np.ndarray)}
        return replace(self, **arrays)

    def trajectory(self) -> LandmarkTrajectory:
        """The landmarks alone, with the frame rate if the run states it."""
        return LandmarkTrajectory(self.frame, self.landmarks, stated_fps(self.meta))


@dataclass(frozen=True, eq=False)
class TrackedFrame:
    """What is known about one frame after tracking; see :class:`Estimate` and :class:`Run`."""

    frame: int
    estimate: Estimate
    landmarks: FloatArray  # (9, 3), world, metres. NaN where not tracked.
    cloud: Cloud
    seconds: Mapping[str, float]  # by stage name
    contradicted: float = float("nan")  # :func:`contradicted_share`; NaN if not asked
    keypoints: Keypoints | None = None  # seen by the pose detector; None without one

    def without_cloud(self) -> TrackedFrame:
        """The same frame without its cloud and correspondences, to be kept in numbers."""
        nothing = cloudless(self.frame, self.cloud.problems, self.cloud.counts)
        pose = replace(self.estimate.pose)  # without the frames of its parts: 2 kB
        bare = replace(self.estimate, pose=pose, correspondences=None)
        return replace(self, cloud=nothing, estimate=bare)

    @property
    def tracked(self) -> bool:
        """Whether the frame has a pose."""
        return self.estimate.tracked

    @property
    def problems(self) -> Mapping[str, str]:
        """By view name, a sentence on what the view lacks, or why it was left out."""
        return {**self.cloud.problems, **self.estimate.doubts}

    @property
    def reason(self) -> str:
        """Why the frame is not tracked; empty when it is."""
        return self.estimate.reason

    @property
    def pose(self) -> Pose | None:
        """The pose, where tracked."""
        return self.estimate.pose if self.estimate.tracked else None

    @property
    def x(self) -> FloatArray:
        """State (n,); NaN where not tracked."""
        x = self.estimate.x
        return x if self.tracked else np.full_like(x, np.nan)

    @property
    def P(self) -> FloatArray:  # noqa: N802
        """Covariance (n, n); NaN where not tracked."""
        P = self.estimate.P
        return P if self.tracked else np.full_like(P, np.nan)


def seen_by_frame(frames: Iterable[TrackedFrame]) -> dict[int, Keypoints] | None:
    """What the pose detector has seen in frames; None if there was no detector."""
    seen = {one.frame: one.keypoints for one in frames if one.keypoints is not None}
    return seen or None


@dataclass(frozen=True, eq=False)
class Replaced:
    """Frames of a run from one on, in the place of all that it had from there."""

    first: int
    frames: tuple[TrackedFrame, ...]  # empty if they are tracked anew

    def into(self, found: Sequence[TrackedFrame]) -> list[TrackedFrame]:
        """Frames of the run with these in their place, without clouds."""
        kept = found[: bisect_left(found, self.first, key=attrgetter("frame"))]
        return [*kept, *(one.without_cloud() for one in self.frames)]


def cloudless(
    frame: int,
    problems: Mapping[str, str] | None = None,
    counts: Mapping[str, PointCounts] | None = None,
) -> Cloud:
    """A cloud without points, of which no more is known than what views lacked and counted."""
    nothing = np.empty((0, 3)), np.empty(0, np.int64), np.empty((0, 2), np.int64)
    return Cloud(frame, *nothing, (), {}, problems or {}, counts=counts or {})


@dataclass(frozen=True, eq=False)
class FirstFrame:
    """First frame that shows somebody, and the pose from which the tracker begins there."""

    frame: int
    pose: Pose


@dataclass(frozen=True, eq=False)
class Origin:
    """Where a run comes from: all that is needed to repeat it."""

    # With the frames that were asked for and the views that were used. Pictures in colour have grey
    # values that differ a little.
    spec: RunSpec
    state_names: tuple[str, ...]
    meta: Mapping[str, Any]  # JSON-serialisable, of the run


def run_of(frames: Sequence[TrackedFrame], origin: Origin) -> Run:
    """Put tracked frames together to a run; an empty sequence gives an empty run."""
    return assembled(frames, origin.state_names, origin.meta, origin.spec.used_keypoints)


def assembled(
    frames: Sequence[TrackedFrame],
    state_names: tuple[str, ...],
    meta: Mapping[str, Any],
    keypoints: Keypoints | None = None,
) -> Run:
    """Put tracked frames together to a run with a meta, and the keypoints that it was given."""
    seen = seen_by_frame(frames)
    n, names = len(state_names), tuple(dict.fromkeys(s for one in frames for s in one.seconds))
    states, joints = [frame.x for frame in frames], joints_named(state_names)
    seconds = [[frame.seconds.get(name, 0.0) for name in names] for frame in frames]
    return Run(
        frame=np.array([frame.frame for frame in frames], dtype=np.int64),
        landmarks=_stacked([frame.landmarks for frame in frames], (len(LANDMARKS), 3)),
        x=_stacked(states, (n,)),
        P=_stacked([in_chain_axes(frame, joints) for frame in frames], (n, n)),
        state_names=state_names,
        tracked=np.array([frame.tracked for frame in frames], dtype=bool),
        unexplained_fraction=np.array([frame.estimate.unexplained_fraction for frame in frames]),
        residual=np.array([frame.estimate.residual for frame in frames]),
        innovation=np.array([frame.estimate.innovation for frame in frames]),
        limb_sigma_deg=_stacked([frame.estimate.limb_sigma_deg for frame in frames], (6,)),
        limb_lost=_stacked([frame.estimate.limb_lost for frame in frames], (6,)),
        seconds=np.array(seconds).reshape(len(frames), len(names)),
        stage_names=names,
        meta=meta,
        keypoints=keypoints if seen is None else joined_keypoints(list(seen.values())),
    )


def _stacked(arrays: list[FloatArray], shape: tuple[int, ...]) -> FloatArray:
    return np.stack(arrays) if arrays else np.empty((0, *shape))


def in_chain_axes(frame: TrackedFrame, joints: tuple[int, ...] | None) -> FloatArray:
    """Covariance (n, n) of a frame's error state about the axes of the chain of its state x (n,).

    Both limbs point the same way, so that tangents t about the pose's axes are T t about the
    chain's, T the turn between them about the limb. The thesis's joints have no manifold: P stays.
    """
    pose, P = frame.pose, frame.P
    if pose is None or joints in (None, THESIS_JOINTS) or not np.isfinite(P).all():
        return P
    own, chain = _world(pose), _world(pose_of_state(frame.x, joints))
    turn = np.eye(len(P))
    for k, part in enumerate(joints):
        at = slice(6 + 2 * k, 8 + 2 * k)
        turn[at, at] = (chain[part].T @ own[part])[:2, :2]
    return turn @ P @ turn.T


def joints_named(names: tuple[str, ...]) -> tuple[int, ...] | None:
    """Joints of a state with these names; None where they are not those of a body."""
    parts = [name.removesuffix("_alpha") for name in names[6:] if name.endswith("_alpha")]
    if not all(part in PARTS for part in parts):
        return None
    joints = tuple(PARTS.index(part) for part in parts)
    return joints if state_names(joints) == tuple(names) else None


def _world(pose: Pose) -> FloatArray:
    """Rotations world_from_part (P, 3, 3)."""
    result = pose.rotations.copy()
    for part, parent in enumerate(PARENTS):
        if part != TORSO:
            result[part] = result[parent] @ pose.rotations[part]
    return result

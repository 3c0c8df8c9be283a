"""Where the body is likely to be where clicks alone do not tell it, before all is fitted together.

Straight ways between clicked frames are good starts for slow movements only, and a limb whose end
is clicked in one camera alone may point towards that camera as well as away from it. So frames
are asked one by one, outwards from those whose clicks tell the pose: from the pose of the
neighbour, from what was filled in, and from the other way along the line of sight. The start
whose fit explains clicks, measured points and movement best is taken.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from stereotrack_core.annotation.fit.movement import pose_sigmas
from stereotrack_core.annotation.fit.state import Freedom
from stereotrack_core.annotation.fit.stretch import FrameData, Stretch, depth_cost
from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.body.pose import HANGING, Pose, rotation_towards
from stereotrack_core.body.skeleton import (
    FOREARMS,
    LEFT_SHANK,
    LEFT_THIGH,
    PARENTS,
    RIGHT_SHANK,
    RIGHT_THIGH,
    UPPER_ARMS,
)
from stereotrack_core.errors import Cancelled

_ROUNDS = 4

_STEP = (0.06, 10.0, 20.0)
"""How far a body may move from one frame to the next at 10 Hz: metres; degrees of the torso, of a
joint."""

_TOLD = (0.05, 8.0, 15.0)
"""How far a pose that clicks tell may be off."""

LEGS = (LEFT_THIGH, RIGHT_THIGH, LEFT_SHANK, RIGHT_SHANK)

_LEG_SIGMA = np.radians(45.0)

_STATED_AT = 10.0

_LARGEST = 25.0
"""What one click can cost at most when poses are compared."""

_ENDS = {
    UPPER_ARMS[0]: "left_elbow",
    UPPER_ARMS[1]: "right_elbow",
    FOREARMS[0]: "left_hand",
    FOREARMS[1]: "right_hand",
}
"""The landmark at the far end of a part of the arms."""


def told_by_clicks(stretch: Stretch, data: Sequence[FrameData], wanted: int) -> BoolArray:
    """Frames (K,) whose clicks tell the pose: the first `wanted` landmarks in two cameras each."""
    found: BoolArray = np.array([_cameras(stretch, one)[:wanted].min() > 1 for one in data])
    return found


def asked_between(
    stretch: Stretch,
    data: Sequence[FrameData],
    poses: Sequence[Pose],
    known: BoolArray,
    fps: float,
    cancelled: Callable[[], bool] | None,
) -> list[Pose]:
    """Poses to begin from.

    Parameters
    ----------
    stretch : Stretch
    data : sequence of FrameData
    poses : sequence of Pose
        As filled between clicked frames.
    known : (K,) bool
        Frames whose clicks tell the pose.
    fps : float
        Frame sets per second.
    cancelled : callable, optional

    Raises
    ------
    Cancelled
    """
    f = stretch.freedom
    found = [_on_legs(pose) for pose in poses] if f.with_depth else list(poses)
    if not known.any():
        return found
    filled = list(found)
    sigma = pose_sigmas(f, *_STEP) * np.sqrt(_STATED_AT / fps)
    for k in _outwards(known):
        if cancelled is not None and cancelled():
            raise Cancelled
        frame = data[k]
        if not len(frame.clicks) and (frame.depth is None or not f.with_depth):
            continue
        if known[k]:
            if f.with_depth and frame.depth is not None:
                found[k] = _asked(stretch, frame, filled[k], filled[k], _told_sigma(f))[1]
            continue
        neighbours = [found[i] for i in _nearer(k, known)]
        starts = [*neighbours, filled[k]]
        starts += _other_ways(stretch, frame, filled[k])
        results = [_asked(stretch, frame, start, neighbours[0], sigma) for start in starts]
        found[k] = min(results, key=lambda result: result[0])[1]
    return found


def _told_sigma(f: Freedom) -> FloatArray:
    """How far the pose of a frame may be off whose clicks tell it all but the legs."""
    sigma = pose_sigmas(f, *_TOLD)
    for part in LEGS:
        at = f.columns.first[part]
        sigma[at : at + 2] = _LEG_SIGMA
    return sigma


def _on_legs(pose: Pose) -> Pose:
    """The pose with legs that go straight down, however the trunk bends."""
    rotations = pose.rotations.copy()
    down = pose.torso.T @ np.array([0.0, 0.0, -1.0])
    for part in LEGS[:2]:
        rotations[part] = rotation_towards(HANGING, down)
    for part in LEGS[2:]:
        rotations[part] = np.eye(3)
    return Pose(pose.position, rotations)


def _asked(
    stretch: Stretch, frame: FrameData, start: Pose, expected: Pose, sigma: FloatArray
) -> tuple[float, Pose]:
    """Fit one frame; what it costs, and the pose."""
    found = stretch.fit([frame], [start], expected, sigma, rounds=_ROUNDS)
    pose = found.states[0].pose
    moved = stretch.freedom.pose_difference(pose, expected) / sigma
    cost = float(moved @ moved)
    cost += float(np.minimum(found.judgements[0].surprise, _LARGEST).sum())
    if frame.depth is not None and stretch.freedom.with_depth:
        cost += depth_cost(stretch, frame.depth.points, pose)
    return cost, pose


def _cameras(stretch: Stretch, frame: FrameData) -> IntArray:
    """In how many cameras each landmark (L,) of a frame is clicked."""
    return np.bincount(frame.clicks.landmark, minlength=len(stretch.freedom.parts))


def _other_ways(stretch: Stretch, frame: FrameData, pose: Pose) -> list[Pose]:
    """The pose with one part the other way along the line of sight of the one camera."""
    f, names = stretch.freedom, stretch.freedom.landmark_set.names
    cameras = _cameras(stretch, frame)
    frames, found = f.body.frames(pose), []
    for part, name in _ENDS.items():
        i = names.index(name)
        if cameras[i] != 1:
            continue
        click = int(np.flatnonzero(frame.clicks.landmark == i)[0])
        rotation = frame.clicks.rotations[click]
        sight = rotation.T @ np.append(frame.clicks.normalised[click], 1.0)
        sight /= np.linalg.norm(sight)
        along = frames.rotations[part][:, 2]
        turned = along - 2.0 * (along @ sight) * sight
        rotations = pose.rotations.copy()
        local = frames.rotations[PARENTS[part]].T @ turned
        rotations[part] = rotation_towards(rotations[part], local)
        found.append(Pose(pose.position, rotations))
    return found


def _distance(known: BoolArray) -> IntArray:
    at = np.flatnonzero(known)
    distance: IntArray = np.abs(np.arange(len(known))[:, None] - at).min(axis=1)
    return distance


def _outwards(known: BoolArray) -> list[int]:
    """All frames, known ones first and then the nearest to them."""
    return [int(k) for k in np.argsort(_distance(known), kind="stable")]


def _nearer(k: int, known: BoolArray) -> list[int]:
    """Neighbours of a frame that are nearer to a known one."""
    distance = _distance(known)
    there = (i for i in (k - 1, k + 1) if 0 <= i < len(known))
    return [i for i in there if distance[i] < distance[k]]

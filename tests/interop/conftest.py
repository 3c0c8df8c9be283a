"""Runs and trajectories for the tests of file formats."""

import numpy as np
import pytest

from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory
from stereotrack_core.tracking.frame import Run


def _body_trajectory(random, frame):
    """Landmarks of a person with constant bone lengths who turns everything at random."""
    count = len(frame)

    def turned(scale):
        return rotation_from_vector(random.uniform(-scale, scale, (count, 3)))

    def at(rotation, *offset):
        return np.einsum("fij,j->fi", rotation, np.array(offset, dtype=float))

    torso = turned(1.0)
    hips = random.normal(0.0, 0.5, (count, 3)) + [0.0, 0.0, 0.95]
    shoulders = hips + at(torso, 0, 0, 0.5)
    points = {"head": shoulders + at(torso @ turned(0.4), 0, 0, 0.22)}
    for side, sign in (("left", -1.0), ("right", 1.0)):
        upper = torso @ turned(1.5)
        fore = upper @ turned(1.2)
        points[f"{side}_hip"] = hips + at(torso, sign * 0.11, 0, 0)
        points[f"{side}_shoulder"] = shoulders + at(torso, sign * 0.19, 0, 0)
        points[f"{side}_elbow"] = points[f"{side}_shoulder"] + at(upper, sign * 0.29, 0, 0)
        points[f"{side}_hand"] = points[f"{side}_elbow"] + at(fore, sign * 0.33, 0, 0)
    stacked = np.stack([points[name] for name in LANDMARKS], axis=1)
    return LandmarkTrajectory(np.asarray(frame, dtype=np.int64), stacked)


def _make_run(random, frame=range(3, 12), states=5, stages=("match", "filter"), **meta):
    """A run in which the second frame is not tracked."""
    trajectory = _body_trajectory(random, list(frame))
    count = len(trajectory.frame)
    tracked = np.ones(count, dtype=bool)
    tracked[1:2] = False
    lost = np.where(tracked, 1.0, np.nan)
    meta = {"preset": "accurate", "fps": 10.0, "parameters": {"σ": 0.02, "n": 3}} | meta
    return Run(
        frame=trajectory.frame,
        landmarks=trajectory.points * lost[:, None, None],
        x=random.normal(size=(count, states)) * lost[:, None],
        P=random.normal(size=(count, states, states)) * lost[:, None, None],
        state_names=tuple(f"state {k}" for k in range(states)),
        tracked=tracked,
        unexplained_fraction=random.random(count),
        residual=random.random(count) * 0.02 * lost,
        innovation=random.random(count) * lost,
        limb_sigma_deg=random.random((count, 6)),
        limb_lost=random.random((count, 6)),
        seconds=random.random((count, len(stages))),
        stage_names=tuple(stages),
        meta=meta,
    )


@pytest.fixture
def random():
    return np.random.default_rng(20260611)


@pytest.fixture
def make_run():
    return _make_run


@pytest.fixture
def body_trajectory():
    return _body_trajectory

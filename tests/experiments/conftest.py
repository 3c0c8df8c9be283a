"""A recording of cones, and jobs on it."""

from pathlib import Path
from types import SimpleNamespace

import pytest

from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.cli.sweep import text_of
from stereotrack_core.experiments.sweep.plan import SweepPlan
from stereotrack_core.experiments.sweep.points import SweepRequest
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.tracking.presets import preset
from tests.tracking.recordings import write_depth_recording
from tests.tracking.scenes import pose_with_arms

FRAMES = 6
SMALL = {
    "pixel_step": 1,
    "speckle_size": 0,
    "search_arms": False,
    "data_points": 200,
    "fit_shape": False,
}


def pose(k):
    return pose_with_arms([1, 0.1 * k, 0], [1, 0.2 * k, 0], [-1, 0.1 * k, 0], [-1, 0.2 * k, 0.1])


@pytest.fixture(scope="session")
def cones(tmp_path_factory):
    """Six frames of a body of cones in four depth views, with a reference."""
    body = body_model(AVERAGE, preset("fast").body)
    folder = tmp_path_factory.mktemp("sweeps") / "cones"
    return write_depth_recording(folder, body, [pose(k) for k in range(FRAMES)])


@pytest.fixture(scope="session")
def plan(cones):
    """Function that makes jobs of points on the cones."""

    def jobs(*points, recording=cones, changes=SMALL, seeds=(0,), **more):
        request = SweepRequest(
            (recording.folder,),
            Path("sweep.csv"),
            changes=tuple(f"{name}={text_of(value)}" for name, value in changes.items()),
            seeds=",".join(map(str, seeds)),
            **{"preset": "fast", "frames": "0:4", "init": "tpose", **more},
        )
        return SweepPlan(request, (recording,)).jobs_of(points)

    return jobs


@pytest.fixture
def copied(cones, tmp_path):
    """The recording at another place, where it may be spoilt."""
    import shutil

    folder = tmp_path / "elsewhere"
    shutil.copytree(cones.folder, folder)
    return SimpleNamespace(folder=folder, open=lambda: open_recording(folder))


class Watched:
    """A watcher that remembers; asks to stop after so many results."""

    def __init__(self, enough=None):
        self.results = {}
        self.frames = 0
        self.told = []
        self._enough = enough

    def on_frames(self, count):
        self.frames += count

    def on_result(self, job, result):
        assert job.identity == result.identity
        self.told.append(job.identity)
        self.results[job.identity] = result

    def stopped(self):
        return self._enough is not None and len(self.told) >= self._enough


@pytest.fixture
def watched():
    return Watched

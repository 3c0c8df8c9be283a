"""Small recordings of cones, alone and as a study, and jobs on them."""

import shutil
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest

from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.parameters import value_text
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.study.description import (
    Study,
    StudyRecording,
    StudySettings,
    with_recordings,
    write_study,
)
from stereotrack_core.study.job import do_batch
from stereotrack_core.study.run import Source, jobs_of
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
WALKS = {"anna/slow": 2, "anna/fast": 3, "ben/slow": 6}
"""Numbers of frames by folder."""


def settings(changes=SMALL, **more):
    texts = tuple(f"{name}={value_text(value)}" for name, value in changes.items())
    return StudySettings(**{"preset": "fast", "init": "tpose", "changes": texts, **more})


def pose(k):
    return pose_with_arms([1, 0.1 * k, 0], [1, 0.2 * k, 0], [-1, 0.1 * k, 0], [-1, 0.2 * k, 0.1])


class InThisProcess:
    count = 1

    def __enter__(self):
        return self

    def __exit__(self, *_):
        return None

    def do(self, jobs, watcher):
        for job in jobs:
            for result in do_batch((job,), on_frames=watcher.on_frames):
                watcher.on_result(job, result)


@pytest.fixture(scope="session")
def cones(tmp_path_factory):
    """Six frames of a body of cones in four depth views, with a reference."""
    body = body_model(AVERAGE, preset("fast").body)
    folder = tmp_path_factory.mktemp("sweeps") / "cones"
    return write_depth_recording(folder, body, [pose(k) for k in range(FRAMES)])


@pytest.fixture(scope="session")
def plan(cones):
    def jobs(*points, recording=cones, changes=SMALL, seeds=(0,), **more):
        asked = {"frames": "0:4", "seeds": ",".join(map(str, seeds)), **more}
        study = Study(Path("sweep.csv"), settings=settings(changes, **asked))
        row = StudyRecording(str(recording.folder))
        return jobs_of(study, Source(row, recording, None, FRAMES), points, keep=False)

    return jobs


@pytest.fixture
def copied(cones, tmp_path):
    """The recording at another place, where it may be spoilt."""
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


@pytest.fixture(scope="session")
def walks(tmp_path_factory):
    body = body_model(AVERAGE, preset("fast").body)
    root = tmp_path_factory.mktemp("study") / "walks"
    for name, count in WALKS.items():
        folder = root / name
        folder.parent.mkdir(parents=True, exist_ok=True)
        write_depth_recording(folder, body, [pose(k) for k in range(count)])
    return root


@pytest.fixture
def study(walks, tmp_path, monkeypatch):
    """The same in a place of their own, listed, with settings that are quick."""
    monkeypatch.setattr(
        "stereotrack_core.project.whereabouts.documents_folder", lambda: Path("/no documents")
    )
    shutil.copytree(walks, tmp_path / "data")
    bare = Study(tmp_path / "walks.study.toml", settings=settings())
    made = with_recordings(bare, [tmp_path / "data"]).study
    rows = []
    for row in made.rows:
        _, subject, condition = row.recording.split("/")
        rows.append(replace(row, factors={"subject": subject, "condition": condition}))
    made = replace(made, rows=tuple(rows))
    write_study(made)
    return made

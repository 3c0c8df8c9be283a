"""Small recordings in folders of subjects and conditions, and a project with a run."""

import shutil
from pathlib import Path

import pytest

from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.experiments.runner.job import do_batch
from stereotrack_core.study.create import Pattern, create_study
from stereotrack_core.tracking.presets import preset
from tests.experiments.conftest import SMALL, pose
from tests.tracking.recordings import write_depth_recording

SETTINGS = {
    "preset": "fast",
    "changes": tuple(f"{name}={value}" for name, value in SMALL.items()),
    "init": "tpose",
}
WALKS = {"anna/slow": 2, "anna/fast": 3, "ben/slow": 6}
"""Numbers of frames by folder."""


class InThisProcess:
    """An executor without processes."""

    count = 1

    def do(self, jobs, watcher):
        for job in jobs:
            for result in do_batch((job,), on_frames=watcher.on_frames):
                watcher.on_result(job, result)


@pytest.fixture(scope="session")
def walks(tmp_path_factory):
    """Three recordings of different lengths below subjects and conditions."""
    body = body_model(AVERAGE, preset("fast").body)
    root = tmp_path_factory.mktemp("study") / "walks"
    for name, count in WALKS.items():
        folder = root / name
        folder.parent.mkdir(parents=True, exist_ok=True)
        write_depth_recording(folder, body, [pose(k) for k in range(count)])
    return root


@pytest.fixture
def study(walks, tmp_path, monkeypatch):
    """The same in a place of their own, listed."""
    monkeypatch.setattr(
        "stereotrack_core.study.places.documents_folder", lambda: Path("/no documents")
    )
    shutil.copytree(walks, tmp_path / "data")
    path = tmp_path / "walks.study.csv"
    return create_study(path, [tmp_path / "data"], Pattern("subject/condition")).study

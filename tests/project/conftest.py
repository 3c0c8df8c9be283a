"""A small recording on disk and a project of it."""

import multiprocessing
import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.project.database import make_database
from stereotrack_core.project.project import Project
from stereotrack_core.recording.description import Recording, Stream, View
from stereotrack_core.recording.writing import write_png, write_recording_description

WIDTH, HEIGHT = 64, 48
PROCESSES = multiprocessing.get_context("forkserver" if hasattr(os, "fork") else "spawn")
PROCESSES.set_forkserver_preload(["stereotrack_core.project.project"])
"""Processes that can be killed; forked, so that not each of them loads the program."""


def write_recording(folder: Path, name: str = "walk") -> Recording:
    """A stereo view N and a mono view S, of three frames each."""
    matrix = np.array([[50.0, 0, 31.5], [0, 50, 23.5], [0, 0, 1]])
    cameras = {
        camera: Camera(camera, WIDTH, HEIGHT, matrix, np.zeros(5), False, RigidTransform.identity())
        for camera in ("N_left", "N_right", "S_cam")
    }
    for camera in cameras:
        (folder / camera).mkdir(parents=True)
        for k in range(3):
            write_png(folder / camera / f"{k}.png", np.full((HEIGHT, WIDTH), 40 * k, np.uint8))
    streams = {camera: Stream(camera, f"{camera}/%d.png") for camera in cameras}
    views = (
        View("N", "stereo", streams["N_right"], left=streams["N_left"]),
        View("S", "mono", streams["S_cam"]),
    )
    recording = Recording(folder, name, 10.0, views, cameras)
    write_recording_description(recording)
    return recording


@pytest.fixture
def recording(tmp_path) -> Recording:
    return write_recording(tmp_path / "data" / "walk")


@pytest.fixture
def another_recording(tmp_path) -> Recording:
    return write_recording(tmp_path / "data" / "another", name="another")


@pytest.fixture
def project_path(recording) -> Path:
    return recording.folder.parent / "walk.stereotrack"


@pytest.fixture
def path(tmp_path) -> Path:
    """An empty project in a folder of its own."""
    path = tmp_path / "project" / "walk.stereotrack"
    make_database(path)
    return path


@pytest.fixture
def project(recording, project_path) -> Iterator[Project]:
    with Project.create(project_path, recording.folder, who="A") as made:
        yield made

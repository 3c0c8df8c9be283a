"""Everything in the program that writes a file, and a disk that is full."""

from __future__ import annotations

import resource
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from PySide6.QtGui import QPixmap

from app.shell.dialogs import write_picture
from stereotrack_core.annotation.click import Click, Visibility
from stereotrack_core.annotation.landmark_set import NINE, write_landmark_set
from stereotrack_core.annotation.reference import Reference
from stereotrack_core.demo import copied_demo
from stereotrack_core.evaluation.joint_angles import angles_of_run
from stereotrack_core.interop.bvh import write_bvh
from stereotrack_core.interop.c3d import write_c3d
from stereotrack_core.interop.calibrations.formats import write_foreign
from stereotrack_core.interop.coco import write_coco
from stereotrack_core.interop.deeplabcut import write_deeplabcut
from stereotrack_core.interop.keypoints.json_files import write_results
from stereotrack_core.interop.keypoints.table import write_table
from stereotrack_core.interop.labels import write_clicks
from stereotrack_core.interop.ply import write_cloud
from stereotrack_core.interop.reference_npz import write_reference, write_reference_table
from stereotrack_core.interop.run_file import write_run
from stereotrack_core.interop.run_npz import write_npz
from stereotrack_core.interop.sleap import write_sleap
from stereotrack_core.interop.trc import write_trc
from stereotrack_core.project.exporting.runs import export_angles
from stereotrack_core.recording.calibration import write_calibration
from stereotrack_core.recording.description import Recording, Segment, write_segments, write_subject
from stereotrack_core.recording.importing.making import make_recording
from stereotrack_core.recording.importing.proposing import propose
from stereotrack_core.recording.importing.sources import look_at
from stereotrack_core.recording.keypoints import Keypoints, keypoints_of
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory, write_landmarks
from stereotrack_core.recording.writing import VideoWriter, write_png, write_recording_description
from stereotrack_core.simulation.make import Simulation, simulate
from stereotrack_core.simulation.rig import SceneOptions
from stereotrack_core.study.description import Study, StudyRecording, write_study
from stereotrack_core.study.job import Job, JobResult, values_of
from stereotrack_core.study.points import Point
from stereotrack_core.study.store import write_result_table
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.presets import named, preset, write_preset
from stereotrack_core.tracking.run_spec import RunSpec


@contextmanager
def full_disk(room: int) -> Iterator[None]:
    """Let no file grow beyond so many bytes; writing more fails as on a full disk."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (room, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def content_of(folder: Path) -> dict[str, bytes]:
    """Every file below a folder, hidden ones as well; folders are empty."""
    return {
        str(path.relative_to(folder)): path.read_bytes() if path.is_file() else b""
        for path in sorted(folder.rglob("*"))
    }


@dataclass(frozen=True, eq=False)
class Things:
    """What the writers are given."""

    recording: Recording
    run: Run
    run_file: Path
    truth: LandmarkTrajectory

    @property
    def reference(self) -> Reference:
        """The truth with something to say about itself."""
        return Reference(self.truth.frame, self.truth.points, meta={"annotators": ["A"]})

    @property
    def clicks(self) -> list[Click]:
        """Clicks in one camera."""
        camera = self.recording.views[0].image.camera
        return [
            Click(frame, camera, name, (3.0 + frame, 7.5), Visibility.SEEN)
            for frame in range(10)
            for name in LANDMARKS
        ]

    @property
    def keypoints(self) -> Keypoints:
        """What a detector might say of one camera."""
        camera = self.recording.views[0].image.camera
        rows = ((k, camera, "left_wrist", 3.0 + k, 7.5, 0.5, "x", 0) for k in range(40))
        return keypoints_of(rows)

    @property
    def picture(self) -> np.ndarray:
        """Noise, which nothing makes smaller."""
        return np.random.default_rng(1).integers(0, 256, (96, 128), dtype=np.uint8)


def _video(path: Path, things: Things) -> None:
    height, width = things.picture.shape
    with VideoWriter(path, fps=10, width=width, height=height, crf=0) as video:
        for turn in range(12):
            video.write(np.roll(things.picture, turn))


def _simulate(folder: Path, _things: Things) -> None:
    small = SceneOptions().replaced(width=96, height=64, focal=60)
    simulate(folder, Simulation(motion="t-pose", frames=3, views="N", options=small))


def _foreign(path: Path, things: Things, form: str) -> None:
    write_foreign(path, tuple(things.recording.cameras.values()), form)


def _demo(folder: Path, _things: Things) -> None:
    copied_demo(folder.parent)


def _imported(folder: Path, things: Things) -> None:
    images = (things.recording.folder / things.recording.views[0].image.frames).parent
    choices = propose(look_at([images]))
    make_recording(replace(choices, fps=10.0, calibration=None), folder)


def _description(folder: Path, things: Things) -> None:
    segments = (Segment("walk", 0, 5),)
    facts = {**vars(things.recording), "folder": folder, "segments": segments}
    write_recording_description(Recording(**facts))


def _window(path: Path, _things: Things) -> None:
    picture = QPixmap(160, 120)
    picture.fill()
    write_picture(path, picture)


def _angles(path: Path, things: Things) -> None:
    export_angles(path, angles_of_run(things.run), 10.0)


def _cloud(path: Path, _things: Things) -> None:
    points = np.random.default_rng(2).normal(size=(300, 3))
    write_cloud(path, points, np.arange(300) % 2, ("N", "S"), 7)


def _study(path: Path) -> Study:
    rows = (StudyRecording(f"data/r{k}", factors={"subject": f"s{k}"}) for k in range(40))
    return Study(path, tuple(rows))


def _results(path: Path, things: Things) -> None:
    study, truth = _study(Path("walks.study.toml")), things.truth
    result = JobResult("x", "done", values_of(things.run, things.recording.fps, truth))
    spec = RunSpec(preset("fast"), "fast")
    jobs = [Job("x", "", "", row.recording, "", "", Point(), spec) for row in study.rows]
    write_result_table(path, study, jobs, {"x": result})


FILES: dict[str, Callable[[Path, Things], None]] = {
    "run.npz": lambda path, things: write_npz(path, things.run),
    "run.csv": lambda path, things: write_run(path, things.run),
    "run.trc": lambda path, things: write_trc(path, things.truth, 10.0),
    "run.c3d": lambda path, things: write_c3d(path, things.truth, 10.0, things.run.residual),
    "run.bvh": lambda path, things: write_bvh(path, things.truth, 10.0),
    "reference.npz": lambda path, things: write_reference(path, things.reference),
    "exported reference.csv": lambda path, things: write_reference_table(path, things.reference),
    "landmarks.csv": lambda path, things: write_landmarks(path, things.truth),
    "clicks.csv": lambda path, things: write_clicks(path, things.clicks, things.recording),
    "coco.json": lambda path, things: write_coco(path, things.clicks, things.recording, NINE),
    "keypoints.csv": lambda path, things: write_table(path, things.keypoints, things.recording),
    "keypoints.json": lambda path, things: write_results(path, things.keypoints, things.recording),
    "deeplabcut.csv": lambda path, things: write_deeplabcut(path, things.clicks, LANDMARKS),
    "sleap.slp": lambda path, things: write_sleap(path, things.clicks, things.recording, NINE),
    "landmark set.toml": lambda path, _: write_landmark_set(path, NINE),
    "preset.toml": lambda path, _: write_preset(
        path, named("own", preset("fast").replaced(sigma_joint=20.0), "fast")
    ),
    "subject.toml": lambda path, things: write_subject(path, things.recording.subject),
    "calibration.toml": lambda path, things: write_calibration(path, things.recording.cameras),
    "theirs.toml": lambda path, things: _foreign(path, things, "aniposelib"),
    "theirs.xml": lambda path, things: _foreign(path, things, "opencv"),
    "segments.csv": lambda path, _: write_segments(
        path, [Segment(f"part {k}", k, k + 1) for k in range(20)]
    ),
    "cloud.ply": _cloud,
    "picture.png": lambda path, things: write_png(path, things.picture),
    "video.mp4": _video,
    "window.png": _window,
    "angles.csv": _angles,
    "walks.study.toml": lambda path, _: write_study(_study(path)),
    "results.csv": _results,
}
"""What writes one file (and perhaps another one beside it), by the file's name."""

FOLDERS: dict[str, Callable[[Path, Things], None]] = {
    "simulated": _simulate,
    "demo": _demo,
    "recording": _description,
    "imported": _imported,
}
"""What makes a folder."""

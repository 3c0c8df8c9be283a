"""Everything in the program that writes a file, and a disk that is full."""

import resource
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import tomli_w

from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.atomic import write_file
from stereotrack_core.demo import copied_demo
from stereotrack_core.evaluation.joint_angles import angles_of_run
from stereotrack_core.interop.bvh import write_bvh
from stereotrack_core.interop.c3d import write_c3d
from stereotrack_core.interop.calibrations.formats import write_foreign
from stereotrack_core.interop.coco import write_coco
from stereotrack_core.interop.deeplabcut import write_deeplabcut
from stereotrack_core.interop.keypoints.json_files import write_results
from stereotrack_core.interop.keypoints.reading import write_table
from stereotrack_core.interop.labels import write_clicks
from stereotrack_core.interop.ply import write_cloud
from stereotrack_core.interop.reference_npz import write_reference, write_reference_table
from stereotrack_core.interop.run_file import write_run
from stereotrack_core.interop.run_npz import write_npz
from stereotrack_core.interop.sleap import write_sleap
from stereotrack_core.interop.trc import write_trc
from stereotrack_core.project.exporting import export_angles
from stereotrack_core.recording.calibration import write_calibration
from stereotrack_core.recording.description import write_segments, write_subject
from stereotrack_core.recording.importing.making import make_recording
from stereotrack_core.recording.importing.proposing import propose
from stereotrack_core.recording.importing.sources import look_at
from stereotrack_core.recording.landmarks import write_landmarks
from stereotrack_core.recording.writing import VideoWriter, write_png, write_recording_description
from stereotrack_core.simulation.make import Simulation, simulate
from stereotrack_core.simulation.rig import SceneOptions
from stereotrack_core.study.description import Study, StudyRecording, StudySettings, write_study
from stereotrack_core.study.job import Job, JobResult, values_of
from stereotrack_core.study.points import Point
from stereotrack_core.study.store import write_result_table
from stereotrack_core.tracking.presets import UserPreset, preset, write_preset
from stereotrack_core.tracking.run_spec import RunSpec
from tests.reading.samples import Samples


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


def _video(path: Path, samples: Samples) -> None:
    with VideoWriter(path, fps=10, width=128, height=96, crf=0) as video:
        for turn in range(12):
            video.write(np.roll(samples.picture, turn))


def _simulate(folder: Path, _samples: Samples) -> None:
    small = SceneOptions().replaced(width=96, height=64, focal=60)
    simulate(folder, Simulation(motion="t-pose", frames=3, views="N", options=small))


def _imported(folder: Path, samples: Samples) -> None:
    choices = propose(look_at([samples.recording.folder / "N_right"]))
    make_recording(replace(choices, fps=10.0, calibration=None), folder)


def _foreign(path: Path, samples: Samples, form: str) -> None:
    write_foreign(path, tuple(samples.recording.cameras.values()), form)


def _cloud(path: Path, _samples: Samples) -> None:
    points = np.random.default_rng(2).normal(size=(300, 3))
    write_cloud(path, points, np.arange(300) % 2, ("N", "S"), 7)


def _study(path: Path) -> Study:
    rows = (
        StudyRecording("a/one", "one.stereotrack", factors={"gait": "slow"}),
        StudyRecording("a/two", factors={"gait": "fast"}),
    )
    settings = StudySettings(changes=("iterations=3",), grid=("views=N,NS",), seeds="0,1")
    return Study(path, rows, settings)


def _results(path: Path, samples: Samples) -> None:
    study = _study(Path("walks.study.toml"))
    result = JobResult("x", "done", values_of(samples.run, samples.recording, None))
    spec = RunSpec(preset("fast"), "fast")
    jobs = [Job("x", "", "", row.recording, "", "", Point(), spec) for row in study.rows]
    write_result_table(path, study, jobs, {"x": result})


PRESET = UserPreset("mine", "fast", {"iterations": 4, "legs": True, "picture_cost": 500.0})

FILES: dict[str, Callable[[Path, Samples], object]] = {
    "run.npz": lambda path, our: write_npz(path, our.run),
    "run.csv": lambda path, our: write_run(path, our.run),
    "run.trc": lambda path, our: write_trc(path, our.recording.reference, 10.0),
    "run.c3d": lambda path, our: write_c3d(path, our.recording.reference, 10.0, our.run.residual),
    "run.bvh": lambda path, our: write_bvh(path, our.recording.reference, 10.0),
    "reference.npz": lambda path, our: write_reference(path, our.reference),
    "exported reference.csv": lambda path, our: write_reference_table(path, our.reference),
    "landmarks.csv": lambda path, our: write_landmarks(path, our.recording.reference),
    "clicks.csv": lambda path, our: write_clicks(path, our.clicks, our.recording),
    "coco.json": lambda path, our: write_coco(path, our.clicks, our.recording, NINE),
    "keypoints.csv": lambda path, our: write_table(path, our.keypoints, our.recording),
    "keypoints.json": lambda path, our: write_results(path, our.keypoints, our.recording),
    "deeplabcut.csv": lambda path, our: write_deeplabcut(path, our.clicks, NINE.names),
    "sleap.slp": lambda path, our: write_sleap(path, our.seen_clicks, our.recording, NINE),
    "landmark set.toml": lambda path, _: write_file(path, tomli_w.dumps(NINE.facts())),
    "preset.toml": lambda path, _: write_preset(path, PRESET),
    "subject.toml": lambda path, our: write_subject(path, our.recording.subject),
    "calibration.toml": lambda path, our: write_calibration(path, our.recording.cameras),
    "theirs.toml": partial(_foreign, form="aniposelib"),
    "theirs.xml": partial(_foreign, form="opencv"),
    "segments.csv": lambda path, our: write_segments(path, our.recording.segments),
    "cloud.ply": _cloud,
    "picture.png": lambda path, our: write_png(path, our.picture),
    "video.mp4": _video,
    "angles.csv": lambda path, our: export_angles(path, angles_of_run(our.run), 10.0),
    "walks.study.toml": lambda path, _: write_study(_study(path)),
    "results.csv": _results,
}
"""What writes one file (and perhaps another one beside it), by the file's name."""

FOLDERS: dict[str, Callable[[Path, Samples], object]] = {
    "simulated": _simulate,
    "demo": lambda folder, _: copied_demo(folder.parent),
    "recording": lambda folder, our: write_recording_description(
        replace(our.recording, folder=folder)
    ),
    "imported": _imported,
}
"""What makes a folder."""

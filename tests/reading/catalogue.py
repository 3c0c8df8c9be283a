"""Every reader with a valid file, ways to damage it, and what is done with what was read."""

from __future__ import annotations

import json
import os
import random
import shutil
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import tomli_w
from scipy.io import savemat

from stereotrack_core.annotation.landmark_set import NINE, read_landmark_set, write_landmark_set
from stereotrack_core.errors import InputError
from stereotrack_core.evaluation.joint_angles import angles_of_reference, angles_of_run
from stereotrack_core.interop.c3d import write_c3d
from stereotrack_core.interop.calibrations.deciding import completed, decide
from stereotrack_core.interop.calibrations.formats import read_foreign
from stereotrack_core.interop.calibrations.opencv_storage import storage_text
from stereotrack_core.interop.coco import write_coco
from stereotrack_core.interop.deeplabcut import write_deeplabcut
from stereotrack_core.interop.first_pose import first_pose
from stereotrack_core.interop.label_source import LabelSource
from stereotrack_core.interop.labels import is_trajectory, read_labels, write_clicks
from stereotrack_core.interop.reference_npz import read_reference, write_reference
from stereotrack_core.interop.run_file import read_run, read_trajectory, write_trajectory
from stereotrack_core.interop.run_npz import write_npz
from stereotrack_core.interop.sleap import write_sleap
from stereotrack_core.interop.trc import write_trc
from stereotrack_core.project.runs import facts_of_meta, run_facts
from stereotrack_core.recording.consistency import check_consistency
from stereotrack_core.recording.description import read_segments, read_subject
from stereotrack_core.recording.detections import read_detections
from stereotrack_core.recording.folder import describe, open_recording
from stereotrack_core.recording.images import DamagedFrame, read_image
from stereotrack_core.recording.landmarks import read_landmarks, unknown_landmarks
from stereotrack_core.recording.stream_files import open_stream, picture_size
from stereotrack_core.study.store import stored_results
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.presets import UserPreset, read_preset, write_preset
from stereotrack_core.tracking.repeating import stored_spec, what_differs
from stereotrack_core.tracking.stored import body_of_run, fps_of_run, pose_of_run
from tests.interop.calibrations import layouts
from tests.reading.more_files import more_files
from tests.reading.mutations import (
    Mutation,
    mutated_arrays,
    mutated_bytes,
    mutated_json,
    mutated_meta,
    mutated_table,
    mutated_toml,
)
from tests.reading.samples import Samples, made_video

Read = Callable[[Path], object]


@dataclass(frozen=True)
class Reader:
    """What is damaged and read.

    Attributes
    ----------
    file : str
        Name under which the damaged file is put, relative to a folder of its own.
    content : bytes
        A valid file.
    damage : Mutation
    read : callable
        Reads the file and uses it as the program does.
    """

    file: str
    content: bytes
    damage: Mutation
    read: Read


def readers(samples: Samples, folder: Path) -> dict[str, Reader]:
    """All readers; `folder` may be written to, and lasts as long as they are used."""
    return {
        **_of_the_recording(samples, folder),
        **_of_arrays(samples, folder),
        **_of_other_tools(samples, folder),
        **_of_calibrations(folder),
        **_of_sweeps(folder),
        **_of_pictures(folder),
        **{name: Reader(*entry) for name, entry in more_files(samples, folder).items()},
    }


def _written(folder: Path, name: str, write: Callable[[Path], object]) -> bytes:
    write(folder / name)
    return (folder / name).read_bytes()


def each(*uses: Callable[[], object]) -> None:
    """Do all of them, whatever is refused."""
    for use in uses:
        with suppress(InputError):
            use()


# ---- the recording folder


def _of_the_recording(samples: Samples, folder: Path) -> dict[str, Reader]:
    own = samples.recording.folder

    def whole(path: Path) -> object:
        """The folder with one file of it damaged."""
        with suppress(InputError):
            open_recording(path.parent)
        return describe(path.parent, [])

    def trajectory(path: Path) -> object:
        each(lambda: unknown_landmarks(path), lambda: is_trajectory(path))
        found = read_landmarks(path)
        each(*(
            lambda s=suffix: write_trajectory(path.with_suffix(s), found, 10.0)
            for suffix in (".trc", ".c3d", ".bvh")
        ))  # fmt: skip
        return found

    detections = "frame,view,kind,x,y,z,sigma,confidence\n0,,head,0,0,1.6,0.05,1\n"
    detections += "1.5,S,left_hand,3,4,,2,\n2,N_left,hand,3,4,,2,0.5\n"
    corners = "frame,view,corner,x,y\n" + "".join(
        f"{frame},{view},{corner},{frame + 1},{corner + 0.5}\n"
        for frame in range(6) for view in ("N", "O", "S") for corner in range(8)
    )  # fmt: skip
    preset = UserPreset("mine", "fast", {"iterations": 4, "legs": True, "picture_cost": 500.0})
    return {
        "recording.toml": _in_recording(own, "recording.toml", mutated_toml, whole),
        "calibration.toml": _in_recording(own, "calibration.toml", mutated_toml, whole),
        "subject.toml": Reader(
            "s.toml", (own / "subject.toml").read_bytes(), mutated_toml, read_subject
        ),
        "reference.csv": Reader(
            "r.csv", (own / "reference.csv").read_bytes(), mutated_table, trajectory
        ),
        "segments.csv": Reader(
            "s.csv", (own / "segments.csv").read_bytes(), mutated_table, read_segments
        ),
        "detections.csv": Reader(
            "d.csv", detections.encode(), mutated_table,
            lambda path: read_detections(path, samples.recording),
        ),
        "board_corners_2d.csv": _in_recording(
            own, "board_corners_2d.csv", mutated_table,
            lambda path: list(check_consistency(describe(path.parent, []), 6)), corners.encode(),
        ),
        "landmark set": Reader(
            "l.toml", _written(folder, "l.toml", lambda path: write_landmark_set(path, NINE)),
            mutated_toml, read_landmark_set,
        ),
        "preset": Reader(
            "p.toml", _written(folder, "p.toml", lambda path: write_preset(path, preset)),
            mutated_toml, lambda path: read_preset(path).settings,
        ),
    }  # fmt: skip


def _in_recording(
    own: Path, name: str, damage: Mutation, read: Read, content: bytes | None = None
) -> Reader:
    """A file in a copy of the recording's folder."""

    def read_there(path: Path) -> object:
        for file in own.iterdir():
            if file.is_dir() and not (path.parent / file.name).exists():
                shutil.copytree(file, path.parent / file.name)
            elif file.is_file() and not os.path.lexists(path.parent / file.name):
                shutil.copy(file, path.parent)
        return read(path)

    return Reader(name, content or (own / name).read_bytes(), damage, read_there)


# ---- runs and references


def use_run(run: Run, samples: Samples) -> None:
    """What window and commands ask a run that was read."""
    each(
        run.trajectory,
        lambda: fps_of_run(run),
        lambda: body_of_run(run),
        lambda: [pose_of_run(run, i) for i in range(len(run.frame))],
        lambda: run_facts(json.loads(json.dumps(facts_of_meta(run.meta, run.frame, 3)))),
        lambda: stored_spec(run),
        lambda: what_differs(run, samples.recording),
        lambda: angles_of_run(run),
    )


def _of_arrays(samples: Samples, folder: Path) -> dict[str, Reader]:
    stored = _written(folder, "run.npz", lambda path: write_npz(path, samples.run))
    written = _written(folder, "ref.npz", lambda path: write_reference(path, samples.reference))

    def run(path: Path) -> object:
        each(lambda: read_trajectory(path), lambda: first_pose(str(path), 2))
        found = read_run(path)
        use_run(found, samples)
        trajectory = found.trajectory()
        each(*(
            lambda s=suffix: write_trajectory(path.with_suffix(s), trajectory, 10.0)
            for suffix in (".trc", ".c3d", ".bvh")
        ))  # fmt: skip
        return found

    def reference(path: Path) -> object:
        each(lambda: read_trajectory(path), lambda: first_pose(str(path), 2))
        found = read_reference(path)
        each(found.trajectory, lambda: angles_of_reference(found))
        return found

    return {
        "run.npz": Reader("run.npz", stored, mutated_arrays, run),
        "run.npz, meta": Reader("run.npz", stored, mutated_meta, run),
        "reference.npz": Reader("ref.npz", written, mutated_arrays, reference),
        "reference.npz, meta": Reader("ref.npz", written, mutated_meta, reference),
    }


# ---- files of other tools


def _of_other_tools(samples: Samples, folder: Path) -> dict[str, Reader]:
    recording, clicks, run = samples.recording, samples.clicks, samples.run

    def labels(path: Path) -> object:
        each(lambda: is_trajectory(path))
        found = read_labels(LabelSource(path, recording, NINE.names), 6)
        for problem in found.problems:
            str(problem)
        return found

    trajectory, of_sleap = run.trajectory(), {}
    if find_spec("sleap_io") is not None:
        shown = tuple(click for click in clicks if click.position is not None)
        content = _written(folder, "c.slp", lambda path: write_sleap(path, shown, recording, NINE))
        of_sleap = {"SLEAP": Reader("c.slp", content, mutated_bytes, labels)}
    return {
        **of_sleap,
        "TRC": Reader(
            "t.trc", _written(folder, "t.trc", lambda path: write_trc(path, trajectory, 10.0)),
            mutated_table, read_trajectory,
        ),
        "C3D": Reader(
            "t.c3d", _written(folder, "t.c3d", lambda path: write_c3d(path, trajectory, 10.0)),
            mutated_bytes, read_trajectory,
        ),
        "clicks": Reader(
            "c.csv", _written(folder, "c.csv", lambda path: write_clicks(path, clicks, recording)),
            mutated_table, labels,
        ),
        "COCO": Reader(
            "c.json",
            _written(folder, "c.json", lambda path: write_coco(path, clicks, recording, NINE)),
            mutated_json, labels,
        ),
        "DeepLabCut": Reader(
            "S.csv",
            _written(folder, "S.csv", lambda path: write_deeplabcut(path, clicks, NINE.names)),
            mutated_table, labels,
        ),
    }  # fmt: skip


def _of_calibrations(folder: Path) -> dict[str, Reader]:
    def decided(path: Path) -> object:
        foreign = completed(read_foreign([path]), size=(1280, 720))
        return decide(foreign)

    pair, _ = layouts.matlab(new=False)
    text = json.dumps(pair, default=lambda array: array.tolist())
    r, p = np.eye(3), np.array([[600.0, 0, 320, -72], [0, 600, 240, 0], [0, 0, 1, 0]])
    files: tuple[tuple[str, str, str | bytes, Mutation], ...] = (
        ("foreign TOML", "c.toml", tomli_w.dumps(layouts.sections()), mutated_toml),
        ("OpenCV YAML", "c.yml", layouts.stereo(), mutated_table),
        ("OpenCV XML", "c.xml", storage_text(layouts.RIG[:2], "mm", ".xml"), mutated_table),
        ("ROS", "r.yaml", layouts.ros("r", layouts.RIG[0], r, p), mutated_table),
        ("Qualisys", "q.txt", layouts.qualisys(layouts.RIG).replace("><", ">\n<"), mutated_table),
        ("ZED", "SN1.conf", layouts.ZED, mutated_table),
        ("MATLAB JSON", "m.json", text, mutated_json),
        (
            *("MATLAB MAT", "m.mat"),
            *(_written(folder, "m.mat", lambda path: savemat(path, {"s": pair})), mutated_bytes),
        ),
    )
    return {
        name: Reader(file, content.encode() if isinstance(content, str) else content, damage,
                     decided)
        for name, file, content, damage in files
    }  # fmt: skip


# ---- sweeps


def _of_sweeps(folder: Path) -> dict[str, Reader]:
    result = {
        "job": "a", "status": "done", "measures": {"unexplained_fraction": 0.1}, "frames": 3,
        "error": "", "attempts": 1, "recording": "r", "seed": 0, "point": {"iterations": 3},
    }  # fmt: skip
    search = {"search": "abc", "batch": 4}
    journal = "".join(json.dumps(line) + "\n" for line in (result, search, result)).encode()
    return {
        "sweep journal": Reader(
            "s.jobs.jsonl", journal, mutated_json,
            lambda path: stored_results(path.with_name("s.csv")),
        ),
    }  # fmt: skip


# ---- pictures and videos


def _of_pictures(folder: Path) -> dict[str, Reader]:
    rng = np.random.default_rng(3)
    colour = rng.integers(0, 255, (24, 32, 3)).astype(np.uint8)
    depth = rng.integers(0, 60_000, (24, 32)).astype(np.uint16)

    def encoded(suffix: str, picture: Any) -> bytes:
        return cv2.imencode(suffix, picture)[1].tobytes()

    def image(path: Path) -> object:
        for kind in ("grey", "colour", "depth"):
            with suppress(DamagedFrame):
                read_image(path, kind)
        each(lambda: picture_size(path.parent, path.name, "recording.toml"))
        return None

    pictures = {
        "PNG": ("i.png", encoded(".png", colour)),
        "depth PNG": ("i.png", encoded(".png", depth)),
        "JPEG": ("i.jpg", encoded(".jpg", colour)),
        "TIFF": ("i.tiff", encoded(".tiff", depth)),
        "BMP": ("i.bmp", encoded(".bmp", colour)),
    }
    videos = {
        "MP4": ("v.mp4", ("libx264", "yuv420p", {"g": "3", "bf": "1"})),
        "Matroska": ("v.mkv", ("ffv1", "gray")),
        "AVI": ("v.avi", ("mjpeg", "yuvj420p")),
    }
    return {
        **{
            name: Reader(file, data, mutated_bytes, image)
            for name, (file, data) in pictures.items()
        },
        **{
            name: Reader(file, made_video(folder / file, *how), mutated_bytes, watch)
            for name, (file, how) in videos.items()
        },
    }


def watch(path: Path) -> None:
    """Read a video as a stream of a recording, and all of its frames that can be read."""
    folder, name = path.parent, path.name
    each(lambda: picture_size(folder, name, "recording.toml"))
    for kind in ("colour", "grey", "depth"):
        source = open_stream(folder, name, kind, "recording.toml")
        try:
            frames: Iterable[int] = range(min(source.count(), 8))
            for k in (*frames, 0):
                with suppress(DamagedFrame):
                    source.read(k, lambda number, picture: None)
        finally:
            source.close()


def damaged(reader: Reader, name: str, number: int) -> bytes:
    """The damaged file of that number, the same always."""
    return reader.damage(reader.content, random.Random(f"{name} {number}"))

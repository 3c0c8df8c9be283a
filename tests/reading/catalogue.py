"""Every reader with a valid file, ways to damage it, and what is done with what was read."""

import json
import os
import random
import shutil
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from importlib.util import find_spec
from pathlib import Path

import cv2
import numpy as np
import tomli_w
from scipy.io import savemat

from stereotrack_core.annotation.landmark_set import NINE, read_landmark_set
from stereotrack_core.errors import InputError
from stereotrack_core.evaluation.joint_angles import angles_of_run, angles_of_trajectory
from stereotrack_core.interop.calibrations.deciding import completed, decide
from stereotrack_core.interop.calibrations.formats import read_foreign
from stereotrack_core.interop.calibrations.opencv_storage import storage_text
from stereotrack_core.interop.first_pose import first_pose
from stereotrack_core.interop.label_source import LabelSource
from stereotrack_core.interop.labels import is_trajectory, read_labels
from stereotrack_core.interop.reference_npz import read_reference
from stereotrack_core.interop.run_file import read_run, read_trajectory, write_trajectory
from stereotrack_core.project.runs import facts_of_meta, run_facts
from stereotrack_core.recording.consistency import check_consistency
from stereotrack_core.recording.description import read_segments, read_subject
from stereotrack_core.recording.detections import read_detections
from stereotrack_core.recording.folder import describe, open_recording
from stereotrack_core.recording.images import DamagedFrame, read_image
from stereotrack_core.recording.landmarks import (
    LandmarkTrajectory,
    read_landmarks,
    unknown_landmarks,
)
from stereotrack_core.recording.stream_files import open_stream, picture_size
from stereotrack_core.study.store import stored_results
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.presets import read_preset
from stereotrack_core.tracking.repeating import stored_spec, what_differs
from stereotrack_core.tracking.stored import body_of_run, fps_of_run, pose_of_run
from tests.interop.calibrations import layouts
from tests.reading.more_files import Contents, Reader, more_files
from tests.reading.mutations import (
    mutated_arrays,
    mutated_bytes,
    mutated_json,
    mutated_meta,
    mutated_table,
    mutated_toml,
)
from tests.reading.samples import FRAMES, Samples, made_video


def readers(samples: Samples, folder: Path) -> dict[str, Reader]:
    """All readers; `folder` may be written to, and lasts as long as they are used."""
    content = Contents(samples, folder)
    return {
        **_of_the_recording(samples, content),
        **_of_arrays(samples, content),
        **_of_calibrations(content),
        **_of_labels(samples, content),
        **_of_pictures(folder),
        **more_files(samples, content),
    }


def each(*uses: Callable[[], object]) -> None:
    """Do all of them, whatever is refused."""
    for use in uses:
        with suppress(InputError):
            use()


def exported(path: Path, found: LandmarkTrajectory) -> None:
    """Write a trajectory in every format that is not a table."""
    for suffix in (".trc", ".c3d", ".bvh"):
        with suppress(InputError):
            write_trajectory(path.with_suffix(suffix), found, 10.0)


def _of_the_recording(samples: Samples, content: Contents) -> dict[str, Reader]:
    own = samples.recording.folder

    def whole(path: Path) -> object:
        """The folder with one file of it damaged."""
        with suppress(InputError):
            open_recording(path.parent)
        return describe(path.parent, [])

    def trajectory(path: Path) -> object:
        each(lambda: unknown_landmarks(path), lambda: is_trajectory(path))
        found = read_landmarks(path)
        exported(path, found)
        return found

    detections = "frame,view,kind,x,y,z,sigma,confidence\n0,,head,0,0,1.6,0.05,1\n"
    detections += "1.5,S,left_hand,3,4,,2,\n2,N_left,hand,3,4,,2,0.5\n"
    corners = "frame,view,corner,x,y\n" + "".join(
        f"{frame},{view},{corner},{frame + 1},{corner + 0.5}\n"
        for frame in range(6) for view in ("N", "O", "S") for corner in range(8)
    )  # fmt: skip
    tables = {"reference.csv": trajectory, "segments.csv": read_segments}
    journal = {
        "job": "a", "status": "done", "measures": {"unexplained_fraction": 0.1}, "frames": 3,
        "error": "", "attempts": 1, "recording": "r", "seed": 0, "point": {"iterations": 3},
    }  # fmt: skip
    lines = [json.dumps(line) + "\n" for line in (journal, {"search": "abc", "batch": 4}, journal)]
    return {
        "recording.toml": _in_recording(own, "recording.toml", mutated_toml, whole),
        "calibration.toml": _in_recording(own, "calibration.toml", mutated_toml, whole),
        "subject.toml": Reader("s.toml", content("subject.toml"), mutated_toml, read_subject),
        **{name: Reader(name, (own / name).read_bytes(), mutated_table, read)
           for name, read in tables.items()},
        "detections.csv": Reader(
            "d.csv", detections.encode(), mutated_table,
            lambda path: read_detections(path, samples.recording),
        ),
        "board_corners_2d.csv": _in_recording(
            own, "board_corners_2d.csv", mutated_table,
            lambda path: list(check_consistency(describe(path.parent, []), 6)), corners.encode(),
        ),
        "landmark set": Reader(
            "l.toml", content("landmark set.toml"), mutated_toml, read_landmark_set
        ),
        "preset": Reader(
            "p.toml", content("preset.toml"), mutated_toml, lambda path: read_preset(path).settings
        ),
        "sweep journal": Reader(
            "s.jobs.jsonl", "".join(lines).encode(), mutated_json,
            lambda path: stored_results(path.with_name("s.csv")),
        ),
    }  # fmt: skip


def _in_recording(own, name, damage, read, content=None) -> Reader:
    """A file in a copy of the recording's folder."""

    def read_there(path: Path) -> object:
        for file in own.iterdir():
            if file.is_dir() and not (path.parent / file.name).exists():
                shutil.copytree(file, path.parent / file.name)
            elif file.is_file() and not os.path.lexists(path.parent / file.name):
                shutil.copy(file, path.parent)
        return read(path)

    return Reader(name, content or (own / name).read_bytes(), damage, read_there)


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


def _of_arrays(samples: Samples, content: Contents) -> dict[str, Reader]:
    def run(path: Path) -> object:
        each(lambda: read_trajectory(path), lambda: first_pose(str(path), 2))
        found = read_run(path)
        use_run(found, samples)
        exported(path, found.trajectory())
        return found

    def reference(path: Path) -> object:
        each(lambda: read_trajectory(path), lambda: first_pose(str(path), 2))
        found = read_reference(path)
        each(found.trajectory, lambda: angles_of_trajectory(found.trajectory()))
        return found

    ways = {"": mutated_arrays, ", meta": mutated_meta}
    return {
        name + end: Reader(name, content(name), damage, read)
        for name, read in (("run.npz", run), ("reference.npz", reference))
        for end, damage in ways.items()
    }


def _of_labels(samples: Samples, content: Contents) -> dict[str, Reader]:
    def labels(path: Path) -> object:
        each(lambda: is_trajectory(path))
        found = read_labels(LabelSource(path, samples.recording, NINE.names), FRAMES)
        each(*(problem.__str__ for problem in found.problems))
        return found

    files = [
        ("TRC", "t.trc", "run.trc", mutated_table, read_trajectory),
        ("C3D", "t.c3d", "run.c3d", mutated_bytes, read_trajectory),
        ("clicks", "c.csv", "clicks.csv", mutated_table, labels),
        ("COCO", "c.json", "coco.json", mutated_json, labels),
        ("DeepLabCut", "S.csv", "deeplabcut.csv", mutated_table, labels),
    ]
    argus = b"head_cam_1_x,head_cam_1_y\n12.5,7.25\nNaN,NaN\n13.5,8.25\n"
    if find_spec("sleap_io") is not None:
        files.append(("SLEAP", "c.slp", "sleap.slp", mutated_bytes, labels))
    return {
        **{name: Reader(file, content(ours), *how) for name, file, ours, *how in files},
        "Argus": Reader("argus.csv", argus, mutated_table, labels),
    }


def _of_calibrations(content: Contents) -> dict[str, Reader]:
    def decided(path: Path) -> object:
        return decide(completed(read_foreign([path]), size=(1280, 720)))

    pair, _ = layouts.matlab(new=False)
    text = json.dumps(pair, default=lambda array: array.tolist())
    mat = content.written("m.mat", partial(savemat, mdict={"s": pair}))
    r, p = np.eye(3), np.array([[600.0, 0, 320, -72], [0, 600, 240, 0], [0, 0, 1, 0]])
    files = (
        ("foreign TOML", "c.toml", tomli_w.dumps(layouts.sections()), mutated_toml),
        ("OpenCV YAML", "c.yml", layouts.stereo(), mutated_table),
        ("OpenCV XML", "c.xml", storage_text(layouts.RIG[:2], "mm", ".xml"), mutated_table),
        ("ROS", "r.yaml", layouts.ros("r", layouts.RIG[0], r, p), mutated_table),
        ("Qualisys", "q.txt", layouts.qualisys(layouts.RIG).replace("><", ">\n<"), mutated_table),
        ("ZED", "SN1.conf", layouts.ZED, mutated_table),
        ("MATLAB JSON", "m.json", text, mutated_json),
        ("MATLAB MAT", "m.mat", mat, mutated_bytes),
    )
    return {
        name: Reader(file, data.encode() if isinstance(data, str) else data, damage, decided)
        for name, file, data, damage in files
    }


def _of_pictures(folder: Path) -> dict[str, Reader]:
    rng = np.random.default_rng(3)
    colour = rng.integers(0, 255, (24, 32, 3)).astype(np.uint8)
    depth = rng.integers(0, 60_000, (24, 32)).astype(np.uint16)

    def image(path: Path) -> object:
        for kind in ("grey", "colour", "depth"):
            with suppress(DamagedFrame):
                read_image(path, kind)
        each(lambda: picture_size(path.parent, path.name, "recording.toml"))
        return None

    pictures = {
        "PNG": ("i.png", colour), "depth PNG": ("i.png", depth), "JPEG": ("i.jpg", colour),
        "TIFF": ("i.tiff", depth), "BMP": ("i.bmp", colour),
    }  # fmt: skip
    videos = {
        "MP4": ("v.mp4", "libx264", "yuv420p", {"g": "3", "bf": "1"}),
        "Matroska": ("v.mkv", "ffv1", "gray"),
        "AVI": ("v.avi", "mjpeg", "yuvj420p"),
    }
    encoded = {
        name: Reader(file, cv2.imencode(file[1:], picture)[1].tobytes(), mutated_bytes, image)
        for name, (file, picture) in pictures.items()
    }
    return encoded | {
        name: Reader(file, made_video(folder / file, *how), mutated_bytes, watch)
        for name, (file, *how) in videos.items()
    }


def watch(path: Path) -> None:
    """Read a video as a stream of a recording, and all of its frames that can be read."""
    folder, name = path.parent, path.name
    each(lambda: picture_size(folder, name, "recording.toml"))
    for kind in ("colour", "grey", "depth"):
        source = open_stream(folder, name, kind, "recording.toml")
        try:
            for k in (*range(min(source.count(), 8)), 0):
                with suppress(DamagedFrame):
                    source.read(k, lambda number, picture: None)
        finally:
            source.close()


def damaged(reader: Reader, name: str, number: int) -> bytes:
    """The damaged file of that number, the same always."""
    return reader.damage(reader.content, random.Random(f"{name} {number}"))

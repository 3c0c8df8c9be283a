"""Further readers for the catalogue: keypoints, HDF5, bags of ROS, studies, point tables."""

from __future__ import annotations

import io
import json
import pickle
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.errors import InputError
from stereotrack_core.interop.deeplabcut import write_deeplabcut
from stereotrack_core.interop.keypoints.reading import read_keypoints
from stereotrack_core.interop.keypoints.source import KeypointSource
from stereotrack_core.interop.keypoints.table import write_table
from stereotrack_core.interop.label_source import LabelSource
from stereotrack_core.interop.labels import read_labels
from stereotrack_core.recording.importing.readers import first_picture
from stereotrack_core.recording.importing.sources import look_at
from stereotrack_core.recording.keypoint_names import BODY_25, COCO_17
from stereotrack_core.recording.keypoints import keypoints_of
from stereotrack_core.study.description import (
    Study,
    StudyRecording,
    StudySettings,
    read_study,
    selected,
    write_study,
)
from tests.reading.mutations import (
    Mutation,
    mutated_bytes,
    mutated_json,
    mutated_table,
    mutated_toml,
)
from tests.reading.samples import FRAMES, Samples

Entry = tuple[str, bytes, Mutation, Callable[[Path], object]]
"""What a reader of the catalogue is made of."""


def more_files(samples: Samples, folder: Path) -> dict[str, Entry]:
    """Name of the file, valid content, damage, and what reads it, by the reader's name."""
    return {
        **_of_keypoints(samples, folder),
        **_of_studies(folder),
        **_of_points(samples),
        **(_of_hdf5(samples) if find_spec("h5py") is not None else {}),
        **(_of_bags(folder) if find_spec("rosbags") is not None else {}),
    }


def _written(path: Path, write: Callable[[Path], object]) -> bytes:
    write(path)
    return path.read_bytes()


# ---- keypoints


def _of_keypoints(samples: Samples, folder: Path) -> dict[str, Entry]:
    def read(path: Path) -> object:
        found = read_keypoints(KeypointSource(path, samples.recording, camera="S"), FRAMES)
        return found.summary(), len(found.keypoints)

    def one_of_openpose(path: Path) -> object:
        return read(path.parent)

    entries: dict[str, tuple[str, bytes, Mutation]] = {
        "keypoints, MMPose": ("S.json", _json(_mmpose()), mutated_json),
        "keypoints, COCO results": ("S.json", _json([_result(k) for k in range(3)]), mutated_json),
        "keypoints, COCO": ("S.json", _json(_annotations()), mutated_json),
        "keypoints, table": (
            "S.csv",
            _written(folder / "k.csv", lambda path: _table(path, samples)),
            mutated_table,
        ),
        "keypoints, DeepLabCut": (
            "S.csv",
            _written(
                folder / "d.csv", lambda path: write_deeplabcut(path, samples.clicks, NINE.names)
            ),
            mutated_table,
        ),
    }
    openpose = _json({"people": [{"person_id": [-1], "pose_keypoints_2d": _values(25)}]})
    return {
        **{name: (*entry, read) for name, entry in entries.items()},
        "keypoints, OpenPose": (
            "S_000000000002_keypoints.json", openpose, mutated_json, one_of_openpose
        ),
    }  # fmt: skip


def _json(content: Any) -> bytes:
    return json.dumps(content).encode()


def _values(count: int) -> list[float]:
    return [value for i in range(count) for value in (3.0 + i, 4.0 + i, 0.5)]


def _result(image: int) -> dict[str, Any]:
    return {"image_id": image, "category_id": 1, "keypoints": _values(17), "score": 0.9}


def _mmpose() -> dict[str, Any]:
    places = [[3.0 + i, 4.0 + i] for i in range(17)]
    instance = {"keypoints": places, "keypoint_scores": [0.5] * 17}
    frames = [{"frame_id": k + 1, "instances": [instance]} for k in range(2)]
    named = {str(i): name for i, name in enumerate(COCO_17)}
    return {"meta_info": {"keypoint_id2name": named}, "instance_info": frames}


def _annotations() -> dict[str, Any]:
    return {
        "images": [{"id": 5, "file_name": "S/000002.png"}],
        "annotations": [
            {"id": 1, "image_id": 5, "category_id": 1, "keypoints": [1, 2, 2, 3, 4, 1, 0, 0, 0]}
        ],
        "categories": [{"id": 1, "keypoints": list(COCO_17[:3])}],
    }


def _table(path: Path, samples: Samples) -> None:
    rows = ((k, "S", BODY_25[i], 3.0 + k, 7.5, 0.5, "x", 0) for k in range(3) for i in range(4))
    write_table(path, keypoints_of(rows), samples.recording)


# ---- studies


def _of_studies(folder: Path) -> dict[str, Entry]:
    rows = (
        StudyRecording("a/one", "one.stereotrack", factors={"gait": "slow"}),
        StudyRecording("a/two", factors={"gait": "fast"}),
    )
    settings = StudySettings(changes=("iterations=3",), grid=("views=N,NS",), seeds="0,1")
    made = Study(folder / "s.study.toml", rows, settings)
    file = _written(made.path, lambda path: write_study(replace(made, path=path)))

    def study(path: Path) -> object:
        found = read_study(path)
        return [found.runs_of(row) for row in selected(found, ["gait=slow"])]

    return {"study": ("s.study.toml", file, mutated_toml, study)}


# ---- tables of points


def _of_points(samples: Samples) -> dict[str, Entry]:
    def read(path: Path) -> object:
        source = LabelSource(path, samples.recording, NINE.names)
        return [str(problem) for problem in read_labels(source, 6).problems]

    table = b"head_cam_1_x,head_cam_1_y\n12.5,7.25\nNaN,NaN\n13.5,8.25\n"
    return {"Argus": ("argus.csv", table, mutated_table, read)}


# ---- HDF5


OF_HDF5 = ("DeepLabCut HDF5", "keypoints, DeepLabCut HDF5")


def _of_hdf5(samples: Samples) -> dict[str, Entry]:
    def labels(path: Path) -> object:
        return read_labels(LabelSource(path, samples.recording, NINE.names), FRAMES).problems

    def keypoints(path: Path) -> object:
        source = KeypointSource(path, samples.recording, camera="S")
        return read_keypoints(source, FRAMES).summary()

    label, predicted = OF_HDF5
    return {
        label: ("S.h5", _stored(_fixed_labels), mutated_bytes, labels),
        predicted: ("SDLC_walk.h5", _stored(_predictions), mutated_bytes, keypoints),
    }


def _stored(write: Callable[[Any], None]) -> bytes:
    import h5py

    file = io.BytesIO()
    with h5py.File(file, "w") as stored:
        write(stored)
    return file.getvalue()


def _fixed_labels(stored: Any) -> None:
    """As pandas writes a table of the format ``fixed``."""
    group = stored.create_group("df_with_missing")
    axes = {
        "block0_items": [("scorer", name, axis) for name in NINE.names[:2] for axis in "xy"],
        "axis1": [("labeled-data", "S", f"img{frame:06d}.png") for frame in range(3)],
    }
    for axis, names in axes.items():
        for level, texts in enumerate(zip(*names, strict=True)):
            known = sorted(set(texts))
            group[f"{axis}_level{level}"] = np.array([text.encode() for text in known])
            group[f"{axis}_label{level}"] = np.array([known.index(text) for text in texts])
    group["block0_values"] = np.arange(2.0 * 2 * 3).reshape(3, 4)


def _predictions(stored: Any) -> None:
    """As PyTables writes what DeepLabCut has predicted."""
    axes = ("x", "y", "likelihood")
    columns = [("scorer", part, axis) for part in ("nose", "neck") for axis in axes]
    kinds = np.dtype([("index", "<i8"), ("values_block_0", "<f8", (6,))])
    rows = np.array([(frame, (1.0, 2.0, 0.5, 4.0, 5.0, 0.75)) for frame in range(3)], dtype=kinds)
    table = stored.create_group("df_with_missing").create_dataset("table", data=rows)
    table.attrs["values_block_0_kind"] = np.void(pickle.dumps(columns, 0))


def _of_bags(folder: Path) -> dict[str, Entry]:
    from tests.recording.importing.bags import depth_bag, stereo_bag

    def look(path: Path) -> object:
        found = look_at([path])
        for source in found.sources:
            with suppress(InputError):
                first_picture(source)
        return found

    one = stereo_bag(folder / "one.bag", frames=2)
    two = next(depth_bag(folder / "two", "mcap", frames=2).glob("*.mcap"))
    three = next(stereo_bag(folder / "three", "sqlite3", frames=2).glob("*.db3"))
    return {
        "ROS bag": ("one.bag", one.read_bytes(), mutated_bytes, look),
        "ROS MCAP": ("two.mcap", two.read_bytes(), mutated_bytes, look),
        "ROS SQLite": ("three.db3", three.read_bytes(), mutated_bytes, look),
    }

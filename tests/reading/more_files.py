"""Readers for the catalogue: what one is, and those of keypoints, HDF5, studies."""

import io
import json
import pickle
from collections.abc import Callable
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.interop.keypoints.reading import read_keypoints
from stereotrack_core.interop.keypoints.source import KeypointSource
from stereotrack_core.interop.label_source import LabelSource
from stereotrack_core.interop.labels import read_labels
from stereotrack_core.recording.keypoint_names import COCO_17
from stereotrack_core.study.description import read_study, selected
from tests.end_to_end.writers import FILES
from tests.reading.mutations import (
    Mutation,
    mutated_bytes,
    mutated_json,
    mutated_table,
    mutated_toml,
)
from tests.reading.samples import FRAMES, Samples

OF_HDF5 = ("DeepLabCut HDF5", "keypoints, DeepLabCut HDF5")
# Libraries that not everybody installs.
NEEDED = {"SLEAP": "sleap_io", **dict.fromkeys(OF_HDF5, "h5py")}


@dataclass(frozen=True)
class Reader:
    """What is damaged and read."""

    file: str  # name under which the damaged file is put, relative to a folder of its own
    content: bytes  # a valid file
    damage: Mutation
    read: Callable[[Path], object]  # reads the file and uses it as the program does


@dataclass(frozen=True)
class Contents:
    """Valid files as the program writes them."""

    samples: Samples
    folder: Path

    def __call__(self, name: str) -> bytes:
        """Content of one of :data:`FILES`."""
        return self.written(name, lambda path: FILES[name](path, self.samples))

    def written(self, name: str, write: Callable[[Path], object]) -> bytes:
        """What is written to a file of that name."""
        write(self.folder / name)
        return (self.folder / name).read_bytes()


def more_files(samples: Samples, content: Contents) -> dict[str, Reader]:
    """Further readers by their names."""
    return {
        **_of_keypoints(samples, content),
        "study": Reader("s.study.toml", content("walks.study.toml"), mutated_toml, _study),
        **(_of_hdf5(samples) if find_spec("h5py") is not None else {}),
    }


def _study(path: Path) -> object:
    found = read_study(path)
    return [found.runs_of(row) for row in selected(found, ["gait=slow"])]


def _of_keypoints(samples: Samples, content: Contents) -> dict[str, Reader]:
    def read(path: Path) -> object:
        found = read_keypoints(KeypointSource(path, samples.recording, camera="S"), FRAMES)
        return found.summary(), len(found.keypoints)

    openpose = {"people": [{"person_id": [-1], "pose_keypoints_2d": _values(25)}]}
    trees = {
        "MMPose": ("S.json", _mmpose(), read),
        "COCO results": ("S.json", [_result(k) for k in range(3)], read),
        "COCO": ("S.json", _annotations(), read),
        "OpenPose": (
            "S_000000000002_keypoints.json", openpose, lambda path: read(path.parent)
        ),
    }  # fmt: skip
    files = {name: Reader(file, json.dumps(tree).encode(), mutated_json, use)
             for name, (file, tree, use) in trees.items()}  # fmt: skip
    for name, ours in (("table", "keypoints.csv"), ("DeepLabCut", "deeplabcut.csv")):
        files[name] = Reader("S.csv", content(ours), mutated_table, read)
    return {f"keypoints, {name}": reader for name, reader in files.items()}


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


def _of_hdf5(samples: Samples) -> dict[str, Reader]:
    def labels(path: Path) -> object:
        return read_labels(LabelSource(path, samples.recording, NINE.names), FRAMES).problems

    def keypoints(path: Path) -> object:
        source = KeypointSource(path, samples.recording, camera="S")
        return read_keypoints(source, FRAMES).summary()

    label, predicted = OF_HDF5
    return {
        label: Reader("S.h5", _stored(_fixed_labels), mutated_bytes, labels),
        predicted: Reader("SDLC_walk.h5", _stored(_predictions), mutated_bytes, keypoints),
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

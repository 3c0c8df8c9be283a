"""Further readers for the catalogue: HDF5 of DeepLabCut, and tables of points of other programs."""

from __future__ import annotations

import io
import pickle
import random
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.interop.keypoints.reading import read_keypoints
from stereotrack_core.interop.keypoints.source import KeypointSource
from stereotrack_core.interop.label_source import LabelSource
from stereotrack_core.interop.labels import read_labels
from stereotrack_core.interop.point_tables import write_points
from tests.reading.mutations import Mutation, mutated_bytes, mutated_table
from tests.reading.samples import FRAMES, Samples

Entry = tuple[str, bytes, Mutation, Callable[[Path], object]]
"""What a reader of the catalogue is made of."""

OF_HDF5 = ("DeepLabCut HDF5", "keypoints, DeepLabCut HDF5")


def label_files(samples: Samples, folder: Path) -> dict[str, Entry]:
    """Name of the file, valid content, damage, and what reads it, by the reader's name."""

    def labels(path: Path) -> object:
        found = read_labels(LabelSource(path, samples.recording, NINE.names), FRAMES)
        return [str(problem) for problem in found.problems]

    def keypoints(path: Path) -> object:
        found = read_keypoints(KeypointSource(path, samples.recording, camera="S"), FRAMES)
        return found.summary(), len(found.keypoints)

    entries: dict[str, Entry] = {}
    for name, form in (("Argus", "argus"), ("XMALab", "xmalab")):
        path = folder / f"{form}.csv"
        write_points(path, samples.clicks, samples.recording, NINE.names, form)
        beside = path.with_name(path.name + ".json").read_bytes()
        entries[name] = (path.name, path.read_bytes(), mutated_table, _with(beside, labels))
    if find_spec("h5py") is not None:
        label, predicted = OF_HDF5
        entries[label] = ("S.h5", _labels(), mutated_hdf5, labels)
        entries[predicted] = ("SDLC_walk.h5", _keypoints(), mutated_hdf5, keypoints)
    return entries


def _with(beside: bytes, read: Callable[[Path], object]) -> Callable[[Path], object]:
    def read_there(path: Path) -> object:
        path.with_name(path.name + ".json").write_bytes(beside)
        return read(path)

    return read_there


def _of_hdf5(write: Callable[[Any], None], content: bytes = b"") -> bytes:
    import h5py

    file = io.BytesIO(content)
    with h5py.File(file, "r+" if content else "w") as stored:
        write(stored)
    return file.getvalue()


def _labels() -> bytes:
    """As pandas writes a table of the format ``fixed``."""
    places = np.arange(2.0 * 2 * 3).reshape(3, 4)
    places[1, 2:] = np.nan

    def write(stored: Any) -> None:
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
        group["block0_values"] = places

    return _of_hdf5(write)


def _keypoints() -> bytes:
    """As PyTables writes what DeepLabCut has predicted."""
    columns = [
        ("scorer", part, axis) for part in ("nose", "neck") for axis in ("x", "y", "likelihood")
    ]
    kinds = np.dtype([("index", "<i8"), ("values_block_0", "<f8", (6,))])
    rows = np.array([(frame, (1.0, 2.0, 0.5, 4.0, 5.0, 0.75)) for frame in range(3)], dtype=kinds)

    def write(stored: Any) -> None:
        table = stored.create_group("df_with_missing").create_dataset("table", data=rows)
        table.attrs["values_block_0_kind"] = np.void(pickle.dumps(columns, 0))

    return _of_hdf5(write)


def mutated_hdf5(content: bytes, rng: random.Random) -> bytes:
    """The file with another data set or attribute in place of one, or with wrong bytes."""
    if rng.random() < 0.3:
        return mutated_bytes(content, rng)

    def spoil(stored: Any) -> None:
        group = stored["df_with_missing"]
        name = rng.choice(sorted(group))
        attributes = group[name].attrs
        if len(attributes) and rng.random() < 0.5:
            attributes["values_block_0_kind"] = _other_kind(rng)
            return
        kept = dict(attributes)
        before = group[name][()]
        del group[name]
        if rng.random() < 0.9:
            group[name] = _other_array(before, rng)
            for key, value in kept.items():
                group[name].attrs[key] = value

    return _of_hdf5(spoil, content)


def _other_kind(rng: random.Random) -> Any:
    """A description of columns that pandas would not have written."""
    told = rng.choice(
        [[], [()], [("a",)] * 6, [("s", "nose", "x")] * 6, "xyzxyz", 6, [(1, 2, 3)] * 6, {"a": 1}]
    )
    return rng.choice([np.void(pickle.dumps(told, 0)), np.void(b"x"), "text", 4.0])


def _other_array(before: Any, rng: random.Random) -> Any:
    """An array of another type, shape or content."""
    choices: list[Callable[[], Any]] = [
        lambda: before[:-1],
        lambda: np.concatenate([before, before]),
        lambda: before[::-1].copy(),
        lambda: np.zeros(0),
        lambda: np.zeros((3, 0)),
        lambda: 3.0,
        lambda: np.array([b"text", b"\xff\xfe", b""]),
        lambda: rng.choice([-1.0, 2.0**70, np.nan, np.inf, 1e308]) * np.ones(np.shape(before)),
        lambda: np.full(np.shape(before), -(2**62)),
        lambda: np.zeros(np.shape(before), dtype=complex),
        lambda: np.zeros(3, dtype=[("index", "<f8"), ("values_block_0", "<f8", (5,))]),
        lambda: np.full(3, np.nan, dtype=[("index", "<f8"), ("values_block_0", "<f8", (6,))]),
    ]
    return rng.choice(choices)()

"""Keypoints predicted by 2-D detectors in a recording, as one table.

They are a program's predictions, never clicks. Places are pixels of the raw picture of a camera.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from types import MappingProxyType
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray

TextArray: TypeAlias = NDArray[np.str_]


@dataclass(frozen=True, eq=False)
class Keypoints:
    """Predicted keypoints, one in a row; N rows, in the order of their frames."""

    frame: IntArray  # (N,). Of the recording, counted from 0.
    camera: TextArray  # (N,). Name of the camera in the calibration.
    keypoint: TextArray  # (N,). As `keypoint_names` has them; left and right are the person's.
    place: FloatArray  # (N, 2). Column and row in the raw picture, finite.
    confidence: FloatArray  # (N,). From 0 to 1, as the detector says.
    source: TextArray  # (N,). Name of the detector, or of the file where it has none.
    person: IntArray  # (N,). Which of several people, from 0.

    def __len__(self) -> int:
        return len(self.frame)

    def __getitem__(self, rows: BoolArray | IntArray | slice) -> Keypoints:
        """Some of the rows."""
        return Keypoints(*(getattr(self, one.name)[rows] for one in fields(self)))

    def of_frame(self, frame: int) -> Keypoints:
        """Rows of one frame."""
        return self.of_frames(range(frame, frame + 1))

    def of_frames(self, frames: range) -> Keypoints:
        """Rows of successive frames."""
        first, end = np.searchsorted(self.frame, [frames.start, frames.stop])
        return self[slice(int(first), int(end))]

    @property
    def cameras(self) -> tuple[str, ...]:
        """Cameras that anything is predicted of, by name."""
        return tuple(np.unique(self.camera).tolist())

    def fingerprint(self) -> str:
        """Hash (32 hexadecimal digits) of all that they say."""
        digest = hashlib.blake2b(digest_size=16)
        for one in fields(self):
            digest.update(repr(getattr(self, one.name).tolist()).encode())
        return digest.hexdigest()


Row: TypeAlias = tuple[int, str, str, float, float, float, str, int]
"""Frame, camera, keypoint, column, row, confidence, source and person."""


def keypoints_of(rows: Iterable[Row]) -> Keypoints:
    """Sorted table of the rows with finite places; confidences from 0 to 1, 1 where unknown."""
    kept = [row for row in rows if np.isfinite(row[3:5]).all()]
    kept.sort(key=lambda row: (row[0], row[1], row[6], row[7], row[2]))
    frame, camera, keypoint, x, y, confidence, source, person = (
        zip(*kept, strict=True) if kept else ((),) * 8
    )
    sure = np.nan_to_num(np.array(confidence, dtype=np.float64), nan=1.0)
    return Keypoints(
        np.array(frame, dtype=np.int64),
        np.array(camera, dtype=np.str_),
        np.array(keypoint, dtype=np.str_),
        np.stack([np.array(x, dtype=np.float64), np.array(y, dtype=np.float64)], axis=1),
        np.clip(sure, 0.0, 1.0),
        np.array(source, dtype=np.str_),
        np.array(person, dtype=np.int64),
    )


def rows_of(keypoints: Keypoints) -> Iterator[Row]:
    """The rows as plain values."""
    names = [one.name for one in fields(keypoints) if one.name != "place"]
    columns = [getattr(keypoints, name).tolist() for name in names]
    for (frame, camera, keypoint, sure, source, person), (x, y) in zip(
        zip(*columns, strict=True), keypoints.place.tolist(), strict=True
    ):
        yield frame, camera, keypoint, x, y, sure, source, person


def joined_keypoints(tables: Sequence[Keypoints]) -> Keypoints:
    """Rows of tables whose frames follow each other."""
    if not tables:
        return keypoints_of(())
    names = [one.name for one in fields(Keypoints)]
    return Keypoints(*(np.concatenate([getattr(t, name) for t in tables]) for name in names))


_NAMED = MappingProxyType({"camera": "camera", "point": "keypoint", "source": "source"})
"""Columns that are stored as numbers and a list of names, and the fields that they are."""


def columns_of(keypoints: Keypoints) -> dict[str, NDArray[Any]]:
    """Arrays to store: texts are numbers of the names in ``camera_names`` and the like.

    The number of the person is left out: what a run uses is of one person.
    """
    kept = ("frame", "place", "confidence")
    columns: dict[str, NDArray[Any]] = {name: getattr(keypoints, name) for name in kept}
    for name, field in _NAMED.items():
        names, number = np.unique(getattr(keypoints, field), return_inverse=True)
        columns |= {name: np.ravel(number).astype(np.int64), f"{name}_names": names}
    return columns


def keypoints_of_columns(columns: Mapping[str, NDArray[Any]]) -> Keypoints:
    """The table of :func:`columns_of`, bit by bit; ValueError if its numbers are impossible."""
    frame, place = columns["frame"].astype(np.int64), columns["place"].astype(np.float64)
    sure = columns["confidence"].astype(np.float64)
    texts = {}
    for name in _NAMED:
        number, names = columns[name], columns[f"{name}_names"]
        if len(number) and not (number.min() >= 0 and number.max() < len(names)):
            raise ValueError(f"a {name} of the keypoints has no name")
        texts[name] = names.astype(np.str_)[number] if len(names) else np.empty(0, dtype=np.str_)
    if not (np.isfinite(place).all() and ((sure >= 0.0) & (sure <= 1.0)).all()):
        raise ValueError("the keypoints contain impossible numbers")
    if (frame[1:] < frame[:-1]).any() or (frame < 0).any():
        raise ValueError("the keypoints are not in the order of their frames")
    return Keypoints(frame, texts["camera"], texts["point"], place, sure, texts["source"],
                     np.zeros(len(frame), dtype=np.int64))  # fmt: skip


def of_one_person(keypoints: Keypoints) -> Keypoints:
    """Rows of one person over all frames: of each source the one with the most confidence in all.

    Which of several people is followed is not decided here: in most recordings the surest is the
    one in the middle, whom all cameras see.
    """
    pictures, people = _pictures(keypoints, with_person=False), _pictures(keypoints)
    if people.max(initial=-1) == pictures.max(initial=-1):  # one person in every picture
        return keypoints
    kept: BoolArray = np.zeros(len(keypoints), dtype=np.bool_)
    for source in np.unique(keypoints.source).tolist():
        own = keypoints.source == source
        people, row = np.unique(keypoints.person[own], return_inverse=True)
        surest = people[np.argmax(np.bincount(row, keypoints.confidence[own]))]
        kept |= own & (keypoints.person == surest)
    return keypoints[kept]


def _pictures(keypoints: Keypoints, *, with_person: bool = True) -> IntArray:
    """Number (N,) of the picture and source of each row, or of the person in it, by frame."""
    number = np.zeros(len(keypoints), dtype=np.int64)
    for name in ("source", "camera", "frame", *(("person",) if with_person else ())):
        values, row = np.unique(getattr(keypoints, name), return_inverse=True)
        number = np.unique(number * max(len(values), 1) + np.ravel(row), return_inverse=True)[1]
    return np.ravel(number)


def changes_of_surest(keypoints: Keypoints) -> int:
    """How often the person who is the surest of a picture is another one in the next picture."""
    group = _pictures(keypoints)
    first = np.unique(group, return_index=True)[1]
    total = np.bincount(group, keypoints.confidence, len(first))
    picture = _pictures(keypoints, with_person=False)[first]
    order = np.lexsort((-total, picture))
    picture = picture[order]
    surest = first[order][np.unique(picture, return_index=True)[1]]
    own = keypoints[surest]
    same = (own.camera[1:] == own.camera[:-1]) & (own.source[1:] == own.source[:-1])
    return int(np.count_nonzero(same & (own.person[1:] != own.person[:-1])))

"""MediaPipe's landmarks as people save them: JSON, a list of ``frame`` and ``landmarks``.

A landmark is a table of ``x``, ``y`` and perhaps ``visibility``; several people of a frame are
lists of landmarks, or several entries. Places are shares of the image's size, or pixels.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from stereotrack_core.errors import InputError
from stereotrack_core.interop.keypoints.arrays import CONFIDENCES, pixels_of_shares
from stereotrack_core.interop.keypoints.people import FileRow, Who, stated_name
from stereotrack_core.interop.keypoints.source import KeypointSource
from stereotrack_core.interop.label_source import checked_frame
from stereotrack_core.plain_data import Kind, check_kind

_FRAMES = ("frame", "frame_id", "frame_number", "frame_index", "frame_idx")
_LANDMARKS = ("landmarks", "pose_landmarks", "keypoints")
_REMEDY = "Save a list of frame and landmarks, each with x, y and visibility."
_POINT: Kind = {"x": float, "y": float, **dict.fromkeys(CONFIDENCES, float), "name": str}
_KIND: Kind = [{**dict.fromkeys(_FRAMES, int), **{name: [object] for name in _LANDMARKS}}]


def is_mediapipe(content: Any) -> bool:
    """Whether JSON is such a list, or a table that holds one under ``frames``."""
    entries = _entries(content)
    first = entries[0] if entries else None
    if not isinstance(first, Mapping) or not any(name in first for name in _FRAMES):
        return False
    filled = [own for one in entries if isinstance(one, Mapping) and (own := _landmarks(one))]
    point = filled[0][0] if filled and isinstance(filled[0], list) else None
    point = point[0] if isinstance(point, list) and point else point
    return isinstance(point, Mapping) and {"x", "y"} <= set(point)


def _entries(content: Any) -> Sequence[Any]:
    if isinstance(content, Mapping):
        content = content.get("frames")
    return content if isinstance(content, list) else ()


def _landmarks(entry: Mapping[str, Any]) -> Any:
    return next((entry[name] for name in _LANDMARKS if entry.get(name)), None)


def read_mediapipe(source: KeypointSource, content: Any) -> Iterator[FileRow]:
    """Rows of the file; InputError where it makes no sense, or its camera cannot be told."""
    path = str(source.path)
    camera, entries = source.camera_of(source.path.name, path), _entries(content)
    check_kind(entries, _KIND, path, _REMEDY)
    people: dict[int, int] = {}
    rows: list[tuple[int, str, float, Who]] = []
    places: list[tuple[float, float]] = []
    for number, entry in enumerate(entries):
        where = f"{path}, entry {number}"
        stated = next((entry[name] for name in _FRAMES if entry.get(name) is not None), None)
        if stated is None:
            raise InputError("it states no frame", where=where, remedy=_REMEDY)
        frame = checked_frame(float(stated), where=where)
        own = _landmarks(entry) or []
        for points in own if own and isinstance(own[0], list) else [own]:
            who = Who(people.get(frame, 0), stated_name(entry.get("person_id")))
            people[frame] = who.place + 1
            check_kind(points, [_POINT], where, _REMEDY)
            names = source.points_of(len(points), where) if points else ()
            for name, point in zip(names, points, strict=True):
                sure = next((point[key] for key in CONFIDENCES if point.get(key) is not None), 1.0)
                places.append((point.get("x", np.nan), point.get("y", np.nan)))
                rows.append((frame, str(point.get("name") or name), float(sure), who))
    pixels = pixels_of_shares(
        np.array(places, dtype=np.float64).reshape(-1, 2), source.recording.cameras[camera]
    )
    for (frame, name, sure, who), (x, y) in zip(rows, pixels.tolist(), strict=True):
        yield frame, camera, name, x, y, sure, source.name, who

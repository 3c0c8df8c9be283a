"""OpenPose's folders of JSON files, one file for each picture (``--write_json``).

A file has ``people``, each with ``pose_keypoints_2d``: x, y and confidence of every point, and is
named after the picture: ``video_000000000012_keypoints.json``, ``cam01.0012.json``. It is known by
what it holds. A folder belongs to the camera that it is named after (``cam01`` or ``cam01_json``),
or holds such folders.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any

from stereotrack_core.errors import InputError
from stereotrack_core.interop.keypoints.people import FileRow, Who, stated_name
from stereotrack_core.interop.keypoints.source import KeypointSource
from stereotrack_core.interop.label_source import PicturePlaces
from stereotrack_core.plain_data import Kind, check_kind
from stereotrack_core.reading import SETTINGS_BYTES, read_json

_END = "_keypoints.json"
_REMEDY = "Use a folder written by OpenPose with --write_json."
_KIND: Kind = {"people": [{"pose_keypoints_2d": [float], "person_id": [object]}]}


def is_openpose(content: Any) -> bool:
    """Whether JSON is of one picture by OpenPose."""
    people = content.get("people") if isinstance(content, Mapping) else None
    return isinstance(people, list) and all(
        isinstance(one, Mapping) and "pose_keypoints_2d" in one for one in people
    )


def is_openpose_folder(folder: Path) -> bool:
    """Whether a folder holds such files, or folders of them; other JSON files do not matter."""
    return next(_pictures(folder), None) is not None


def _pictures(folder: Path) -> Iterator[Path]:
    """Files of OpenPose. Of files that differ in their numbers alone, the first one tells it."""
    known: dict[tuple[Path, str], bool] = {}
    for pattern in ("*.json", "*/*.json"):
        for path in sorted(folder.glob(pattern)):
            kind = path.parent, re.sub(r"\d+", "#", path.name)
            if kind not in known:
                known[kind] = path.name.endswith(_END) or _holds_openpose(path)
            if known[kind]:
                yield path


def _holds_openpose(path: Path) -> bool:
    try:
        return is_openpose(read_json(path, SETTINGS_BYTES, _REMEDY))
    except InputError:
        return False


def read_openpose(source: KeypointSource) -> Iterator[FileRow]:
    """Rows of all files of a folder, or of one file.

    InputError where a file cannot be read, or its camera or frame cannot be told.
    """
    path = source.path
    pictures = list(_pictures(path)) if path.is_dir() else [path]
    places = PicturePlaces(source.labels, map(_named, pictures))
    for path in pictures:
        if (place := places.of(_named(path), str(path))) is None:
            continue
        content = read_json(path, SETTINGS_BYTES, _REMEDY)
        check_kind(content, _KIND, str(path), _REMEDY)
        for index, one in enumerate(content.get("people") or []):
            values = (one or {}).get("pose_keypoints_2d") or []
            who = Who(index, stated_name((one or {}).get("person_id")))
            yield from _rows(values, source, str(path), (*place, who))


@cache
def _camera_folder(folder: Path) -> str:
    """Name of a folder without what says that it holds JSON."""
    name = folder.resolve().name
    return name.removesuffix("_json") or name


def _named(path: Path) -> str:
    """Path of the picture that a file is of, as its camera and its frame are told by."""
    return f"{_camera_folder(path.parent)}/{path.name.removesuffix(_END)}"


def _rows(
    values: list[float], source: KeypointSource, where: str, place: tuple[int, str, Who]
) -> Iterator[FileRow]:
    frame, camera, who = place
    if len(values) % 3:
        raise InputError(
            f"pose_keypoints_2d has {len(values)} numbers, not three for each point",
            where=where,
            remedy=_REMEDY,
        )
    if not values:
        return
    for i, name in enumerate(source.points_of(len(values) // 3, where)):
        x, y, sure = values[3 * i : 3 * i + 3]
        yield frame, camera, name, float(x), float(y), float(sure), source.name, who

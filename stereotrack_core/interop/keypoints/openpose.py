"""OpenPose's folders of JSON files, one file for each picture (``--write_json``).

A file is named after the picture, ``video_000000000012_keypoints.json``, and has ``people``, each
with ``pose_keypoints_2d``: x, y and confidence of every point. A folder belongs to the camera that
it is named after, or holds such folders.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from stereotrack_core.errors import InputError
from stereotrack_core.interop.keypoints.source import KeypointSource
from stereotrack_core.interop.label_source import frame_of
from stereotrack_core.plain_data import Kind, check_kind
from stereotrack_core.reading import SETTINGS_BYTES, read_json
from stereotrack_core.recording.keypoints import Row

_END = "_keypoints.json"
_REMEDY = "Use a folder written by OpenPose with --write_json."
_KIND: Kind = {"people": [{"pose_keypoints_2d": [float], "person_id": [object]}]}


def is_openpose(folder: Path) -> bool:
    """Whether a folder holds such files, or folders of them."""
    return next(_files(folder), None) is not None


def _files(folder: Path) -> Iterator[Path]:
    for pattern in (f"*{_END}", f"*/*{_END}"):
        yield from sorted(folder.glob(pattern))


def read_openpose(source: KeypointSource) -> Iterator[Row]:
    """Rows of all files of a folder.

    InputError where a file cannot be read, or its camera or frame cannot be told.
    """
    folder = source.path
    cameras: dict[Path, str] = {}
    for path in _files(folder):
        if path.parent not in cameras:
            told = f"{path.parent.resolve().name}/{path.name.removesuffix(_END)}"
            cameras[path.parent] = source.camera_of(told, str(path))
        frame = frame_of(path.name.removesuffix(_END), where=str(path))
        content = read_json(path, SETTINGS_BYTES, _REMEDY)
        check_kind(content, _KIND, str(path), _REMEDY)
        for person, one in enumerate(content.get("people") or []):
            values = (one or {}).get("pose_keypoints_2d") or []
            yield from _rows(values, source, str(path), (frame, cameras[path.parent], person))


def _rows(
    values: list[float], source: KeypointSource, where: str, place: tuple[int, str, int]
) -> Iterator[Row]:
    frame, camera, person = place
    if len(values) % 3:
        raise InputError(
            f"pose_keypoints_2d has {len(values)} numbers, not three for each point",
            where=where,
            remedy=_REMEDY,
        )
    if not values:
        return
    for i, name in enumerate(source.points_of(len(values) // 3, where)[: len(values) // 3]):
        x, y, sure = values[3 * i : 3 * i + 3]
        yield frame, camera, name, float(x), float(y), float(sure), source.name, person

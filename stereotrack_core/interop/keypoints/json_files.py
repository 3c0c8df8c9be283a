"""Keypoints in JSON: COCO, MMPose and RTMPose, MediaPipe, OpenPose.

A results file of COCO is a list of ``image_id``, ``keypoints`` (x, y and confidence or visibility
of every point) and ``score``; the frame is the ``image_id``, or the last number of a picture's name
in its place. An annotations file has ``images``, ``annotations`` and ``categories``, as for labels.

The third number of a point is a confidence in one file and COCO's visibility in another (0, 1
hidden, 2 visible); it is the latter where all of a file are 0, 1 or 2 and any is 2. People may have
a ``track_id``.

MMPose's and RTMPose's demo scripts write ``meta_info`` and ``instance_info``, whose ``frame_id``
begins at 1; the inferencer writes a list of ``frame_id`` and ``instances`` that begins at 0. An
instance has ``keypoints`` and ``keypoint_scores``.

MediaPipe's landmarks are saved as a list of ``frame`` and ``landmarks``. A landmark is a table of
``x``, ``y`` and perhaps ``visibility``; several people of a frame are lists of landmarks, or
several entries. Places are shares of the image's size, or pixels.

OpenPose writes one file for each picture (``--write_json``). A file has ``people``, each with
``pose_keypoints_2d``: x, y and confidence of every point, and is named after the picture:
``video_000000000012_keypoints.json``, ``cam01.0012.json``. It is known by what it holds. A folder
belongs to the camera that it is named after (``cam01`` or ``cam01_json``), or holds such folders.
"""

import json
import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from stereotrack_core.atomic import write_file
from stereotrack_core.errors import InputError
from stereotrack_core.interop.coco import coco_content, places_of_images
from stereotrack_core.interop.keypoints.arrays import CONFIDENCES, pixels_of_shares
from stereotrack_core.interop.keypoints.source import FileRow, KeypointSource, Who, stated_name
from stereotrack_core.interop.label_source import PicturePlaces, checked_frame
from stereotrack_core.plain_data import Kind, check_kind
from stereotrack_core.reading import SETTINGS_BYTES, read_json
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.keypoint_names import COCO_17
from stereotrack_core.recording.keypoints import Keypoints, rows_of

_COCO_REMEDY = "A results file is a list of image_id, keypoints and score."
_VALUES: Kind = [(float, [float])]
_RESULTS: Kind = [{"image_id": (int, str), "keypoints": _VALUES, "source": str}]
_OF_POINTS = "Write x, y and confidence of every point."
_VISIBLE = 2.0  # COCO's mark of a visible point
_IDENTITIES = ("track_id", "person_id", "instance_id", "idx")
"""Keys of a person's identity over all pictures; ``idx`` is AlphaPose's."""


def read_json_rows(source: KeypointSource, content: Any) -> Iterator[FileRow]:
    """Rows of JSON by what it holds, COCO's annotations if nothing else; InputError if unknown."""
    first = content[0] if isinstance(content, list) and content else None
    keys = set(first) if isinstance(first, Mapping) else set()
    if is_openpose(content):
        return read_openpose(source)
    if is_mediapipe(content):
        return read_mediapipe(source, content)
    is_demo = isinstance(content, Mapping) and "instance_info" in content
    if is_demo or {"frame_id", "instances"} <= keys:
        return read_mmpose(source, content)
    if {"image_id", "keypoints"} <= keys:
        return read_results(source, content)
    return read_annotations(source)


def read_results(source: KeypointSource, content: Any) -> Iterator[FileRow]:
    """Rows of a results file; InputError where it makes no sense."""
    check_kind(content, _RESULTS, str(source.path), _COCO_REMEDY)
    places = PicturePlaces(source, [str(one.get("image_id")) for one in content])
    people = [
        (one, f"{source.path}, entry {number}", source.detector or str(one.get("source") or ""))
        for number, one in enumerate(content)
    ]
    return _coco_rows(source, people, lambda image, where: places.of(str(image), where), {})


def read_annotations(source: KeypointSource) -> Iterator[FileRow]:
    """Rows of an annotations file; InputError where it is none."""
    content = coco_content(source.path)
    categories = {one.get("id"): one.get("keypoints") for one in content["categories"]}
    path, own = source.path, source.detector
    there = [one for one in content["annotations"] if one.get("keypoints") is not None]
    people = [(one, f"{path}, annotation {one.get('id', '?')}", own) for one in there]
    for one, where, _ in people:
        check_kind(one["keypoints"], _VALUES, where, _OF_POINTS)
    return _coco_rows(source, people, places_of_images(content["images"], source), categories)


def _coco_rows(
    source: KeypointSource,
    people: Sequence[tuple[Mapping[str, Any], str, str]],
    place_of: Callable[[Any, str], tuple[int, str] | None],
    categories: Mapping[Any, Sequence[Any] | None],
) -> Iterator[FileRow]:
    """Rows of people, each with its place in the file and its detector; points by category."""
    every = [_triples(one, "keypoints", where) for one, where, _ in people]
    marks = {sure for values in every for _, _, sure in values}
    scale = 1.0 / _VISIBLE if _VISIBLE in marks and marks <= {0.0, 1.0, _VISIBLE} else 1.0
    count: Counter[tuple[int, str, str]] = Counter()
    for (one, where, detector), values in zip(people, every, strict=True):
        if (place := place_of(one.get("image_id"), where)) is None:
            continue
        identities = (stated_name(one.get(key)) for key in _IDENTITIES)
        who = Who(count[*place, detector], next(filter(None, identities), ""))
        count[*place, detector] += 1
        named = categories.get(one.get("category_id"))
        names = source.points_of(len(values), where) if named is None else map(str, named)
        for name, (x, y, mark) in zip(names, values, strict=False):
            yield *place, name, x, y, mark * scale, detector or source.name, who


def _triples(one: Mapping[str, Any], key: str, where: str) -> list[tuple[float, float, float]]:
    """x, y and confidence of each point, from one list or a list of triples."""
    values = one.get(key) or []
    flat = [float(v) for one in values for v in (one if isinstance(one, list) else [one])]
    if len(flat) % 3:
        what = f"{key} has {len(flat)} numbers, not three for each point"
        raise InputError(what, where, _OF_POINTS)
    return list(zip(flat[0::3], flat[1::3], flat[2::3], strict=True))


def write_results(path: Path, keypoints: Keypoints, recording: Recording) -> int:
    """Write COCO's 17 points of pictures ``camera/000012.png``; returns how many are others."""
    people: dict[tuple[int, str, str, int], list[float]] = {}
    others = 0
    for frame, camera, name, x, y, sure, told, person in rows_of(keypoints):
        if name not in COCO_17 or camera not in recording.cameras:
            others += 1
            continue
        values = people.setdefault((frame, camera, told, person), [0.0] * (3 * len(COCO_17)))
        at = 3 * COCO_17.index(name)
        values[at : at + 3] = [x, y, sure]
    content = [
        {
            "image_id": f"{camera}/{frame:06d}.png",
            "category_id": 1,
            "keypoints": values,
            "score": sum(values[2::3]) / len(COCO_17),
            "source": told,
            "track_id": person,
        }
        for (frame, camera, told, person), values in people.items()
    ]
    write_file(path, json.dumps(content, allow_nan=False))
    return others


_MMPOSE_REMEDY = "Use the .json that MMPose writes with --save-predictions or pred_out_dir."
_MMPOSE_FRAMES: Kind = [
    {"frame_id": int, "instances": [{"keypoints": [[float]], "keypoint_scores": [float]}]}
]
_MMPOSE_KIND: Kind = {
    "meta_info": {"keypoint_id2name": {str: str}},
    "instance_info": _MMPOSE_FRAMES,
}
_FIRST_OF_DEMO = 1


def read_mmpose(source: KeypointSource, content: Any) -> Iterator[FileRow]:
    """Rows of the file; InputError where it makes no sense, or its camera cannot be told."""
    path = str(source.path)
    camera, first = source.camera_of(source.path.name, path), 0
    named: Mapping[str, str] = {}
    if isinstance(content, Mapping):
        check_kind(content, _MMPOSE_KIND, path, _MMPOSE_REMEDY)
        first = _FIRST_OF_DEMO
        named = (content.get("meta_info") or {}).get("keypoint_id2name") or {}
        content = content.get("instance_info") or []
    check_kind(content, _MMPOSE_FRAMES, path, _MMPOSE_REMEDY)
    for one in content:
        if (number := one.get("frame_id")) is None:
            raise InputError("a frame has no frame_id", path, _MMPOSE_REMEDY)
        frame = checked_frame(float(number - first), where=path)
        where = f"{path}, frame {frame}"
        for index, instance in enumerate(one.get("instances") or []):
            who = Who(index, stated_name(instance.get("track_id", instance.get("instance_id"))))
            points: Sequence[Sequence[float]] = instance.get("keypoints") or []
            sure = instance.get("keypoint_scores") or [1.0] * len(points)
            if len(sure) != len(points) or any(len(point) < 2 for point in points):
                what = "keypoints and keypoint_scores do not belong together"
                raise InputError(what, where, _MMPOSE_REMEDY)
            names: Sequence[str] = [named.get(str(i)) or f"point_{i}" for i in range(len(points))]
            if not named or source.layout is not None:
                names = source.points_of(len(points), where)
            for name, (x, y, *_), score in zip(names, points, sure, strict=False):
                yield frame, camera, name, float(x), float(y), float(score), source.name, who


_MEDIAPIPE_FRAMES = ("frame", "frame_id", "frame_number", "frame_index", "frame_idx")
_LANDMARKS = ("landmarks", "pose_landmarks", "keypoints")
_MEDIAPIPE_REMEDY = "Save a list of frame and landmarks, each with x, y and visibility."
_POINT: Kind = {"x": float, "y": float, **dict.fromkeys(CONFIDENCES, float), "name": str}
_MEDIAPIPE_KIND: Kind = [
    {**dict.fromkeys(_MEDIAPIPE_FRAMES, int), **{name: [object] for name in _LANDMARKS}}
]


def is_mediapipe(content: Any) -> bool:
    """Whether JSON is such a list, or a table that holds one under ``frames``."""
    entries = _entries(content)
    first = entries[0] if entries else None
    if not isinstance(first, Mapping) or not any(name in first for name in _MEDIAPIPE_FRAMES):
        return False
    filled = [own for one in entries if isinstance(one, Mapping) and (own := _landmarks(one))]
    point = filled[0][0] if filled and isinstance(filled[0], list) else None
    point = point[0] if isinstance(point, list) and point else point
    return isinstance(point, Mapping) and {"x", "y"} <= set(point)


def _entries(content: Any) -> Sequence[Any]:
    content = content.get("frames") if isinstance(content, Mapping) else content
    return content if isinstance(content, list) else ()


def _landmarks(entry: Mapping[str, Any]) -> Any:
    return next((entry[name] for name in _LANDMARKS if entry.get(name)), None)


def read_mediapipe(source: KeypointSource, content: Any) -> Iterator[FileRow]:
    """Rows of the file; InputError where it makes no sense, or its camera cannot be told."""
    path = str(source.path)
    camera, entries = source.camera_of(source.path.name, path), _entries(content)
    check_kind(entries, _MEDIAPIPE_KIND, path, _MEDIAPIPE_REMEDY)
    people: dict[int, int] = {}
    rows: list[tuple[int, str, float, Who]] = []
    places: list[tuple[float, float]] = []
    for number, entry in enumerate(entries):
        where = f"{path}, entry {number}"
        stated = [entry[name] for name in _MEDIAPIPE_FRAMES if entry.get(name) is not None]
        if not stated:
            raise InputError("it states no frame", where, _MEDIAPIPE_REMEDY)
        frame = checked_frame(float(stated[0]), where=where)
        own = _landmarks(entry) or []
        for points in own if own and isinstance(own[0], list) else [own]:
            who = Who(people.get(frame, 0), stated_name(entry.get("person_id")))
            people[frame] = who.place + 1
            check_kind(points, [_POINT], where, _MEDIAPIPE_REMEDY)
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


_END = "_keypoints.json"
_OPENPOSE_REMEDY = "Use a folder written by OpenPose with --write_json."
_OPENPOSE_KIND: Kind = {"people": [{"pose_keypoints_2d": [float], "person_id": [object]}]}


def is_openpose(content: Any) -> bool:
    """Whether JSON is of one picture by OpenPose."""
    people = content.get("people") if isinstance(content, Mapping) else None
    return isinstance(people, list) and all(
        isinstance(one, Mapping) and "pose_keypoints_2d" in one for one in people
    )


def _pictures(folder: Path) -> Iterator[Path]:
    """Files of OpenPose. Of files that differ in their numbers alone, the first one tells it."""
    known: dict[tuple[Path, str], bool] = {}
    for pattern in ("*.json", "*/*.json"):
        for path in sorted(folder.glob(pattern)):
            kind = path.parent, re.sub(r"\d+", "#", path.name)
            if kind not in known:
                known[kind] = path.name.endswith(_END)
                with suppress(InputError):
                    known[kind] |= is_openpose(read_json(path, SETTINGS_BYTES, _OPENPOSE_REMEDY))
            if known[kind]:
                yield path


def read_openpose(source: KeypointSource) -> Iterator[FileRow]:
    """Rows of a folder's files, or of one; InputError if unreadable, or camera or frame unknown."""
    path = source.path
    pictures = list(_pictures(path)) if path.is_dir() else [path]
    if not pictures:
        raise InputError("the folder holds no JSON files of OpenPose", path, _OPENPOSE_REMEDY)
    places = PicturePlaces(source, map(_named, pictures))
    for path in pictures:
        if (place := places.of(_named(path), str(path))) is None:
            continue
        content = read_json(path, SETTINGS_BYTES, _OPENPOSE_REMEDY)
        check_kind(content, _OPENPOSE_KIND, str(path), _OPENPOSE_REMEDY)
        for index, one in enumerate(content.get("people") or []):
            values = _triples(one or {}, "pose_keypoints_2d", str(path))
            who = Who(index, stated_name((one or {}).get("person_id")))
            names = source.points_of(len(values), str(path)) if values else ()
            for name, (x, y, sure) in zip(names, values, strict=True):
                yield *place, name, x, y, sure, source.name, who


def _named(path: Path) -> str:
    """Path of the picture that a file is of, as its camera and its frame are told by."""
    folder = path.parent.resolve().name
    return f"{folder.removesuffix('_json') or folder}/{path.name.removesuffix(_END)}"

"""COCO's files of predicted keypoints: results and annotations, as JSON.

A results file is a list of ``image_id``, ``keypoints`` (x, y and confidence or visibility of every
point) and ``score``; the frame is the ``image_id``, or the last number of a picture's name in its
place. An annotations file has ``images``, ``annotations`` and ``categories``, as for labels.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from stereotrack_core.atomic import write_file
from stereotrack_core.errors import InputError
from stereotrack_core.interop.coco import coco_content, place_of_picture
from stereotrack_core.interop.keypoints.source import KeypointSource
from stereotrack_core.interop.label_source import checked_frame, frame_of
from stereotrack_core.plain_data import Kind, check_kind
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.keypoint_names import COCO_17
from stereotrack_core.recording.keypoints import Keypoints, Row, rows_of

_REMEDY = "A results file is a list of image_id, keypoints and score."
_VALUES: Kind = [(float, [float])]
_RESULTS: Kind = [{"image_id": (int, str), "keypoints": _VALUES, "score": float, "source": str}]
_OF_POINTS = "Write x, y and confidence of every point."
_MOST_SURE = 2.0
"""COCO's mark of a visible point; annotations have 0, 1 and 2 where results have confidences."""


def is_results(content: Any) -> bool:
    """Whether JSON is a results file."""
    first = content[0] if isinstance(content, list) and content else None
    return isinstance(first, Mapping) and {"image_id", "keypoints"} <= set(first)


def read_results(source: KeypointSource, content: Any) -> Iterator[Row]:
    """Rows of a results file; InputError where it makes no sense."""
    check_kind(content, _RESULTS, str(source.path), _REMEDY)
    people: Counter[tuple[int, str, str]] = Counter()
    for number, one in enumerate(content):
        where = f"{source.path}, entry {number}"
        told = source.detector or str(one.get("source") or source.name)
        frame, camera = _place(one.get("image_id"), source, where)
        person = people[frame, camera, told]
        people[frame, camera, told] += 1
        values = _triples(one.get("keypoints") or [], where)
        names = source.points_of(len(values), where)
        for name, (x, y, sure) in zip(names, values, strict=False):
            yield frame, camera, name, x, y, sure, told, person


def read_annotations(source: KeypointSource) -> Iterator[Row]:
    """Rows of an annotations file; InputError where it is none."""
    content = coco_content(source.path)
    categories = {one.get("id"): one.get("keypoints") for one in content["categories"]}
    images = {one.get("id"): one for one in content["images"]}
    people: Counter[tuple[int, str]] = Counter()
    for one in content["annotations"]:
        if one.get("keypoints") is None:
            continue
        where = f"{source.path}, annotation {one.get('id', '?')}"
        place = place_of_picture(images.get(one.get("image_id")), source.labels, where)
        person = people[place]
        people[place] += 1
        check_kind(one["keypoints"], _VALUES, where, _OF_POINTS)
        values = _triples(one["keypoints"], where)
        named = categories.get(one.get("category_id"))
        names = source.points_of(len(values), where) if named is None else map(str, named)
        for name, (x, y, mark) in zip(names, values, strict=False):
            sure = mark / _MOST_SURE if mark in (0.0, 1.0, 2.0) else mark
            yield *place, name, x, y, sure, source.name, person


def _place(image: Any, source: KeypointSource, where: str) -> tuple[int, str]:
    """Frame and camera of an ``image_id``, a number or a picture's name."""
    text = str(image)
    if text.isdecimal():
        camera = source.camera_of(source.path.name, where)
        return checked_frame(float(text), where=where), camera
    return frame_of(text, where=where), source.camera_of(text, where)


def _triples(values: Sequence[Any], where: str) -> list[tuple[float, float, float]]:
    """x, y and confidence of each point, from one list or a list of triples."""
    flat = [float(v) for one in values for v in (one if isinstance(one, list) else [one])]
    if len(flat) % 3:
        raise InputError(
            f"keypoints has {len(flat)} numbers, not three for each point",
            where=where,
            remedy=_OF_POINTS,
        )
    return list(zip(flat[0::3], flat[1::3], flat[2::3], strict=True))


def write_results(path: Path, keypoints: Keypoints, recording: Recording) -> int:
    """Write COCO's 17 points as a results file; returns how many rows are not among them.

    ``image_id`` is a picture's name, ``camera/000012.png``. Raises InputError where it cannot be
    written.
    """
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
        }
        for (frame, camera, told, _), values in people.items()
    ]
    write_file(path, json.dumps(content, allow_nan=False))
    return others

"""COCO's files of predicted keypoints: results and annotations, as JSON.

A results file is a list of ``image_id``, ``keypoints`` (x, y and confidence or visibility of every
point) and ``score``; the frame is the ``image_id``, or the last number of a picture's name in its
place. An annotations file has ``images``, ``annotations`` and ``categories``, as for labels.

The third number of a point is a confidence in one file and COCO's visibility in another (0, 1
hidden, 2 visible); it is the latter where all of a file are 0, 1 or 2 and any is 2. People may have
a ``track_id``.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from stereotrack_core.atomic import write_file
from stereotrack_core.errors import InputError
from stereotrack_core.interop.coco import coco_content, places_of_images
from stereotrack_core.interop.keypoints.people import FileRow, Who, stated_name
from stereotrack_core.interop.keypoints.source import KeypointSource
from stereotrack_core.interop.label_source import PicturePlaces, checked_frame
from stereotrack_core.plain_data import Kind, check_kind
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.keypoint_names import COCO_17
from stereotrack_core.recording.keypoints import Keypoints, rows_of

_REMEDY = "A results file is a list of image_id, keypoints and score."
_VALUES: Kind = [(float, [float])]
_RESULTS: Kind = [{"image_id": (int, str), "keypoints": _VALUES, "source": str}]
_OF_POINTS = "Write x, y and confidence of every point."
_VISIBLE = 2.0
"""COCO's mark of a visible point."""
_IDENTITIES = ("track_id", "person_id", "instance_id", "idx")
"""Keys of a person's identity over all pictures; ``idx`` is AlphaPose's."""


def is_results(content: Any) -> bool:
    """Whether JSON is a results file."""
    first = content[0] if isinstance(content, list) and content else None
    return isinstance(first, Mapping) and {"image_id", "keypoints"} <= set(first)


def read_results(source: KeypointSource, content: Any) -> Iterator[FileRow]:
    """Rows of a results file; InputError where it makes no sense."""
    check_kind(content, _RESULTS, str(source.path), _REMEDY)
    pictures = [text for one in content if not (text := str(one.get("image_id"))).isdecimal()]
    places = PicturePlaces(source.labels, pictures)
    people: Counter[tuple[int, str, str]] = Counter()
    every = [
        _triples(one.get("keypoints") or [], f"{source.path}, entry {number}")
        for number, one in enumerate(content)
    ]
    scale = _scale_of(every)
    for number, (one, values) in enumerate(zip(content, every, strict=True)):
        where = f"{source.path}, entry {number}"
        told = source.detector or str(one.get("source") or source.name)
        image = str(one.get("image_id"))
        if image.isdecimal():
            camera = source.camera_of(source.path.name, where)
            place: tuple[int, str] | None = (checked_frame(float(image), where=where), camera)
        else:
            place = places.of(image, where)
        if place is None:
            continue
        who = Who(people[*place, told], _identity(one))
        people[*place, told] += 1
        names = source.points_of(len(values), where)
        for name, (x, y, sure) in zip(names, values, strict=True):
            yield *place, name, x, y, sure * scale, told, who


def read_annotations(source: KeypointSource) -> Iterator[FileRow]:
    """Rows of an annotations file; InputError where it is none."""
    content = coco_content(source.path)
    categories = {one.get("id"): one.get("keypoints") for one in content["categories"]}
    place_of = places_of_images(content["images"], source.labels)
    people: Counter[tuple[int, str]] = Counter()
    there = [one for one in content["annotations"] if one.get("keypoints") is not None]
    every = []
    for one in there:
        where = f"{source.path}, annotation {one.get('id', '?')}"
        check_kind(one["keypoints"], _VALUES, where, _OF_POINTS)
        every.append(_triples(one["keypoints"], where))
    scale = _scale_of(every)
    for one, values in zip(there, every, strict=True):
        where = f"{source.path}, annotation {one.get('id', '?')}"
        if (place := place_of(one.get("image_id"), where)) is None:
            continue
        who = Who(people[place], _identity(one))
        people[place] += 1
        named = categories.get(one.get("category_id"))
        names = source.points_of(len(values), where) if named is None else map(str, named)
        for name, (x, y, mark) in zip(names, values, strict=False):
            yield *place, name, x, y, mark * scale, source.name, who


def _identity(one: Mapping[str, Any]) -> str:
    return next(filter(None, (stated_name(one.get(key)) for key in _IDENTITIES)), "")


def _scale_of(people: Sequence[Sequence[tuple[float, float, float]]]) -> float:
    """Factor from the third numbers of a file's points to confidences."""
    marks = {sure for values in people for _, _, sure in values}
    return 1.0 / _VISIBLE if _VISIBLE in marks and marks <= {0.0, 1.0, _VISIBLE} else 1.0


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
            "track_id": person,
        }
        for (frame, camera, told, person), values in people.items()
    ]
    write_file(path, json.dumps(content, allow_nan=False))
    return others

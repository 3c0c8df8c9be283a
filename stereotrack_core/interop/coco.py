"""Keypoints in the layout of COCO (https://cocodataset.org/#format-data), as JSON.

One annotation is one person in one picture; a keypoint is x, y in pixels (the centre of the first
one is 0) and v: 2 visible, 1 labelled but hidden, 0 not labelled. What is outside the image cannot
be told from what nobody has labelled, so an annotation may list it under ``outside``. Provenance of
keypoints may stand under ``sources``, ``sigmas``, ``flags``, ``annotators`` and ``times``, in their
order, empty if not known. Pictures may state ``camera`` and ``frame``, otherwise both are told from
the file's name.
"""

import json
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from stereotrack_core.annotation.click import Click, Visibility
from stereotrack_core.annotation.landmark_set import LandmarkSet
from stereotrack_core.atomic import write_file
from stereotrack_core.errors import InputError
from stereotrack_core.interop import label_source
from stereotrack_core.plain_data import Kind, check_kind
from stereotrack_core.reading import TABLE_BYTES, read_json
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.landmarks import SKELETON

# Not read by sleap-io (0.9.5): it leaves out annotations whose pictures are not beside the file,
# and what is listed under `outside` and as provenance.

_ENTRY: Kind = {
    **dict.fromkeys(("id", "image_id", "category_id"), (int, str)),
    "keypoints": [object],
    "outside": [object],
    **{f"{name}s": [object] for name in label_source.PROVENANCE},
}
_KINDS: Mapping[str, Kind] = {"images": [_ENTRY], "annotations": [_ENTRY], "categories": [_ENTRY]}
"""What a file has to hold, and of which kind it has to be."""


def write_coco(
    path: Path, clicks: Iterable[Click], recording: Recording, landmarks: LandmarkSet
) -> None:
    """Write clicks of all cameras but deleted ones, with their provenance."""
    names = landmarks.names
    images, annotations = [], []
    pictures = label_source.pictures_of(clicks, names, recording, path)
    for number, (camera, frame, found) in enumerate(pictures, start=1):
        name, size = camera.name, {"width": camera.width, "height": camera.height}
        picture = {"id": number, "file_name": f"{name}/{frame:06d}.png", **size}
        images.append({**picture, "camera": name, "frame": frame})
        annotations.append(_annotation(number, found, names))
    bones = [[names.index(a) + 1, names.index(b) + 1] for a, b in SKELETON if {a, b} <= set(names)]
    category = {"id": 1, "name": "person", "keypoints": list(names), "skeleton": bones}
    content = {
        "info": {"description": recording.name},
        "images": images,
        "annotations": annotations,
        "categories": [{"supercategory": "person", **category}],
    }
    write_file(path, json.dumps(content, indent=1, allow_nan=False))


def read_coco(source: label_source.LabelSource) -> label_source.Labels:
    """Read the keypoints of one person; InputError if it is no COCO file, or none is known."""
    path = source.path
    content = coco_content(path)
    named = [one for one in content["categories"] if one.get("keypoints")]
    categories = {one.get("id"): [str(name) for name in one["keypoints"]] for one in named}
    theirs = [name for keypoints in categories.values() for name in keypoints]
    if not theirs:
        raise InputError("no category has keypoints", path, "Export keypoints, not boxes.")
    there = [one for one in content["annotations"] if one.get("keypoints") is not None]
    marks = (v for one in there for v in one["keypoints"][2::3])
    score = next((v for v in marks if isinstance(v, float) and not v.is_integer()), None)
    if score is not None:
        what = f"its keypoints have confidences ({score:g}), so they are predictions and no labels"
        window = "File, Import predictions in the workbench"
        remedy = f"Import them with `stereotrack import predictions`, or {window}."
        raise InputError(what, path, remedy)
    place_of_picture = places_of_images(content["images"], source)
    seen: set[tuple[int, str]] = set()

    def read(annotation: Mapping[str, Any], known: Mapping[str, str]) -> Iterable[Click]:
        where = f"{path}, annotation {annotation.get('id', '?')}"
        place = place_of_picture(annotation.get("image_id"), where)
        if place is None:
            return ()
        if place in seen:
            what = f"the file has a second person in {place[1]} at frame {place[0]}"
            raise InputError(what, where, "Keep only the annotations of one person.")
        seen.add(place)
        keypoints = categories.get(annotation.get("category_id"), [])
        return _clicks(annotation, keypoints, known, place, where)

    unstated = tuple(n for n in ("flag", "sigma") if not any(f"{n}s" in one for one in there))
    return replace(source.labels(theirs, there, read), unstated=unstated)


def _annotation(number: int, clicks: Mapping[str, Click], names: Sequence[str]) -> dict[str, Any]:
    keypoints: list[float] = []
    for name in names:
        click = clicks.get(name)
        if click is None or click.position is None:
            keypoints += [0, 0, 0]
        else:
            keypoints += [*map(float, click.position), int(click.visibility)]
    places = [click.position for click in clicks.values() if click.position is not None]
    axes = list(zip(*places, strict=True)) or [(0.0,), (0.0,)]
    low, size = [min(axis) for axis in axes], [max(axis) - min(axis) for axis in axes]
    return {
        "id": number,
        "image_id": number,
        "category_id": 1,
        "iscrowd": 0,
        "keypoints": keypoints,
        "num_keypoints": len(places),
        "bbox": [*low, *size],
        "area": size[0] * size[1],
        "outside": [name for name, click in clicks.items() if click.position is None],
        **_provenance(clicks, names),
    }


def _provenance(clicks: Mapping[str, Click], names: Sequence[str]) -> dict[str, list[str | float]]:
    known = {name: label_source.provenance_of_click(click) for name, click in clicks.items()}
    return {
        f"{stated}s": [known[name][stated] if name in known else "" for name in names]
        for stated in label_source.PROVENANCE
    }


def coco_content(path: Path) -> dict[str, list[dict[str, Any]]]:
    """Images, annotations and categories of a file; InputError where it has none."""
    remedy = "A COCO file is JSON with images, annotations and categories."
    content = read_json(path, TABLE_BYTES, remedy)
    check_kind(content, _KINDS, str(path), remedy)
    missing = [key for key in _KINDS if content.get(key) is None]
    if missing:
        raise InputError(f"this is not a COCO file: it lacks {', '.join(missing)}", path, remedy)
    return {key: [one for one in content[key] if one is not None] for key in _KINDS}


def places_of_images(
    images: Iterable[Mapping[str, Any]], source: label_source.LabelSource
) -> Callable[[Any, str], tuple[int, str] | None]:
    """Gives frame and camera of the image with an id; None for another camera than stated."""
    by_id = {one.get("id"): one for one in images}
    names = {key: str(one.get("file_name", "")) for key, one in by_id.items()}
    own = {names[key]: str(c) for key, one in by_id.items() if (c := one.get("camera")) is not None}
    places = label_source.PicturePlaces(source, names.values(), own)

    def place(key: Any, where: str) -> tuple[int, str] | None:
        if key not in by_id:
            what = "the image of this annotation is not in the file"
            raise InputError(what, where, "Add it to images.")
        frame = by_id[key].get("frame")
        if not isinstance(frame, int) or isinstance(frame, bool):
            return places.of(names[key], where)
        camera = places.camera(names[key], where)
        return None if camera is None else (label_source.checked_frame(frame, where=where), camera)

    return place


def _clicks(
    annotation: Mapping[str, Any],
    keypoints: Sequence[str],
    known: Mapping[str, str],
    place: tuple[int, str],
    where: str,
) -> list[Click]:
    values = annotation["keypoints"]
    if len(values) != 3 * len(keypoints) or not all(
        isinstance(value, int | float) and math.isfinite(value) for value in values
    ):
        what = f"keypoints must be {len(keypoints)} triples of x, y and v"
        raise InputError(what, where, "Use the file as written by the labelling tool.")
    outside = {str(name) for name in annotation.get("outside") or []}
    listed = {name: annotation.get(f"{name}s") or [] for name in label_source.PROVENANCE}
    clicks = []
    for i, name in enumerate(keypoints):
        if name not in known:
            continue
        stated = {key: own[i] for key, own in listed.items() if i < len(own)}
        more = label_source.stated_provenance(stated, where)
        x, y, v = values[3 * i : 3 * i + 3]
        if v in (1, 2):
            seen = Visibility(int(v))
            clicks.append(Click(*place, known[name], (float(x), float(y)), seen, **more))
        elif name in outside:
            clicks.append(Click(*place, known[name], None, Visibility.OUTSIDE, **more))
    return clicks

"""Where the person is in each view, over the whole recording, without any tracking."""

from collections.abc import Iterable, Sequence
from typing import TypeAlias

import cv2
import numpy as np

from stereotrack_core.arrays import BoolArray, Float32Array, ImageArray
from stereotrack_core.recording.description import Recording, View
from stereotrack_core.recording.reader import FrameReader, reference_pictures
from stereotrack_core.work import NO_WORK, Work

Box: TypeAlias = tuple[float, float, float, float]
"""Left, top, right and bottom, in pixels of a view's reference image."""

_FRAMES = 8
_MANY_FRAMES = 40  # where somebody who stands still is looked for
_SIDE = 240  # pixels of the longer side of the images that are compared
_LEAST_DIFFERENCE, _NOISE = 12.0, 6.0  # grey values, and times what is usual between two images
_REACH = 0.04  # share of the side over which parts belong together: arms are thin
_LEAST_SWAY, _SWAY = 1.5, 3.0  # grey values, and times what is usual, by which a place changes
_LEAST_SHARE = 0.6  # of all that changes a little: else it is the camera, or the light
_LEAST_AREA, _MOST_AREA = 0.003, 0.6  # shares of the image; more is a lamp, not a person


def person_boxes(recording: Recording, work: Work = NO_WORK) -> dict[str, Box]:
    """Boxes around all that a person does, by the name of the view.

    A few frames spread over the recording are compared with the empty scene where the recording
    has it, and else with what they show most of the time. Who stands still before an unknown scene
    is looked for in more frames: nobody stands quite still. A view in which nothing differs, or
    nearly everything, has no box. Raises InputError where a stream cannot be read, and Cancelled.
    """
    alone, boxes = reference_pictures(recording), dict[str, Box]()
    with FrameReader(alone, colour=False, cache_bytes=1, read_ahead=0) as reader:
        count, _ = reader.frame_count_so_far()
        seen = _seen(reader, _spread(_FRAMES, count), work)
        for view in alone.views:
            background = reader.background(view.name)
            empty = None if background is None else _small(background[1])
            found = _box(seen[view.name], empty)
            if found is not None:
                boxes[view.name] = _scaled(found, recording, view)
        if boxes.keys() < seen.keys():
            seen = _seen(reader, _spread(_MANY_FRAMES, count), work)
            for view in alone.views:
                sways = None if view.name in boxes else _swaying(seen[view.name])
                if sways is not None:
                    boxes[view.name] = _scaled(sways, recording, view)
    return boxes


def _spread(wanted: int, count: int) -> list[int]:
    """So many frames, or all, spread over a recording."""
    return sorted({round(k) for k in np.linspace(0, count - 1, min(wanted, count))})


def _seen(reader: FrameReader, frames: Iterable[int], work: Work) -> dict[str, list[Float32Array]]:
    """Small images of some frames, by the name of the view."""
    seen: dict[str, list[Float32Array]] = {view.name: [] for view in reader.recording.views}
    for frame in frames:
        work.check()
        for name, images in reader.frame_set(frame).views.items():
            seen[name].append(_small(images.image))
    return seen


def _scaled(box: Box, recording: Recording, view: View) -> Box:
    """A box in pixels of the view's image, of one in those of the small image."""
    camera = recording.reference_camera(view)
    factor = max(camera.width, camera.height) / _SIDE
    return box[0] * factor, box[1] * factor, box[2] * factor, box[3] * factor


def _small(image: ImageArray) -> Float32Array:
    """The image with its longer side of the usual length, without noise."""
    height, width = image.shape[:2]
    factor = _SIDE / max(height, width)
    size = max(round(width * factor), 1), max(round(height * factor), 1)
    small = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
    return np.asarray(cv2.GaussianBlur(small, (3, 3), 0), dtype=np.float32)


def _box(seen: Sequence[Float32Array], empty: Float32Array | None) -> Box | None:
    """Box around what differs in any of the images of a view, in their pixels."""
    if len(seen) < (3 if empty is None else 1):
        return None
    stack = np.stack(seen)
    if empty is None or empty.shape != stack.shape[1:]:
        empty = np.median(stack, axis=0)
    difference = np.abs(stack - empty)
    differs = difference > max(_LEAST_DIFFERENCE, _NOISE * float(np.median(difference)))
    found = [part for part in map(_largest, differs) if part is not None]
    return _bounds(np.any(found, axis=0)) if found else None


def _swaying(seen: Sequence[Float32Array]) -> Box | None:
    """Box around what changes more than the noise does, over many images of a view."""
    if len(seen) < _FRAMES:
        return None
    stack = np.stack(seen)
    stack = stack - np.median(stack, axis=(1, 2), keepdims=True)  # lamps flicker
    spread = stack.std(axis=0)
    differs = spread > max(_LEAST_SWAY, _SWAY * float(np.median(spread)))
    found = _largest(differs)
    if found is None or found.sum() < _LEAST_SHARE * differs.sum():
        return None
    return _bounds(found)


def _bounds(found: BoolArray) -> Box:
    rows, columns = (np.flatnonzero(found.any(axis=axis)) for axis in (1, 0))
    return float(columns[0]), float(rows[0]), float(columns[-1] + 1), float(rows[-1] + 1)


def _largest(differs: BoolArray) -> BoolArray | None:
    """The largest part of what differs, with all that lies close to it."""
    if differs.mean() > _MOST_AREA:
        return None
    reach = 2 * round(0.5 * _REACH * _SIDE) + 1
    joined = cv2.dilate(differs.astype(np.uint8), np.ones((reach, reach), np.uint8))
    _, labels = cv2.connectedComponents(joined)
    areas = np.bincount(labels[differs], minlength=2)
    best = int(np.argmax(areas[1:])) + 1
    return differs & (labels == best) if areas[best] > _LEAST_AREA * differs.size else None

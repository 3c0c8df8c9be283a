"""Where the person is in each view, over the whole recording, without any tracking."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TypeAlias

import cv2
import numpy as np

from stereotrack_core.arrays import BoolArray, Float32Array, ImageArray
from stereotrack_core.errors import Cancelled
from stereotrack_core.recording.description import Recording, View
from stereotrack_core.recording.reader import FrameReader

Box: TypeAlias = tuple[float, float, float, float]
"""Left, top, right and bottom, in pixels of a view's reference image."""

_FRAMES = 8
_SIDE = 240  # pixels of the longer side of the images that are compared
_LEAST_DIFFERENCE, _NOISE = 12.0, 6.0  # grey values, and times what is usual between two images
_REACH = 0.04  # share of the side over which parts belong together: arms are thin
_LEAST_AREA, _MOST_AREA = 0.003, 0.6  # shares of the image; more is a lamp, not a person


def person_boxes(
    recording: Recording, cancelled: Callable[[], bool] = lambda: False
) -> dict[str, Box]:
    """Boxes around all that a person does, by the name of the view.

    A few frames spread over the recording are compared with the empty scene where the recording
    has it, and else with what they show most of the time. A view in which nothing differs, or
    nearly everything, has no box.

    Parameters
    ----------
    cancelled : callable
        Whether nobody waits for it any more; asked between frames.

    Raises
    ------
    InputError
        Where a stream cannot be read.
    Cancelled
    """
    views = tuple(_image_alone(view) for view in recording.views)
    seen: dict[str, list[Float32Array]] = {view.name: [] for view in views}
    empty: dict[str, Float32Array] = {}
    alone = replace(recording, views=views)
    with FrameReader(alone, colour=False, cache_bytes=1, read_ahead=0) as reader:
        count, _ = reader.frame_count_so_far()
        for k in sorted({round(k) for k in np.linspace(0, count - 1, min(_FRAMES, count))}):
            if cancelled():
                raise Cancelled
            for name, images in reader.frame_set(k).views.items():
                seen[name].append(_small(images.image))
        for name in seen:
            background = reader.background(name)
            if background is not None:
                empty[name] = _small(background[1])
    boxes = {}
    for view in recording.views:
        camera = recording.reference_camera(view)
        box = _box(seen[view.name], empty.get(view.name))
        if box is not None:
            factor = max(camera.width, camera.height) / _SIDE
            boxes[view.name] = (box[0] * factor, box[1] * factor, box[2] * factor, box[3] * factor)
    return boxes


def _image_alone(view: View) -> View:
    return replace(view, kind="mono", left=None, depth=None, mask=None)


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
    if not found:
        return None
    rows, columns = (np.flatnonzero(np.any(found, axis=(0, axis))) for axis in (2, 1))
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

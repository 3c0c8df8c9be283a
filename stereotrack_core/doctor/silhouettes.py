"""Do the silhouettes of the views fit each other? For cameras without depth, too.

What moves in one image is somewhere on its rays where all other views show something that moves as
well. Where most rays have no such place, a camera is not where the calibration puts it, or an image
is not as the camera saw it. Usual slips are undone in turn; what fills the rays is the tested
correction.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import combinations
from typing import TypeAlias

import cv2
import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray, ImageArray
from stereotrack_core.depth.light import empty_scene
from stereotrack_core.depth.outline import outline_without_depth
from stereotrack_core.depth.sources import grey
from stereotrack_core.doctor.slips import SLIPS, exchanged_views, resized
from stereotrack_core.errors import Finding
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.reader import FrameReader

_FRAMES, _LEARNED = 12, 24
"""Frames that are compared, and those that give the empty scene where there is no image of it."""

_WIDTH = 480
"""Pixels to which wider images are reduced."""

_RAYS = 80
"""Rays of a silhouette that are asked."""

_DISTANCES = np.arange(0.6, 8.0, 0.06)
"""Metres along them; a forearm is as thick as a step."""

_MARGIN = 1.0 / 160.0
"""Share of the width by which the others' silhouettes are widened."""

_LEAST_AREA = 0.002
"""Share of the image that a silhouette has to cover."""

_LEAST_GAIN, _LEFT = 0.008, 0.7
"""By how much the filled share has to rise with a correction, and the most of the rest that it may
leave. In sound recordings the given cameras fill more than any of them."""

_FULL = 0.97
"""Filled share that good silhouettes have; of two views less says nothing."""

_ALIKE = 0.003
"""Filled shares between which two corrections cannot be told apart."""


@dataclass(frozen=True, eq=False)
class Silhouettes:
    """What one view shows of the person, by its camera."""

    camera: Camera
    cameras: tuple[str, ...]
    """Names of all cameras of the view."""
    masks: tuple[BoolArray, ...]
    """(H, W), frame by frame."""

    @property
    def mirrored(self) -> Silhouettes:
        """As of images that are turned left to right."""
        return replace(self, masks=tuple(mask[:, ::-1] for mask in self.masks))

    @property
    def overturned(self) -> Silhouettes:
        """As of images that are upside down."""
        return replace(self, masks=tuple(mask[::-1, ::-1] for mask in self.masks))


Shown: TypeAlias = Mapping[str, Silhouettes]
"""Silhouettes by view name."""


def silhouettes_of(recording: Recording, reader: FrameReader) -> Shown:
    """What all views show that is not the empty scene, in frames spread over the recording.

    Where there is no image of the empty scene, what most frames show is taken for it. Views that
    have changed nearly everywhere are left out.
    """
    count = reader.frame_count
    spread = np.unique(np.linspace(0, count - 1, min(_LEARNED, count)).astype(int))
    pictures: dict[str, list[ImageArray]] = {view.name: [] for view in recording.views}
    for k in spread:
        for name, images in reader.frame_set(int(k)).views.items():
            pictures[name].append(_small(images.image))
    chosen = np.unique(np.linspace(0, len(spread) - 1, min(_FRAMES, len(spread))).astype(int))
    shown = {}
    for view in recording.views:
        seen, camera = pictures[view.name], recording.cameras.get(view.image.camera)
        if len(seen) < len(spread) or camera is None:
            continue
        background = reader.background(view.name)
        empty = (
            np.median(seen, axis=0).astype(np.uint8)
            if background is None
            else _small(background[1])
        )
        scene = empty_scene(empty)
        outlines = [outline_without_depth(seen[k], scene) for k in chosen]
        masks = tuple(mask for mask in outlines if mask is not None)
        if len(masks) < len(outlines):
            continue
        reduced = resized(camera, empty.shape[1] / camera.width)
        shown[view.name] = Silhouettes(reduced, view.cameras(), masks)
    return shown


def _small(image: ImageArray) -> ImageArray:
    """The image in grey, at most so large that silhouettes are sharp enough."""
    small = grey(image)
    height, width = small.shape
    if width > _WIDTH:
        size = _WIDTH, round(height * _WIDTH / width)
        small = cv2.resize(small, size, interpolation=cv2.INTER_AREA).astype(np.uint8, copy=False)
    return small


def filled(shown: Shown) -> float:
    """Share of the rays through silhouettes on which all others show something at one place.

    Mean over the views; NaN where there are no silhouettes.
    """
    wide = {name: [_widened(mask) for mask in one.masks] for name, one in shown.items()}
    shares = []
    for name, one in shown.items():
        hit = asked = 0
        for k, mask in enumerate(one.masks):
            pixels = np.argwhere(mask)[:, ::-1]
            if len(pixels) < _LEAST_AREA * mask.size:
                continue
            pixels = pixels[:: max(1, len(pixels) // _RAYS)]
            rays = one.camera.rays_world(pixels.astype(np.float64))
            points = one.camera.position_world + rays[:, None] * _DISTANCES[:, None]
            inside = np.ones(points.shape[:2], dtype=bool)
            for other, their in shown.items():
                if other != name:
                    inside[inside] = _in_mask(their.camera, wide[other][k], points[inside])
            hit += int(inside.any(axis=1).sum())
            asked += len(pixels)
        if asked:
            shares.append(hit / asked)
    return float(np.mean(shares)) if shares else float("nan")


def _widened(mask: BoolArray) -> BoolArray:
    size = 2 * max(1, round(_MARGIN * mask.shape[1])) + 1
    return cv2.dilate(mask.astype(np.uint8), np.ones((size, size), np.uint8)).astype(bool)


def _in_mask(camera: Camera, mask: BoolArray, points: FloatArray) -> BoolArray:
    """Whether points (N, 3), world, lie in the mask (H, W) of a camera."""
    pixels = np.nan_to_num(camera.project(points), nan=-1.0)
    u, v = np.clip(np.round(pixels), -1, 1e6).astype(int).T
    inside = (u >= 0) & (u < mask.shape[1]) & (v >= 0) & (v < mask.shape[0])
    inside[inside] = mask[v[inside], u[inside]]
    return np.asarray(inside)


def check_silhouettes(shown: Shown) -> Iterator[Finding]:
    """Findings about views whose silhouettes fit the others' with a usual slip undone."""
    if len(shown) < 2:
        return
    given = filled(shown)
    least = max(given + _LEAST_GAIN, 1.0 - _LEFT * (1.0 - given))
    if len(shown) == 2:
        least = max(least, _FULL)
    if not least <= 1.0:
        return
    tried = sorted(
        ((filled(changed), one) for changed, one in _undone(shown)),
        key=lambda one: one[0],
        reverse=True,
    )
    best, first = tried[0]
    if best < least:
        return
    others = [one for share, one in tried[1:] if share > best - _ALIKE]
    or_else = "".join(f" Or else {one.where}: {one.what}." for one in others)
    yield replace(
        first,
        what=f"{first.what}: {100 * given:.0f} % of what moves in one image is where the others "
        f"show it, and {100 * best:.0f} % with this corrected",
        remedy=f"{first.remedy}{or_else}",
        correction=None if others else first.correction,
    )


def _undone(shown: Shown) -> Iterator[tuple[Shown, Finding]]:
    """Silhouettes with every usual slip undone, and what to say of it."""
    for (a, one), (b, other) in combinations(shown.items(), 2):
        if one.masks[0].shape == other.masks[0].shape:
            exchanged = {a: replace(one, masks=other.masks), b: replace(other, masks=one.masks)}
            yield {**shown, **exchanged}, exchanged_views(a, b)
    stored = "Store the images as the camera saw them."
    for name, one in shown.items():
        for images, what in ((one.mirrored, "mirrored"), (one.overturned, "upside down")):
            found = Finding("error", f"view {name}", f"its images are {what}", stored)
            yield {**shown, name: images}, found
        for slip in SLIPS:
            changed = replace(one, camera=slip.undone(one.camera))
            change = slip.correction(one.cameras)
            found = Finding("error", f"view {name}", slip.what, slip.remedy, change)
            yield {**shown, name: changed}, found

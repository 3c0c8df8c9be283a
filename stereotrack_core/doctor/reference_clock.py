"""Does the reference show the same instants as the images? By the motion that both see.

The reference's limbs are drawn as each view's camera would see them. What changes from drawing to
drawing is compared with what changes from image to image: it needs no depth.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import cv2
import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.importing.signals import motion_of, reduced
from stereotrack_core.recording.landmarks import LANDMARKS, SKELETON

_WIDTH = 160
"""Pixels of a drawing."""

_THICK, _TRUNK, _HEAD = 0.05, 0.12, 0.1
"""Metres from bones to the surface of arms, trunk and head."""

_GREY = 160
_NEAREST, _FARTHEST_PX = 0.2, 20.0
"""Metres before a camera, and widths beside the image, from which nothing is drawn."""

_LONGEST = 15
_FEWEST_FRAMES = 20
_CERTAIN, _ELSEWHERE = 0.6, 0.85
"""Correlation from which motions agree, and the share of it that the second best place may have."""

_AT = {name: i for i, name in enumerate(LANDMARKS)}


@dataclass(frozen=True)
class Delay:
    """By how many frames a reference shows everything later than the images.

    `correlation` of the motion there, `elsewhere` at the best other place, and `given` as it is.
    """

    frames: float
    correlation: float
    elsewhere: float
    given: float

    @property
    def certain(self) -> bool:
        """Whether the motions agree there, and clearly less anywhere else."""
        return self.correlation > _CERTAIN and self.elsewhere < _ELSEWHERE * self.correlation


def reference_delay(
    recording: Recording, signals: Mapping[tuple[str, str], FloatArray]
) -> Delay | None:
    """The delay by the motion (F,) in the images of all views together; None where it is unknown.

    Of the longest stretch of successive frames that the reference knows.
    """
    reference = recording.reference
    if reference is None:
        return None
    some = _longest_stretch(reference.frame)
    pairs = []
    for view in recording.views:
        seen, camera = signals.get((view.name, "image")), recording.cameras.get(view.image.camera)
        if seen is None or camera is None or len(some) < _FEWEST_FRAMES:
            continue
        drawn = motion_of(drawings(camera, reference.points[some]))
        on_frames = _on_frames(drawn, reference.frame[some], len(seen))
        if drawn.std() > 0 and seen.std() > 0:  # views count alike
            pairs.append((on_frames / drawn.std(), seen / seen.std()))
    return delay_of(pairs) if pairs else None


def _longest_stretch(frame: IntArray) -> IntArray:
    """Places (N,) in a list of frames (F,) that follow each other without a gap."""
    ends = np.flatnonzero(np.diff(frame) != 1) + 1
    return np.asarray(max(np.split(np.arange(len(frame)), ends), key=len))


def _on_frames(values: FloatArray, frame: IntArray, count: int) -> FloatArray:
    """Values (N,) at frames (N,) of frames 0 to `count`; NaN at others."""
    result = np.full(count, np.nan)
    inside = (frame >= 0) & (frame < count)
    result[frame[inside]] = values[inside]
    return result


def delay_of(pairs: list[tuple[FloatArray, FloatArray]]) -> Delay | None:
    """The delay of the first of each pair of signals (F,), NaN where unknown, of all together."""
    lags = np.arange(-_LONGEST, _LONGEST + 1)
    values = np.array([_correlation(pairs, int(lag)) for lag in lags])
    known = np.isfinite(values)
    if not known[_LONGEST] or known.sum() < len(lags) // 2:
        return None
    values = np.where(known, values, -1.0)
    best = int(np.argmax(values))
    first = last = best
    while first > 0 and values[first - 1] < values[first]:
        first -= 1
    while last < len(lags) - 1 and values[last + 1] < values[last]:
        last += 1
    rest = np.concatenate([values[:first], values[last + 1 :]])
    aside = 0.0
    if 0 < best < len(lags) - 1:
        before, top, after = values[best - 1 : best + 2]
        bend = before - 2 * top + after
        aside = float(0.5 * (before - after) / bend) if bend < 0 else 0.0
    return Delay(
        float(lags[best]) + aside, float(values[best]), float(rest.max(initial=0.0)),
        float(values[_LONGEST]),
    )  # fmt: skip


def _correlation(pairs: list[tuple[FloatArray, FloatArray]], lag: int) -> float:
    """Correlation of what the first signals show so many frames later; NaN where too little is."""
    sums = np.zeros(3)
    count = 0
    for one, other in pairs:
        length = len(other) - abs(lag)
        if length <= 0:
            continue
        a = one[max(lag, 0) : max(lag, 0) + length]
        b = other[max(-lag, 0) : max(-lag, 0) + length]
        known = np.isfinite(a)
        sums += [float(a[known] @ b[known]), float(a[known] @ a[known]), float(b[known] @ b[known])]
        count = max(count, int(known.sum()))
    if count < _FEWEST_FRAMES or min(sums[1], sums[2]) <= 0:
        return float("nan")
    return float(sums[0] / np.sqrt(sums[1] * sums[2]))


def drawings(camera: Camera, points: FloatArray) -> Iterator[FloatArray]:
    """What a camera would see of landmarks (F, 9, 3), reduced as images are."""
    scale = _WIDTH / camera.width
    height = max(1, round(camera.height * scale))
    for landmarks in points:
        ranges = camera.camera_from_world.apply(landmarks)[:, 2]
        with np.errstate(divide="ignore", invalid="ignore"):
            pixels = camera.project(landmarks) * scale
            seen = (ranges > _NEAREST) & (np.abs(pixels) < _FARTHEST_PX * _WIDTH).all(axis=1)
        picture = np.zeros((height, _WIDTH), dtype=np.uint8)
        for a, b in SKELETON:
            i, j = _AT[a], _AT[b]
            if seen[i] and seen[j]:
                thick = _TRUNK if "hip" in a + b else _THICK
                width = max(1, round(2 * thick * camera.focal * scale / ranges[i]))
                one, other = np.rint(pixels[[i, j]]).astype(int).tolist()
                cv2.line(picture, one, other, _GREY, width, cv2.LINE_AA)
        head = _AT["head"]
        if seen[head]:
            radius = max(1, round(_HEAD * camera.focal * scale / ranges[head]))
            middle = np.rint(pixels[head]).astype(int).tolist()
            cv2.circle(picture, middle, radius, _GREY, -1, cv2.LINE_AA)
        yield reduced(cv2.GaussianBlur(picture, (0, 0), 1.0))

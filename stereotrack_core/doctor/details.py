"""Details that both images of a pair show, and how they lie to each other after rectification.

They are matched in the raw images and kept where any epipolar geometry explains them, so that this
does not depend on the calibration.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import cv2
import numpy as np

from stereotrack_core.arrays import FloatArray, ImageArray
from stereotrack_core.depth.rectify import common_rotation
from stereotrack_core.geometry.camera import Camera

_DETAILS = 1500
_RATIO = 0.75
"""Distance of the best match over that of the second best up to which it is unambiguous."""

_EPIPOLAR_PX = 1.5
FEWEST = 40
"""Details without which nothing is said."""

_BEHIND_PX = 1.0
"""Parallax of the wrong sign from which a detail lies behind the cameras."""

Pair: TypeAlias = tuple[Camera, Camera]
"""Left and right camera."""


@dataclass(frozen=True, eq=False)
class Details:
    """Raw pixels (N, 2) of the same details in the left image and in the reference image."""

    left: FloatArray
    image: FloatArray
    seen: int = 0
    """Details of the image that has fewer of them, matched or not."""

    @property
    def exchanged(self) -> Details:
        """The same with the images exchanged."""
        return Details(self.image, self.left, self.seen)

    def left_turned(self, camera: Camera) -> Details:
        """The same with the left image, by this camera, turned upside down."""
        turned = np.array([camera.width - 1.0, camera.height - 1.0]) - self.left
        return replace(self, left=turned)


@dataclass(frozen=True)
class RowFit:
    """How details of a pair lie to each other after rectification."""

    row_px: float
    """Median distance of their rows, pixels of the raw images."""
    wrong_side: float
    """Share that would lie behind the cameras."""

    @property
    def misfit(self) -> float:
        """Row offset, larger where most details are on the wrong side."""
        return self.row_px + (100.0 if self.wrong_side > 0.5 else 0.0)


def details_of(pairs: Sequence[tuple[ImageArray, ImageArray]]) -> Details:
    """Details that the two grey images of every pair, all by the same cameras, show."""
    finder = cv2.SIFT.create(_DETAILS)
    matcher = cv2.BFMatcher.create(cv2.NORM_L2)
    found: list[FloatArray] = [np.zeros((0, 4))]
    seen = 0
    for left, image in pairs:
        (points_l, own_l), (points_r, own_r) = (
            finder.detectAndCompute(one, None) for one in (left, image)
        )
        if own_l is None or own_r is None or min(len(own_l), len(own_r)) < 2:
            continue
        seen += min(len(own_l), len(own_r))
        back = {m[0].queryIdx: m[0].trainIdx for m in matcher.knnMatch(own_r, own_l, k=1)}
        rows = [
            (*points_l[best.queryIdx].pt, *points_r[best.trainIdx].pt)
            for best, second in matcher.knnMatch(own_l, own_r, k=2)
            if best.distance < _RATIO * second.distance and back[best.trainIdx] == best.queryIdx
        ]
        found.append(np.array(rows, dtype=np.float64).reshape(-1, 4))
    every = np.concatenate(found)
    kept = np.zeros(len(every), dtype=bool)
    if len(every) >= FEWEST:
        cv2.setRNGSeed(0)
        _, mask = cv2.findFundamentalMat(
            every[:, :2], every[:, 2:], cv2.FM_RANSAC, _EPIPOLAR_PX, 0.999, 2000
        )
        if mask is not None:
            kept = mask.ravel().astype(bool)
    return Details(every[kept, :2], every[kept, 2:], seen)


def row_fit(cameras: Pair, details: Details) -> RowFit:
    """How details lie to each other after rectification with these cameras."""
    rows, parallax = offsets(cameras, details)
    known = np.isfinite(rows) & np.isfinite(parallax)
    if np.count_nonzero(known) < 0.5 * len(rows):
        return RowFit(np.inf, 0.0)
    return RowFit(
        float(np.median(np.abs(rows[known]))), float(np.mean(parallax[known] < -_BEHIND_PX))
    )


def offsets(cameras: Pair, details: Details) -> tuple[FloatArray, FloatArray]:
    """Row offsets and parallaxes (N,), pixels, after rectification."""
    left, right = cameras
    rotation = common_rotation(left, right)
    own = left.rays_world(details.left) @ rotation.T
    other = right.rays_world(details.image) @ rotation.T
    with np.errstate(divide="ignore", invalid="ignore"):
        apart = left.focal * (own[:, :2] / own[:, 2:] - other[:, :2] / other[:, 2:])
    apart[(own[:, 2] < 0.1) | (other[:, 2] < 0.1)] = np.nan
    return apart[:, 1], apart[:, 0]

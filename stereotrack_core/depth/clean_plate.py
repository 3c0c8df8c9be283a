"""The empty scene of a mono view, from pictures of a person who moves."""

from __future__ import annotations

from collections.abc import Iterable

import cv2
import numpy as np

from stereotrack_core.arrays import BoolArray, ImageArray
from stereotrack_core.pose_model.detector import DetectedPose, PoseDetector, next_crop
from stereotrack_core.pose_model.following import Whereabouts, detect_person

_PERSON = 0.5
"""Probability of the network from which a pixel shows the person."""

_BESIDE = 2
"""Pixels around the person that are left out too. With 8, places beside a person who hardly moves
are never seen and have to be filled: the silhouettes of a mesh overlap with the true ones by 0.68
then, with 2 by 0.9."""

_FEWEST = 5
"""Pictures with the person without which the scene is not known."""

_FILLED = 5.0
"""Pixels from which a place that is always covered is filled."""


def clean_plate(
    detector: PoseDetector, pictures: Iterable[ImageArray], where: Whereabouts
) -> ImageArray | None:
    """What pictures (H, W) show where the person is not; None where few of them show a person.

    A pixel is the median of the pictures in which the network sees no person there. What the person
    always covers is filled from its surroundings, from which the person's clothes mostly differ.
    """
    shown, hidden, pose = [], [], None
    for picture in pictures:
        pose = detect_person(detector, picture, pose, where)
        if pose is not None:
            shown.append(picture)
            hidden.append(_near_person(detector, picture, pose))
    if len(shown) < _FEWEST:
        return None
    covered = np.stack(hidden)
    values = np.sort(np.where(covered, np.int16(256), np.stack(shown)), axis=0)  # covered ones last
    always = np.asarray(covered.all(axis=0), dtype=np.uint8)
    middle = (~covered).sum(axis=0, keepdims=True) // 2
    plate = np.take_along_axis(values, middle, axis=0).reshape(always.shape).astype(np.uint8)
    return np.asarray(cv2.inpaint(plate, always, _FILLED, cv2.INPAINT_TELEA), dtype=np.uint8)


def _near_person(detector: PoseDetector, picture: ImageArray, pose: DetectedPose) -> BoolArray:
    mask = detector.landmarks(picture, next_crop(pose), mask=True).mask
    assert mask is not None  # noqa: S101 - it was asked for
    around = np.ones((2 * _BESIDE + 1, 2 * _BESIDE + 1), dtype=np.uint8)
    return cv2.dilate((mask > _PERSON).astype(np.uint8), around) > 0

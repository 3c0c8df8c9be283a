"""The sharp edge of whatever is new in a picture."""

from __future__ import annotations

import cv2
import numpy as np

from stereotrack_core.arrays import BoolArray, ImageArray

_NEAR = np.ones((7, 7), np.uint8)
"""Neighbourhood whose strongest difference says what half of a difference is."""

_SHARE, _LEAST = 0.4, 10.0
"""Share of the strongest difference nearby, and least grey levels, of a pixel that is new."""

_SURELY_INSIDE = np.ones((9, 9), np.uint8)
_CLOSED = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (5, 5))
_OPENED = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (3, 3))
_SMALL_HOLE = 60
"""Pixels of a hole that is taken for a place where the person looks like the wall."""


def sharp_outline(picture: ImageArray, empty: ImageArray, foreground: BoolArray) -> BoolArray:
    """Where the picture is not the empty scene's, with edges at half their height.

    A fixed threshold would put the edge of a strong difference a pixel or two too far outside,
    because lenses blur. Where stereo sees something well inside its own edge, that counts too.

    Parameters
    ----------
    picture, empty : (H, W) uint8
        Now, and without anybody.
    foreground : (H, W) bool
        What the disparities say; block matching widens it by up to half its window.
    """
    difference = cv2.absdiff(
        cv2.GaussianBlur(picture, (3, 3), 0), cv2.GaussianBlur(empty, (3, 3), 0)
    )
    limit = np.maximum(cv2.dilate(difference, _NEAR).astype(np.float32) * _SHARE, _LEAST)
    new = (difference > limit).astype(np.uint8)
    new |= cv2.erode(foreground.astype(np.uint8), _SURELY_INSIDE)
    closed = cv2.morphologyEx(new, cv2.MORPH_CLOSE, _CLOSED)
    _, labels, stats, _ = cv2.connectedComponentsWithStats(1 - closed, connectivity=4)
    hole = stats[:, cv2.CC_STAT_AREA] < _SMALL_HOLE
    hole[0] = False
    closed[hole[labels]] = 1
    result: BoolArray = cv2.morphologyEx(closed, cv2.MORPH_OPEN, _OPENED).astype(bool)
    return result

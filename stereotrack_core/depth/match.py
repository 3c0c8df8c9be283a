"""Stereo matching with the right image as reference (2.1.2, 2.1.4)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

from stereotrack_core.arrays import ImageArray
from stereotrack_core.depth.parameters import DepthParameters

DisparityArray: TypeAlias = NDArray[np.int16]

STEPS = 16
"""Disparities are whole numbers of sixteenths of a pixel until they become points."""

_PREFILTER_CAP = 31


@dataclass(frozen=True)
class DisparityRange:
    """Disparities d with ``minimum`` <= d < ``minimum + count``, in pixels of the pair."""

    minimum: int
    count: int

    @property
    def invalid(self) -> int:
        """What the matcher writes where it found nothing, in sixteenths."""
        return (self.minimum - 1) * STEPS


class Matcher:
    """StereoBM or StereoSGBM for one view; not to be used by two threads at once.

    Parameters
    ----------
    parameters : DepthParameters
    disparities : DisparityRange
    """

    def __init__(self, parameters: DepthParameters, disparities: DisparityRange) -> None:
        self.disparities = disparities
        self._edges_first = parameters.edge_images and parameters.matcher == "sgbm"
        make = _block_matcher if parameters.matcher == "bm" else _semi_global_matcher
        self._matcher = make(parameters, disparities)

    def __call__(self, left: ImageArray, right: ImageArray) -> DisparityArray:
        """Disparities of the right image's pixels.

        The left image shows at column u + d what the right one shows at u. OpenCV refers to
        the left image; seen in a mirror, the right image is a left one.

        Parameters
        ----------
        left, right : (H, W) uint8, rectified

        Returns
        -------
        (H, W) int16, sixteenths of a pixel; ``disparities.invalid`` where there is none
        """
        if self._edges_first:
            left, right = edge_image(left), edge_image(right)
        mirrored = self._matcher.compute(cv2.flip(right, 1), cv2.flip(left, 1))
        disparity = np.asarray(cv2.flip(mirrored, 1), dtype=np.int16)
        self._drop_unseen(disparity)
        return disparity

    def _drop_unseen(self, disparity: DisparityArray) -> None:
        """Invalidate, in place, what would appear beyond the left image's border."""
        width = disparity.shape[1]
        reach = self.disparities.minimum + self.disparities.count
        first = max(width - max(reach, 0), 0)
        room = ((width - 1 - np.arange(first, width)) * STEPS).astype(np.int16)
        border = disparity[:, first:]
        border[border > room] = self.disparities.invalid


def edge_image(image: ImageArray) -> ImageArray:
    """Horizontal derivative around grey 128, which does not depend on the image's brightness."""
    edges: ImageArray = cv2.Sobel(image, cv2.CV_8U, 1, 0, ksize=3, scale=0.5, delta=128).astype(
        np.uint8, copy=False
    )
    return edges


def _odd(window: int) -> int:
    return window | 1


def _block_matcher(p: DepthParameters, disparities: DisparityRange) -> cv2.StereoBM:
    matcher = cv2.StereoBM.create(disparities.count, _odd(p.match_window))
    matcher.setMinDisparity(disparities.minimum)
    # XSOBEL is 1, NORMALIZED_RESPONSE 0; their names differ between versions of OpenCV.
    matcher.setPreFilterType(1 if p.edge_images else 0)
    matcher.setPreFilterCap(_PREFILTER_CAP)
    matcher.setTextureThreshold(p.match_texture)
    matcher.setUniquenessRatio(p.match_uniqueness)
    matcher.setDisp12MaxDiff(p.match_left_right)
    return matcher


def _semi_global_matcher(p: DepthParameters, disparities: DisparityRange) -> cv2.StereoSGBM:
    # Large windows blur what the smoothness term keeps sharp: half of the block matcher's.
    window = _odd(p.match_window // 2)
    return cv2.StereoSGBM.create(
        minDisparity=disparities.minimum,
        numDisparities=disparities.count,
        blockSize=window,
        P1=8 * window * window,
        P2=32 * window * window,
        disp12MaxDiff=p.match_left_right,
        preFilterCap=_PREFILTER_CAP,
        uniquenessRatio=p.match_uniqueness,
        mode=cv2.StereoSGBM_MODE_SGBM_3WAY,
    )

"""All images of one instant."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from stereotrack_core.arrays import BoolArray, Float32Array, ImageArray


@dataclass(frozen=True, eq=False)
class ViewImages:
    """What one view shows at one instant, raw (distorted, not rotated).

    Attributes
    ----------
    image : (H, W) or (H, W, 3) uint8
        Reference image, grey or BGR.
    left : (H, W) or (H, W, 3) uint8, or None
        Left image of a stereo view.
    depth : (H, W) float32, metres along the camera's z, or None
        NaN where not measured.
    mask : (H, W) bool, or None
        True on the person.
    """

    image: ImageArray
    left: ImageArray | None = None
    depth: Float32Array | None = None
    mask: BoolArray | None = None


@dataclass(frozen=True, eq=False)
class FrameSet:
    """All images of one instant.

    Attributes
    ----------
    index : int
        Frame number in the recording, from 0.
    views : mapping from view name to ViewImages
        Views whose images could not be read are absent.
    problems : mapping from view name to str
        Why a view is absent, as a sentence.
    """

    index: int
    views: Mapping[str, ViewImages]
    problems: Mapping[str, str] = field(default_factory=dict)

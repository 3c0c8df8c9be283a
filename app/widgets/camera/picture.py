"""What a camera view shows: one picture of one view, ready to be painted."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, fields, is_dataclass, replace
from typing import Any, Literal, TypeAlias

import numpy as np

from stereotrack_core.arrays import ImageArray

from .click_marks import CLICK_OVERLAYS
from .overlays import Overlay

PictureKind: TypeAlias = Literal["image", "left", "disparity", "foreground", "depth"]

PICTURE_KINDS: dict[PictureKind, str] = {
    "image": "Reference image",
    "left": "Left image",
    "disparity": "Disparity",
    "foreground": "Foreground",
    "depth": "Depth",
}
"""Kinds of pictures with their names; the reference image of a stereo view is the right one."""


def _silent(_x: float, _y: float) -> str:
    return ""


@dataclass(frozen=True, eq=False)
class Picture:
    """One picture of one view at one instant."""

    view: str
    kind: PictureKind
    frame: int
    pixels: ImageArray | None
    """(H, W) or (H, W, 3) uint8, or None. Grey or BGR; None where there is nothing to show."""
    message: str = ""
    """Why there is nothing to show, or what is suspicious."""
    rotation: int = 0
    """Degrees clockwise that make it look upright."""
    overlay: Overlay = field(default_factory=Overlay)
    camera: str = ""
    """The camera whose raw pixels these are; empty for a picture that was computed."""
    value_at: Callable[[float, float], str] = _silent
    """From column and row to words about the pixel: its value and the depth of its ray."""

    def looks_like(self, other: Picture) -> bool:
        """Whether it is painted like another one, whatever may be said of its pixels."""
        mine, others = (replace(one, value_at=_silent) for one in (self, other))
        return self.pixels is other.pixels and alike(mine, others)


def alike(a: Any, b: Any) -> bool:
    """Whether two values are equal, with all arrays in them."""
    if a is b or type(a) is not type(b):
        return a is b
    if isinstance(a, np.ndarray):
        return bool(np.array_equal(a, b, equal_nan=a.dtype.kind == "f"))
    if isinstance(a, tuple):
        return len(a) == len(b) and all(map(alike, a, b))
    if is_dataclass(a):
        return all(alike(getattr(a, part.name), getattr(b, part.name)) for part in fields(a))
    return bool(a == b)


@dataclass(frozen=True)
class Display:
    """How pictures are displayed, the same for all views."""

    overlays: frozenset[str] = frozenset({"outline", "others", "reference", *CLICK_OVERLAYS})
    """Names of the overlays that are switched on."""
    highlighted: str = ""
    """Limb that is selected everywhere, or empty."""
    brightness: float = 0.0
    """-1 to 1."""
    contrast: float = 1.0
    """Factor."""
    loupe: bool = False
    loupe_in_corner: bool = False
    """Whether the loupe is in a corner, so that it hides nothing around the cursor."""
    keep_person: bool = False
    """Whether views enlarge the person and follow it, until somebody zooms by hand."""


def brightened(pixels: ImageArray, brightness: float, contrast: float) -> ImageArray:
    """Picture with another brightness (-1 to 1) and contrast (factor); a copy for display only."""
    if brightness == 0.0 and contrast == 1.0:
        return pixels
    levels = np.arange(256.0)
    table = np.clip((levels - 127.5) * contrast + 127.5 + 255.0 * brightness, 0, 255)
    result: ImageArray = table.astype(np.uint8)[pixels]
    return result

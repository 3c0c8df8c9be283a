"""The model and texts drawn over a picture of a view, without a window."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import cv2
import matplotlib
import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from stereotrack_core.arrays import FloatArray, ImageArray
from stereotrack_core.body.mesh import PartMesh
from stereotrack_core.evaluation.limb_colours import limb_bgr
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.landmarks import LANDMARKS, SKELETON

_SHIFT = 4
_FARTHEST = 1e4
"""Pixels outside of which nothing is drawn."""

_DARK, _LIGHT = (25, 25, 25), (255, 255, 255)


@dataclass(frozen=True)
class Window:
    """A part of a picture and the size at which it is shown.

    Attributes
    ----------
    left, top : float, pixels of the picture
    scale : float
        Pixels shown for a pixel of the picture.
    width, height : int, pixels
        As shown.
    """

    left: float
    top: float
    scale: float
    width: int
    height: int

    def cut(self, image: ImageArray) -> ImageArray:
        """The part of a picture (H, W) or (H, W, 3), as (height, width, 3) BGR."""
        colour = cv2.cvtColor(image, cv2.COLOR_GRAY2BGR) if image.ndim == 2 else image
        move = np.array(
            [[self.scale, 0.0, -self.scale * self.left], [0.0, self.scale, -self.scale * self.top]]
        )
        how = cv2.INTER_LINEAR if self.scale > 0.75 else cv2.INTER_AREA
        cut = cv2.warpAffine(colour, move, (self.width, self.height), flags=how)
        return np.asarray(cut, dtype=np.uint8)

    def of(self, pixels: FloatArray) -> FloatArray:
        """Where pixels (..., 2) of the picture are shown."""
        result: FloatArray = (pixels - (self.left, self.top)) * self.scale
        return result


def whole_window(camera: Camera, height: int) -> Window:
    """The whole picture of a camera at some height."""
    scale = height / camera.height
    return Window(0.0, 0.0, scale, max(1, round(scale * camera.width)), height)


def draw_body(
    picture: ImageArray,
    camera: Camera,
    window: Window,
    meshes: Sequence[PartMesh],
    *,
    shaded: bool = False,
    thick: Sequence[str] = (),
) -> None:
    """Draw a body's outline, limb by limb, into a picture, in place.

    Parameters
    ----------
    picture : (H, W, 3) uint8, BGR
        As cut out by the window.
    camera : Camera
    window : Window
    meshes : sequence of PartMesh
        See :func:`body_mesh`.
    shaded : bool
        Whether the limbs are filled as well, the far ones first.
    thick : sequence of str
        Limbs with a broader line.
    """
    shapes = _silhouettes(camera, window, meshes)
    if shaded:
        veil = picture.copy()
        for limb, _, hull in sorted(shapes, key=lambda shape: -shape[1]):
            cv2.fillPoly(veil, [hull], limb_bgr(limb), cv2.LINE_AA, _SHIFT)
        cv2.addWeighted(veil, 0.6, picture, 0.4, 0.0, dst=picture)
    for limb in dict.fromkeys(limb for limb, _, _ in shapes):
        mask: NDArray[np.uint8] = np.zeros(picture.shape[:2], dtype=np.uint8)
        for _, _, hull in (shape for shape in shapes if shape[0] == limb):
            cv2.fillPoly(mask, [hull], 255, cv2.LINE_8, _SHIFT)
        lines, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        broad = 1 if limb in thick else 0
        cv2.polylines(picture, lines, True, _DARK, 3 + broad, cv2.LINE_AA)
        cv2.polylines(picture, lines, True, limb_bgr(limb), 1 + broad, cv2.LINE_AA)


def draw_reference(
    picture: ImageArray, camera: Camera, window: Window, landmarks: FloatArray
) -> None:
    """Draw the reference (9, 3), world, as a dashed white skeleton into a picture, in place."""
    neck = 0.5 * (
        landmarks[LANDMARKS.index("left_shoulder")] + landmarks[LANDMARKS.index("right_shoulder")]
    )
    lines = [(landmarks[LANDMARKS.index(a)], landmarks[LANDMARKS.index(b)]) for a, b in SKELETON]
    lines.append((neck, landmarks[LANDMARKS.index("head")]))
    for a, b in lines:
        ends = window.of(camera.project(np.array([a, b])))
        if not np.isfinite(ends).all() or np.abs(ends).max() > _FARTHEST:
            continue
        pieces = max(1, round(float(np.linalg.norm(ends[1] - ends[0])) / 10.0))
        along = np.linspace(0.0, 1.0, 2 * pieces + 1)[:, None]
        places = np.round((ends[0] + along * (ends[1] - ends[0])) * 2**_SHIFT).astype(np.int32)
        for start, end in zip(places[0:-1:2], places[1::2], strict=True):
            for colour, width in ((_DARK, 3), (_LIGHT, 1)):
                cv2.line(picture, start.tolist(), end.tolist(), colour, width, cv2.LINE_AA, _SHIFT)


def _silhouettes(
    camera: Camera, window: Window, meshes: Sequence[PartMesh]
) -> list[tuple[str, float, NDArray[np.int32]]]:
    """Limb, distance and convex outline of every cone that is wholly in front of the camera."""
    shapes = []
    for mesh in meshes:
        shown = window.of(camera.project(mesh.vertices))
        if not np.isfinite(shown).all() or np.abs(shown).max() > _FARTHEST:
            continue
        hull = cv2.convexHull(np.round(shown * 2**_SHIFT).astype(np.int32))
        away = float(np.linalg.norm(mesh.vertices.mean(axis=0) - camera.position_world))
        shapes.append((mesh.limb, away, np.asarray(hull, dtype=np.int32)))
    return shapes


def text_width(text: str, size: float, *, bold: bool = False) -> float:
    """Width in pixels of a line of text whose letters are `size` pixels high."""
    return float(_font(size, bold).getlength(text))


def write(
    picture: ImageArray,
    text: str,
    place: tuple[float, float],
    size: float,
    colour: tuple[int, int, int] = (20, 20, 20),
    *,
    bold: bool = False,
    middle: bool = False,
) -> None:
    """Write a line of text into a picture, in place.

    Parameters
    ----------
    picture : (H, W, 3) uint8, BGR
    text : str
    place : (float, float), pixels
        Where the line begins, on its base line; its middle where `middle` is set.
    size : float, pixels
    colour : (int, int, int)
        Blue, green, red.
    bold, middle : bool
    """
    drawn = Image.fromarray(picture)
    pen = ImageDraw.Draw(drawn)
    anchor = "ms" if middle else "ls"
    pen.text(place, text, font=_font(size, bold), fill=colour, anchor=anchor)
    picture[:] = np.asarray(drawn)


@cache
def _font(size: float, bold: bool) -> ImageFont.FreeTypeFont:
    name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
    place = Path(matplotlib.get_data_path()) / "fonts" / "ttf" / name
    return ImageFont.truetype(place, size, layout_engine=ImageFont.Layout.BASIC)

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
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.mesh import PartMesh
from stereotrack_core.body.model import BodyModel, placed_cones
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.sampling import segment_blocked
from stereotrack_core.body.skeleton import LIMB_OF_PART
from stereotrack_core.evaluation.limb_colours import limb_bgr
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.landmarks import LANDMARKS, SKELETON
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.stored import body_of_run, pose_of_run

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
    thick: Sequence[str] = (),
) -> None:
    """Draw a body's outline, limb by limb, into a picture, in place.

    Parameters
    ----------
    picture : (H, W, 3) uint8, BGR
        As cut out by the window.
    meshes : sequence of PartMesh
        See :func:`body_mesh`.
    thick : sequence of str
        Limbs with a broader line.
    """
    shapes = _silhouettes(camera, window, meshes)
    for limb in dict.fromkeys(limb for limb, _ in shapes):
        mask: NDArray[np.uint8] = np.zeros(picture.shape[:2], dtype=np.uint8)
        for hull in (hull for own, hull in shapes if own == limb):
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
) -> list[tuple[str, NDArray[np.int32]]]:
    """Limb and convex outline of every cone that is wholly in front of the camera."""
    shapes = []
    for mesh in meshes:
        shown = window.of(camera.project(mesh.vertices))
        if not np.isfinite(shown).all() or np.abs(shown).max() > _FARTHEST:
            continue
        hull = cv2.convexHull(np.round(shown * 2**_SHIFT).astype(np.int32))
        shapes.append((mesh.limb, np.asarray(hull, dtype=np.int32)))
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
    place : (float, float), pixels
        Where the line begins, on its base line; its middle where `middle` is set.
    size : float, pixels
    colour : (int, int, int)
        Blue, green, red.
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


_ALONG = np.linspace(0.15, 0.95, 5)


def best_view(
    recording: Recording, run: Run, frames: Sequence[int], limbs: Sequence[str] = ()
) -> str:
    """Name of the view in which some limbs are seen best; the first one where nothing tells.

    A limb counts with the length at which it appears where it is inside the picture and no other
    part of the body stands before it. `limbs`: names in ``LIMBS``; both arms where not given.
    """
    wanted = [LIMBS.index(limb) for limb in (limbs or LIMBS[2:])]
    body = body_of_run(run)
    places = [int(i) for i in np.flatnonzero(np.isin(run.frame, np.asarray(frames)))]
    poses = [pose for i in places if (pose := pose_of_run(run, i)) is not None]
    best, most = recording.views[0].name, -1.0
    for view in recording.views:
        camera = recording.reference_camera(view)
        seen = sum(np.prod(seen_shares(camera, body, pose), axis=0)[wanted].sum() for pose in poses)
        if seen > most + 1e-9:
            best, most = view.name, float(seen)
    return best


def seen_shares(camera: Camera, body: BodyModel, pose: Pose) -> tuple[FloatArray, FloatArray]:
    """Share of each limb's axis (6,), 0 to 1, that nothing hides from a camera, and its length.

    Places outside of the picture count as hidden. Lengths (6,) are in pixels; 0 where the limb is
    not wholly in front of the camera.
    """
    frames = body.frames(pose)
    placed = placed_cones(body, frames)
    shares, lengths = np.zeros(len(LIMBS)), np.zeros(len(LIMBS))
    for limb in range(len(LIMBS)):
        axis = body.skeleton.lengths[limb] * frames.rotations[limb, :, 2]
        places = frames.origins[limb] + _ALONG[:, None] * axis
        pixels = camera.project(places)
        if not np.isfinite(pixels).all():
            continue
        inside = (pixels >= 0).all(axis=1) & (pixels < (camera.width, camera.height)).all(axis=1)
        others = placed[LIMB_OF_PART[body.cones.part] != limb]
        hidden = segment_blocked(places, camera.position_world, others)
        shares[limb] = float((inside & ~hidden).mean())
        lengths[limb] = float(np.linalg.norm(pixels[-1] - pixels[0]))
    return shares, lengths

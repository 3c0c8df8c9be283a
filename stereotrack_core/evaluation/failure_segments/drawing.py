"""The model and the reference drawn over pictures of views, without a window."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from stereotrack_core.annotation.predict import hidden_landmarks, in_image
from stereotrack_core.arrays import FloatArray, ImageArray
from stereotrack_core.body.limbs import LIMB_ENDS, LIMBS
from stereotrack_core.body.mesh import PartMesh, body_mesh
from stereotrack_core.evaluation.limbs import limb_bgr, limb_ends
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.description import Recording, View
from stereotrack_core.recording.landmarks import LANDMARKS, SKELETON
from stereotrack_core.recording.reader import FrameSet
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.stored import body_of_run, pose_of_run

_SHIFT = 4
_FARTHEST = 1e4  # pixels outside of which nothing is drawn
_DARK, _LIGHT = (25, 25, 25), (255, 255, 255)


@dataclass(frozen=True)
class Window:
    """A part of a picture and the size at which it is shown."""

    left: float
    top: float  # `left` and `top`: pixels of the picture
    scale: float  # pixels shown for a pixel of the picture
    width: int
    height: int  # `width` and `height`: pixels. As shown.

    def cut(self, image: ImageArray) -> ImageArray:
        """The part of a picture (H, W) or (H, W, 3), as (height, width, 3) BGR."""
        colour = cv2.cvtColor(image, cv2.COLOR_GRAY2BGR) if image.ndim == 2 else image
        s = self.scale
        move = np.array([[s, 0.0, -s * self.left], [0.0, s, -s * self.top]])
        how = cv2.INTER_LINEAR if self.scale > 0.75 else cv2.INTER_AREA
        cut = cv2.warpAffine(colour, move, (self.width, self.height), flags=how)
        return np.asarray(cut, dtype=np.uint8)

    def of(self, pixels: FloatArray) -> FloatArray:
        """Where pixels (..., 2) of the picture are shown."""
        return (pixels - (self.left, self.top)) * self.scale


def draw_body(
    picture: ImageArray,
    camera: Camera,
    window: Window,
    meshes: Sequence[PartMesh],
    thick: Sequence[str] = (),
) -> None:
    """Draw a body's outline, limb by limb, some thick, into a picture (H, W, 3) BGR, in place."""
    for limb in dict.fromkeys(mesh.limb for mesh in meshes):
        mask: NDArray[np.uint8] = np.zeros(picture.shape[:2], dtype=np.uint8)
        for mesh in (one for one in meshes if one.limb == limb):
            shown = window.of(camera.project(mesh.vertices))
            if np.isfinite(shown).all() and np.abs(shown).max() <= _FARTHEST:
                hull = cv2.convexHull(np.round(shown * 2**_SHIFT).astype(np.int32))
                cv2.fillPoly(mask, [hull], 255, cv2.LINE_8, _SHIFT)
        lines, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        broad = 1 if limb in thick else 0
        cv2.polylines(picture, lines, True, _DARK, 3 + broad, cv2.LINE_AA)
        cv2.polylines(picture, lines, True, limb_bgr(limb), 1 + broad, cv2.LINE_AA)


def draw_reference(
    picture: ImageArray, camera: Camera, window: Window, landmarks: FloatArray
) -> None:
    """Draw the reference (9, 3), world, as a dashed white skeleton into a picture, in place."""
    both = [landmarks[LANDMARKS.index(f"{side}_shoulder")] for side in ("left", "right")]
    neck = 0.5 * (both[0] + both[1])
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


def plain_picture(images: FrameSet, view: View, window: Window) -> ImageArray:
    """A part of a view's picture of a frame, grey where there is none."""
    seen = images.views.get(view.name)
    if seen is not None:
        return window.cut(seen.image)
    return np.full((window.height, window.width, 3), 60, dtype=np.uint8)


def body_at(run: Run, frame: int) -> list[PartMesh]:
    """The surface of a run's body in a frame; empty where it has no pose."""
    rows = np.flatnonzero(run.frame == frame)
    pose = pose_of_run(run, int(rows[0])) if len(rows) else None
    return [] if pose is None else list(body_mesh(body_of_run(run), pose))


def best_view(
    recording: Recording, run: Run, frames: Sequence[int], limbs: Sequence[str] = ()
) -> str:
    """Name of the view in which some limbs, or both arms, are seen best.

    A limb counts with the length at which it appears times the share of its ends that the view
    sees.
    """
    wanted = [LIMBS.index(limb) for limb in (limbs or LIMBS[2:])]
    nine = run.landmarks[np.isin(run.frame, np.asarray(frames)) & run.tracked]
    cameras = [recording.reference_camera(view) for view in recording.views]
    places = np.array([camera.position_world for camera in cameras])
    hidden = hidden_landmarks(nine, LANDMARKS, nine, places)
    of_limbs = np.array([np.isin(LANDMARKS, sum(LIMB_ENDS[limb], ())) for limb in LIMBS])
    seen = np.zeros(len(cameras))
    for v, camera in enumerate(cameras):
        shown = in_image(camera, camera.project(nine)) & ~hidden[:, v]
        shares = shown @ of_limbs.T / of_limbs.sum(axis=1)
        spans = np.diff(camera.project(limb_ends(nine)), axis=2)[:, :, 0]
        lengths = np.nan_to_num(np.linalg.norm(spans, axis=-1))
        seen[v] = (shares * lengths)[:, wanted].sum()
    return recording.views[int(np.argmax(seen))].name

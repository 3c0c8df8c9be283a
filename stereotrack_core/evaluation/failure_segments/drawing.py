"""The model and texts drawn over pictures of views, without a window; a strip of such pictures."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from stereotrack_core.annotation.click_gains import hidden_landmarks
from stereotrack_core.annotation.predict import in_image
from stereotrack_core.arrays import FloatArray, ImageArray, IntArray
from stereotrack_core.body.limbs import LIMB_ENDS, LIMBS
from stereotrack_core.body.mesh import PartMesh, body_mesh
from stereotrack_core.evaluation.failure_segments.find import FailureSearch
from stereotrack_core.evaluation.failure_segments.segment import FailureSegment
from stereotrack_core.evaluation.limbs import limb_bgr, limb_ends
from stereotrack_core.evaluation.summary import errors_against, points_at
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.description import Recording, View
from stereotrack_core.recording.landmarks import LANDMARKS, SKELETON, LandmarkTrajectory
from stereotrack_core.recording.reader import FrameReader, FrameSet
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


_STRIP_HEIGHT, _GAP, _BORDER = 300, 6, 10
_TEXT, _LINE = 15.0, 22
_INK, _FAINT = (20, 20, 20), (90, 90, 90)  # of captions, and of the title
_ROOM = 0.25  # metres around the person's landmarks that are shown as well
_CORNERS = np.array([[1.0, 1.0, 1.0], [1.0, -1.0, 0.0], [-1.0, 1.0, 0.0], [-1.0, -1.0, 0.5]])
_SMALLEST = 8.0  # pixels that a person covers at least


@dataclass(frozen=True, eq=False)
class Shown:
    """Contents of pictures of a run."""

    recording: Recording
    run: Run
    limbs: Sequence[str] = ()  # with errors and broader outlines; of none, the worst arm segment
    reference: LandmarkTrajectory | None = None  # dashed; errors are measured against it

    def pictures(
        self, images: FrameSet, view: View, window: Window
    ) -> tuple[ImageArray, ImageArray]:
        """A view of a frame, upright: as it is, or grey, and with body and reference."""
        camera, plain = self.recording.reference_camera(view), plain_picture(images, view, window)
        drawn = plain.copy()
        draw_body(drawn, camera, window, body_at(self.run, images.index), thick=self.limbs)
        if self.reference is not None:
            truth = points_at(self.reference, np.array([images.index]))[0]
            draw_reference(drawn, camera, window, truth)
        turns = -(view.display_rotation // 90)
        upright = (np.ascontiguousarray(np.rot90(one, turns)) for one in (plain, drawn))
        return next(upright), next(upright)

    def captions(self, frames: Sequence[int]) -> list[tuple[str, ...]]:
        """Caption of each frame: its number, then the limbs' errors or the run's own judgement."""
        limbs, unit = self._values(np.asarray(frames, dtype=np.int64))
        captions = []
        for i, frame in enumerate(frames):
            known = {limb: value[i] for limb, value in limbs.items() if np.isfinite(value[i])}
            if not self.limbs and known:
                worst = max(known, key=lambda limb: known[limb])
                known = {worst: known[worst]}
            lines = [f"{limb.replace('_', ' ')} {value:.0f}{unit}" for limb, value in known.items()]
            captions.append((f"frame {frame}", *(lines or ["unknown"])))
        return captions

    def _values(self, frames: IntArray) -> tuple[dict[str, FloatArray], str]:
        """Error of each limb in degrees; without a reference how likely it is lost."""
        named = tuple(self.limbs) or tuple(limb for limb in LIMBS if limb != "head")
        if self.reference is None:
            known, unit = self.run.frame, " % lost"
            values = {one: 100.0 * self.run.limb_lost[:, LIMBS.index(one)] for one in named}
        else:
            errors, unit = errors_against(self.run.trajectory(), self.reference), "°"
            known = errors.frame
            values = {one: np.degrees(errors.of_limb(one)) for one in named}
        result = {limb: np.full(len(frames), np.nan) for limb in named}
        _, asked, own = np.intersect1d(frames, known, return_indices=True)
        for limb in named:
            result[limb][asked] = values[limb][own]
        return result, unit


def picture_strip(shown: Shown, frames: Sequence[int], reader: FrameReader) -> ImageArray:
    """Pictures (H, W, 3) BGR of the best view, below them with the model, and captions."""
    recording, run = shown.recording, shown.run
    view = recording.view(best_view(recording, run, frames, shown.limbs))
    window = _person_window(recording.reference_camera(view), run, frames, _STRIP_HEIGHT)
    pictures = [shown.pictures(reader.frame_set(int(frame)), view, window) for frame in frames]
    columns = list(zip(pictures, shown.captions(frames), strict=True))
    return _sheet(columns, f"view {view.name}")


def _person_window(camera: Camera, run: Run, frames: Sequence[int], height: int) -> Window:
    """Part of the picture, so high, that has the person in all these frames; else all of it."""
    points = run.landmarks[np.isin(run.frame, np.asarray(frames))].reshape(-1, 3)
    points = points[np.isfinite(points).all(axis=1)]
    pixels = camera.project((points[:, None] + _ROOM * _CORNERS).reshape(-1, 3))
    pixels = pixels[np.isfinite(pixels).all(axis=1)]
    low, high = np.zeros(2), np.array([camera.width, camera.height], dtype=np.float64)
    if len(pixels):
        first, last = np.clip([pixels.min(axis=0), pixels.max(axis=0)], 0, high)
        if (last - first >= _SMALLEST).all():
            low, high = first, last
    scale = height / (high[1] - low[1])
    width = max(1, round(float(scale * (high[0] - low[0]))))
    return Window(float(low[0]), float(low[1]), float(scale), width, height)


def _sheet(columns: Sequence[tuple[Sequence[ImageArray], Sequence[str]]], title: str) -> ImageArray:
    """Columns of pictures with lines of text below, beside each other under a title."""
    import matplotlib  # all three only where something is written: they take their time
    from PIL import Image, ImageDraw, ImageFont

    place = Path(matplotlib.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf"
    font = ImageFont.truetype(place, _TEXT, layout_engine=ImageFont.Layout.BASIC)
    widths = [
        max(pictures[0].shape[1], *(int(font.getlength(line)) + 5 for line in lines))
        for pictures, lines in columns
    ]
    below = _BORDER + _LINE + sum(len(picture) + _GAP for picture in columns[0][0])
    height = below + _LINE * max(len(lines) for _, lines in columns) + _BORDER
    width = sum(widths) + _GAP * (len(widths) - 1) + 2 * _BORDER
    sheet = Image.new("RGB", (width, height), "white")
    pen = ImageDraw.Draw(sheet)
    pen.text((_BORDER, _BORDER), title, font=font, fill=_FAINT)
    left = _BORDER
    for wide, (pictures, lines) in zip(widths, columns, strict=True):
        top = _BORDER + _LINE
        for picture in pictures:
            beside = (wide - picture.shape[1]) // 2
            sheet.paste(Image.fromarray(picture[..., ::-1]), (left + beside, top))
            top += len(picture) + _GAP
        middle, words = (left + wide / 2, below), "\n".join(lines)
        pen.text(middle, words, _INK, font, anchor="ma", align="center")
        left += wide + _GAP
    return np.ascontiguousarray(np.asarray(sheet)[..., ::-1])


_STRIP_FRAMES = 5


def strip_of(
    search: FailureSearch, recording: Recording, failure: FailureSegment, reader: FrameReader
) -> ImageArray:
    """Evenly spread frames of a failure as a strip (H, W, 3) BGR; see :func:`picture_strip`."""
    frames = np.round(np.linspace(failure.first, failure.last, _STRIP_FRAMES)).astype(int)
    reference = search.reference if failure.found == "truth" else None
    shown = Shown(recording, search.run, failure.limbs, reference)
    return picture_strip(shown, np.unique(frames).tolist(), reader)

"""Film strips of a failure: a cell for each view and frame, cropped to the limbs that fail."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from stereotrack_core.annotation.predict import hidden_landmarks, in_image
from stereotrack_core.arrays import FloatArray, ImageArray
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


CELL = 200  # pixels of a cell's sides
_COLUMNS = 5
_AROUND = 0.2  # seconds before and after a failure that are shown as well
_ROOM = 0.15  # metres around the limbs that are shown as well
_SMALLEST = 16.0  # pixels of the picture that a cell shows at least


@dataclass(frozen=True, eq=False)
class FilmCell:
    """One view of a frame."""

    view: str
    camera: str
    frame: int
    window: Window
    quarter_turns: int  # clockwise, by which the pictures are turned upright
    pictures: tuple[ImageArray, ...]  # (CELL, CELL, 3) BGR, of each run and of the reference

    def pixel_at(self, x: float, y: float) -> tuple[float, float]:
        """Pixel of the camera's image at a place of the cell, 0 to 1 in both directions."""
        for _ in range(self.quarter_turns):
            x, y = y, 1.0 - x
        across, down = x * self.window.width - 0.5, y * self.window.height - 0.5
        scale = self.window.scale
        return self.window.left + across / scale, self.window.top + down / scale

    def place_of(self, pixel: tuple[float, float]) -> tuple[float, float]:
        """Place in the cell, 0 to 1 in both directions, of a pixel of the camera's image."""
        shown = self.window.of(np.array(pixel))
        x, y = (shown + 0.5) / (self.window.width, self.window.height)
        for _ in range(self.quarter_turns):
            x, y = 1.0 - y, x
        return float(x), float(y)


def film_frames(failure: FailureSegment, fps: float, count: int) -> tuple[int, ...]:
    """Evenly spread frames of a failure and a little around it, with the worst one."""
    around = max(1, round(_AROUND * fps))
    first, last = max(failure.first - around, 0), min(failure.last + around, count - 1)
    spread = np.round(np.linspace(first, last, min(_COLUMNS, last - first + 1))).astype(int)
    nearest = int(np.argmin(np.abs(spread - failure.peak_frame)))
    spread[nearest] = failure.peak_frame
    return tuple(np.unique(spread).tolist())


@dataclass(frozen=True, eq=False)
class Film:
    """Contents of a strip: the runs and the reference, one at a time."""

    recording: Recording
    runs: tuple[Run, ...]
    reference: LandmarkTrajectory | None
    limbs: tuple[str, ...]
    frames: tuple[int, ...]

    def cells(self, reader: FrameReader) -> tuple[FilmCell, ...]:
        """The cells of the reader's views, view by view and in each by frames."""
        windows = {view.name: self._window(view) for view in reader.views}
        found: dict[str, list[FilmCell]] = {view.name: [] for view in reader.views}
        for frame in self.frames:
            images, bodies = reader.frame_set(frame), [body_at(run, frame) for run in self.runs]
            for view in reader.views:
                window = windows[view.name]
                pictures = self._pictures(images, view, window, bodies)
                turns = (view.display_rotation // 90) % 4
                upright = (np.ascontiguousarray(np.rot90(one, -turns)) for one in pictures)
                camera = view.image.camera
                cell = FilmCell(view.name, camera, frame, window, turns, tuple(upright))
                found[view.name].append(cell)
        return tuple(cell for row in found.values() for cell in row)

    def _pictures(
        self, images: FrameSet, view: View, window: Window, bodies: Sequence[Sequence[PartMesh]]
    ) -> list[ImageArray]:
        camera, seen = self.recording.reference_camera(view), images.views.get(view.name)
        grey = np.full((window.height, window.width, 3), 60, dtype=np.uint8)
        plain = grey if seen is None else window.cut(seen.image)
        drawn = [plain.copy() for _ in bodies]
        for picture, meshes in zip(drawn, bodies, strict=True):
            draw_body(picture, camera, window, meshes, thick=self.limbs)
        if self.reference is not None:
            truth = points_at(self.reference, np.array([images.index]))[0]
            drawn.append(plain.copy())
            draw_reference(drawn[-1], camera, window, truth)
        return drawn

    def _window(self, view: View) -> Window:
        """Square part of a view's picture that has the limbs in all frames and runs."""
        camera: Camera = self.recording.reference_camera(view)
        ends = sorted({name for limb in self.limbs for end in LIMB_ENDS[limb] for name in end})
        rows = [LANDMARKS.index(name) for name in ends] or list(range(len(LANDMARKS)))
        frames = np.array(self.frames)
        known = [run.trajectory() for run in self.runs]
        known += [] if self.reference is None else [self.reference]
        points = np.concatenate([points_at(one, frames)[:, rows].reshape(-1, 3) for one in known])
        corners = _ROOM * np.array([[1, 1, 1], [-1, -1, -1], [1, -1, 0], [-1, 1, 0]])
        pixels: FloatArray = camera.project((points[:, None] + corners).reshape(-1, 3))
        pixels = pixels[np.isfinite(pixels).all(axis=1)]
        whole = np.array([camera.width, camera.height], dtype=np.float64)
        if len(pixels):
            low, high = (np.clip(ends, 0.0, whole) for ends in (pixels.min(0), pixels.max(0)))
        if not len(pixels) or (high - low < _SMALLEST).any():
            low, high = np.zeros(2), whole
        side, middle = float((high - low).max()), (low + high) / 2.0
        left, top = (middle - side / 2.0).tolist()
        return Window(left, top, CELL / side, CELL, CELL)


_STRIP_FRAMES, _GAP, _BORDER = 5, 6, 10
_TEXT, _LINE = 15.0, 22
_INK, _FAINT = (20, 20, 20), (90, 90, 90)  # of captions, and of the title


def strip_of(search: FailureSearch, recording: Recording, failure: FailureSegment) -> ImageArray:
    """Strip (H, W, 3) BGR of evenly spread frames of a failure in the view that shows it best.

    The run is above; where the failure was found by error, the reference is below.
    """
    run, limbs = search.run, failure.limbs
    frames = np.unique(np.linspace(failure.first, failure.last, _STRIP_FRAMES).round().astype(int))
    reference = search.reference if failure.found == "truth" else None
    view = best_view(recording, run, frames.tolist(), limbs)
    film = Film(recording, (run,), reference, limbs, tuple(frames.tolist()))
    with FrameReader(recording, views=[view], read_ahead=0) as reader:
        pictures = [cell.pictures for cell in film.cells(reader)]
    return _sheet(list(zip(pictures, captions(film), strict=True)), f"view {view}")


def captions(film: Film) -> list[tuple[str, ...]]:
    """Caption of each frame: its number, then the limbs' errors or the run's own judgement."""
    run, frames = film.runs[0], np.array(film.frames)
    if film.reference is None:
        known, values, unit = run.frame, 100.0 * run.limb_lost, " % lost"
    else:
        errors, unit = errors_against(run.trajectory(), film.reference), "°"
        known, values = errors.frame, errors.degrees
    told = [[f"frame {frame}"] for frame in film.frames]
    _, asked, own = np.intersect1d(frames, known, return_indices=True)
    for lines, row in zip((told[i] for i in asked), values[own], strict=True):
        each = ((limb, row[LIMBS.index(limb)]) for limb in film.limbs)
        lines += [f"{limb.replace('_', ' ')} {x:.0f}{unit}" for limb, x in each if np.isfinite(x)]
    return [tuple(lines) if len(lines) > 1 else (*lines, "unknown") for lines in told]


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

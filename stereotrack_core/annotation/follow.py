"""Follow what is around clicks through the images.

Every step is taken by pyramidal Lucas-Kanade from the last picture and checked by going back (the
forward-backward error of Kalal, Mikolajczyk and Matas, ICPR 2010, doi:10.1109/ICPR.2010.675).
"""

import warnings
from collections import defaultdict
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence

import cv2
import numpy as np

from stereotrack_core.annotation.click import Click, Prediction, sigma_of
from stereotrack_core.arrays import FloatArray, ImageArray
from stereotrack_core.errors import InputError
from stereotrack_core.recording.reader import FrameReader

FOLLOWING = "following"  # source of followed points
_CRITERIA = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 40, 1e-3)
_LINES = 480
_WINDOW, _LEVELS = 13, 3  # side of the patch, pixels at 480 lines; pyramid levels above the first
_BACK = 1.0  # pixels at 480 lines by which a step forward and back may miss the start
MOST_FRAMES = 30  # over which anything is followed
_APART = 6.0  # pixels at 480 lines between the nine points that stand for one
_UNCERTAIN, _ASTRAY, _UNLIKE_NEIGHBOURS = 3.0, 0.1, 2.0
"""Pixels at 480 lines by which a followed group may be off; share of the way; and pixels where none
of the group finds the way back."""


def follow_points(
    images: Iterable[ImageArray | None],
    starts: FloatArray,
    *,
    cancelled: Callable[[], bool] = lambda: False,
) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Follow pixels (n, 2) of the first picture through the others, until one is missing.

    Nine points around each are followed, and the median of those that find the way back counts.
    Yields pixels (n, 2) and standard deviations (n,) per axis for every further grey picture, NaN
    where they were lost.
    """
    pictures = iter(images)
    before = next(pictures, None)
    if before is None:
        return
    scale = max(1.0, min(before.shape[:2]) / _LINES)
    around = _APART * scale * np.array([(x, y) for x in (-1, 0, 1) for y in (-1, 0, 1)])
    points = (starts[:, None] + around).reshape(-1, 2)
    back = np.zeros(len(points))
    for picture in pictures:
        if picture is None or cancelled():
            return
        found = flow(before, picture, points, scale)
        missed = np.linalg.norm(flow(picture, before, found, scale) - points, axis=1)
        back = np.fmax(back, np.where(np.isnan(missed), np.inf, missed))
        before, points = picture, found
        kept = (back <= _BACK * scale).reshape(len(starts), -1)
        ends = np.where(kept[..., None], points.reshape(len(starts), -1, 2) - around, np.nan)
        yield _middle(starts, ends, scale)


def _middle(starts: FloatArray, ends: FloatArray, scale: float) -> tuple[FloatArray, FloatArray]:
    """Where groups (n, 9, 2) have come to (n, 2), and the standard deviations (n,)."""
    known = np.isfinite(ends[..., 0])
    with warnings.catch_warnings(action="ignore", category=RuntimeWarning):  # a whole group is lost
        middle = np.nanmedian(ends, axis=1)
        apart = np.nanmedian(np.abs(ends - middle[:, None]).sum(axis=-1), axis=1)
    own = apart / np.sqrt(np.maximum(known.sum(axis=1), 1))
    spread = own + _UNLIKE_NEIGHBOURS * scale * (1.0 - known.mean(axis=1))
    way = np.linalg.norm(middle - starts, axis=1)
    return middle, np.hypot(np.hypot(_UNCERTAIN * scale, _ASTRAY * way), spread)


def flow(
    one: ImageArray,
    two: ImageArray,
    points: FloatArray,
    scale: float,
    *,
    window: int = _WINDOW,
    move: FloatArray | None = None,
) -> FloatArray:
    """Where points (m, 2) of one grey picture are in another; NaN where they are not found.

    `window` is the side of the patch at 480 lines, and pictures are finer by `scale`; `move` (m, 2)
    is expected.
    """
    known = np.isfinite(points).all(axis=1)
    found = np.full(points.shape, np.nan)
    if known.any():
        at = points[known].astype(np.float32).reshape(-1, 1, 2)
        near = at if move is None else at + move[known].astype(np.float32).reshape(-1, 1, 2)
        ends, status, _ = cv2.calcOpticalFlowPyrLK(
            one, two, at, near.copy(), winSize=(round(window * scale) | 1,) * 2, maxLevel=_LEVELS,
            criteria=_CRITERIA, flags=0 if move is None else cv2.OPTFLOW_USE_INITIAL_FLOW,
        )  # fmt: skip
        found[known] = np.where(status.reshape(-1, 1), ends.reshape(-1, 2), np.nan)
    return found


def pictures_of(
    reader: FrameReader, camera: str, frames: Iterable[int]
) -> Iterator[ImageArray | None]:
    """Grey pictures (H, W) of a camera, None for one not readable. Raises InputError."""
    for view in reader.views:
        if view.image.camera == camera or (view.left is not None and view.left.camera == camera):
            break
    else:
        what = f"no stream of the recording uses the camera {camera!r}"
        raise InputError(what, reader.recording.name, "Choose a camera of one of the views.")
    for frame in frames:
        images = reader.frame_set(frame).views.get(view.name)
        picture = None
        if images is not None:
            picture = images.image if view.image.camera == camera else images.left
        if picture is not None and picture.ndim == 3:
            picture = np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), dtype=np.uint8)
        yield picture


def follow_clicks(
    reader: FrameReader,
    clicks: Iterable[Click],
    frames: Collection[int],
    *,
    cancelled: Callable[[], bool] = lambda: False,
) -> tuple[Prediction, ...]:
    """Follow clicks to frames before and after, each up to its landmark's next click."""
    shown = {stream.camera for view in reader.views for stream in view.streams().values()}
    groups: dict[tuple[str, int], list[Click]] = defaultdict(list)
    clicked: dict[tuple[str, str], list[int]] = defaultdict(list)
    for click in clicks:
        if click.camera in shown:
            clicked[click.camera, click.landmark].append(click.frame)
            if click.position is not None:
                groups[click.camera, click.frame].append(click)
    found: list[Prediction] = []
    for (camera, start), own in groups.items():
        for step in (1, -1):
            ends = [
                min([abs(f - start) for f in clicked[key] if (f - start) * step > 0] or [2**62])
                for key in ((camera, click.landmark) for click in own)
            ]
            reach = min(max(ends) - 1, MOST_FRAMES)
            wanted = [f for f in frames if 0 < (f - start) * step <= reach]
            if not wanted:
                continue
            way = range(start, (max(wanted) if step > 0 else min(wanted)) + step, step)
            places = np.array([click.position for click in own], dtype=np.float64)
            pictures = pictures_of(reader, camera, way)
            steps = follow_points(pictures, places, cancelled=cancelled)
            for frame, (pixels, spreads) in zip(way[1:], steps, strict=False):
                if frame in wanted:
                    found += _found([*zip(own, ends, strict=True)], frame, pixels, spreads)
    return tuple(found)


def _found(
    clicks: Sequence[tuple[Click, int]], frame: int, pixels: FloatArray, spreads: FloatArray
) -> Iterator[Prediction]:
    """Predictions of clicks that are nearer to the frame than their landmarks' next clicks."""
    for (click, end), place, spread in zip(clicks, pixels.tolist(), spreads, strict=True):
        if abs(frame - click.frame) < end and np.isfinite(spread):
            x, y = place
            total = float(np.hypot(spread, sigma_of(click)))
            yield Prediction(frame, click.camera, click.landmark, FOLLOWING, (x, y), total)

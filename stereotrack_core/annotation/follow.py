"""Follow the patch of the image around a click, until it becomes unreliable.

Every step is taken by pyramidal Lucas-Kanade from the last picture and checked by going back (the
forward-backward error of Kalal, Mikolajczyk and Matas, ICPR 2010, doi:10.1109/ICPR.2010.675). Then
the patch of the first picture is looked for around the place found, so that small errors do not add
up (the third strategy of Matthews, Ishikawa and Baker, doi:10.1109/TPAMI.2004.16); where it is
found near by, it decides.
"""

from __future__ import annotations

import warnings
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import chain

import cv2
import numpy as np

from stereotrack_core.annotation.click import USUAL_SIGMA, Click, Prediction, sigma_of
from stereotrack_core.arrays import FloatArray, ImageArray, IntArray
from stereotrack_core.errors import InputError
from stereotrack_core.recording.reader import FrameReader

FOLLOWING = "following"
"""Source of followed points."""

_CRITERIA = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 40, 1e-3)
_LEAST_TEXTURE = 1e-4
"""Least eigenvalue of the gradients in the patch, as OpenCV norms it, at 480 lines."""

_LINES = 480
_DRIFT = 0.5
_UNLIKE = 6.0
"""Pixels after one frame, growing with its root; and pixels for a patch that is not alike at all;
at 480 lines. Clothes do not move as the joint under them does: on rendered recordings with truth
the patch was off by 0.5 px in the median after 20 frames, and by 5 px in one case of twenty."""


_WINDOW, _LEVELS = 13, 3
"""Side of the patch in pixels at 480 lines, and levels of the image pyramid above the first."""

_BACK = 1.0
"""Largest distance in pixels from the start after one step forward and back, at 480 lines."""

_SCORE = 0.8  # smallest correlation with the clicked patch
MOST_FRAMES = 30  # over which anything is followed


@dataclass(frozen=True, eq=False)
class Followed:
    """A patch followed over F pictures, the first of which was clicked."""

    pixels: FloatArray
    """(F, 2); raw pixels; the last row may be the unreliable one that ended it, NaN where it was
    lost."""
    score: FloatArray  # (F,); correlation with the first patch, -1 to 1; 1 in the first
    forward_backward_px: FloatArray
    """(F,); distance from where it came from, after going back; 0 in the first."""
    sigma_px: FloatArray
    """(F,); standard deviation per axis to be expected besides that of the click."""
    reliable_until: int  # rows before this one are reliable
    reason: str  # why it ended there, in words


def follow_patch(
    images: Iterable[ImageArray | None],
    start: FloatArray,
    *,
    cancelled: Callable[[], bool] | None = None,
) -> Followed:
    """Follow the patch around a pixel (2,) of the first picture through the others.

    The grey pictures (H, W), in the order of following, are read one by one as far as needed; None
    stands for one that cannot be read, which ends it. Before every picture `cancelled` is asked
    whether to stop; what was followed is kept.

    ValueError where there is no first picture.
    """
    pictures = iter(images)
    first = next(pictures, None)
    if first is None:
        raise ValueError("there is no first image to follow a patch from")
    patch = _Patch(first, np.asarray(start, dtype=np.float64))
    steps = [_Step(patch.start, 1.0, 0.0)]
    before, trouble = first, ""
    while not trouble:
        picture, end = _next_picture(pictures, len(steps), cancelled)
        if picture is None:
            return _followed(steps, len(steps), end, patch.scale)
        steps.append(patch.step(before, steps[-1].pixel, picture))
        trouble = _trouble(steps[-1], picture, patch.scale)
        before = picture
    return _followed(steps, len(steps) - 1, trouble, patch.scale)


@dataclass(frozen=True, eq=False)
class _Step:
    """Where a patch was found (2,), how much it is like the first, and how far back it comes."""

    pixel: FloatArray
    score: float
    back: float


class _Patch:
    """The patch that was clicked."""

    def __init__(self, picture: ImageArray, start: FloatArray) -> None:
        self.start = start
        self.scale = max(1.0, min(picture.shape[:2]) / _LINES)
        self._picture = picture
        self._window = (round(_WINDOW * self.scale) | 1,) * 2
        self._content = cv2.getRectSubPix(picture, self._window, start.tolist())

    def step(self, before: ImageArray, at: FloatArray, picture: ImageArray) -> _Step:
        """Go from a place in the last picture to the next one."""
        found = self._flow(before, at, picture, at, _LEVELS)
        back = self._flow(picture, found, before, found, _LEVELS)
        step = _Step(found, self._score(picture, found), float(np.linalg.norm(back - at)))
        if not np.isfinite(found).all():
            return step
        again = self._flow(self._picture, self.start, picture, found, 0)
        near = np.linalg.norm(again - found) < self._window[0] / 4.0
        if near and (score := self._score(picture, again)) > step.score:
            return _Step(again, score, step.back)
        return step

    def _flow(
        self,
        one: ImageArray,
        at: FloatArray,
        two: ImageArray,
        guess: FloatArray,
        levels: int,
    ) -> FloatArray:
        """Place (2,) in picture two of a place in picture one; NaN where it is not found."""
        if not np.isfinite([at, guess]).all():
            return np.full(2, np.nan)
        found, status, _ = cv2.calcOpticalFlowPyrLK(
            one,
            two,
            at.astype(np.float32).reshape(1, 1, 2),
            guess.astype(np.float32).reshape(1, 1, 2),
            winSize=self._window,
            maxLevel=levels,
            criteria=_CRITERIA,
            flags=cv2.OPTFLOW_USE_INITIAL_FLOW,
            minEigThreshold=_LEAST_TEXTURE / self.scale**2,
        )
        return np.asarray(found, np.float64).reshape(2) if status.all() else np.full(2, np.nan)

    def _score(self, picture: ImageArray, at: FloatArray) -> float:
        """Correlation of the patch at a place with the first one."""
        if not np.isfinite(at).all():
            return float("nan")
        there = cv2.getRectSubPix(picture, self._window, at.tolist())
        return float(cv2.matchTemplate(there, self._content, cv2.TM_CCOEFF_NORMED)[0, 0])


def _next_picture(
    pictures: Iterator[ImageArray | None],
    done: int,
    cancelled: Callable[[], bool] | None,
) -> tuple[ImageArray | None, str]:
    """The next picture, or why there is none."""
    if done > MOST_FRAMES:
        return None, f"the limit of {MOST_FRAMES} frames was reached"
    if cancelled is not None and cancelled():
        return None, "stopped"
    try:
        picture = next(pictures)
    except StopIteration:
        return None, "the images end"
    return picture, "the image cannot be read"


def _trouble(step: _Step, picture: ImageArray, scale: float) -> str:
    """Why a step cannot be relied on; empty where it can."""
    if not np.isfinite(step.pixel).all():
        return "the image has no texture here"
    height, width = picture.shape[:2]
    x, y = step.pixel
    if not (-0.5 <= x <= width - 0.5 and -0.5 <= y <= height - 0.5):
        return "it leaves the image"
    if not step.back <= scale * _BACK:
        missed = (
            f"misses the start by {step.back:.1f} px"
            if np.isfinite(step.back)
            else "does not find the start"
        )
        return f"following backwards {missed}"
    if not step.score >= _SCORE:
        return f"the patch has changed too much (correlation {step.score:.2f})"
    return ""


def _followed(steps: list[_Step], reliable: int, reason: str, scale: float) -> Followed:
    score, frames = np.array([step.score for step in steps]), np.arange(len(steps))
    return Followed(
        pixels=np.array([step.pixel for step in steps]),
        score=score,
        forward_backward_px=np.array([step.back for step in steps]),
        sigma_px=scale * (_DRIFT * np.sqrt(frames) + _UNLIKE * (1.0 - score) * (frames > 0)),
        reliable_until=reliable,
        reason=reason,
    )


_APART = 6.0  # pixels at 480 lines between the nine points that stand for one
_UNCERTAIN, _ASTRAY, _UNLIKE_NEIGHBOURS = 3.0, 0.1, 2.0
"""Pixels at 480 lines by which a followed group may be off; share of the way; and pixels where none
of the group finds the way back."""


def follow_points(
    images: Iterable[ImageArray | None],
    starts: FloatArray,
    *,
    cancelled: Callable[[], bool] | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Follow pixels (n, 2) of the first picture to the last one.

    Nine points around each are followed, and the median of how those moved that find the way back
    counts: where a joint hides under plain skin, what is around it moves along.

    Returns the pixels (n, 2), and their standard deviations (n,) per axis; NaN where they were
    lost, and everywhere where a picture is missing or it was cancelled.
    """
    lost = np.full(starts.shape, np.nan), np.full(len(starts), np.nan)
    pictures = iter(images)
    before = next(pictures, None)
    if before is None:
        return lost
    scale = max(1.0, min(before.shape[:2]) / _LINES)
    around = _APART * scale * np.array([(x, y) for x in (-1, 0, 1) for y in (-1, 0, 1)])
    points = (starts[:, None] + around).reshape(-1, 2)
    back = np.zeros(len(points))
    for picture in pictures:
        if picture is None or (cancelled is not None and cancelled()):
            return lost
        found = _flow(before, picture, points, scale)
        missed = np.linalg.norm(_flow(picture, before, found, scale) - points, axis=1)
        back = np.fmax(back, np.where(np.isnan(missed), np.inf, missed))
        before, points = picture, found
    kept = (back <= _BACK * scale).reshape(len(starts), -1)
    ends = np.where(kept[..., None], points.reshape(len(starts), -1, 2) - around, np.nan)
    return _middle(starts, ends, scale)


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


def _flow(one: ImageArray, two: ImageArray, points: FloatArray, scale: float) -> FloatArray:
    """Where points (m, 2) of one picture are in another; NaN where they are not found."""
    known = np.isfinite(points).all(axis=1)
    found = np.full(points.shape, np.nan)
    if known.any():
        at = points[known].astype(np.float32).reshape(-1, 1, 2)
        window = (round(_WINDOW * scale) | 1,) * 2
        ends, status, _ = cv2.calcOpticalFlowPyrLK(
            one, two, at, at.copy(), winSize=window, maxLevel=_LEVELS, criteria=_CRITERIA
        )
        found[known] = np.where(status.reshape(-1, 1), ends.reshape(-1, 2), np.nan)
    return found


@dataclass(frozen=True, eq=False)
class FollowedClick:
    """A click followed through frames (F,), which descend where it was followed backward."""

    click: Click
    frame: IntArray
    followed: Followed

    def words(self) -> str:
        """``left elbow in N_right: followed to frame 231; then it leaves the image``."""
        last = int(self.frame[self.followed.reliable_until - 1])
        what = f"{self.click.landmark.replace('_', ' ')} in {self.click.camera}"
        return f"{what}: followed to frame {last}; stopped because {self.followed.reason}"


def follow_click(
    reader: FrameReader,
    click: Click,
    frames: range,
    *,
    cancelled: Callable[[], bool] | None = None,
) -> FollowedClick:
    """Follow a click over frames that begin with its own, forward or backward.

    A reader that was opened for the camera's view alone decodes the least.

    InputError where the camera shows no image of the recording, or the click's own picture
    cannot be read.
    """
    pictures = pictures_of(reader, click.camera, frames)
    first = next(pictures, None)
    if first is None:
        raise InputError(
            f"the image of {click.camera} at frame {click.frame} cannot be read",
            where=reader.recording.name,
            remedy="Start from another frame.",
        )
    start = np.array(click.position)
    followed = follow_patch(chain([first], pictures), start, cancelled=cancelled)
    return FollowedClick(click, np.array(frames[: len(followed.pixels)]), followed)


def pictures_of(
    reader: FrameReader, camera: str, frames: Iterable[int]
) -> Iterator[ImageArray | None]:
    """Grey pictures (H, W) of a camera, one by one; None for one that cannot be read.

    InputError where none of the reader's views shows this camera.
    """
    for view in reader.views:
        if view.image.camera == camera or (view.left is not None and view.left.camera == camera):
            break
    else:
        raise InputError(
            f"no stream of the recording uses the camera {camera!r}",
            where=reader.recording.name,
            remedy="Choose a camera of one of the views.",
        )
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
    frame: int,
    *,
    sigma: Mapping[str, float] | float = USUAL_SIGMA,
    cancelled: Callable[[], bool] | None = None,
) -> tuple[Prediction, ...]:
    """Follow clicks of other frames to one frame, through all frames in between.

    Those in cameras that the reader does not show, and those that were lost, are left out.
    """
    groups: dict[tuple[str, int], list[Click]] = defaultdict(list)
    shown = {stream.camera for view in reader.views for stream in view.streams().values()}
    for click in clicks:
        if click.position is not None and click.camera in shown:
            groups[click.camera, click.frame].append(click)
    found = []
    for (camera, start), own in groups.items():
        if abs(frame - start) > MOST_FRAMES:
            continue
        way = range(start, frame + 1) if frame > start else range(start, frame - 1, -1)
        places = np.array([click.position for click in own], dtype=np.float64)
        ends, spreads = follow_points(pictures_of(reader, camera, way), places, cancelled=cancelled)
        for click, end, spread in zip(own, ends.tolist(), spreads.tolist(), strict=True):
            if np.isfinite(spread):
                total = float(np.hypot(spread, sigma_of(click, sigma)))
                key = (frame, camera, click.landmark)
                found.append(Prediction(*key, FOLLOWING, (end[0], end[1]), total))
    return tuple(found)

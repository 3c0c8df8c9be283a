"""What may explain errors: distance from the cameras, speed, and how many views see a limb."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.body.limbs import LIMB_ENDS, LIMBS
from stereotrack_core.body.model import BodyModel, placed_cones
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.sampling import inside_other_cone, regular_points, visible
from stereotrack_core.body.skeleton import LIMB_OF_PART
from stereotrack_core.errors import Cancelled
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.landmarks import LANDMARKS

POINTS_PER_CONE = 24
"""Points on each cone of the body by which it is judged what a camera sees."""

FREE_SHARE = 0.5
"""A view sees a limb free where it sees this share of the limb's side that faces it."""


@dataclass(frozen=True, eq=False)
class Circumstances:
    """Where limbs are and how they move; F frames, limbs in the order of ``LIMBS``."""

    frame: IntArray
    """(F,)."""
    distance: FloatArray
    """(F, 6), metres. From the limb's middle to the nearest camera."""
    speed: FloatArray
    """(F, 6), metres per second. Of the limb's far end: hand, elbow, head, middle of the
    shoulders."""


def circumstances_of(
    frame: IntArray, points: FloatArray, cameras: Sequence[Camera], fps: float
) -> Circumstances:
    """Circumstances in every frame.

    Parameters
    ----------
    frame : (F,) int64
        Ascending.
    points : (F, 9, 3) float64, world, metres
        Landmarks: of the reference, where there is one, for those of a run are wrong where it errs.
    cameras : sequence of Camera
        One for each view: that of its reference image.
    fps : float
        Frame sets per second.
    """
    ends = limb_ends(points)
    places = np.array([camera.position_world for camera in cameras]).reshape(-1, 3)
    away = np.linalg.norm(ends.mean(axis=2)[:, :, None] - places, axis=-1)
    distance = away.min(axis=-1) if len(places) else np.full(away.shape[:2], np.nan)
    return Circumstances(frame, distance, _speeds(frame, ends[:, :, 1], fps))


def views_that_see(
    body: BodyModel,
    poses: Sequence[Pose | None],
    cameras: Sequence[Camera],
    *,
    on_progress: Callable[[int], None] = lambda _: None,
    cancelled: Callable[[], bool] = lambda: False,
) -> FloatArray:
    """How many views see each limb free (F, 6), by the body model.

    Hidden neither by another limb nor by the border of the image; NaN where the pose is not known.
    There is one camera for each view, and `on_progress` is told how many frames are done.
    """
    result: FloatArray = np.full((len(poses), len(LIMBS)), np.nan)
    for i, pose in enumerate(poses):
        if pose is not None:
            result[i] = np.sum(seen_shares(body, pose, cameras) >= FREE_SHARE, axis=0)
        on_progress(i + 1)
        if cancelled():
            raise Cancelled
    return result


def limb_ends(points: FloatArray) -> FloatArray:
    """Near and far ends (F, 6, 2, 3), world, metres, of the limbs of landmarks (F, 9, 3)."""
    result: FloatArray = np.empty((len(points), len(LIMBS), 2, 3))
    for i, limb in enumerate(LIMBS):
        for end, names in enumerate(LIMB_ENDS[limb]):
            own = [LANDMARKS.index(name) for name in names]
            result[:, i, end] = points[:, own].mean(axis=1)
    return result


def seen_shares(body: BodyModel, pose: Pose, cameras: Sequence[Camera]) -> FloatArray:
    """Share (V, 6) of every limb's side facing a camera that this camera sees.

    Points of the surface that lie inside another part of the body count for neither.
    """
    frames = body.frames(pose)
    sampled = regular_points(body.cones, POINTS_PER_CONE * len(body.cones))
    sampled = sampled[LIMB_OF_PART[sampled.part] < len(LIMBS)]
    placed = placed_cones(body, frames)
    points = frames.apply(sampled.part, sampled.points)
    outside = ~inside_other_cone(points, sampled.cone, placed)
    sampled, points = sampled[outside], points[outside]
    normals = np.einsum("nij,nj->ni", frames.rotations[sampled.part], sampled.normals)
    result: FloatArray = np.zeros((len(cameras), len(LIMBS)))
    of_limb = LIMB_OF_PART[sampled.part]
    for v, camera in enumerate(cameras):
        place = camera.position_world
        facing = np.einsum("ni,ni->n", normals, place - points) > 0
        free = visible(points, normals, place[None], placed) & in_image(camera, points)
        for limb in range(len(LIMBS)):
            own = facing & (of_limb == limb)
            result[v, limb] = free[own].mean() if own.any() else 0.0
    return result


def in_image(camera: Camera, points: FloatArray) -> BoolArray:
    """Whether points (N, 3), world, metres, are within a camera's image (N,)."""
    pixels = camera.project(points)
    with np.errstate(invalid="ignore"):
        within = (pixels > -0.5) & (pixels < np.array([camera.width, camera.height]) - 0.5)
    result: BoolArray = np.asarray(within.all(axis=-1))
    return result


def _speeds(frame: IntArray, ends: FloatArray, fps: float) -> FloatArray:
    """Speeds (F, 6) of points (F, 6, 3) by the frames before and after, or by one of them."""
    step = np.full((len(frame) + 1, len(LIMBS)), np.nan)
    moved = np.linalg.norm(np.diff(ends, axis=0), axis=-1) * fps
    step[1:-1] = np.where((np.diff(frame) == 1)[:, None], moved, np.nan)
    both = np.full(ends.shape[:2], np.nan)
    if len(frame) > 2:
        over = np.linalg.norm(ends[2:] - ends[:-2], axis=-1) * fps / 2.0
        both[1:-1] = np.where((frame[2:] - frame[:-2] == 2)[:, None], over, np.nan)
    result: FloatArray = np.where(np.isfinite(both), both, np.fmax(step[:-1], step[1:]))
    return result


LEAST = 15
"""Values that stand together for one point of the curve, at least."""

LEAST_OF_A_PLACE = 5
"""Values of which a median is stated where places are taken one by one."""

_SHARE = 0.15
"""Of all values, that stand together for one point of the curve where that is more."""

_POINTS = 40
_FEW = 6
"""So many different places or fewer are taken one by one."""


@dataclass(frozen=True, eq=False)
class Trend:
    """A curve through a cloud of points; K places."""

    x: FloatArray
    """(K,). Ascending."""
    median: FloatArray
    low: FloatArray
    high: FloatArray
    """`median`, `low` and `high`: (K,). Median and quartiles of what stands around each place."""
    count: IntArray
    """(K,). How many values that were."""


def trend(x: FloatArray, y: FloatArray) -> Trend:
    """Running median of y (N,) over x (N,); pairs that are not known are left out.

    Around each place the same number of values counts: 15 % of all, at least :data:`LEAST`.
    Where x has only a few different values, as the number of views, each has a median of its own.
    """
    known = np.isfinite(x) & np.isfinite(y)
    order = np.argsort(x[known], kind="stable")
    x, y = x[known][order], y[known][order]
    places = np.unique(x)
    if len(places) <= _FEW:
        groups = {float(place): y[x == place] for place in places}
        enough = {place: own for place, own in groups.items() if len(own) >= LEAST_OF_A_PLACE}
        return _stated(list(enough), list(enough.values()))
    size = max(LEAST, round(_SHARE * len(x)))
    if len(x) < size:
        return _stated([], [])
    begins = np.unique(np.linspace(0, len(x) - size, _POINTS).round().astype(np.int64))
    windows = [slice(int(begin), int(begin) + size) for begin in begins]
    return _stated([float(np.median(x[own])) for own in windows], [y[own] for own in windows])


def _stated(places: list[float], groups: list[FloatArray]) -> Trend:
    quartiles = np.array([np.percentile(own, [25, 50, 75]) for own in groups]).reshape(-1, 3)
    counts = np.array([len(own) for own in groups], dtype=np.int64)
    low, median, high = quartiles.T
    return Trend(np.array(places), median, low, high, counts)

"""Does one camera contradict the others? By points that several cameras have seen.

Every camera is left out once: its sightings are compared with the points that the other cameras
give. A camera whose calibration or clock is wrong lies off nearly everywhere, smoothly over its
image or along the movement, and without it the others agree; single wrong sightings do neither.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.triangulation import covariance_of_rays, nearest_to_rays

_LEAST_PX = 6.0  # median distance from which a camera is named; eyes are no better
LEAST_RATIO = 2.5  # how much farther off it lies than the others are from each other
_LEAST_COUNT = 8
_LEAST_SHARE = 0.5  # share of its sightings that lie off where the camera is to blame
_USUAL_SHARE = 0.15  # share of wrong sightings that surprises nobody in any camera
_MOST_CHANCE = 1e-4
_LEAST_EXPLAINED = 0.6  # share of the distance that follows place or movement
_EXCHANGED = 0.5  # share of the distance that is left at most where left and right were mixed up
_CLEAR_SHARE = 0.6
_CLEAR_CHANCE = 0.01  # share of points that fit better without this camera than any other
_ASTRAY = 2.5  # standard deviations beyond which a sighting lies off
_GROSS = 5.0  # standard deviations that count at most where cameras are weighed against each other
_LARGEST_SPREAD = 4.0  # pixels by which the others' point may move for each of theirs
_LEAST_SPEED_PX = 3.0
_LEAST_LATE = 0.3
_LONGEST_STEP = 3  # frames between which a movement is taken to be even
_WHOLE_IMAGE = 24  # sightings from which a displacement may vary over the image
_ROUNDS = 30


@dataclass(frozen=True)
class Disagreement:
    """A camera that contradicts the others: `off` of its `count` sightings."""

    camera: str  # its name; empty where nobody can say which of two is wrong
    others: tuple[str, ...]  # those that agree with each other; or else the two that do not
    off_px: float
    """Median distance of its sightings from where the others have the points; where there are no
    others, from each other's epipolar lines."""
    agreement_px: float  # median distance of the others' sightings from their points; NaN if none
    count: int
    off: int
    late_frames: float = float("nan")  # later than the others, where that explains more; else NaN

    @property
    def doubtful(self) -> tuple[str, ...]:
        """Names of the cameras that may be wrong."""
        return (self.camera,) if self.camera else self.others


@dataclass(frozen=True)
class CameraResidual:
    """How far a camera's sightings lie from the points that the cameras agree on."""

    camera: str
    count: int  # sightings that could be compared
    median_px: float  # median distance, pixels; NaN where that are too few


@dataclass(frozen=True, eq=False)
class _Rest:
    """What the cameras say without one of them about N points."""

    error: FloatArray
    """(N,) in pixels per axis by which they miss the point that they give, `miss` the median
    distance of their sightings from it."""
    miss: float
    picture: FloatArray
    """(N, 2) is the point's in the camera that was left out, `off` (N, 2) its sighting minus that,
    NaN where either is not known well enough, `spread` (N,) the pixels by which the picture moves
    for every pixel of theirs."""
    off: FloatArray
    spread: FloatArray


def disagreeing_camera(
    cameras: Sequence[Camera],
    frame: IntArray,
    pixels: FloatArray,
    mirror: Sequence[int] | None = None,
) -> Disagreement | None:
    """The camera that contradicts the others by raw pixels (V, F, L, 2), NaN if unseen.

    None where exchanging left and right in it (`mirror` of each point) explains most of that.
    """
    seen = [v for v in range(len(cameras)) if np.isfinite(pixels[v]).all(axis=-1).any()]
    cameras, pixels = [cameras[v] for v in seen], pixels[seen]
    if len(cameras) < 2:
        return None
    found = _of_two(cameras, pixels) if len(cameras) == 2 else _of_many(cameras, frame, pixels)
    if found is None or mirror is None:
        return found
    for v, camera in enumerate(cameras):
        if camera.name in found.doubtful:
            exchanged = pixels.copy()
            exchanged[v] = pixels[v][:, list(mirror)]
            after, before = (
                _middle(_distances_from_others(cameras, one, v)) for one in (exchanged, pixels)
            )
            if after < _EXCHANGED * before:
                return None
    return found


def camera_residuals(
    cameras: Sequence[Camera], pixels: FloatArray, doubtful: Sequence[str] = ()
) -> tuple[CameraResidual, ...]:
    """What is said of each camera with raw pixels (V, F, L, 2), by points of the sound ones."""
    seen = [v for v in range(len(cameras)) if np.isfinite(pixels[v]).all(axis=-1).any()]
    if len(seen) < 2:
        return ()
    sound = [v for v in seen if cameras[v].name not in doubtful]
    sound = sound if len(sound) > 1 else seen
    chosen = [cameras[v] for v in sound]
    points, _ = _points(chosen, pixels[sound].reshape(len(sound), -1, 2))
    found = []
    for v in seen:
        if v in sound:
            off = np.linalg.norm(pixels[v].reshape(-1, 2) - cameras[v].project(points), axis=-1)
        else:
            off = _distances_from_others([cameras[v], *chosen], pixels[[v, *sound]], 0)
        found.append(CameraResidual(cameras[v].name, int(np.isfinite(off).sum()), _middle(off)))
    return tuple(found)


def _distances_from_others(cameras: Sequence[Camera], pixels: FloatArray, v: int) -> FloatArray:
    """How far the sightings of camera v of (V, F, L, 2) lie from what the others say (F, L)."""
    two = len(cameras) == 2
    rest = _between_two(cameras, pixels) if two else _without(cameras, pixels, v)
    return np.asarray(np.linalg.norm(rest.off, axis=-1).reshape(pixels.shape[1:3]))


def _of_many(cameras: Sequence[Camera], frame: IntArray, pixels: FloatArray) -> Disagreement | None:
    rests = [_without(cameras, pixels, v) for v in range(len(cameras))]
    middle = np.array([_middle(rest.error) for rest in rests])
    if not np.isfinite(middle).any():
        return None
    limit = _GROSS * max(float(np.nanmin(middle)), 0.1 * _LEAST_PX)
    cost = np.array([_middle(np.minimum(rest.error, limit) ** 2, np.mean) for rest in rests])
    best, second = (int(v) for v in np.argsort(np.where(np.isfinite(cost), cost, np.inf))[:2])
    wrong = float(np.mean(rests[best].error[np.isfinite(rests[best].error)] > limit))
    speed = _speeds(frame, rests[best].picture.reshape(*pixels.shape[1:])).reshape(-1, 2)
    found = _judged(rests[best], middle[best], max(wrong, _USUAL_SHARE), len(cameras), speed)
    if found is None:
        return None
    off_px, count, off, late = found
    if not _fit_better(rests[best].error, rests[second].error):
        pair = tuple(cameras[v].name for v in sorted((best, second)))
        return Disagreement("", pair, off_px, np.nan, count, off)
    others = tuple(camera.name for v, camera in enumerate(cameras) if v != best)
    miss = rests[best].miss
    return Disagreement(cameras[best].name, others, off_px, miss, count, off, late)


def _of_two(cameras: Sequence[Camera], pixels: FloatArray) -> Disagreement | None:
    """Whether two cameras contradict each other; which one is wrong they cannot say."""
    rest = _between_two(cameras, pixels)
    found = _judged(rest, 0.0, _USUAL_SHARE, 2, np.full_like(rest.off, np.nan))
    if found is None:
        return None
    off_px, count, off, _ = found
    return Disagreement("", tuple(camera.name for camera in cameras), off_px, np.nan, count, off)


def _fit_better(one: FloatArray, other: FloatArray) -> bool:
    """Whether most of the points have smaller errors in the first case, by more than chance."""
    both = np.isfinite(one) & np.isfinite(other)
    count, better = int(both.sum()), int((one[both] < other[both]).sum())
    chance = float(scipy.special.bdtrc(better - 1, count, 0.5))
    return better > _CLEAR_SHARE * count and chance < _CLEAR_CHANCE


def _between_two(cameras: Sequence[Camera], pixels: FloatArray) -> _Rest:
    """Distances from each other's epipolar lines, in the image of the first camera."""
    flat = pixels.reshape(2, -1, 2)
    points, _ = _points(cameras, flat)
    # the point lies half-way between both rays
    off = 2.0 * (flat[0] - cameras[0].project(points))
    return _Rest(np.empty(0), np.nan, flat[0], off, np.zeros(len(points)))


def _without(cameras: Sequence[Camera], pixels: FloatArray, left: int) -> _Rest:
    pixels = pixels.reshape(len(cameras), -1, 2)
    kept = [v for v in range(len(cameras)) if v != left]
    points, covariance = _points([cameras[v] for v in kept], pixels[kept])
    missed = [pixels[v] - cameras[v].project(points) for v in kept]
    squares = np.array([np.square(one).sum(axis=-1) for one in missed])
    number = np.isfinite(squares).sum(axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        error = np.sqrt(np.nansum(squares, axis=0) / np.where(number > 1, 2 * number - 3, np.nan))
    own = cameras[left]
    picture, spread = own.project(points), _spread(own, points, covariance)
    known = spread < _LARGEST_SPREAD
    off = np.where(known[:, None], pixels[left] - picture, np.nan)
    return _Rest(error, _middle(np.sqrt(squares)), picture, off, spread)


def _points(cameras: Sequence[Camera], pixels: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Points (N, 3), world, and covariances (N, 3, 3); rays count by metres per pixel there."""
    origins = np.array([camera.position_world for camera in cameras])
    directions = np.stack(
        [camera.rays_world(own) for camera, own in zip(cameras, pixels, strict=True)], axis=1
    )
    first = nearest_to_rays(origins, directions)
    focal = np.array([camera.focal for camera in cameras])
    distance = np.linalg.norm(first[:, None] - origins, axis=-1)
    weight = np.square(focal / np.maximum(distance, 1e-6))
    return (nearest_to_rays(origins, directions, weight), covariance_of_rays(directions, weight))


def _spread(camera: Camera, points: FloatArray, covariance: FloatArray) -> FloatArray:
    """Largest standard deviations (N,) of points in an image, pixels; infinite where unknown."""
    result = np.full(len(points), np.inf)
    known = np.isfinite(points).all(axis=-1) & np.isfinite(covariance).all(axis=(-1, -2))
    if known.any():
        ray = points[known] - camera.position_world
        distance = np.maximum(np.linalg.norm(ray, axis=-1), 1e-6)
        unit = ray / distance[:, None]
        across = np.eye(3) - unit[:, :, None] * unit[:, None, :]
        largest = np.linalg.eigvalsh(across @ covariance[known] @ across)[:, -1]
        result[known] = np.sqrt(np.maximum(largest, 0.0)) * camera.focal / distance
    return result


def _judged(
    rest: _Rest, error: float, usual: float, cameras: int, speed: FloatArray
) -> tuple[float, int, int, float] | None:
    """Median distance, sightings, those that lie off, frames later; None for no fault."""
    known = np.isfinite(rest.off).all(axis=-1)
    off, place, speed = rest.off[known], rest.picture[known], speed[known]
    distance = np.linalg.norm(off, axis=-1)
    gate = np.maximum(_LEAST_PX, _ASTRAY * error * np.hypot(1.0, rest.spread[known]))
    astray = distance > gate
    moving = np.linalg.norm(np.nan_to_num(speed), axis=-1) > _LEAST_SPEED_PX

    def blamed(chosen: BoolArray) -> bool:
        count, far = int(chosen.sum()), int((astray & chosen).sum())
        if count < _LEAST_COUNT or far < _LEAST_SHARE * count:
            return False
        chance = cameras * float(scipy.special.bdtrc(far - 1, count, usual))
        middle = float(np.median(distance[chosen]))
        return chance < _MOST_CHANCE and middle > max(_LEAST_PX, LEAST_RATIO * error)

    found, left = None, np.inf
    if blamed(np.ones(len(off), dtype=np.bool_)):
        columns = [np.ones(len(off))]
        if len(off) >= _WHOLE_IMAGE:
            columns += list((place - np.median(place, axis=0)).T)
        both_axes = np.einsum("km,ij->mikj", columns, np.eye(2)).reshape(len(off), 2, -1)
        follows, share, _ = _explained(off, both_axes)
        if follows:
            found, left = (float(np.median(distance)), len(off), int(astray.sum()), np.nan), share
    if blamed(moving):
        follows, share, (late,) = _explained(off[moving], -speed[moving][:, :, None])
        if follows and share < left and abs(late) >= _LEAST_LATE:
            far = int(astray[moving].sum())
            found = float(np.median(distance[moving])), int(moving.sum()), far, float(late)
    return found


def _explained(off: FloatArray, design: FloatArray) -> tuple[bool, float, FloatArray]:
    """Whether distances (M, 2) follow `design` (M, 2, K), the share left, and coefficients."""
    weight = np.ones(len(off))
    fitted: FloatArray = np.zeros_like(off)
    solution: FloatArray = np.zeros(design.shape[-1])
    for _ in range(_ROUNDS):
        rows = (np.sqrt(weight)[:, None, None] * design).reshape(-1, design.shape[-1])
        values = (np.sqrt(weight)[:, None] * off).ravel()
        solution = np.asarray(np.linalg.lstsq(rows, values, rcond=None)[0], dtype=np.float64)
        fitted = design @ solution
        weight = 1.0 / np.maximum(np.linalg.norm(off - fitted, axis=-1), 0.1)
    whole, followed, left = (
        float(np.median(np.linalg.norm(one, axis=-1))) for one in (off, fitted, off - fitted)
    )
    return followed >= _LEAST_EXPLAINED * whole, left / whole, solution


def _speeds(frame: IntArray, picture: FloatArray) -> FloatArray:
    """Movement (F, L, 2) of points (F, L, 2) in pixels per frame; NaN where it is not known."""
    result = np.full_like(picture, np.nan)
    if len(frame) >= 3:
        steps = np.diff(frame)
        near = (steps[:-1] <= _LONGEST_STEP) & (steps[1:] <= _LONGEST_STEP)
        way = (picture[2:] - picture[:-2]) / (frame[2:] - frame[:-2])[:, None, None]
        result[1:-1] = np.where(near[:, None, None], way, np.nan)
    return result


def _middle(values: FloatArray, middle: Callable[[FloatArray], Any] = np.median) -> float:
    """The middle of what is known of values; NaN where that is too little."""
    known = values[np.isfinite(values)]
    return float(middle(known)) if known.size >= _LEAST_COUNT else float("nan")

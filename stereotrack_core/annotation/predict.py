"""Where a landmark is after clicks in two or more images, and how far every click is from that.

The point follows from robust weighted least squares in the raw images. The error of a click is its
distance from what the other clicks predict, with a single other one from its epipolar curve. What a
person accepted takes part only where fewer than two clicks are a person's own.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stereotrack_core.annotation.click import (
    USUAL_SIGMA,
    Click,
    Prediction,
    Sigmas,
    Visibility,
    sigma_of,
)
from stereotrack_core.arrays import BoolArray, FloatArray
from stereotrack_core.depth.points import Volume
from stereotrack_core.geometry.camera import Camera, nearest_on_ray, pixel_jacobian
from stereotrack_core.geometry.triangulation import (
    Sightings,
    nearest_to_rays,
    point_of_sightings,
    segment_distance,
)
from stereotrack_core.recording.description import Cameras
from stereotrack_core.recording.landmarks import LANDMARKS

_COARSE, _FINE = 1000, 300  # samples of a ray to find its visible part, and of that part
_GRID = 9  # points along every side of the working volume, to know whether the cameras see it
_NEAREST = 1e-3  # metres; nearer to a camera nothing is looked for


def epipolar_curve(
    from_camera: Camera, pixel: FloatArray, to_camera: Camera, volume: Volume
) -> FloatArray:
    """Where a landmark clicked in one image can be in another, cut to the volume.

    Samples (K, 2) in raw pixels, from near to far; at the borders one lies beyond the image.
    """
    origin = from_camera.position_world
    direction = from_camera.rays_world(np.asarray(pixel, dtype=np.float64))
    near, far = ray_in_volume(origin, direction, volume)
    to_other = to_camera.position_world - origin
    foot = float(to_other @ direction)
    away = max(float(np.linalg.norm(to_other - foot * direction)), _NEAREST)
    # even steps of the angle at which the other camera sees the ray
    low, high = np.arctan((np.array([near, far]) - foot) / away)
    part = np.empty((0, 2))
    for count in (_COARSE, _FINE) if far > near else ():
        angle = np.linspace(low, high, count)
        distance = foot + away * np.tan(angle)
        pixels = to_camera.project(origin + distance[:, None] * direction)
        seen = np.flatnonzero(in_image(to_camera, pixels))
        if not len(seen):
            return np.empty((0, 2))
        first, last = max(int(seen[0]) - 1, 0), min(int(seen[-1]) + 1, count - 1)
        low, high, part = angle[first], angle[last], pixels[first : last + 1]
    return part[np.isfinite(part).all(axis=1)]


def volume_in_sight(volume: Volume, cameras: Sequence[Camera]) -> Volume:
    """The volume, or one around where the cameras look if fewer than two see some of it."""
    shares = np.linspace(0.0, 1.0, _GRID)
    grid = np.stack(np.meshgrid(shares, shares, shares), axis=-1).reshape(-1, 3)
    points = volume.low + grid * (volume.high - volume.low)
    seen = sum(in_image(camera, camera.project(points)).astype(int) for camera in cameras)
    if not cameras or np.max(seen) >= min(2, len(cameras)):
        return volume
    half = 0.5 * (volume.high - volume.low)
    middle = watched_point(cameras, float(np.linalg.norm(half)))
    return Volume(middle - half, middle + half)


def watched_point(cameras: Sequence[Camera], away: float) -> FloatArray:
    """The point (3,), world, that cameras look at together; else one so far in front of them."""
    origins = np.array([camera.position_world for camera in cameras])
    axes = np.array([camera.camera_from_world.rotation[2] for camera in cameras])
    point = nearest_to_rays(origins, axes)
    if np.isfinite(point).all() and (((point - origins) * axes).sum(axis=1) > 0).all():
        return point
    return np.asarray((origins + away * axes).mean(axis=0))


def ray_in_volume(origin: FloatArray, direction: FloatArray, volume: Volume) -> tuple[float, float]:
    """Distances at which a ray (3,) enters and leaves; the second is less where it misses."""
    with np.errstate(divide="ignore", invalid="ignore"):
        crossings = (np.stack([volume.low, volume.high]) - origin) / direction
    along = direction == 0
    if (along & ((origin < volume.low) | (origin > volume.high))).any() or along.all():
        return 0.0, -1.0
    low, high = np.sort(crossings[:, ~along], axis=0)
    return max(float(low.max()), _NEAREST), float(high.min())


def in_image(camera: Camera, pixels: FloatArray) -> BoolArray:
    """Whether raw pixels (..., 2) lie on the camera's image; False for NaN."""
    low = pixels >= -0.5
    high = pixels <= np.array([camera.width - 0.5, camera.height - 0.5])
    return np.asarray((low & high).all(axis=-1))


_LINES = 480.0


def pixel_scale(camera: Camera) -> float:
    """Factor from pixels at 480 lines to those of a camera; at least 1."""
    return max(1.0, min(camera.width, camera.height) / _LINES)


@dataclass(frozen=True, eq=False)
class PredictedPoint:
    """A landmark at one frame, from the clicks of it."""

    landmark: str
    world: FloatArray  # (3,), metres
    covariance: FloatArray  # (3, 3), square metres; grows where the clicks contradict each other
    used: tuple[str, ...]  # cameras whose clicks placed the point
    pixel: Mapping[str, FloatArray]  # (2,) raw pixels, by camera that shows it; as other clicks say
    spread_px: Mapping[str, float]  # largest standard deviation of these, pixels
    error_px: Mapping[str, float]  # of every click: how far it is from what the others predict
    outliers: tuple[str, ...] = ()  # cameras whose click fits none of the others

    @property
    def rms_px(self) -> float:
        """Root mean square error in pixels over the cameras that were used; NaN without any."""
        errors = [self.error_px[name] for name in self.used if name in self.error_px]
        return float(np.sqrt(np.mean(np.square(errors)))) if errors else float("nan")


def clicked_landmarks(cameras: Cameras, clicks: Iterable[Click]) -> FloatArray:
    """Landmarks (9, 3) of a frame, world, as its clicks place them; NaN where they do not."""
    found = predicted_points(cameras, clicks)
    unknown = np.full(3, np.nan)
    return np.array([found[n].world if n in found else unknown for n in LANDMARKS])


def predicted_points(
    cameras: Cameras, clicks: Iterable[Click], *, sigma: Sigmas = USUAL_SIGMA
) -> dict[str, PredictedPoint]:
    """Points of all landmarks of a frame that its clicks place; see :func:`predicted_point`."""
    named: dict[str, list[Click]] = {}
    for click in clicks:
        named.setdefault(click.landmark, []).append(click)
    points = {name: predicted_point(cameras, own, sigma=sigma) for name, own in named.items()}
    return {name: point for name, point in points.items() if point is not None}


def predicted_point(
    cameras: Cameras, clicks: Iterable[Click], *, sigma: Sigmas = USUAL_SIGMA
) -> PredictedPoint | None:
    """The point of one landmark at one frame, and how far every click is from what others say.

    None with clicks in fewer than two places, or where their rays do not meet in front of the
    cameras.
    """
    placed = (one for one in clicks if not one.deleted and one.position is not None)
    there = {one.camera: one for one in placed if one.camera in cameras}
    # a person's own tell where the point is; all of them where those are too few
    used = {name: click for name, click in there.items() if not click.accepted}
    used = used if len(used) >= 2 else there
    if len(used) < 2:
        return None
    sightings = Sightings.of(
        [cameras[name] for name in used],
        np.array([_place(click) for click in used.values()]),
        np.array([sigma_of(click, sigma) for click in used.values()]),
    )
    found = point_of_sightings(sightings)
    if found is None:
        return None
    others = {n: _from_others(cameras, there[n], used, sightings, found.world) for n in there}
    own = {name: place for name, place in others.items() if np.isfinite(place).all()}
    pixel, spread = {}, {}
    for name, camera in cameras.items():
        place = own.get(name, camera.project(found.world))
        if in_image(camera, place):
            pixel[name] = place
            jacobian = pixel_jacobian(camera, found.world)
            in_picture = jacobian @ found.covariance @ jacobian.T
            spread[name] = float(np.sqrt(np.linalg.norm(in_picture, 2)))
    return PredictedPoint(
        landmark=next(iter(used.values())).landmark,
        world=found.world,
        covariance=found.covariance,
        used=tuple(used),
        pixel=pixel,
        spread_px=spread,
        error_px={
            name: float(np.linalg.norm(_place(there[name]) - place)) for name, place in own.items()
        },
        outliers=tuple(name for name, out in zip(used, found.outlier, strict=True) if out),
    )


def _from_others(
    cameras: Cameras, click: Click, used: Mapping[str, Click], seen: Sightings, world: FloatArray
) -> FloatArray:
    """Where the clicks of the other cameras put a clicked landmark in its image (2,), or NaN."""
    camera = cameras[click.camera]
    if click.camera not in used:
        return camera.project(world)
    names = list(used)
    own = names.index(click.camera)
    others = seen.without(own)
    if len(names) > 2:
        found = point_of_sightings(others)
        return np.full(2, np.nan) if found is None else camera.project(found.world)
    (origin,), (direction,) = others.rays
    start = float((world - origin) @ direction)
    return camera.project(nearest_on_ray(camera, _place(click), origin, direction, start))


def _place(click: Click) -> FloatArray:
    return np.array(click.position, dtype=np.float64)


_CAPSULES: tuple[tuple[tuple[str, ...], tuple[str, ...], float], ...] = (
    (("left_hip",), ("left_shoulder",), 0.10),
    (("right_hip",), ("right_shoulder",), 0.10),
    (("left_hip", "right_hip"), ("left_shoulder", "right_shoulder"), 0.12),
    (("left_shoulder", "right_shoulder"), ("head",), 0.07),
    (("left_shoulder",), ("left_elbow",), 0.045),
    (("right_shoulder",), ("right_elbow",), 0.045),
    (("left_elbow",), ("left_hand",), 0.035),
    (("right_elbow",), ("right_hand",), 0.035),
)
"""Ends (middles of landmarks) and radius in metres."""

_AGAINST = 1.5  # radii before a landmark in which nothing hides it


def hidden_landmarks(
    nine: FloatArray, names: Sequence[str], points: FloatArray, places: FloatArray
) -> BoolArray:
    """Whether (F, C, n) the body stands between cameras and landmarks; False where not known.

    The body is that of `nine` (F, 9, 3); asked for are n `names` at `points` (F, n, 3), from
    optical centres at `places` (C, 3), world.
    """
    sight_from = np.broadcast_to(places[None, :, None], (len(nine), len(places), len(names), 3))
    sight_to = np.broadcast_to(points[:, None], sight_from.shape)
    towards = sight_from - sight_to
    towards = towards / np.linalg.norm(towards, axis=-1, keepdims=True)
    hidden: BoolArray = np.zeros(sight_from.shape[:-1], dtype=np.bool_)
    for one, two, radius in _CAPSULES:
        places_of = ([LANDMARKS.index(name) for name in end] for end in (one, two))
        ends = [np.mean([nine[:, k] for k in own], axis=0)[:, None, None] for own in places_of]
        # What lies against a capsule is not behind it.
        apart = segment_distance(sight_from, sight_to + _AGAINST * radius * towards, *ends)
        own = np.array([name in (*one, *two) for name in names])
        hidden |= (apart < radius) & ~own
    return hidden


def projected_landmarks(
    frames: Sequence[int],
    names: Sequence[str],
    points: FloatArray,
    covariance: FloatArray,
    cameras: Cameras,
    source: str,
) -> Iterator[Prediction]:
    """Points (F, n, 3) with covariances (F, n, 3, 3) in all images that show them.

    Where all nine landmarks are among them, those that the body hides are guessed.
    """
    hidden = np.zeros((len(points), len(cameras), len(names)), dtype=np.bool_)
    if set(LANDMARKS) <= set(names) and cameras:
        nine = points[:, [names.index(name) for name in LANDMARKS]]
        origins = np.array([camera.position_world for camera in cameras.values()])
        hidden = hidden_landmarks(nine, names, points, origins)
    for view, (name, camera) in enumerate(cameras.items()):
        pixels = camera.project(points)
        jacobian = pixel_jacobian(camera, points)
        spread = jacobian @ covariance @ np.swapaxes(jacobian, -1, -2)
        sigma = np.sqrt(0.5 * np.trace(spread, axis1=-2, axis2=-1))
        for row, place in np.argwhere(in_image(camera, pixels)):
            x, y = pixels[row, place].tolist()
            own = float(sigma[row, place])
            seen = Visibility.GUESSED if hidden[row, view, place] else Visibility.SEEN
            sure = own if own > 0 else None
            yield Prediction(frames[row], name, names[place], source, (x, y), sure, seen)

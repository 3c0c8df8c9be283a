"""Notice clicks of left and right that were mixed up, from the other views.

Two clicks of one landmark in two images lie on each other's epipolar lines. Of all ways to exchange
left and right in some of the views, the one with the least distances is looked for; where it is
clearly better than the clicks as they are, the views that have to change are told.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, product

import numpy as np

from stereotrack_core.annotation.click import Click
from stereotrack_core.arrays import FloatArray
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.rotation import skew

MOST_VIEWS = 8
"""Of more views the first ones are looked at; exchanges grow as their power of two."""

LEAST_GAIN = 8.0
"""Log likelihood that an exchange has to gain."""

_GROSS = 12.0
"""Distances of more than so many sigma count as this: one gross mistake shall not decide."""

_TOO_NEAR = 1e-6  # metres between two optical centres below which there are no epipolar lines


@dataclass(frozen=True)
class Swap:
    """Two landmarks that were mixed up in some images of one frame.

    Attributes
    ----------
    first, second : the landmarks
    cameras : where they should be exchanged
    certain : False where to exchange them in all the other views instead fits as well and needs no
        more exchanges: somebody has to look which
    distance, distance_after : root mean square distance to the epipolar lines in pixels, as they
        are and after the exchange
    """

    frame: int
    first: str
    second: str
    cameras: tuple[str, ...]
    certain: bool
    distance: float
    distance_after: float


def epipolar_distance(
    camera: Camera, pixels: FloatArray, other: Camera, other_pixels: FloatArray
) -> FloatArray:
    """Distance (...) in pixels of points (..., 2) in one image from epipolar lines of those in
    another.

    Measured on the undistorted image, at its focal length; the mean over both images. NaN where a
    point is NaN or the cameras are in one place.
    """
    one = _homogeneous(camera.normalised(pixels))
    two = _homogeneous(other.normalised(other_pixels))
    two_from_one = other.camera_from_world @ camera.world_from_camera
    shift = two_from_one.translation
    if np.linalg.norm(shift) < _TOO_NEAR:
        return np.full(np.broadcast_shapes(one.shape, two.shape)[:-1], np.nan)
    essential = skew(shift / np.linalg.norm(shift)) @ two_from_one.rotation
    line_in_two, line_in_one = one @ essential.T, two @ essential
    product_ = np.abs(np.sum(two * line_in_two, axis=-1))
    with np.errstate(divide="ignore", invalid="ignore"):
        in_two = product_ / np.linalg.norm(line_in_two[..., :2], axis=-1) * other.focal
        in_one = product_ / np.linalg.norm(line_in_one[..., :2], axis=-1) * camera.focal
    result: FloatArray = 0.5 * (in_one + in_two)
    return result


def find_swaps(
    clicks: Iterable[Click],
    cameras: Mapping[str, Camera],
    pairs: Sequence[tuple[str, str]],
    *,
    sigma: float = 2.0,
) -> tuple[Swap, ...]:
    """Pairs of landmarks that were mixed up, by frame.

    `pairs` sequence of (str, str), landmarks that may be mixed up, as :meth:`LandmarkSet.pairs`
    gives them. `sigma`: standard deviation of a click in pixels per axis.

    Notes
    -----
    The distance of two good clicks has the variance 2 sigma^2 (both are noisy), so exchanging
    gains the log likelihood (S - S') / (4 sigma^2), with the sums S of squared distances before and
    after. An exchange is told where that is at least :data:`LEAST_GAIN` and S is halved. Where two
    landmarks lie in one epipolar plane (one behind the other, or at the same height in a horizontal
    stereo pair) they cannot be told apart this way, and nothing is.
    """
    at_frame: dict[int, dict[str, dict[str, tuple[float, float]]]] = {}
    for click in clicks:
        if click.position is not None and not click.deleted and click.camera in cameras:
            views = at_frame.setdefault(click.frame, {})
            views.setdefault(click.camera, {})[click.landmark] = click.position
    return tuple(
        swap
        for frame in sorted(at_frame)
        for pair in pairs
        if (swap := _swap(frame, pair, at_frame[frame], cameras, sigma)) is not None
    )


def _swap(
    frame: int,
    pair: tuple[str, str],
    positions: Mapping[str, Mapping[str, tuple[float, float]]],
    cameras: Mapping[str, Camera],
    sigma: float,
) -> Swap | None:
    views = [name for name, places in positions.items() if pair[0] in places or pair[1] in places]
    views = sorted(views, key=lambda name: -sum(one in positions[name] for one in pair))
    views = views[:MOST_VIEWS]
    missing = (np.nan, np.nan)
    points = {name: np.array([positions[name].get(one, missing) for one in pair]) for name in views}
    costs, terms = _costs(points, cameras, _GROSS * sigma)
    if not terms:
        return None

    def squares(exchanged: Sequence[bool]) -> float:
        return sum(own[exchanged[i] != exchanged[j]] for (i, j), own in costs.items())

    as_they_are = (False,) * len(views)
    others = [(False, *rest) for rest in product((False, True), repeat=len(views) - 1)]
    best = min(others, key=squares)
    gain = (squares(as_they_are) - squares(best)) / (2.0 * sigma) ** 2
    now, after = (math.sqrt(squares(one) / terms) for one in (as_they_are, best))
    if gain < LEAST_GAIN or after > now / math.sqrt(2.0):
        return None
    exchanged = [name for name, changes in zip(views, best, strict=True) if changes]
    kept = [name for name in views if name not in exchanged]
    fewer = min(exchanged, kept, key=len)
    return Swap(frame, *pair, tuple(sorted(fewer)), len(exchanged) != len(kept), now, after)


def _costs(
    points: Mapping[str, FloatArray], cameras: Mapping[str, Camera], largest: float
) -> tuple[dict[tuple[int, int], tuple[float, float]], int]:
    """Squared distances between two views each with a pair as it is and exchanged, square pixels.

    Also the number of distances; none where there is nothing to compare: two views, one of them
    with both landmarks.
    """
    costs, terms = {}, 0
    for (i, one), (j, two) in combinations(enumerate(points), 2):
        if np.isnan(points[one]).any() and np.isnan(points[two]).any():
            continue  # one click each: to exchange them would leave nothing to compare
        distances = epipolar_distance(
            *(cameras[one], points[one][:, None]), *(cameras[two], points[two][None])
        )
        both_ways = np.stack([distances.diagonal(), distances[::-1].diagonal()])
        squared = np.minimum(both_ways, largest) ** 2
        if np.isfinite(squared).any(axis=1).all():
            straight, crossed = np.nansum(squared, axis=1)
            costs[i, j] = float(straight), float(crossed)
            terms += int(np.isfinite(squared[0]).sum())
    return costs, terms


def _homogeneous(points: FloatArray) -> FloatArray:
    return np.concatenate([points, np.ones_like(points[..., :1])], axis=-1)

"""Predictions for places that nobody has clicked: from a fit, a run, neighbours, or following.

A source is the word under which the predictions are kept (:mod:`project.predictions`). None of them
is a click before a person says so, and none is made where a person has said anything already, be it
that there is nothing.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import pairwise

import numpy as np

from stereotrack_core.annotation.click import USUAL_SIGMA, Click, ClickKey, Prediction, sigma_of
from stereotrack_core.annotation.epipolar import in_image
from stereotrack_core.annotation.fit.results import GAP, TrajectoryFit
from stereotrack_core.annotation.follow import FollowedClick
from stereotrack_core.annotation.landmark_set import NINE, LandmarkSet
from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.geometry.camera import Camera, pixel_jacobian
from stereotrack_core.tracking.frame import Run

FIT, NEIGHBOURS, FOLLOWING = "fit", "neighbours", "following"

_LIMB_LENGTH = 0.3  # metres by which the end of a limb moves when it turns by one radian
_BENT = 0.15
"""How far from the straight line between two clicks a landmark is half way, as a share of it."""

_CONTRADICTION = 4.0  # standard deviations by which following from both sides may differ


def from_fit(
    fit: TrajectoryFit, cameras: Mapping[str, Camera], frames: range | None = None
) -> Iterator[Prediction]:
    """Landmarks of a fit in every image; between clicked frames they are filled in joint space."""
    known = (fit.kind != GAP) & _within(fit.frame, frames)
    yield from _projected(
        fit.frame[known].tolist(),
        fit.names,
        fit.landmarks[known],
        fit.covariance[known],
        cameras,
        FIT,
    )


def from_run(
    run: Run,
    name: str,
    cameras: Mapping[str, Camera],
    landmark_set: LandmarkSet = NINE,
    frames: range | None = None,
) -> Iterator[Prediction]:
    """The landmarks of a set that a tracker found in every image; the source is ``run NAME``."""
    known = run.tracked & _within(run.frame, frames)
    names = [name for name in landmark_set.names if name in run.landmark_names]
    places = [run.landmark_names.index(one) for one in names]
    limbs = [LIMBS.index(landmark_set[one].limb) for one in names]
    spread = _LIMB_LENGTH * np.radians(run.limb_sigma_deg[known][:, limbs])
    covariance = np.square(spread)[..., None, None] * np.eye(3)
    numbers, points = run.frame[known].tolist(), run.landmarks[known][:, places]
    yield from _projected(numbers, names, points, covariance, cameras, source_of_run(name))


def source_of_run(name: str) -> str:
    """The source of predictions from a run of the project."""
    return f"run {name}"


def from_neighbours(
    clicks: Iterable[Click],
    *,
    gaps: Sequence[range] = (),
    longest: int = 30,
    sigma: Mapping[str, float] | float = USUAL_SIGMA,
) -> Iterator[Prediction]:
    """Straight from one click of a landmark in an image to its next one there.

    Deleted clicks and those outside the image end a stretch without a prediction over it, as do
    gaps, and more frames between two clicks than `longest`. `sigma` is the usual standard deviation
    of a click in pixels per axis.
    """
    rows: dict[tuple[str, str], list[Click]] = defaultdict(list)
    for click in clicks:
        if not click.deleted:
            rows[click.camera, click.landmark].append(click)
    for row in rows.values():
        row.sort(key=lambda click: click.frame)
        for one, two in pairwise(row):
            between = range(one.frame + 1, two.frame)
            broken = any(gap.start < two.frame and gap.stop > between.start for gap in gaps)
            if one.position and two.position and len(between) <= longest and not broken:
                yield from _straight(one, two, between, sigma)


def from_following(
    found: Iterable[FollowedClick], *, sigma: Mapping[str, float] | float = USUAL_SIGMA
) -> Iterator[Prediction]:
    """Where patches were followed to, as far as that is reliable.

    What was followed to one place from both sides is averaged by its certainty; where the two
    contradict each other, neither is taken.
    """
    places: dict[ClickKey, list[tuple[FloatArray, float]]] = defaultdict(list)
    for one in found:
        own = sigma_of(one.click, sigma)
        for i in range(1, one.followed.reliable_until):
            key = ClickKey(int(one.frame[i]), one.click.camera, one.click.landmark)
            spread = float(np.hypot(own, one.followed.sigma_px[i]))
            places[key].append((one.followed.pixels[i], spread))
    for key, several in places.items():
        pixels = np.array([pixel for pixel, _ in several])
        weights = np.array([spread for _, spread in several]) ** -2.0
        mean = weights @ pixels / weights.sum()
        apart = np.linalg.norm(pixels - mean, axis=1) * np.sqrt(weights)
        if apart.max() <= _CONTRADICTION:
            position = (float(mean[0]), float(mean[1]))
            yield Prediction(*key, FOLLOWING, position, float(weights.sum() ** -0.5))


def _within(frame: IntArray, frames: range | None) -> BoolArray:
    if frames is None:
        return np.ones(len(frame), dtype=np.bool_)
    return (frame >= frames.start) & (frame < frames.stop)


def _projected(
    frames: Sequence[int],
    names: Sequence[str],
    points: FloatArray,
    covariance: FloatArray,
    cameras: Mapping[str, Camera],
    source: str,
) -> Iterator[Prediction]:
    """Points (F, n, 3) with covariances (F, n, 3, 3) in all images that show them."""
    for name, camera in cameras.items():
        pixels = camera.project(points)
        jacobian = pixel_jacobian(camera, points)
        spread = jacobian @ covariance @ np.swapaxes(jacobian, -1, -2)
        sigma = np.sqrt(0.5 * np.trace(spread, axis1=-2, axis2=-1))
        for row, place in np.argwhere(in_image(camera, pixels)):
            x, y = pixels[row, place].tolist()
            own = float(sigma[row, place])
            yield Prediction(
                frames[row], name, names[place], source, (x, y), own if own > 0 else None
            )


def _straight(
    one: Click, two: Click, between: range, sigma: Mapping[str, float] | float
) -> Iterator[Prediction]:
    start, end = np.array(one.position), np.array(two.position)
    sides = sigma_of(one, sigma), sigma_of(two, sigma)
    for frame in between:
        share = (frame - one.frame) / (two.frame - one.frame)
        x, y = ((1.0 - share) * start + share * end).tolist()
        bent = _BENT * float(np.linalg.norm(end - start)) * 4.0 * share * (1.0 - share)
        spread = np.hypot((1.0 - share) * sides[0] + share * sides[1], bent)
        yield Prediction(frame, one.camera, one.landmark, NEIGHBOURS, (x, y), float(spread))

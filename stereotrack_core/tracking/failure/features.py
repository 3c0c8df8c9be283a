"""Features by which each limb of a pose is judged, and the probability that it fails.

None needs a reference.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from time import perf_counter
from typing import Any

import numpy as np
import scipy

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.model import BodyModel, placed_cones
from stereotrack_core.body.pose import PartFrames, Pose
from stereotrack_core.body.skeleton import FOREARMS, LIMB_OF_PART, TORSO, UPPER_ARMS
from stereotrack_core.body.surface import nearest_on_surface
from stereotrack_core.compiled import compiled
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.tracking.arm_search.picture import (
    COLUMNS,
    SeenPicture,
    cone_images,
    near_at,
    outline_table,
    reached,
    seen_pictures,
)
from stereotrack_core.tracking.estimate import (
    OVERCONFIDENCE,
    Correspondences,
    Estimate,
    Prior,
    limb_sigma_deg,
)
from stereotrack_core.tracking.failure.alternatives import elsewhere
from stereotrack_core.tracking.failure.coefficients import CONSTANTS, SLOPES
from stereotrack_core.tracking.residuals.surface import unexplained_fraction_of
from stereotrack_core.tracking.state import Setup

FEATURES: tuple[str, ...] = (
    *("through", "behind", "before", "unknown", "worst", "visible", "agreed", "needed"),
    *("neighbour", "unexplained", "sigma", "residual", "data", "jump", "unexplained fraction"),
    *("buried", "crossed", "better", "ambiguous"),
)
"""Names of the columns of :func:`limb_features`; coefficients are found by them."""

LOST_DEG = 45.0
"""Error of a limb's direction beyond which it fails."""

THROUGH, BEHIND, BEFORE, UNKNOWN, AGREED, NEEDED, VISIBLE = LOOKS = range(7)
"""Columns of the looks: pixels beside the person, with a range behind or before the body's,
without a range, with the body's range, with one that no other limb would have there, and all that
are in sight."""


_LITTLE = 0.05
"""Share of a limb's area that is added before logarithms are taken."""

_SEEN = 0.4
"""Share of a limb's own area, mean over views, in which its surface has been seen for certain."""

_CLEARLY_WORSE = 0.1
"""Share of its area by which every other place of a limb explains less than where it is."""

_STEP = 3
_SQUARED_SIGMA = 0.8**2
_LEAST_SEEN = 12.0
"""Pixels of a limb, thinned out, from which one view alone can call it wrong."""

_ALONG = np.linspace(0.25, 1.0, 4)


def judged(
    found: Estimate, cloud: Cloud, setup: Setup, sigma_points: Pose, movement: FloatArray
) -> Estimate:
    """The estimate with the features by which it can be judged, and what they say.

    Parameters
    ----------
    sigma_points : Pose
        Stacked (2n + 1), of the posterior.
    movement : (n,) float64
        Of the error state since the frame before.
    """
    begun, body = perf_counter(), setup.body
    sigma = limb_sigma_deg(body.frames(sigma_points), setup.weights.covariance)
    share = unexplained_fraction_of(cloud.points, body, body.frames(found.pose))
    found = dataclasses.replace(found, unexplained_fraction=share)
    jump = unexpected(movement, found.prior, setup.joints)
    features = limb_features(cloud, body, found, sigma, jump)
    return dataclasses.replace(
        found,
        limb_sigma_deg=OVERCONFIDENCE * sigma,
        limb_lost=failure_probability(features, views_of_somebody(cloud)),
        limb_features=features,
        seconds={**found.seconds, "judge": perf_counter() - begun},
    )


def with_neighbours(features: FloatArray) -> FloatArray:
    """Features (..., 6, 2 S) of each limb beside those of the other half of its arm."""
    return np.concatenate([features, features[..., list(NEIGHBOUR), :]], axis=-1)


def views_of_somebody(cloud: Cloud) -> str:
    """Whose coefficients hold: those of ``one`` view that sees the person, or of ``several``."""
    return "one" if len(seen_pictures(cloud, _STEP)) == 1 else "several"


def failure_probability(features: FloatArray | None, views: str) -> FloatArray:
    """Probability (6,) that each limb fails: more than 45 deg off; NaN where not known.

    A logistic regression of the features (6, S), one for the upper arms and one for the forearms,
    fitted on simulated recordings alone by ``tools/fit_lost_limbs.py``. Torso and head have none:
    they failed too rarely to learn from. An upper arm that no view shows is suspicious if several
    look; from one view it may be hidden behind its own forearm. So one view has coefficients of its
    own. No probability exceeds the :func:`bound` that the cloud sets.

    Parameters
    ----------
    views : ``one`` or ``several``
        See :func:`views_of_somebody`.
    """
    if features is None:
        return np.full(len(LIMBS), np.nan)
    slopes = np.array([SLOPES[views][name] for name in FEATURES]).reshape(len(FEATURES), 2, 2)
    free = probability_by(features, CONSTANTS[views], slopes.T.reshape(2, -1))
    return np.minimum(free, bound(features))


def probability_by(
    features: FloatArray, constants: Sequence[float], slopes: FloatArray
) -> FloatArray:
    """Probability (..., 6) by constant and slopes (2 S,) each of upper arms and of forearms."""
    every = with_neighbours(features)
    result = np.full(features.shape[:-1], np.nan)
    for limbs, constant, own in zip((UPPER_ARMS, FOREARMS), constants, slopes, strict=True):
        result[..., list(limbs)] = scipy.special.expit(constant + every[..., list(limbs), :] @ own)
    return result


def bound(features: FloatArray) -> FloatArray:
    """What the failure probabilities (..., 6) can be at most, as far as the cloud shows the limbs.

    One half where the cloud has the limb's surface over enough of its area, no other limb would be
    there, and no other place of the arm explains the pictures as well: of such limbs 1 in 100 was
    lost in simulated recordings. 1 where there is less than half of that surface.
    """
    needed = np.exp(features[..., FEATURES.index("needed")]) - _LITTLE
    worse = -features[..., FEATURES.index("better")]
    half = _SEEN / 2.0
    seen = np.clip((needed - half) / half, 0.0, 1.0) * np.clip(worse / _CLEARLY_WORSE, 0.0, 1.0)
    result: FloatArray = 1.0 - 0.5 * seen
    return result


def limb_features(
    cloud: Cloud, body: BodyModel, found: Estimate, sigma_deg: FloatArray, jump: FloatArray
) -> FloatArray | None:
    """Features (6, len(FEATURES)) of the limbs; None where no view has a picture of somebody.

    Of a limb's pixels in sight of all views: the shares that lie beside the person
    (``through``), where the range is behind or before the limb's, and where there is none; the
    share through or behind of the view that contradicts most (``worst``); logarithms of the areas
    in sight, in agreement, and in agreement where no other limb would be (``needed``), over the
    limb's own; the share through or behind of the neighbouring limb. Then the unexplained area in
    the limb's reach over its own (square root), the logarithm of the posterior's standard
    deviation, the root mean square distance of the limb's data in centimetres, the logarithm of
    their number over what its area should have, the logarithm of the jump, the frame's unexplained
    fraction, and how deep its axis lies in the torso and how near to the other arm, in decimetres;
    and how good it would be elsewhere, see :func:`elsewhere`.

    Parameters
    ----------
    found : Estimate
        With its unexplained fraction and correspondences.
    sigma_deg : (6,) float64
        Of the limbs' directions.
    jump : (6,) float64
        See :func:`unexpected`.
    """
    pictures = seen_pictures(cloud, _STEP)
    if not pictures or found.correspondences is None:
        return None
    frames, own = body.frames(found.pose), _own_areas(body)
    looks, unexplained = _looks(body, frames, pictures)
    limbs = looks[:, : len(LIMBS)]
    areas = np.array([seen.area(frames.origins[TORSO]) for seen in pictures])
    seen = np.maximum(limbs[..., VISIBLE], 1e-9)
    against = (limbs[..., THROUGH] + limbs[..., BEHIND]) / seen
    total = np.einsum("v,vlk->lk", areas, limbs)
    share = total / np.maximum(total[:, VISIBLE : VISIBLE + 1], 1e-9)
    wrong = share[:, THROUGH] + share[:, BEHIND]
    enough = limbs[..., VISIBLE] >= _LEAST_SEEN
    views = len(pictures)
    residual, data = _of_data(found.correspondences, own)
    better, ambiguous = elsewhere(cloud, body, found.pose, own).T
    columns = {
        "through": share[:, THROUGH],
        "behind": share[:, BEHIND],
        "before": share[:, BEFORE],
        "unknown": share[:, UNKNOWN],
        "worst": np.max(np.where(enough, against, 0.0), axis=0),
        "visible": np.log(total[:, VISIBLE] / views / own + _LITTLE),
        "agreed": np.log(total[:, AGREED] / views / own + _LITTLE),
        "needed": np.log(total[:, NEEDED] / views / own + _LITTLE),
        "neighbour": wrong[list(NEIGHBOUR)],
        "unexplained": np.sqrt(areas @ unexplained / views / own),
        "sigma": np.log(np.clip(np.nan_to_num(sigma_deg, nan=20.0), 0.1, 90.0)),
        "residual": residual,
        "data": data,
        "jump": np.log1p(np.minimum(jump, 100.0)),
        "unexplained fraction": np.full(len(LIMBS), min(found.unexplained_fraction, 1.0)),
        "buried": _buried(body, frames),
        "crossed": _crossed(body, frames),
        "better": better,
        "ambiguous": ambiguous,
    }
    return np.column_stack([columns[name] for name in FEATURES])


def unexpected(movement: FloatArray, prior: Prior | None, joints: tuple[int, ...]) -> FloatArray:
    """Movement (6,) of each limb over the standard deviation that was expected of it.

    `movement` (n,) is that of the error state since the frame before; 0 without a prior.
    """
    result = np.zeros(len(LIMBS))
    if prior is None:
        return result
    squared = movement**2 / np.diagonal(prior.P)
    result[TORSO] = np.sqrt(squared[3:6].mean())
    for joint, value in zip(joints, squared[6:].reshape(-1, 2).mean(axis=1), strict=True):
        if joint < len(LIMBS):
            result[joint] = np.sqrt(value)
    return result


NEIGHBOUR = (0, 0, 4, 5, 2, 3)
"""The limb whose place says something about each limb's own."""


def _own_areas(body: BodyModel) -> FloatArray:
    """Areas (6,) of the limbs, seen from the side, in square metres."""
    cones = body.cones
    area = (cones.r1 + cones.r2) * cones.height
    sums = np.bincount(LIMB_OF_PART[cones.part], area, len(LIMBS) + 1)[:-1]
    return np.maximum(sums.astype(np.float64), 1e-3)


def _looks(
    body: BodyModel, frames: PartFrames, pictures: tuple[SeenPicture, ...]
) -> tuple[FloatArray, FloatArray]:
    """Looks (V, 7, 7) of limbs and legs, unexplained pixels (V, 6) of limbs, in all views."""
    table, limb = outline_table(body.cones, frames), LIMB_OF_PART[body.cones.part]
    images = np.empty((len(table), COLUMNS))
    looks = np.zeros((len(pictures), len(LIMBS) + 1, len(LOOKS)))
    unexplained = np.zeros((len(pictures), len(LIMBS)))
    lengths = body.skeleton.lengths
    reach = 1.2 * lengths[: len(LIMBS)]
    reach[list(UPPER_ARMS)] += lengths[list(FOREARMS)]
    for v, seen in enumerate(pictures):
        picture = np.zeros(seen.measured.shape, dtype=np.float32)
        other, owner = np.zeros_like(picture), np.full(picture.shape, -1, dtype=np.int8)
        cone_images(table, seen.camera_from_world, seen.pinhole, seen.eye, images)
        _draw_owned(images, limb, seen.left, seen.top, seen.step, picture, owner, other)
        _look(
            picture, owner, other, seen.measured, seen.person, seen.scale, _SQUARED_SIGMA, looks[v]
        )
        to_camera = seen.camera_from_world
        joints = frames.origins[: len(LIMBS)] @ to_camera[:, :3].T + to_camera[:, 3]
        box = np.array([seen.left, seen.top, seen.step])
        _unexplained_near(
            picture, seen.measured, seen.person, seen.scale, box, seen.pinhole, joints, reach,
            unexplained[v],
        )  # fmt: skip
    return looks, unexplained


def _of_data(pairs: Correspondences, own: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Root mean square distance in centimetres and logarithm of the relative number of data."""
    distance = np.linalg.norm(pairs.data[:, :3] - pairs.model, axis=1)
    limb, groups = LIMB_OF_PART[pairs.part], len(LIMBS) + 1
    squared = np.bincount(limb, pairs.weight * distance**2, groups)[:-1]
    weight = np.bincount(limb, pairs.weight, groups)[:-1]
    residual = 100.0 * np.sqrt(squared / np.maximum(weight, 1e-9))
    number = np.bincount(limb, minlength=groups)[:-1]
    density = number / own / max(1.0, number.sum() / own.sum())
    return np.where(weight > 0.0, residual, 0.0), np.log(density + 0.05)


def _axes(body: BodyModel, frames: PartFrames) -> FloatArray:
    """Places (6, 4, 3), world, along the limbs' axes."""
    n = len(LIMBS)
    along = body.skeleton.lengths[:n, None] * _ALONG
    steps = along[..., None] * frames.rotations[:n, None, :, 2]
    return frames.origins[:n, None] + steps


def _buried(body: BodyModel, frames: PartFrames) -> FloatArray:
    """How deep (6,) the arms' axes lie in the torso at most, decimetres; 0 for the others."""
    torso = placed_cones(body, frames)[LIMB_OF_PART[body.cones.part] == TORSO]
    axes = _axes(body, frames)
    off = nearest_on_surface(axes.reshape(-1, 3), torso, np.inf).distance.reshape(len(LIMBS), -1)
    # an upper arm begins at the torso
    deep = np.where(np.isfinite(off), np.clip(-off, 0.0, 0.2), 0.0)[:, 1:].mean(axis=1)
    deep[:2] = 0.0
    result: FloatArray = 10.0 * deep
    return result


def _crossed(body: BodyModel, frames: PartFrames) -> FloatArray:
    """How much nearer (6,) than 2 dm an arm's axis comes to the other forearm; decimetres."""
    axes = _axes(body, frames)
    result = np.zeros(len(LIMBS))
    for side in (0, 1):
        other = axes[FOREARMS[1 - side]]
        for limb in (UPPER_ARMS[side], FOREARMS[side]):
            apart = np.linalg.norm(axes[limb][:, None] - other[None], axis=-1).min()
            result[limb] = max(0.0, 2.0 - 10.0 * float(apart))
    return result


@compiled()
def _draw_owned(
    images: Any,
    part: Any,
    left: float,
    top: float,
    step: float,
    picture: Any,
    owner: Any,
    other: Any,
) -> None:
    """Draw cones as cones, note the part that is in front, -1 is none, and the next other one."""
    for c in range(images.shape[0]):
        im = images[c]
        if im[10] < 0.5:
            continue
        i0, i1, j0, j1 = reached(im, left, top, step, picture.shape[0], picture.shape[1])
        for i in range(i0, i1 + 1):
            for j in range(j0, j1 + 1):
                near = near_at(im, left + step * j, top + step * i)
                if near > picture[i, j]:
                    if owner[i, j] != part[c]:
                        other[i, j] = picture[i, j]
                    picture[i, j] = near
                    owner[i, j] = part[c]
                elif owner[i, j] != part[c] and near > other[i, j]:
                    other[i, j] = near


@compiled()
def _look(
    picture: Any,
    owner: Any,
    other: Any,
    measured: Any,
    person: Any,
    scale: float,
    squared_sigma: float,
    looks: Any,
) -> None:
    """Add the pixels of one view to the looks (P, 7) of the parts in front."""
    for i in range(picture.shape[0]):
        for j in range(picture.shape[1]):
            p = owner[i, j]
            if p < 0:
                continue
            looks[p, VISIBLE] += 1.0
            if person[i, j] == 0:
                looks[p, THROUGH] += 1.0
            elif measured[i, j] > 0.0:
                e = scale * (picture[i, j] - measured[i, j])
                off = e * e / (e * e + squared_sigma)
                looks[p, AGREED] += 1.0 - off
                e_other = scale * (other[i, j] - measured[i, j])
                unlike = e_other * e_other / (e_other * e_other + squared_sigma)
                looks[p, NEEDED] += (1.0 - off) * (unlike if other[i, j] > 0.0 else 1.0)
                looks[p, BEHIND if e > 0.0 else BEFORE] += off
            else:
                looks[p, UNKNOWN] += 1.0


@compiled()
def _unexplained_near(
    picture: Any,
    measured: Any,
    person: Any,
    scale: float,
    box: Any,
    pinhole: Any,
    joints: Any,
    reach: Any,
    found: Any,
) -> None:
    """Count for each joint the pixels of the person in its reach that the body does not explain.

    A pixel is not explained where the body is not, or clearly behind what was measured.

    `box` is left, top and step of the picture; `joints` (J, 3) are in the camera's frame.
    """
    for i in range(picture.shape[0]):
        for j in range(picture.shape[1]):
            model, seen = picture[i, j], measured[i, j]
            if person[i, j] == 0 or (model > 0.0 and not scale * (seen - model) > 2.0):
                continue
            x = (box[0] + box[2] * j - pinhole[1]) / pinhole[0]
            y = (box[1] + box[2] * i - pinhole[2]) / pinhole[0]
            for k in range(joints.shape[0]):
                z = 1.0 / seen if seen > 0.0 else joints[k, 2]
                dx, dy, dz = x * z - joints[k, 0], y * z - joints[k, 1], z - joints[k, 2]
                if dx * dx + dy * dy + dz * dz < reach[k] * reach[k]:
                    found[k] += 1.0

"""Signs by which each limb of a pose is judged; none needs truth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.model import BodyModel, placed_cones
from stereotrack_core.body.pose import PartFrames, Pose
from stereotrack_core.body.skeleton import FOREARMS, LIMB_OF_PART, TORSO, UPPER_ARMS
from stereotrack_core.body.surface import nearest_on_surface
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.tracking.arm_search.picture import SeenPicture, outline_table, seen_pictures
from stereotrack_core.tracking.arm_search.picture_kernels import COLUMNS, cone_images
from stereotrack_core.tracking.estimate import Correspondences, Prior
from stereotrack_core.tracking.failure.alternatives import elsewhere
from stereotrack_core.tracking.failure.kernels import (
    AGREED,
    BEFORE,
    BEHIND,
    THROUGH,
    UNKNOWN,
    VISIBLE,
    draw_owned,
    look,
    unexplained_near,
)

FEATURES: tuple[str, ...] = (
    "through",
    "behind",
    "before",
    "unknown",
    "worst",
    "visible",
    "agreed",
    "neighbour",
    "unexplained",
    "sigma",
    "residual",
    "data",
    "jump",
    "unexplained fraction",
    "buried",
    "crossed",
    "better",
    "ambiguous",
)
"""What is known of a limb, in the order of the coefficients; see :func:`limb_features`."""

_STEP = 3
_SQUARED_SIGMA = 0.8**2
_LEAST_SEEN = 12.0
"""Pixels of a limb, thinned out, from which one view alone can call it wrong."""

_ALONG = np.linspace(0.25, 1.0, 4)


@dataclass(frozen=True, eq=False)
class Judged:
    """What a tracker says about its pose, as far as limbs are judged by it.

    Attributes
    ----------
    pose : Pose
    frames : PartFrames
        Of this pose.
    sigma_deg : (6,) float64
        Of the limbs' directions.
    unexplained_fraction : float
    correspondences : Correspondences
    jump : (6,) float64
        Movement of each limb that was not expected, over its standard deviation.
    """

    pose: Pose
    frames: PartFrames
    sigma_deg: FloatArray
    unexplained_fraction: float
    correspondences: Correspondences
    jump: FloatArray


def limb_features(cloud: Cloud, body: BodyModel, judged: Judged) -> FloatArray | None:
    """Signs (6, len(FEATURES)) of the limbs; None where no view has a picture of somebody.

    Of a limb's pixels in sight of all views: the shares that lie beside the person
    (``through``), where the range is behind or before the limb's, and where there is none; the
    share through or behind of the view that contradicts most (``worst``); logarithms of the areas
    in sight and in agreement over the limb's own; the share through or behind of the neighbouring
    limb. Then the unexplained area in the limb's reach over its own (square root), the logarithm
    of the posterior's standard deviation, the root mean square distance of the limb's data in
    centimetres, the logarithm of their number over what its area should have, the logarithm of
    the jump, the frame's unexplained fraction, and how deep its axis lies in the torso and how
    near to the other arm, in decimetres; and how good it would be elsewhere, see
    :func:`elsewhere`.
    """
    pictures = seen_pictures(cloud, _STEP)
    if not pictures:
        return None
    frames, own = judged.frames, _own_areas(body)
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
    columns = (
        share[:, THROUGH],
        share[:, BEHIND],
        share[:, BEFORE],
        share[:, UNKNOWN],
        np.max(np.where(enough, against, 0.0), axis=0),
        np.log(total[:, VISIBLE] / views / own + 0.05),
        np.log(total[:, AGREED] / views / own + 0.05),
        wrong[list(NEIGHBOUR)],
        np.sqrt(areas @ unexplained / views / own),
        np.log(np.clip(np.nan_to_num(judged.sigma_deg, nan=20.0), 0.1, 90.0)),
        *_of_data(judged.correspondences, own),
        np.log1p(np.minimum(judged.jump, 100.0)),
        np.full(len(LIMBS), min(judged.unexplained_fraction, 1.0)),
        _buried(body, frames),
        _crossed(body, frames),
        *elsewhere(cloud, body, judged.pose, own).T,
    )
    return np.column_stack(columns)


def unexpected(movement: FloatArray, prior: Prior | None, joints: tuple[int, ...]) -> FloatArray:
    """Movement (6,) of each limb that was not expected, over its standard deviation.

    Parameters
    ----------
    movement : (n,) float64
        Of the error state since the frame before.
    prior : Prior or None
        0 is returned where there is none.
    joints : tuple of int
        Parts whose two numbers follow position and rotation in the error state.
    """
    result = np.zeros(len(LIMBS))
    if prior is None:
        return result
    squared = (movement - prior.movement) ** 2 / np.diagonal(prior.P)
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
    result: FloatArray = np.maximum(sums.astype(np.float64), 1e-3)
    return result


def _looks(
    body: BodyModel, frames: PartFrames, pictures: tuple[SeenPicture, ...]
) -> tuple[FloatArray, FloatArray]:
    """Looks (V, 7, 6) of limbs and legs, unexplained pixels (V, 6) of limbs, in all views."""
    table, limb = outline_table(body.cones, frames), LIMB_OF_PART[body.cones.part]
    images = np.empty((len(table), COLUMNS))
    looks = np.zeros((len(pictures), len(LIMBS) + 1, 6))
    unexplained = np.zeros((len(pictures), len(LIMBS)))
    lengths = body.skeleton.lengths
    reach = 1.2 * lengths[: len(LIMBS)]
    reach[list(UPPER_ARMS)] += lengths[list(FOREARMS)]
    for v, seen in enumerate(pictures):
        picture = np.zeros(seen.measured.shape, dtype=np.float32)
        owner = np.full(picture.shape, -1, dtype=np.int8)
        cone_images(table, seen.camera_from_world, seen.pinhole, seen.eye, images)
        draw_owned(images, limb, seen.left, seen.top, seen.step, picture, owner)
        look(picture, owner, seen.measured, seen.person, seen.scale, _SQUARED_SIGMA, looks[v])
        to_camera = seen.camera_from_world
        joints = frames.origins[: len(LIMBS)] @ to_camera[:, :3].T + to_camera[:, 3]
        box = np.array([seen.left, seen.top, seen.step])
        unexplained_near(
            picture, seen.measured, seen.person, seen.scale, box, seen.pinhole, joints, reach,
            unexplained[v],
        )  # fmt: skip
    return looks, unexplained


def _of_data(pairs: Correspondences, own: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Root mean square distance in centimetres and logarithm of the relative number of data."""
    distance = np.linalg.norm(pairs.data[:, :3] - pairs.model, axis=1)
    limb, groups = LIMB_OF_PART[pairs.limb], len(LIMBS) + 1
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
    result: FloatArray = frames.origins[:n, None] + steps
    return result


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

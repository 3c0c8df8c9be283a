"""Features by which each limb of a pose is judged, and the probability that it fails."""

from collections.abc import Sequence
from dataclasses import replace
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
from stereotrack_core.recording.sighted_keypoints import SightedKeypoints
from stereotrack_core.tracking.arm_search.picture import SeenPicture, outline_cones, seen_pictures
from stereotrack_core.tracking.estimate import (
    Estimate,
    Prior,
    limb_sigma_deg,
    overconfidence,
    views_named,
)
from stereotrack_core.tracking.failure.alternatives import elsewhere
from stereotrack_core.tracking.failure.coefficients import CONSTANTS, SLOPES
from stereotrack_core.tracking.residuals.reprojection import KeypointObservation
from stereotrack_core.tracking.residuals.surface import surface_distances, unexplained_fraction
from stereotrack_core.tracking.state import Setup

# Names of the columns of :func:`limb_features`; coefficients are found by them.
FEATURES: tuple[str, ...] = (
    *("through", "behind", "visible", "unexplained"),
    *("jump", "buried", "better", "disagreement", "detected"),
)
LOST_DEG = 45.0  # error of a limb's direction beyond which it fails
THROUGH, BEHIND, VISIBLE = LOOKS = range(3)  # columns: beside the person, before its range, all

# (6, 2). Of limbs without keypoints; columns: disagreement x confidence, confidence.
UNSEEN: FloatArray = np.zeros((len(LIMBS), 2))
_LITTLE = 0.05  # share of a limb's area that is added before logarithms are taken
_STEP = 3
_SQUARED_SIGMA = 0.8**2
_MOST_POINTS = 1500  # of a cloud, thinned out, whose unexplained fraction is stated
_ALONG = np.linspace(0.25, 1.0, 4)


def judged(
    found: Estimate,
    cloud: Cloud,
    setup: Setup,
    sigma_points: Pose,
    movement: FloatArray,
    disagreement: FloatArray = UNSEEN,
) -> Estimate:
    """The estimate with the features by which it can be judged, and what they say.

    `sigma_points`, stacked (2n + 1), are of the posterior; `movement` (n,) is of the error state
    since the frame before; for `disagreement` (6, 2) see :func:`disagreement`.
    """
    begun, body = perf_counter(), setup.body
    sigma = limb_sigma_deg(body.frames(sigma_points), setup.weights.covariance)
    thin = cloud.points[:: max(1, len(cloud.points) // _MOST_POINTS)]
    share = unexplained_fraction(surface_distances(thin, body, found.pose))
    jump = unexpected(movement, found.prior, setup.joints)
    features = limb_features(cloud, body, found.pose, jump, disagreement)
    return replace(
        found,
        unexplained_fraction=share,
        limb_sigma_deg=overconfidence(len(setup.cameras)) * sigma,
        limb_lost=failure_probability(features, views_named(len(seen_pictures(cloud, _STEP)))),
        limb_features=features,
        seconds={**found.seconds, "judge": perf_counter() - begun},
    )


def with_neighbours(features: FloatArray) -> FloatArray:
    """Features (..., 6, 2 S) of each limb beside those of the other half of its arm."""
    return np.concatenate([features, features[..., list(NEIGHBOUR), :]], axis=-1)


def coefficients_of(views: str) -> str:
    """Coefficients that hold for a number of views: of ``one``, or of ``several``."""
    return "one" if views == "one" else "several"


def failure_probability(features: FloatArray | None, views: str) -> FloatArray:
    """Probability (6,) that each limb fails: more than 45 deg off; NaN where not known.

    A logistic regression of the features (6, S), for upper arms and for forearms, fitted on
    simulated recordings by ``tools/fit_lost_limbs.py``; torso and head failed too rarely to learn
    from. One view has coefficients of its own: in it an upper arm that nobody sees may be hidden
    behind its own forearm. `views`: how many see the person, as :func:`views_named` has it.
    """
    if features is None:
        return np.full(len(LIMBS), np.nan)
    fitted = coefficients_of(views)
    slopes = np.array([SLOPES[fitted][name] for name in FEATURES]).reshape(len(FEATURES), 2, 2)
    return probability_by(features, CONSTANTS[fitted], slopes.T.reshape(2, -1))


def probability_by(
    features: FloatArray, constants: Sequence[float], slopes: FloatArray
) -> FloatArray:
    """Probability (..., 6) by constant and slopes (2 S,) each of upper arms and of forearms."""
    every = with_neighbours(features)
    result = np.full(features.shape[:-1], np.nan)
    for limbs, constant, own in zip((UPPER_ARMS, FOREARMS), constants, slopes, strict=True):
        result[..., list(limbs)] = scipy.special.expit(constant + every[..., list(limbs), :] @ own)
    return result


def limb_features(
    cloud: Cloud, body: BodyModel, pose: Pose, jump: FloatArray, disagreement: FloatArray
) -> FloatArray | None:
    """Features (6, len(FEATURES)) of the limbs; None where no view has a picture of somebody.

    Of a limb's pixels in sight of all views: the shares beside the person (``through``) and where
    the range is ``behind`` the limb's; the logarithm of their area over the limb's own
    (``visible``). Then the ``unexplained`` area in the limb's reach over its own (square root), the
    logarithm of the ``jump`` (:func:`unexpected`), how deep its axis lies in the torso
    (``buried``), how much ``better`` it would be elsewhere, and the keypoints' ``disagreement`` (6,
    2).
    """
    pictures = seen_pictures(cloud, _STEP)
    if not pictures:
        return None
    # Areas (6,) of the limbs, seen from the side, in square metres.
    sides = (body.cones["r1"] + body.cones["r2"]) * body.cones["height"]
    sums = np.bincount(LIMB_OF_PART[body.cones["part"]], sides, len(LIMBS) + 1)[:-1]
    frames, own = body.frames(pose), np.maximum(sums.astype(np.float64), 1e-3)
    looks, unexplained = _looks(body, frames, pictures)
    limbs = looks[:, : len(LIMBS)]
    areas = np.array([picture.area(frames.origins[TORSO]) for picture in pictures])
    total = np.einsum("v,vlk->lk", areas, limbs)
    share = total / np.maximum(total[:, VISIBLE:], 1e-9)
    views = len(pictures)
    columns = {
        "through": share[:, THROUGH],
        "behind": share[:, BEHIND],
        "visible": np.log(total[:, VISIBLE] / views / own + _LITTLE),
        "unexplained": np.sqrt(areas @ unexplained / views / own),
        "jump": np.log1p(np.minimum(jump, 100.0)),
        "buried": _buried(body, frames),
        "better": elsewhere(cloud, body, pose, own),
        "disagreement": disagreement[:, 0],
        "detected": disagreement[:, 1],
    }
    return np.column_stack([columns[name] for name in FEATURES])


def unexpected(movement: FloatArray, prior: Prior | None, joints: tuple[int, ...]) -> FloatArray:
    """Movement of each limb (6,), of all (n,), over its expected sigma; 0 without a prior."""
    result = np.zeros(len(LIMBS))
    if prior is None:
        return result
    squared = movement**2 / np.diagonal(prior.P)
    result[TORSO] = np.sqrt(squared[3:6].mean())
    for joint, value in zip(joints, squared[6:].reshape(-1, 2).mean(axis=1), strict=True):
        if joint < len(LIMBS):
            result[joint] = np.sqrt(value)
    return result


NEIGHBOUR = (0, 0, 4, 5, 2, 3)  # the limb whose place says something about each limb's own


def _looks(
    body: BodyModel, frames: PartFrames, pictures: tuple[SeenPicture, ...]
) -> tuple[FloatArray, FloatArray]:
    """Looks (V, 7, 3) of limbs and legs, unexplained pixels (V, 6) of limbs, in all views."""
    placed, lengths = outline_cones(body, frames), body.skeleton.lengths
    looks = np.zeros((len(pictures), len(LIMBS) + 1, len(LOOKS)))
    unexplained = np.zeros((len(pictures), len(LIMBS)))
    reach = 1.2 * lengths[: len(LIMBS)]
    reach[list(UPPER_ARMS)] += lengths[list(FOREARMS)]
    for v, seen in enumerate(pictures):
        picture, owner = seen.drawn(placed)
        to_camera = seen.camera_from_world
        joints = frames.origins[: len(LIMBS)] @ to_camera[:, :3].T + to_camera[:, 3]
        _look(seen, picture, owner, looks[v])
        _unexplained_near(seen, picture, joints, reach, unexplained[v])
    return looks, unexplained


def _buried(body: BodyModel, frames: PartFrames) -> FloatArray:
    """How deep (6,) the arms' axes lie in the torso at most, decimetres; 0 for the others."""
    n = len(LIMBS)
    torso = placed_cones(body, frames)[LIMB_OF_PART[body.cones["part"]] == TORSO]
    along = body.skeleton.lengths[:n, None] * _ALONG
    axes = frames.origins[:n, None] + along[..., None] * frames.rotations[:n, None, :, 2]
    off = nearest_on_surface(axes.reshape(-1, 3), torso, np.inf).distance.reshape(n, -1)
    # an upper arm begins at the torso
    deep = np.where(np.isfinite(off), np.clip(-off, 0.0, 0.2), 0.0)[:, 1:].mean(axis=1)
    deep[:2] = 0.0
    return np.asarray(10.0 * deep)


@compiled()
def _look(seen: Any, picture: Any, owner: Any, out_looks: Any) -> None:
    """Add the pixels of one view to the looks (7, 3) of the limbs in front."""
    for i in range(picture.shape[0]):
        for j in range(picture.shape[1]):
            if owner[i, j] < 0:
                continue
            look, known = out_looks[LIMB_OF_PART[owner[i, j]]], seen.measured[i, j]
            look[VISIBLE] += 1.0
            e = seen.scale * (picture[i, j] - known)
            if seen.person[i, j] == 0:
                look[THROUGH] += 1.0
            elif known > 0.0 and e > 0.0:
                look[BEHIND] += e * e / (e * e + _SQUARED_SIGMA)


@compiled()
def _unexplained_near(seen: Any, picture: Any, joints: Any, reach: Any, out_count: Any) -> None:
    """Count for each joint the person's pixels in its reach that the body does not explain.

    The body is not there, or clearly behind what was measured. `joints` (J, 3) are in the camera's
    frame.
    """
    pinhole = seen.pinhole
    for i in range(picture.shape[0]):
        for j in range(picture.shape[1]):
            model, known = picture[i, j], seen.measured[i, j]
            explained = model > 0.0 and not seen.scale * (known - model) > 2.0
            if seen.person[i, j] == 0 or explained:
                continue
            x = (seen.left + seen.step * j - pinhole[1]) / pinhole[0]
            y = (seen.top + seen.step * i - pinhole[2]) / pinhole[0]
            for k in range(joints.shape[0]):
                z = 1.0 / known if known > 0.0 else joints[k, 2]
                dx, dy, dz = x * z - joints[k, 0], y * z - joints[k, 1], z - joints[k, 2]
                if dx * dx + dy * dy + dz * dz < reach[k] * reach[k]:
                    out_count[k] += 1.0


# Limb and the keypoints at both of its ends.
_ENDS = tuple(
    (limb, f"{side}_{begin}", f"{side}_{end}")
    for limbs, begin, end in ((UPPER_ARMS, "shoulder", "elbow"), (FOREARMS, "elbow", "wrist"))
    for limb, side in zip(limbs, ("left", "right"), strict=True)
)
_HALF_LIFE = 0.3  # seconds after which keypoints say half as much about the limbs of a later frame
_MOST = 1.5  # more says nothing: a keypoint of something else may lie anywhere


def disagreement(seen: SightedKeypoints | None, body: BodyModel, pose: Pose) -> FloatArray | None:
    """Disagreement of keypoints with a pose (6, 2); None where no keypoint was looked for.

    A limb's keypoints span an arrow in each picture, and so do the pose's. The distance of the
    arrows' tips over what the limb would be long across the picture is its disagreement: 0 if they
    agree, 1 for 60 degrees of a limb parallel to the picture. The place of the body cancels. Sides
    that a picture exchanges are exchanged back; of arms that may be crossed nothing is said.
    """
    fit = KeypointObservation(seen, 1.0).fitted(body, pose)
    if fit is None:
        return None
    rows = {name: k for k, name in enumerate(fit.seen.names)}
    arrows = fit.seen.pixel - fit.predicted
    result = UNSEEN.copy()
    for limb, begin, end in _ENDS:
        if begin not in rows or end not in rows:
            continue
        a, b = rows[begin], rows[end]
        sure = np.minimum(fit.sure[a], fit.sure[b])
        if not sure.any():
            continue
        long = fit.metre[b] * body.skeleton.lengths[limb]
        off = np.nan_to_num(np.linalg.norm(arrows[b] - arrows[a], axis=1) / long)
        most = float(sure.max())
        result[limb] = most * float(sure @ np.minimum(off, _MOST)) / float(sure.sum()), most
    return result


def carried_on(
    last: FloatArray, seconds: float, seen: SightedKeypoints | None, body: BodyModel, pose: Pose
) -> FloatArray:
    """Disagreement (6, 2) by a frame's keypoints, else the `last` one, faded."""
    found = disagreement(seen, body, pose)
    return last * 0.5 ** (seconds / _HALF_LIFE) if found is None else found

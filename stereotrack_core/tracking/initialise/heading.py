"""Which way a person faces: what single frames say for a heading and against the opposite one.

A body looks much the same from the front and from behind, with left and right exchanged. Each piece
of evidence is a log-likelihood ratio: positive for the way that a pose faces, negative for the
opposite way (:func:`turned_round`), 0 where nothing is seen that tells them apart. How much each
weighs is chosen, not learned, from recordings whose heading is known (docs/accuracy-elsewhere.md).
"""

from collections.abc import Iterator, Mapping
from types import MappingProxyType

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.model import BodyModel, landmarks
from stereotrack_core.body.pose import PartFrames, Pose
from stereotrack_core.body.skeleton import SHANKS, TORSO
from stereotrack_core.depth.cloud import Cloud, ViewDepth
from stereotrack_core.geometry.upright import Upright
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.tracking.initialise.finder import PoseFinder
from stereotrack_core.tracking.initialise.seeds import upright_pose
from stereotrack_core.tracking.initialise.trunk import (
    away_cost,
    feet_ahead,
    lean_cost,
    legs_cost,
    turned_round,
)
from stereotrack_core.tracking.residuals.clicks import missed
from stereotrack_core.tracking.residuals.reprojection import KeypointObservation

# Pieces of evidence, and independent looks that each is worth at most: frames of somebody who
# stands still say the same again and again.
MOST: Mapping[str, float] = MappingProxyType(
    {"toes": 3.0, "feet": 3.0, "legs": 3.0, "arms": 4.0}
    | {"cameras": 1.0, "keypoints": 3.0, "clicks": 2.0}
)
# Log-likelihood ratios of one look at evidence that could not be clearer, also of arms that cannot
# bend the other way round, and of hands in front of the elbows.
_TOES, _FEET, _LEGS, _CAMERAS, _KEYPOINTS, _CLICKS = 2.0, 0.7, 0.7, 1.5, 3.0, 4.0
_FORWARD, _HANDS = 1.5, 1.0
WALKING = 5.0  # log-likelihood ratio of a metre walked to the front
MOST_WALKED = 6.0  # and of any way: people seldom walk backwards for long
# Least sine of the angle between a view's line of sight and a foot, seen from above, from which the
# view shows whether toes point to one side.
_BESIDE = 0.64
_LEG = np.arange(0.12, 0.21, 0.02)  # heights over the ankle, metres, where a leg is looked for
_ASIDE = np.arange(-0.12, 0.121, 0.01)  # distances from it to the front, metres
_SOLE = np.arange(0.10, -0.26, -0.01)  # heights over the ankle, metres, at which a foot may end
# Metres over the sole, and from the ankle on, where there are toes in front and nothing behind.
_OVER_SOLE, _ALONG_FOOT = 0.03, np.array([0.10, 0.12, 0.14])


def ahead(frames: PartFrames, upright: Upright) -> FloatArray:
    """Level unit vector (3,), world, along which the torso faces; 0 where that is up or down."""
    y = frames.rotations[TORSO, :, 1]
    level = y - (y @ upright.up) * upright.up
    return np.asarray(level / max(float(np.linalg.norm(level)), 1e-6))


def _toes_in(
    body: BodyModel, frames: PartFrames, view: ViewDepth, forward: FloatArray, up: FloatArray
) -> Iterator[float]:
    """Where a view that sees feet from the side shows the toes: 1 in front, -1 behind.

    Clouds hardly have feet, as the floor is too near; the outlines of the person have.
    """
    if view.outline is None:
        return
    centre = view.geometry.world_from_depth.translation
    for shank in SHANKS:
        along = frames.rotations[shank, :, 2]
        ankle = frames.origins[shank] + body.skeleton.lengths[shank] * along
        sight = ankle - centre
        sight = sight - (sight @ up) * up
        beside = np.linalg.norm(np.cross(sight, forward)) / max(float(np.linalg.norm(sight)), 1e-6)
        if beside < _BESIDE:
            continue
        legs = ankle + _LEG[:, None, None] * up + _ASIDE[:, None] * forward
        leg = _inside(view, legs.reshape(-1, 3)).reshape(len(_LEG), len(_ASIDE))
        if not leg.any(axis=1).all():
            continue
        ankle = ankle + float((leg * _ASIDE).sum() / leg.sum()) * forward
        below = _inside(view, ankle + _SOLE[:, None] * up) > 0
        if not below[0] or below.all():
            continue
        sole = ankle + (_SOLE[np.argmin(below)] + _OVER_SOLE) * up
        toes, heel = (sole + way * _ALONG_FOOT[:, None] * forward for way in (1.0, -1.0))
        yield float(_inside(view, toes).mean() - _inside(view, heel).mean())


def _inside(view: ViewDepth, points: FloatArray) -> FloatArray:
    """Whether a view's outline covers points (N, 3), world; 0 or 1 (N,)."""
    u, v, z = view.geometry.project(points)
    person = view.person
    rows, columns = np.rint(v), np.rint(u)
    seen = (z > 0) & (rows >= 0) & (columns >= 0)
    seen &= (rows < person.shape[0]) & (columns < person.shape[1])
    result = np.zeros(len(points))
    result[seen] = person[rows[seen].astype(int), columns[seen].astype(int)]
    return result


def evidence(finder: PoseFinder, pose: Pose, cloud: Cloud) -> dict[str, float]:
    """One look at each piece of evidence of :data:`MOST` that a frame has, for a pose in it."""
    setup, back = finder.setup, turned_round(pose)
    body, upright = setup.body, setup.upright
    here, there = (body.frames(upright_pose(each, upright)) for each in (pose, back))
    cameras = upright.points(setup.cameras)
    costs = [legs_cost(frames) + lean_cost(frames) for frames in (there, here)]
    found = {
        "legs": _LEGS * _beyond(costs[0] - costs[1], 5.0, 20.0),
        "arms": arms_forward(finder, pose),
        "cameras": _CAMERAS * (away_cost(there, cameras) - away_cost(here, cameras)) / 20.0,
    }
    frames = body.frames(pose)
    forward, views = ahead(frames, upright), cloud.depths.values()
    if toes := [toe for view in views for toe in _toes_in(body, frames, view, forward, upright.up)]:
        found["toes"] = _TOES * float(np.mean(toes))
    if feet := feet_ahead(body, here, upright.points(cloud.points)):
        found["feet"] = _FEET * float(np.clip(np.mean(feet) / 0.05, -1.0, 1.0))
    seen = KeypointObservation(cloud.keypoints, setup.parameters.keypoint_sigma)
    fits = [seen.fitted(body, each) for each in (back, pose)]
    if fits[0] is not None and fits[1] is not None:
        gain = (fits[0].cost() - fits[1].cost()) / 0.3
        most = _KEYPOINTS * fits[0].independence
        found["keypoints"] = most * float(np.clip(gain, -1.0, 1.0))
    if cloud.clicks:
        off = missed(body, back, cloud.clicks) - missed(body, pose, cloud.clicks)
        found["clicks"] = _CLICKS * float(np.clip(off / 20.0, -1.0, 1.0))
    return found


def arms_forward(finder: PoseFinder, pose: Pose) -> float:
    """What the arms say: they reach to the front, and elbows bend one way only."""
    body = finder.setup.body
    anatomy = finder.arms_cost(turned_round(pose)) - finder.arms_cost(pose)
    frames = body.frames(pose)
    at = dict(zip(LANDMARKS, landmarks(body, pose), strict=True))
    forearms = [at[f"{side}_hand"] - at[f"{side}_elbow"] for side in ("left", "right")]
    before = float(np.mean(forearms, axis=0) @ frames.rotations[TORSO, :, 1])
    return _FORWARD * _beyond(anatomy, 3.0, 9.0) + _HANDS * _beyond(before, 0.05, 0.10)


def _beyond(value: float, dead: float, full: float) -> float:
    """-1 to 1, and 0 for values up to `dead`; 1 from `dead` + `full` on."""
    return float(np.sign(value) * np.clip((abs(value) - dead) / full, 0.0, 1.0))

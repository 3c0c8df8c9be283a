"""Arms as 2-D keypoints show them: where they could be, and what speaks against a place."""

from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import PartFrames, Pose
from stereotrack_core.body.skeleton import TORSO
from stereotrack_core.recording.sighted_keypoints import SightedKeypoints
from stereotrack_core.tracking.arm_search.arms import Arms, ArmShape, directions
from stereotrack_core.tracking.residuals.reprojection import KeypointObservation

# Metres from its ray at which a joint counts as half contradicted, and if arms may be crossed,
# where each picture has two explanations. Detectors are off by 0.04 m, simulated hands by 0.1 m.
_SCALE, _CROSSED_SCALE = 0.25, 0.15
_CROSSED = 2.0  # factor then: what halves confidences in arms is explained (tracking/detecting.py)
_HAND = 0.05  # metres from its ray within which points are of a hand


@dataclass(frozen=True, eq=False)
class ArmKeypoints:
    """Elbow and wrist of one arm, as V cameras see them; torso's frame."""

    eye: FloatArray  # (V, 3), metres. Optical centres.
    ray: FloatArray  # (3, V, 3). Of elbow, wrist and the other elbow; NaN where not seen.
    sure: FloatArray  # (3, V). Confidences; 0 where not seen.
    met: FloatArray  # (2, 3), metres. Where rays of several cameras meet; NaN where they do not.
    crossed: bool  # whether arms may be crossed, so that the other elbow may be this hand

    def cost(self, shape: ArmShape, arms: Arms) -> FloatArray:
        """Sum (K,) over cameras and joints of confidence times e^4 / (e^4 + s^4).

        If arms may be crossed, the cheaper explanation of each picture: elbow and wrist, or hand.
        """
        nodes = shape.nodes(arms)
        joints = np.concatenate([nodes[:, 1:3], nodes[:, 2:].mean(axis=1, keepdims=True)], axis=1)
        away = joints[:, :, None] - self.eye
        along = np.einsum("kjvi,jvi->kjv", away, self.ray)
        quartic = (np.sum(away**2, axis=3) - along**2) ** 2
        scale = _CROSSED_SCALE if self.crossed else _SCALE
        against = np.where(along > 0.0, quartic / (quartic + scale**4), 1.0)
        cost: FloatArray = np.nan_to_num(self.sure * against)
        arm, hand = cost[:, :2].sum(axis=1), cost[:, 2]
        return np.asarray((_CROSSED * np.minimum(arm, hand) if self.crossed else arm).sum(axis=1))

    def near_hand(self, points: FloatArray) -> FloatArray:
        """Those of the points (N, 3) at which the hand is if arms are crossed; may be none."""
        off = np.linalg.norm(np.cross(points[:, None] - self.eye, self.ray[2]), axis=2)
        return np.asarray(points[(off < _HAND).any(axis=1) & self.crossed])

    def proposals(self, shape: ArmShape) -> Arms | None:
        """Arms whose elbow and wrist lie on the rays of a camera, or where those of several meet.

        A camera alone leaves up to two places of the elbow, and of each two of the wrist.
        """
        found = [tuple(self.met)] if np.isfinite(self.met).all() else []
        for v in np.flatnonzero((self.sure[:2] > 0.0).all(axis=0)).tolist():
            eye, (to_elbow, to_wrist) = self.eye[v], self.ray[:2, v]
            for elbow in _on_sphere(eye, to_elbow, shape.shoulder, shape.upper_length):
                wrists = _on_sphere(eye, to_wrist, elbow, shape.fore_length)
                found += [(elbow, wrist) for wrist in wrists]
        if not found:
            return None
        elbow, wrist = np.array(found).transpose(1, 0, 2)
        return Arms(directions(elbow - shape.shoulder), directions(wrist - elbow))


def arm_keypoints(
    seen: SightedKeypoints | None, sigma: float, body: BodyModel, pose: Pose
) -> tuple[ArmKeypoints, ArmKeypoints] | None:
    """Keypoints of both arms, with sides as they fit a pose; None where there are none."""
    fit = KeypointObservation(seen, sigma).fitted(body, pose, follows=True)
    if fit is None:
        return None
    frames, sides = body.frames(pose), ("left", "right")
    left, right = (_of_side(fit.seen, fit.meeting.world, frames, side) for side in sides)
    return None if left is None or right is None else (left, right)


def _of_side(
    seen: SightedKeypoints, met: FloatArray, frames: PartFrames, side: str
) -> ArmKeypoints | None:
    """Keypoints of one arm; of several detectors the first."""
    names = [f"{side}_elbow", f"{side}_wrist"]  # the second and third of an arm's nodes
    if not set(names) <= set(seen.names):
        return None
    rows = [seen.names.index(name) for name in names]
    torso = frames.rotations[TORSO]
    (centres, rays), three = seen.rays, [*rows, seen.other_side[rows[0]]]
    return ArmKeypoints(
        (centres - frames.origins[TORSO]) @ torso,
        rays[three] @ torso,
        seen.confidence[three],
        (met[rows] - frames.origins[TORSO]) @ torso,
        seen.crossed,
    )


def _on_sphere(
    eye: FloatArray, ray: FloatArray, centre: FloatArray, radius: float
) -> tuple[FloatArray, ...]:
    """Points in which a ray meets a sphere; where it passes by, the nearest point of the sphere."""
    along = float((centre - eye) @ ray)
    nearest = eye + along * ray
    off = float(np.linalg.norm(nearest - centre))
    if off >= radius:
        return (centre + (nearest - centre) * (radius / off),)
    half = float(np.sqrt(radius**2 - off**2))
    return nearest - half * ray, nearest + half * ray

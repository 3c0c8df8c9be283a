"""A person ready to be drawn: clothes, and a surface that follows the bones.

Weights are smooth, and blended by dual quaternions: Kavan et al., "Skinning with dual
quaternions", I3D 2007, doi:10.1145/1230100.1230107. The surface is posed first as if the shoulder
girdle only followed the arms. What the shoulders do beside that moves it once more: the arm goes
along with its joint, and the flesh between arm, neck and chest turns about the clavicle's inner
end, less and less towards head and ribs.
"""

from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
import scipy

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.simulation.people import Person
from stereotrack_core.simulation.room import borders, material_table, worn
from stereotrack_core.simulation.skeleton import BONE, BONES, SIDES, SIGN, PosedBones, rest_joints
from stereotrack_core.simulation.surface import rest_surface


def _skin_weights(person: Person, vertices: FloatArray) -> FloatArray:
    """Weights (V, B) of every bone on the vertices (V, 3) at rest; rows sum to one."""
    joints = rest_joints(person)
    weights = np.zeros((len(vertices), len(BONES)))
    trunk = np.ones(len(vertices))
    for side in (0, 1):
        arm = _arm_share(joints, vertices, side)
        leg = _leg_share(joints, vertices, side)
        _share_arm(person, joints, vertices, side, arm, weights)
        _share_leg(joints, vertices, side, leg, weights)
        trunk -= arm + leg
    _share_trunk(joints, vertices, np.maximum(trunk, 0.0), weights)
    return np.asarray(weights / weights.sum(axis=1, keepdims=True))


def _smooth_step(x: FloatArray, middle: float, half_width: float) -> FloatArray:
    """0 to 1 over `middle` +- `half_width`, smoothly."""
    t = np.clip((x - middle) / (2 * half_width) + 0.5, 0.0, 1.0)
    return t * t * (3 - 2 * t)


def _arm_share(joints: FloatArray, p: FloatArray, side: int) -> FloatArray:
    """Share of the arm; the border leans, so that the flank below the armpit stays trunk."""
    shoulder = joints[BONE[f"upper_arm_{SIDES[side]}"]]
    below = np.minimum(0.0, p[:, 2] - (shoulder[2] - 0.05))
    out = SIGN[side] * p[:, 0] + 0.6 * below
    return _smooth_step(out, abs(shoulder[0]) - 0.004, 0.062)


def _share_arm(
    person: Person,
    joints: FloatArray,
    p: FloatArray,
    side: int,
    arm: FloatArray,
    weights: FloatArray,
) -> None:
    name = SIDES[side]
    out = SIGN[side] * p[:, 0]
    shoulder, elbow, wrist = (
        abs(joints[BONE[f"{bone}_{name}"], 0]) for bone in ("upper_arm", "forearm", "hand")
    )
    twisted = np.clip((out - shoulder) / (0.75 * person.upper_arm), 0.0, 1.0)
    past_elbow = _smooth_step(out, elbow, 0.042)
    past_wrist = _smooth_step(out, wrist, 0.028)
    weights[:, BONE[f"swing_{name}"]] = arm * (1 - past_elbow) * (1 - twisted)
    weights[:, BONE[f"upper_arm_{name}"]] = arm * (1 - past_elbow) * twisted
    weights[:, BONE[f"forearm_{name}"]] = arm * past_elbow * (1 - past_wrist)
    weights[:, BONE[f"hand_{name}"]] = arm * past_elbow * past_wrist


def _leg_share(joints: FloatArray, p: FloatArray, side: int) -> FloatArray:
    hip = joints[BONE[f"thigh_{SIDES[side]}"]]
    below = 1 - _smooth_step(p[:, 2], hip[2] - 0.045, 0.075)
    return below * _smooth_step(SIGN[side] * p[:, 0], 0.0, 0.012)


def _share_leg(
    joints: FloatArray, p: FloatArray, side: int, leg: FloatArray, weights: FloatArray
) -> None:
    name = SIDES[side]
    knee, ankle = joints[BONE[f"shank_{name}"]], joints[BONE[f"foot_{name}"]]
    past_knee = 1 - _smooth_step(p[:, 2], knee[2], 0.055)
    past_ankle = 1 - _smooth_step(p[:, 2] + 0.15 * (p[:, 1] - ankle[1]), ankle[2], 0.032)
    weights[:, BONE[f"thigh_{name}"]] = leg * (1 - past_knee)
    weights[:, BONE[f"shank_{name}"]] = leg * past_knee * (1 - past_ankle)
    weights[:, BONE[f"foot_{name}"]] = leg * past_knee * past_ankle


def _share_trunk(joints: FloatArray, p: FloatArray, trunk: FloatArray, weights: FloatArray) -> None:
    z = p[:, 2]
    spine = np.abs(joints[BONE["chest"], 2] - joints[BONE["waist"], 2])
    passed = [
        _smooth_step(z, joints[BONE["waist"], 2], 0.75 * spine),
        _smooth_step(z, joints[BONE["chest"], 2], 0.75 * spine),
        _smooth_step(z, joints[BONE["neck"], 2], 0.035),
        _smooth_step(z, joints[BONE["head"], 2] - 0.01, 0.04),
    ]
    rest = trunk
    for bone, share in zip(("pelvis", "waist", "chest", "neck"), passed, strict=True):
        weights[:, BONE[bone]] = rest * (1 - share)
        rest = rest * share
    weights[:, BONE["head"]] = rest
    chest = weights[:, BONE["chest"]].copy()
    shoulder = joints[BONE["upper_arm_right"]]
    for side, name in enumerate(SIDES):
        girdle = _smooth_step(SIGN[side] * p[:, 0], 0.5 * shoulder[0], 0.4 * shoulder[0])
        girdle *= _smooth_step(z, shoulder[2] - 0.08, 0.09)
        weights[:, BONE[f"clavicle_{name}"]] = chest * girdle
        weights[:, BONE["chest"]] -= chest * girdle


def _dual_quaternions(rest: FloatArray, bones: PosedBones) -> FloatArray:
    """Unit dual quaternions (B, 8), w x y z, then the dual part; signs make blending go short."""
    shift = bones.joint - np.einsum("bij,bj->bi", bones.rotation, rest)
    result = _rigid_quaternions(bones.rotation, shift)
    result[result[:, :4] @ result[BONE["chest"], :4] < 0] *= -1
    return result


def _rigid_quaternions(rotation: FloatArray, shift: FloatArray) -> FloatArray:
    """Unit dual quaternions (N, 8) of turns (N, 3, 3) and then shifts (N, 3)."""
    real = np.roll(scipy.spatial.transform.Rotation.from_matrix(rotation).as_quat(), 1, axis=1)
    real *= np.where(real[:, :1] < 0, -1.0, 1.0)
    dual = 0.5 * _product(np.concatenate([np.zeros((len(shift), 1)), shift], axis=1), real)
    return np.concatenate([real, dual], axis=1)


def _product(a: FloatArray, b: FloatArray) -> FloatArray:
    """Hamilton product (..., 4) of quaternions w x y z."""
    w, x, y, z = np.moveaxis(a, -1, 0)
    q, r, s, t = np.moveaxis(b, -1, 0)
    return np.stack(
        [
            w * q - x * r - y * s - z * t,
            w * r + x * q + y * t - z * s,
            w * s - x * t + y * q + z * r,
            w * t + x * s - y * r + z * q,
        ],
        axis=-1,
    )


def _skinned(
    vertices: FloatArray, normals: FloatArray, weights: FloatArray, quaternions: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Vertices and normals (V, 3), world, of a surface at rest under posed bones."""
    blended = weights @ quaternions
    blended /= np.linalg.norm(blended[:, :4], axis=1, keepdims=True)
    w, v = blended[:, :1], blended[:, 1:4]
    dual_w, dual_v = blended[:, 4:5], blended[:, 5:8]

    def turned(p: FloatArray) -> FloatArray:
        return p + 2 * np.cross(v, np.cross(v, p) + w * p)

    shift = 2 * (w * dual_v - dual_w * v + np.cross(v, dual_v))
    return turned(vertices) + shift, turned(normals)


_ARM = ("swing", "upper_arm", "forearm", "hand")


def _girdle_weights(person: Person, vertices: FloatArray, weights: FloatArray) -> FloatArray:
    """Shares (V, 5) of what stays, of the left girdle and arm, and of the right ones, at rest."""
    shoulder = rest_joints(person)[BONE["upper_arm_right"]]
    half, z = shoulder[0], vertices[:, 2] - shoulder[2]
    height = _smooth_step(z, -0.10, 0.12) * (1 - _smooth_step(z, 0.10, 0.09))
    height *= 1 - weights[:, BONE["head"]]
    shares = np.zeros((len(vertices), 5))
    for side, name in enumerate(SIDES):
        arm = weights[:, [BONE[f"{bone}_{name}"] for bone in _ARM]].sum(axis=1)
        across = _smooth_step(SIGN[side] * vertices[:, 0], 0.45 * half, 0.4 * half)
        shares[:, 1 + 2 * side] = (1 - arm) * across * height
        shares[:, 2 + 2 * side] = arm
    shares[:, 0] = 1 - shares[:, 1:].sum(axis=1)
    return shares


def _without_own_girdle(bones: PosedBones) -> PosedBones:
    """The bones as they were if the shoulders only followed the arms; the same if they do."""
    if np.array_equal(bones.girdle, np.tile(np.eye(3), (2, 1, 1))):
        return bones
    rotation, joint = bones.rotation.copy(), bones.joint.copy()
    for side, name in enumerate(SIDES):
        rotation[BONE[f"clavicle_{name}"]] = (
            bones.girdle[side].T @ rotation[BONE[f"clavicle_{name}"]]
        )
        joint[[BONE[f"{bone}_{name}"] for bone in _ARM]] -= _arm_shift(bones, side)
    return PosedBones(rotation, joint)


def _with_own_girdle(
    vertices: FloatArray, normals: FloatArray, shares: FloatArray, bones: PosedBones
) -> tuple[FloatArray, FloatArray]:
    """Move a surface (V, 3), world, that followed the bones without their own girdle."""
    turns = np.tile(np.eye(3), (5, 1, 1))
    shifts = np.zeros((5, 3))
    for side, name in enumerate(SIDES):
        pivot = bones.joint[BONE[f"clavicle_{name}"]]
        turns[1 + 2 * side] = bones.girdle[side]
        shifts[1 + 2 * side] = pivot - bones.girdle[side] @ pivot
        shifts[2 + 2 * side] = _arm_shift(bones, side)
    return _skinned(vertices, normals, shares, _rigid_quaternions(turns, shifts))


def _arm_shift(bones: PosedBones, side: int) -> FloatArray:
    """How far the girdle's own motion brings the shoulder, (3,) metres, world."""
    clavicle, shoulder = (
        bones.joint[BONE[f"{bone}_{SIDES[side]}"]] for bone in ("clavicle", "upper_arm")
    )
    out = shoulder - clavicle
    return np.asarray(out - bones.girdle[side].T @ out)


@dataclass(frozen=True, eq=False)
class Actor:
    """A dressed person to be posed; `vertices`, `normals` (V, 3) at rest, as the textures."""

    person: Person
    vertices: FloatArray
    normals: FloatArray
    triangles: IntArray  # (T, 3)
    weights: FloatArray  # (V, B)
    materials: FloatArray  # (6, 9)
    marks: FloatArray  # (8,)

    @cached_property
    def _girdle_shares(self) -> FloatArray:
        return _girdle_weights(self.person, self.vertices, self.weights)

    def posed(self, bones: PosedBones) -> tuple[FloatArray, FloatArray]:
        """Vertices and normals (V, 3), world."""
        following = _without_own_girdle(bones)
        quaternions = _dual_quaternions(rest_joints(self.person), following)
        posed = _skinned(self.vertices, self.normals, self.weights, quaternions)
        return posed if following is bones else _with_own_girdle(*posed, self._girdle_shares, bones)


@cache
def actor(person: Person, clothes: str) -> Actor:
    """Contour, weight and dress a person."""
    vertices, normals, triangles = rest_surface(person)
    weights = _skin_weights(person, vertices)
    materials = material_table(worn(person, clothes))
    return Actor(person, vertices, normals, triangles, weights, materials, borders(person))

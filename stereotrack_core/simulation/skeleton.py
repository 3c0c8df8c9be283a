"""The people of the simulation: lengths and builds, rest joints, joint states, places of bones.

They differ from the tracker's own body. Rest is a T pose that faces north (+y) with the palms down;
the person's right is +x. The origin lies on the floor under the hips' midpoint.
"""

import math
import zlib
from dataclasses import dataclass, field, fields, replace
from functools import cache
from typing import NamedTuple

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.rotation import rotation_from_vector, vector_from_rotation
from stereotrack_core.recording.description import Subject

_SHARES = {
    "shoulder_width": 0.210,
    "hip_width": 0.118,
    "torso_length": 0.282,
    "upper_arm": 0.168,
    "forearm": 0.150,
    "hand": 0.108,
    "shoulder_to_head": 0.116,
    "thigh": 0.246,
    "shank": 0.244,
    "ankle_height": 0.042,
}
"""Lengths between joint centres as shares of the stature, near the middle of the tables in
Winter, Biomechanics and Motor Control of Human Movement (2009), chapter 4."""

_UPRIGHT = ("ankle_height", "shank", "thigh", "torso_length", "shoulder_to_head")
_SPREAD = 0.03  # standard deviation of a length as share of itself; cut at one and a half


@dataclass(frozen=True)
class Person:
    """One person; lengths in metres between joint centres.

    `shoulder_width` and `hip_width` and `torso_length` and `upper_arm` and `forearm` and `hand`: as
    `Subject` names them; `hand` is wrist to fingertip.
    """

    name: str
    stature: float
    shoulder_width: float
    hip_width: float
    torso_length: float
    upper_arm: float
    forearm: float
    hand: float
    shoulder_to_head: float  # shoulder midpoint to the centre of the head
    thigh: float
    shank: float
    ankle_height: float
    girth: float  # factor on the radii of the trunk
    muscle: float  # factor on the radii of the limbs
    hips: float  # factor on the width of the pelvis

    @property
    def arm(self) -> float:
        """Shoulder to wrist, stretched."""
        return self.upper_arm + self.forearm

    @property
    def leg(self) -> float:
        """Hip to ankle, stretched."""
        return self.thigh + self.shank

    def subject(self) -> Subject:
        """The lengths as a person would measure them for ``subject.toml``."""
        arm = self.upper_arm, self.forearm, self.hand
        trunk = self.shoulder_width, self.hip_width, self.torso_length
        return Subject(self.name, *trunk, *arm, self.shoulder_to_head)


def _person(name: str, stature: float, girth: float, muscle: float, hips: float) -> Person:
    rng = np.random.default_rng(zlib.crc32(name.encode()))
    lengths = {
        key: share * stature * (1 + _SPREAD * float(np.clip(rng.normal(), -1.5, 1.5)))
        for key, share in _SHARES.items()
    }
    above_head_centre = 0.122 * math.sqrt(stature / 1.75)
    tall = sum(lengths[key] for key in _UPRIGHT) + above_head_centre
    lengths = {key: length * stature / tall for key, length in lengths.items()}
    return Person(name, stature, **lengths, girth=girth, muscle=muscle, hips=hips)


PEOPLE: dict[str, Person] = {
    person.name: person
    for person in (
        _person("P1", 1.89, girth=0.96, muscle=0.97, hips=0.95),
        _person("P2", 1.75, girth=1.04, muscle=1.06, hips=1.00),
        _person("P3", 1.99, girth=1.12, muscle=1.10, hips=0.98),
        _person("P4", 1.68, girth=0.93, muscle=0.90, hips=1.10),
    )
}
"""The four people by name."""


def person_named(name: str) -> Person:
    """The person of that name; raises :class:`InputError` for an unknown one."""
    try:
        return PEOPLE[name]
    except KeyError:
        what = f"unknown person {name!r}"
        raise InputError(what, "--person", f"Use one of {', '.join(PEOPLE)}.") from None


def grown(person: Person, stature: float) -> Person:
    """The person scaled to another stature in metres; girth and muscle are factors and stay."""
    factor = stature / person.stature
    others = {"name", "girth", "muscle", "hips"}
    names = [one.name for one in fields(person) if one.name not in others]
    lengths = {name: factor * getattr(person, name) for name in names}
    return replace(person, **lengths)


def girth_scale(person: Person) -> float:
    """Factor by which radii of the average body (1.75 m) grow with the stature."""
    return math.sqrt(person.stature / 1.75)


_STRETCH = 0.99985


class TwoLinks(NamedTuple):
    """Two links from the origin, and the angle between them in radians.

    Columns of the frames (3, 3): the link's direction, the hinge about which the joint turns the
    first link towards the second one, and what completes them.
    """

    first_frame: FloatArray
    second_frame: FloatArray
    flexion: float


def two_links(target: FloatArray, length_1: float, length_2: float, pole: FloatArray) -> TwoLinks:
    """Reach from the origin for `target` (3,), or as far as can be, the joint towards `pole`."""
    wanted = float(np.linalg.norm(target))
    d = np.asarray(target, dtype=np.float64) / max(wanted, 1e-9)
    shortest = abs(length_1 - length_2) * 1.02 + 1e-6
    reach = float(np.clip(wanted, shortest, _STRETCH * (length_1 + length_2)))
    q = np.asarray(pole, dtype=np.float64) - d * float(np.dot(pole, d))
    if np.linalg.norm(q) < 1e-6:
        q = np.cross(d, [0.577, 0.577, -0.577])
    q /= np.linalg.norm(q)
    cosine_1 = (length_1**2 + reach**2 - length_2**2) / (2 * length_1 * reach)
    cosine_2 = (length_2**2 + reach**2 - length_1**2) / (2 * length_2 * reach)
    angle_1, angle_2 = np.arccos(np.clip([cosine_1, cosine_2], -1.0, 1.0))
    first = np.cos(angle_1) * d + np.sin(angle_1) * q
    second = np.cos(angle_2) * d - np.sin(angle_2) * q
    hinge = np.cross(q, d)
    one, other = (np.stack([a, hinge, np.cross(a, hinge)], axis=1) for a in (first, second))
    return TwoLinks(one, other, float(angle_1 + angle_2))


def bend_rotation(a: FloatArray, b: FloatArray) -> FloatArray:
    """The rotation (3, 3) that turns unit vector `a` into unit vector `b` without twist."""
    c = float(np.dot(a, b))
    v = np.cross(a, b)
    if c < -1 + 1e-9:
        axis = np.cross(a, [0.0, 0.0, 1.0])
        axis /= np.linalg.norm(axis)
        return 2 * np.outer(axis, axis) - np.eye(3)
    k = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    return np.asarray(np.eye(3) + k + k @ k / (1 + c))


BONES: tuple[str, ...] = (
    "pelvis",
    "waist",
    "chest",
    "neck",
    "head",
    *(
        f"{bone}_{side}"
        for bone in ("clavicle", "swing", "upper_arm", "forearm", "hand", "thigh", "shank", "foot")
        for side in ("left", "right")
    ),
)
"""`swing` is the upper arm without its twist: it leads the surface round the shoulder."""

BONE = {name: index for index, name in enumerate(BONES)}
SIDES: tuple[str, str] = ("left", "right")
SIGN = (-1.0, 1.0)  # direction of x on the left and on the right side

_LEG_REACH = 0.997


@dataclass(frozen=True, eq=False)
class JointState:
    """All that moves, for one frame. Pairs are left, right."""

    position: FloatArray  # (3,) world, metres; midpoint of the hips
    trunk: FloatArray
    """(5, 3, 3); world_from_pelvis, then waist, chest, neck and head, each relative to the one
    before."""
    arms: FloatArray  # (2, 3, 3); chest_from_upper_arm; the identity is the T pose
    elbows: FloatArray  # (2,) radians; flexion
    hands: FloatArray  # (2, 3, 3); forearm_from_hand
    ankles: FloatArray  # (2, 3) world, metres; where the ankle joints are to be
    feet: FloatArray  # (2, 3, 3); world_from_foot
    girdle: FloatArray
    """(2, 2) radians; by how much each shoulder is lifted and pushed forward beside what follows
    the arm: elevation and protraction of the clavicle against the chest (as named in Wu et al.
    2005, doi:10.1016/j.jbiomech.2004.05.042)."""


def difference(a: JointState, b: JointState) -> FloatArray:
    """The step (n,) from `a` to `b`: lengths, angles and rotation vectors, by the shortest arcs."""
    parts = [b.position - a.position, b.elbows - a.elbows, b.ankles - a.ankles]
    for p, q in ((a.trunk, b.trunk), (a.arms, b.arms), (a.hands, b.hands), (a.feet, b.feet)):
        parts.append(vector_from_rotation(np.swapaxes(p, -1, -2) @ q))
    parts.append(b.girdle - a.girdle)
    return np.concatenate([part.ravel() for part in parts])


def moved(state: JointState, step: FloatArray) -> JointState:
    """The state after a step (n,); ``moved(a, difference(a, b))`` is `b`."""
    position, elbows, ankles, trunk, arms, hands, feet, girdle = np.split(
        np.asarray(step), np.cumsum([3, 2, 6, 15, 6, 6, 6])
    )

    def turned(rotations: FloatArray, vectors: FloatArray) -> FloatArray:
        return rotations @ rotation_from_vector(vectors.reshape(-1, 3))

    return JointState(
        state.position + position,
        turned(state.trunk, trunk),
        turned(state.arms, arms),
        state.elbows + elbows,
        turned(state.hands, hands),
        state.ankles + ankles.reshape(2, 3),
        turned(state.feet, feet),
        state.girdle + girdle.reshape(2, 2),
    )


def between(a: JointState, b: JointState, share: float) -> JointState:
    """The state at `share` of the way from `a` to `b`."""
    return moved(a, share * difference(a, b))


def minimum_jerk(t: float) -> float:
    """Share of the way at the share `t` of the time.

    Flash and Hogan 1985, doi:10.1523/JNEUROSCI.05-07-01688.1985.
    """
    return t * t * t * (t * (6 * t - 15) + 10)


@cache
def rest_joints(person: Person) -> FloatArray:
    """Where each bone begins at rest: (len(BONES), 3) metres, read-only."""
    hip_z = person.ankle_height + person.leg * 0.9975
    shoulder_z = hip_z + person.torso_length
    joints = np.zeros((len(BONES), 3))
    joints[BONE["pelvis"]] = 0, 0, hip_z
    joints[BONE["waist"]] = 0, -0.005, hip_z + 0.30 * person.torso_length
    joints[BONE["chest"]] = 0, -0.005, hip_z + 0.56 * person.torso_length
    joints[BONE["neck"]] = 0, -0.015, hip_z + 1.06 * person.torso_length
    joints[BONE["head"]] = 0, -0.005, shoulder_z + 0.64 * person.shoulder_to_head
    for side, s in zip(SIDES, SIGN, strict=True):
        shoulder = np.array([s * person.shoulder_width / 2, 0.0, shoulder_z])
        hip = np.array([s * person.hip_width / 2, 0.0, hip_z])
        ankle = np.array([s * (person.hip_width / 2 + 0.045), -0.01, person.ankle_height])
        joints[BONE[f"clavicle_{side}"]] = s * 0.02, 0.01, shoulder_z - 0.01
        joints[BONE[f"swing_{side}"]] = joints[BONE[f"upper_arm_{side}"]] = shoulder
        joints[BONE[f"forearm_{side}"]] = shoulder + [s * person.upper_arm, 0, 0]
        joints[BONE[f"hand_{side}"]] = shoulder + [s * person.arm, 0, 0]
        joints[BONE[f"thigh_{side}"]] = hip
        knee = two_links(ankle - hip, person.thigh, person.shank, np.array([0, 1.0, 0]))
        joints[BONE[f"shank_{side}"]] = hip + person.thigh * knee.first_frame[:, 0]
        joints[BONE[f"foot_{side}"]] = ankle
    joints.flags.writeable = False
    return joints


@dataclass(frozen=True, eq=False)
class PosedBones:
    """World placement of every bone: world_from_bone (B, 3, 3) and joints (B, 3) in metres.

    Bones have the world's axes at rest. `girdle` (2, 3, 3) is the world rotation of each clavicle
    by what the shoulder does on its own.
    """

    rotation: FloatArray
    joint: FloatArray
    girdle: FloatArray = field(default_factory=lambda: np.tile(np.eye(3), (2, 1, 1)))


def clavicle_rotation(side: int, upper_arm_in_chest: FloatArray, girdle: FloatArray) -> FloatArray:
    """chest_from_clavicle (3, 3): it follows the arm, and moves on its own.

    The girdle follows `upper_arm_in_chest`, a unit vector (3,), by up to 10 degrees up and 9
    forward; `girdle` (2,) is its own elevation and protraction in radians beside that.
    """
    s = SIGN[side]
    raised = (
        np.radians(10.0 if upper_arm_in_chest[2] > 0 else 6.0) * upper_arm_in_chest[2] + girdle[0]
    )
    forward = np.radians(9.0) * upper_arm_in_chest[1] + girdle[1]
    return rotation_from_vector(np.array([0.0, -s * raised, s * forward]))


def posed_bones(person: Person, state: JointState) -> PosedBones:
    """Forward kinematics of trunk and arms; the legs reach for the ankles."""
    rest = rest_joints(person)
    rotation = np.tile(np.eye(3), (len(BONES), 1, 1))
    joint = np.zeros((len(BONES), 3))
    girdle = np.tile(np.eye(3), (2, 1, 1))
    joint[0] = _reachable_hips(person, state, rest)
    rotation[0] = state.trunk[0]
    for bone in range(1, 5):
        rotation[bone] = rotation[bone - 1] @ state.trunk[bone]
        joint[bone] = joint[bone - 1] + rotation[bone - 1] @ (rest[bone] - rest[bone - 1])
    for side in (0, 1):
        girdle[side] = _pose_arm(side, state, rest, rotation, joint)
        thigh, shank, foot = (BONE[f"{b}_{SIDES[side]}"] for b in ("thigh", "shank", "foot"))
        joint[thigh] = joint[0] + rotation[0] @ (rest[thigh] - rest[0])
        forward = rotation[0] @ [0.0, 1.0, 0.0] + 2.0 * (state.feet[side] @ [0.0, 1.0, 0.0])
        links = two_links(state.ankles[side] - joint[thigh], person.thigh, person.shank, forward)
        at_rest = two_links(
            rest[foot] - rest[thigh], person.thigh, person.shank, np.array([0, 1.0, 0])
        )
        rotation[thigh] = links.first_frame @ at_rest.first_frame.T
        rotation[shank] = links.second_frame @ at_rest.second_frame.T
        rotation[foot] = state.feet[side]
        joint[shank] = joint[thigh] + rotation[thigh] @ (rest[shank] - rest[thigh])
        joint[foot] = joint[shank] + rotation[shank] @ (rest[foot] - rest[shank])
    return PosedBones(rotation, joint, girdle)


def _reachable_hips(person: Person, state: JointState, rest: FloatArray) -> FloatArray:
    """Lower the hips until both ankles are within reach, so that feet stay on the floor."""
    hips: FloatArray = state.position.copy()
    reach = _LEG_REACH * person.leg
    for side, name in enumerate(SIDES):
        offset = state.trunk[0] @ (rest[BONE[f"thigh_{name}"]] - rest[0])
        away = state.position + offset - state.ankles[side]
        height = np.sqrt(max(reach**2 - away[0] ** 2 - away[1] ** 2, 0.0))
        hips[2] = min(hips[2], state.ankles[side, 2] + height - offset[2])
    return hips


def _pose_arm(
    side: int, state: JointState, rest: FloatArray, rotation: FloatArray, joint: FloatArray
) -> FloatArray:
    """Fill in the arm's bones; return how the girdle moved on its own, (3, 3) world."""
    name, s = SIDES[side], SIGN[side]
    chest, clavicle, swing, upper, fore, hand = (
        BONE["chest"],
        *(BONE[f"{b}_{name}"] for b in ("clavicle", "swing", "upper_arm", "forearm", "hand")),
    )
    axis = np.array([s, 0.0, 0.0])
    in_chest = state.arms[side]
    rotation[clavicle] = rotation[chest] @ clavicle_rotation(
        side, in_chest @ axis, state.girdle[side]
    )
    rotation[swing] = rotation[chest] @ bend_rotation(axis, in_chest @ axis)
    rotation[upper] = rotation[chest] @ in_chest
    flexion = np.array([0.0, 0.0, s * state.elbows[side]])
    rotation[fore] = rotation[upper] @ rotation_from_vector(flexion)
    rotation[hand] = rotation[fore] @ state.hands[side]
    joint[clavicle] = joint[chest] + rotation[chest] @ (rest[clavicle] - rest[chest])
    joint[upper] = joint[clavicle] + rotation[clavicle] @ (rest[upper] - rest[clavicle])
    joint[swing] = joint[upper]
    joint[fore] = joint[upper] + rotation[upper] @ (rest[fore] - rest[upper])
    joint[hand] = joint[fore] + rotation[fore] @ (rest[hand] - rest[fore])
    if not state.girdle[side].any():
        return np.eye(3)
    following = clavicle_rotation(side, in_chest @ axis, np.zeros(2))
    return np.asarray(rotation[clavicle] @ (rotation[chest] @ following).T)


def landmarks(person: Person, bones: PosedBones) -> FloatArray:
    """The nine landmarks of the recording format, (9, 3) metres, world."""
    at = {name: bones.joint[index] for name, index in BONE.items()}
    rest = rest_joints(person)
    rows = [at[f"upper_arm_{side}"] for side in SIDES] + [at[f"forearm_{side}"] for side in SIDES]
    for side, s in zip(SIDES, SIGN, strict=True):
        to_middle = np.array([s * person.hand / 2, 0.0, 0.0])
        rows.append(at[f"hand_{side}"] + bones.rotation[BONE[f"hand_{side}"]] @ to_middle)
    head = BONE["head"]
    rows.append(at["head"] + bones.rotation[head] @ (head_centre(person) - rest[head]))
    rows += [at[f"thigh_{side}"] for side in SIDES]
    return np.array(rows)


def head_centre(person: Person) -> FloatArray:
    """Centre of the head at rest, (3,) metres."""
    shoulder_z = rest_joints(person)[BONE["upper_arm_left"], 2]
    return np.array([0.0, 0.0, shoulder_z + person.shoulder_to_head])

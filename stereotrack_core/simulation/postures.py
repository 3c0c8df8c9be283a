"""Postures told by where the hands are, steps along a path, smooth ways through postures."""

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.simulation.skeleton import (
    BONE,
    SIDES,
    SIGN,
    JointState,
    Person,
    between,
    clavicle_rotation,
    difference,
    minimum_jerk,
    moved,
    posed_bones,
    rest_joints,
    two_links,
)

Pair = tuple[float, float]
Triple = tuple[float, float, float]


@dataclass(frozen=True)
class Arm:
    """Where a wrist is; `bend`, `turn`: degrees by which the hand tilts to palm and thumb."""

    wrist: Triple
    """Out, forward, up; from the shoulder in the chest's axes, in lengths of the stretched arm;
    "out" is away from the body on both sides. The shoulder is where it is at rest, moved by what
    the posture asks of it, so that a lifted shoulder lifts the hand. With `at_foot`: from the ankle
    of the same side in the world's axes, in metres."""
    elbow: Triple = (0.0, -1.0, 0.0)  # out, forward, up; direction to which the elbow points
    bend: float = 0.0
    turn: float = 0.0
    at_foot: bool = False


HANGING = Arm((0.20, 0.10, -0.955), (0.25, -1.0, 0.0), bend=6.0)
STRETCHED = Arm((0.999, 0.0, 0.0))


@dataclass(frozen=True)
class Posture:
    """One key of a motion; angles in degrees, lengths in shares of the leg.

    `nod` and `look`: the head: down, and to the left. `drop` and `back`: the hips: below standing
    height, and backwards. `lifted` and `forward`: (left, right); the shoulders: up and forward,
    beside what follows the arms. From the T pose people get about 35 up, 10 down, 25 forward and 20
    back in all, of which up to 10 up, 6 down and 9 forward or back follow.
    """

    left: Arm = HANGING
    right: Arm = HANGING
    lean: Triple = (0.0, 0.0, 0.0)  # (pelvis, waist, chest); forward tilt of each
    twist: float = 0.0  # turn of the trunk to the left, shared by waist and chest
    side: float = 0.0  # tilt of the trunk to the right
    nod: float = 0.0
    look: float = 0.0
    drop: float = 0.02
    back: float = 0.0
    sway: float = 0.0  # the hips to the right
    lifted: Pair = (0.0, 0.0)
    forward: Pair = (0.0, 0.0)


def _turn_about(axis: Triple, degrees: float) -> FloatArray:
    return rotation_from_vector(np.radians(degrees) * np.asarray(axis))


def state_of(
    person: Person,
    posture: Posture,
    place: FloatArray | None = None,
    heading: float = 0.0,
    ankles: FloatArray | None = None,
) -> JointState:
    """Joints of `person` in a posture; arms by inverse kinematics on the bent trunk.

    `place` (2,), world, metres, is the origin if not given; `heading` is in radians to the left of
    north; `ankles` (2, 3), world, metres, are beside each other if not given.
    """
    rest = rest_joints(person)
    facing = rotation_from_vector(np.array([0.0, 0.0, heading]))
    x, y = (0.0, 0.0) if place is None else place
    if ankles is None:
        beside = rest[[BONE["foot_left"], BONE["foot_right"]]]
        ankles = beside @ facing.T + np.array([x, y, 0.0])
    shift = np.array([posture.sway, -posture.back, -posture.drop]) * person.leg
    position = np.array([x, y, rest[0, 2]]) + facing @ shift
    identity = np.tile(np.eye(3), (2, 1, 1))
    bare = JointState(
        position, _trunk(posture, facing), identity, np.zeros(2), identity, ankles,
        np.tile(facing, (2, 1, 1)), np.radians([posture.lifted, posture.forward]).T,
    )  # fmt: skip
    return _with_arms(person, bare, posture.left, posture.right)


def _with_arms(person: Person, state: JointState, left: Arm, right: Arm) -> JointState:
    bones = posed_bones(person, state)
    chest = BONE["chest"]
    rotations, flexions, hands = [], [], []
    for side, arm in enumerate((left, right)):
        mirror, own = np.array([SIGN[side], 1.0, 1.0]), state.girdle[side]
        if arm.at_foot:
            foot = state.feet[side] @ (np.asarray(arm.wrist) * mirror)
            world = bones.joint[BONE[f"foot_{SIDES[side]}"]] + foot
            wrist = bones.rotation[chest].T @ (world - bones.joint[chest])
        else:
            shoulder = _shoulder(person, side, own)
            wrist = shoulder + np.asarray(arm.wrist) * mirror * person.arm
        rotation, flexion = _reach(person, side, wrist, np.asarray(arm.elbow) * mirror, own)
        rotations.append(rotation)
        flexions.append(flexion)
        towards_palm = _turn_about((0.0, SIGN[side], 0.0), arm.bend)
        hands.append(towards_palm @ _turn_about((0.0, 0.0, SIGN[side]), arm.turn))
    arms, elbows = np.array(rotations), np.array(flexions)
    return replace(state, arms=arms, elbows=elbows, hands=np.array(hands))


def _reach(
    person: Person, side: int, wrist: FloatArray, elbow: FloatArray, own: FloatArray
) -> tuple[FloatArray, float]:
    """Rotation and flexion that bring the wrist to `wrist` (3,), from the chest's joint."""
    rest = rest_joints(person)
    clavicle = rest[BONE[f"clavicle_{SIDES[side]}"]] - rest[BONE["chest"]]
    to_shoulder = rest[BONE[f"upper_arm_{SIDES[side]}"]] - rest[BONE["chest"]] - clavicle
    axis = np.array([SIGN[side], 0.0, 0.0])
    at_rest = np.stack([axis, [0, 0, SIGN[side]], np.cross(axis, [0, 0, SIGN[side]])], axis=1)
    girdle = clavicle_rotation(side, np.zeros(3), own)
    for _ in range(4):
        shoulder = clavicle + girdle @ to_shoulder
        links = two_links(wrist - shoulder, person.upper_arm, person.forearm, elbow)
        girdle = clavicle_rotation(side, links.first_frame[:, 0], own)
    return links.first_frame @ at_rest.T, links.flexion


def _shoulder(person: Person, side: int, own: FloatArray) -> FloatArray:
    """From the chest's joint to the shoulder of a level arm at the side, (3,)."""
    rest = rest_joints(person)
    clavicle, shoulder = (rest[BONE[f"{bone}_{SIDES[side]}"]] for bone in ("clavicle", "upper_arm"))
    moved = clavicle_rotation(side, np.zeros(3), own) - np.eye(3)
    return np.asarray(shoulder - rest[BONE["chest"]] + moved @ (shoulder - clavicle))


def _trunk(posture: Posture, facing: FloatArray) -> FloatArray:
    pelvis, waist, chest = posture.lean
    forward = (-1.0, 0.0, 0.0)
    up, ahead = (0.0, 0.0, 1.0), (0.0, 1.0, 0.0)
    half_turn = _turn_about(up, posture.twist / 2) @ _turn_about(ahead, posture.side / 2)
    gaze = _turn_about(up, posture.look / 2) @ _turn_about(forward, posture.nod / 2)
    bent = [_turn_about(forward, tilt) @ half_turn for tilt in (waist, chest)]
    return np.array([facing @ _turn_about(forward, pelvis), *bent, gaze, gaze])


_STRIDE = 0.62
_LIFT = 0.085


@dataclass(frozen=True, eq=False)
class Path:
    """A way on the floor, `length` metres long.

    `at` says after how many metres somebody is where, (2,) world, with which heading in radians
    left of north.
    """

    at: Callable[[float], tuple[FloatArray, float]]
    length: float


def circle_path(start: FloatArray, heading: float, radius: float) -> Path:
    """Once round a circle that leaves `start` along `heading`; right for a positive radius."""
    right = np.array([np.cos(heading), np.sin(heading)])
    centre = start + radius * right

    def at(distance: float) -> tuple[FloatArray, float]:
        angle = -distance / radius
        c, s = np.cos(angle), np.sin(angle)
        out = start - centre
        turned = np.array([c * out[0] - s * out[1], s * out[0] + c * out[1]])
        return centre + turned, heading + angle

    return Path(at, 2 * np.pi * abs(radius))


def line_path(start: FloatArray, end: FloatArray) -> Path:
    """Straight from `start` to `end`, (2,) world."""
    way = end - start
    length = float(np.linalg.norm(way))
    heading = float(np.arctan2(-way[0], way[1]))

    def at(distance: float) -> tuple[FloatArray, float]:
        return start + way * (distance / length), heading

    return Path(at, length)


def walk(person: Person, path: Path, frames: int) -> list[JointState]:
    """States of somebody who walks along the path, from standing to standing."""
    steps = max(2, round(path.length / (_STRIDE * person.leg / 0.86)))
    return [_walking(person, path, steps, (k + 1) / frames) for k in range(frames)]


def _walking(person: Person, path: Path, steps: int, time: float) -> JointState:
    """State at the share `time` of the walk; foot `n % 2` swings during step n."""
    phase = min(time * (steps + 1), steps + 1 - 1e-9)
    step = int(phase)
    swing = phase - step
    stride = path.length / steps
    gone = path.length * _eased(time, 1.0 / (steps + 1))
    place, heading = path.at(gone)
    ankles, feet = [], []
    for side in (0, 1):
        # strides gone by the foot before and after the step: it swings in every second one
        before, after = (
            max((min(n + 1, steps) for n in range(count) if n % 2 == side), default=0)
            for count in (step, step + 1)
        )
        moving = minimum_jerk(swing) if after > before else 0.0
        distance = stride * (before + (after - before) * moving)
        lift = _LIFT * np.sin(np.pi * swing) ** 2 if after > before else 0.0
        pitch = -28.0 * np.sin(2 * np.pi * swing) * (0.7 if after > before else 0.0)
        ankle, foot = _foot(person, path, side, distance, lift, pitch)
        ankles.append(ankle)
        feet.append(foot)
    push = np.sin(np.pi * swing) * (1 if step % 2 else -1) * (0 < step < steps)
    left, right = _swinging(-push), _swinging(push)
    lean = (3.0, 1.0, 0.0)
    posture = Posture(left, right, lean, twist=5.0 * push, drop=0.02, sway=-0.012 * push)
    state = state_of(person, posture, place, heading, np.array(ankles))
    return replace(state, feet=np.array(feet))


def _foot(
    person: Person, path: Path, side: int, distance: float, lift: float, pitch: float
) -> tuple[FloatArray, FloatArray]:
    place, heading = path.at(distance)
    facing = _turn_about((0.0, 0.0, 1.0), np.degrees(heading))
    rest = rest_joints(person)[BONE["foot_right" if side else "foot_left"]]
    ankle = np.array([*place, 0.0]) + facing @ (rest * [0.75, 1.0, 1.0])
    ankle[2] += lift + 0.13 * abs(np.sin(np.radians(pitch)))
    return ankle, facing @ _turn_about((1.0, 0.0, 0.0), pitch)


def _swinging(share: float) -> Arm:
    out, forward, up = HANGING.wrist
    return Arm((out, forward + 0.38 * share, up + 0.10 * abs(share)), (0.35, -1.0, -0.1), bend=4.0)


def _eased(t: float, ramp: float) -> float:
    """From 0 to 1 at constant speed, with ramps of length `ramp` at both ends."""
    speed = 1 / (1 - ramp)
    if t < ramp:
        return speed * t * t / (2 * ramp)
    if t > 1 - ramp:
        return 1 - speed * (1 - t) ** 2 / (2 * ramp)
    return speed * (t - ramp / 2)


def _way(times: FloatArray, states: Sequence[JointState]) -> Callable[[float], JointState]:
    """Interpolate joint states at ascending times in seconds; the first is held before.

    Between two keys a cubic Bezier curve on the rotations (Shoemake 1985,
    doi:10.1145/325165.325242); the velocity at a key is the harmonic mean of those before and
    after, none where they differ in sign (Fritsch and Butland 1984, doi:10.1137/0905021), so that
    nothing swings beyond its keys.
    """
    steps = [difference(a, b) for a, b in itertools.pairwise(states)]
    speeds = np.array(steps) / np.diff(times)[:, None]
    velocities = np.zeros((len(states), speeds.shape[1]))
    before, after = speeds[:-1], speeds[1:]
    same = before * after > 0
    total = np.where(same, before + after, 1.0)
    velocities[1:-1] = np.where(same, 2 * before * after / total, 0.0)

    def at(time: float) -> JointState:
        if time <= times[0]:
            return states[0]
        k = min(int(np.searchsorted(times, time, side="left")), len(times) - 1)
        length = times[k] - times[k - 1]
        share = float(min((time - times[k - 1]) / length, 1.0))
        points = [
            states[k - 1],
            moved(states[k - 1], velocities[k - 1] * length / 3),
            moved(states[k], -velocities[k] * length / 3),
            states[k],
        ]
        while len(points) > 1:
            points = [between(a, b, share) for a, b in itertools.pairwise(points)]
        return points[0]

    return at


Key = tuple[float, Posture]  # the seconds that it takes to reach a posture from the one before


@dataclass(frozen=True, eq=False)
class Motion:
    """A named motion at pace 1; `states` gives those of a person in a number of frames."""

    seconds: float
    states: Callable[[Person, int], list[JointState]]


def keyed(*keys: Key) -> Motion:
    """A motion through keys; the first key's seconds are spent holding it."""
    times = np.cumsum([seconds for seconds, _ in keys])

    def states(person: Person, frames: int) -> list[JointState]:
        way = _way(times, [state_of(person, posture) for _, posture in keys])
        return [way(times[-1] * frame / max(frames - 1, 1)) for frame in range(frames)]

    return Motion(float(times[-1]), states)

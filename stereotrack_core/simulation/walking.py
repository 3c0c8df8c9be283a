"""Steps along a path: feet planted on the floor in turn, arms swinging against them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.simulation.people import Person
from stereotrack_core.simulation.postures import HANGING, Arm, Posture, Stand, state_of, turn_about
from stereotrack_core.simulation.skeleton import BONE, JointState, rest_joints

_STRIDE = 0.62
_LIFT = 0.085


@dataclass(frozen=True, eq=False)
class Path:
    """A way on the floor.

    Attributes
    ----------
    at : callable
        Distance gone in metres to (2,) world and the heading in radians left of north.
    length : float
        Metres.
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
        before, after = _plants(step, side, steps)
        moving = _smooth(swing) if after > before else 0.0
        distance = stride * (before + (after - before) * moving)
        lift = _LIFT * np.sin(np.pi * swing) ** 2 if after > before else 0.0
        pitch = -28.0 * np.sin(2 * np.pi * swing) * (0.7 if after > before else 0.0)
        ankle, foot = _foot(person, path, side, distance, lift, pitch)
        ankles.append(ankle)
        feet.append(foot)
    push = np.sin(np.pi * swing) * (1 if step % 2 else -1) * (0 < step < steps)
    arms = [_swinging(-push), _swinging(push)]
    posture = Posture(
        arms[0], arms[1], (3.0, 1.0, 0.0), twist=5.0 * push, drop=0.02, sway=-0.012 * push
    )
    state = state_of(person, posture, Stand(place, heading, np.array(ankles)))
    return replace(state, feet=np.array(feet))


def _plants(step: int, side: int, steps: int) -> tuple[int, int]:
    """Strides gone by one foot before and after a step."""

    def planted(count: int) -> int:
        moved = [n for n in range(count) if n % 2 == side]
        return min(moved[-1] + 1, steps) if moved else 0

    return planted(step), planted(step + 1)


def _foot(
    person: Person, path: Path, side: int, distance: float, lift: float, pitch: float
) -> tuple[FloatArray, FloatArray]:
    place, heading = path.at(distance)
    facing = turn_about((0.0, 0.0, 1.0), np.degrees(heading))
    rest = rest_joints(person)[BONE["foot_right" if side else "foot_left"]]
    ankle = np.array([*place, 0.0]) + facing @ (rest * [0.75, 1.0, 1.0])
    ankle[2] += lift + 0.13 * abs(np.sin(np.radians(pitch)))
    return ankle, facing @ turn_about((1.0, 0.0, 0.0), pitch)


def _swinging(share: float) -> Arm:
    out, forward, up = HANGING.wrist
    return Arm((out, forward + 0.38 * share, up + 0.10 * abs(share)), (0.35, -1.0, -0.1), bend=4.0)


def _smooth(t: float) -> float:
    return t * t * t * (t * (6 * t - 15) + 10)


def _eased(t: float, ramp: float) -> float:
    """From 0 to 1 at constant speed, with ramps of length `ramp` at both ends."""
    speed = 1 / (1 - ramp)
    if t < ramp:
        return speed * t * t / (2 * ramp)
    if t > 1 - ramp:
        return 1 - speed * (1 - t) ** 2 / (2 * ramp)
    return speed * (t - ramp / 2)

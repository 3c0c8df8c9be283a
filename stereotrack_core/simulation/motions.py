"""Named motions, and when a person does which of them."""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import cycle

import numpy as np

from stereotrack_core.errors import InputError
from stereotrack_core.recording.description import Segment
from stereotrack_core.simulation.postures import (
    STRETCHED,
    Arm,
    Motion,
    Posture,
    circle_path,
    keyed,
    walk,
)
from stereotrack_core.simulation.rig import SceneOptions
from stereotrack_core.simulation.skeleton import JointState, Person, between, minimum_jerk

T_POSE = Posture(STRETCHED, STRETCHED)
_STANDING = Posture()


def _t_pose() -> Motion:
    lifted = Posture(Arm((0.995, 0.02, 0.03)), Arm((0.995, 0.01, -0.02)), nod=1.0)
    return keyed((0.4, T_POSE), (0.4, lifted), (0.4, T_POSE))


def _arms_at_sides() -> Motion:
    swayed = Posture(sway=0.02, twist=4.0, look=12.0)
    back = Posture(sway=-0.015, twist=-3.0, look=-10.0)
    return keyed((0.3, _STANDING), (1.2, swayed), (1.4, back), (1.1, _STANDING))


def _travolta() -> Motion:
    low = Arm((-0.60, 0.62, -0.42), (0.5, -0.2, -1.0), bend=4.0)
    front = Arm((0.10, 0.90, 0.12), (0.8, -0.2, -1.0))
    high = Arm((0.60, 0.32, 0.70), (0.5, -0.8, -0.6), turn=6.0)
    hip = Arm((0.30, 0.16, -0.70), (0.8, -1.0, 0.1), bend=8.0)
    hip_low = Arm((0.27, 0.24, -0.78), (0.8, -1.0, 0.1), bend=8.0)
    down = Posture(hip, low, (4.0, 4.0, 4.0), twist=8.0, sway=0.03, look=6.0, drop=0.03)
    middle = Posture(hip_low, front, (2.0, 2.0, 2.0), drop=0.04)
    up = Posture(hip_low, high, twist=-10.0, sway=-0.03, look=-14.0, drop=0.03)
    # up and down again; the middle leads the hand round the body
    stroke = [(0.31, middle), (0.31, up), (0.31, middle), (0.31, down)]
    return keyed((0.1, down), *stroke, *stroke, *stroke)


def _whip() -> Motion:
    ready = Arm((0.45, 0.55, 0.10), (0.9, -0.3, -0.7))
    wound = Arm((0.34, -0.20, 0.80), (0.9, 0.5, 0.0), bend=-10.0)
    struck = Arm((0.02, 0.985, -0.02), (0.9, 0.0, -0.4), bend=10.0)
    through = Arm((-0.42, 0.72, -0.50), (0.7, 0.0, -0.8), bend=8.0)
    balance = Arm((0.42, 0.42, -0.60), (0.6, -1.0, -0.2))
    keys = (
        (0.2, Posture(balance, ready)),
        (0.9, Posture(balance, wound, (-3.0, -4.0, -4.0), twist=-16.0, look=8.0)),
        (0.7, Posture(balance, struck, (6.0, 5.0, 5.0), twist=12.0, drop=0.04)),
        (0.5, Posture(balance, through, (8.0, 7.0, 7.0), twist=20.0, drop=0.05)),
        (0.7, Posture(balance, ready)),
    )
    return keyed(*keys)


def _tie_shoes() -> Motion:
    half = (26.0, 16.0, 12.0)
    deep = (50.0, 26.0, 18.0)
    reaching = Arm((0.34, 0.64, -0.58), (1.0, -0.3, 0.2))
    knees = Posture(reaching, reaching, half, nod=12.0, drop=0.22, back=0.12)

    def tying(left: Arm, right: Arm) -> Posture:
        return Posture(left, right, deep, nod=14.0, drop=0.46, back=0.17)

    def lace(across: float, ahead: float, up: float) -> Arm:
        return Arm((across, ahead, up), (1.0, 0.1, 0.3), bend=14.0, at_foot=True)

    near = tying(lace(0.0, 0.28, 0.13), lace(0.0, 0.28, 0.13))
    pulled = tying(lace(0.05, 0.23, 0.20), lace(0.04, 0.25, 0.22))
    crossed = tying(lace(-0.05, 0.27, 0.14), lace(-0.05, 0.22, 0.18))
    return keyed(
        (0.1, _STANDING), (0.7, knees), (0.8, near), (0.5, pulled), (0.5, crossed),
        (0.5, pulled), (0.4, near), (0.8, knees), (0.7, _STANDING),
    )  # fmt: skip


def _crossing() -> tuple[Posture, Posture, Posture]:
    out = (0.7, 0.1, -1.0)
    front = Posture(
        Arm((0.05, 0.66, -0.40), out, bend=4.0), Arm((0.05, 0.76, -0.36), out, bend=4.0)
    )
    inner = Arm((-0.50, 0.34, -0.43), (0.8, 0.2, -1.0), bend=16.0)
    outer = Arm((-0.50, 0.56, -0.23), (0.8, 0.2, -1.0), bend=14.0)
    crossed = Posture(inner, outer, nod=4.0)
    lower = Posture(
        Arm((-0.47, 0.35, -0.50), (0.8, 0.2, -1.0), bend=12.0),
        Arm((-0.48, 0.57, -0.31), (0.8, 0.2, -1.0), bend=10.0),
        twist=5.0,
        look=10.0,
    )
    return front, crossed, lower


def _cross_arms() -> Motion:
    front, crossed, lower = _crossing()
    return keyed(
        (0.2, _STANDING), (0.9, front), (0.8, crossed), (0.8, lower),
        (0.7, crossed), (0.5, lower), (0.8, front), (0.9, _STANDING),
    )  # fmt: skip


def _hold_arms_crossed() -> Motion:
    """From a raised right arm to crossed arms, held for 5 of 13 s (thesis, figure 4.12)."""
    front, crossed, lower = _crossing()
    raised = Posture(right=Arm((0.45, 0.72, 0.48), (0.6, -0.5, -1.0)), twist=-4.0, look=-15.0)
    ahead = Posture(right=Arm((0.22, 0.94, 0.10), (0.6, -0.5, -1.0)), twist=4.0)
    return keyed(
        (0.5, raised), (1.8, ahead), (2.2, front), (2.0, crossed), (2.5, lower),
        (2.5, crossed), (0.7, front), (0.8, _STANDING),
    )  # fmt: skip


def _point() -> Motion:
    def at(wrist: tuple[float, float, float], twist: float, look: float) -> Posture:
        return Posture(right=Arm(wrist, (0.6, -0.5, -1.0)), twist=twist, look=look)

    ahead = at((0.22, 0.94, 0.10), 4.0, 0.0)
    aside = at((0.90, 0.36, 0.16), -10.0, -35.0)
    upwards = at((0.45, 0.72, 0.48), -4.0, -15.0)
    return keyed(
        (0.2, _STANDING), (0.8, ahead), (0.4, ahead), (0.7, aside), (0.4, aside),
        (0.6, upwards), (0.9, _STANDING),
    )  # fmt: skip


def _shrug() -> Motion:
    """Shoulders on their own while the arms hang; sizes within Posture's."""
    up = Posture(lifted=(27.0, 27.0), nod=2.0)
    left = Posture(lifted=(27.0, -2.0), side=2.0)
    right = Posture(lifted=(-2.0, 27.0), side=-2.0)
    high = Posture(lifted=(22.0, 22.0))
    back = Posture(lifted=(8.0, 8.0), forward=(-13.0, -13.0), lean=(0.0, 0.0, -2.0))
    low = Posture(lifted=(-5.0, -5.0))
    ahead = Posture(lifted=(8.0, 8.0), forward=(16.0, 16.0), lean=(0.0, 0.0, 2.0))
    return keyed(
        (0.3, _STANDING), (0.9, up), (0.5, up), (0.9, _STANDING),
        (0.8, left), (0.4, left), (0.8, _STANDING),
        (0.8, right), (0.4, right), (0.8, _STANDING),
        (0.7, high), (0.6, back), (0.6, low), (0.6, ahead), (0.6, high),
        (0.8, _STANDING),
    )  # fmt: skip


def _reach() -> Motion:
    """Far ahead, overhead with either arm, and drawn back: the shoulders go along."""
    down = (0.6, -0.2, -1.0)
    front = Arm((0.06, 0.94, -0.06), down)
    far = Arm((0.02, 1.06, 0.0), down)
    above = Arm((0.14, 0.16, 1.02), (1.0, 0.3, 0.0))
    bent = Arm((0.16, 0.52, -0.26), (0.6, -0.6, -1.0))
    drawn = Arm((0.20, 0.22, -0.34), (0.35, -1.0, -0.25))
    level = Posture(front, front)
    pushed = Posture(far, far, forward=(16.0, 16.0), lean=(2.0, 2.0, 2.0))
    left = Posture(left=above, lifted=(22.0, 0.0), side=3.0, nod=-6.0)
    right = Posture(right=above, lifted=(0.0, 22.0), side=-3.0, nod=-6.0)
    back = Posture(drawn, drawn, forward=(-13.0, -13.0), lean=(0.0, -1.0, -3.0))
    return keyed(
        (0.2, _STANDING), (0.9, level), (0.6, pushed), (0.4, pushed),
        (0.6, level), (0.9, left), (0.4, left), (0.9, level),
        (0.9, right), (0.4, right), (0.9, level), (0.6, Posture(bent, bent)),
        (0.5, back), (0.5, back), (0.9, _STANDING),
    )  # fmt: skip


def _round(seconds: float, radius: float) -> Motion:
    path = circle_path(np.zeros(2), 0.0, radius)
    return Motion(seconds, lambda person, frames: walk(person, path, frames))


MOTIONS: dict[str, Motion] = {
    "t-pose": _t_pose(),
    "whip": _whip(),
    "travolta": _travolta(),
    "tie-shoes": _tie_shoes(),
    "cross-arms": _cross_arms(),
    "hold-arms-crossed": _hold_arms_crossed(),
    "arms-at-sides": _arms_at_sides(),
    "walk": _round(5.0, 0.45),
    "point": _point(),
    "leave-and-return": _round(9.5, 1.7),
    "shrug": _shrug(),
    "reach": _reach(),
}
"""All motions by the name for ``--motion``."""


def motion_names(motion: str) -> tuple[str, ...]:
    """The names in a chain like ``t-pose+whip``; raises :class:`InputError` if unknown."""
    names = tuple(name.strip() for name in motion.split("+"))
    for name in names:
        if name not in MOTIONS:
            remedy = f"Use one of {', '.join(MOTIONS)}, or several joined by +."
            raise InputError(f"unknown motion {name!r}", "--motion", remedy)
    return names


_BLEND_SECONDS = 0.8


@dataclass(frozen=True)
class Part:
    """A motion of ``MOTIONS`` from a frame on, the fewer the faster; `name`: of its segment."""

    name: str
    motion: str
    first: int
    frames: int

    @property
    def end(self) -> int:
        """First frame after it."""
        return self.first + self.frames


@dataclass(frozen=True, eq=False)
class Chain:
    """States of all frames, and the named stretches among them."""

    states: tuple[JointState, ...]
    segments: tuple[Segment, ...]


def parts_of(names: Sequence[str], frames: int, options: SceneOptions) -> tuple[Part, ...]:
    """Parts one after the other until the frames are filled, by default from a T pose on."""
    blend = max(1, round(_BLEND_SECONDS * options.fps / options.pace))
    opening = ["t-pose"] if options.t_pose_first and names[0] != "t-pose" else []
    parts: list[Part] = []
    for name in itertools.chain(opening, cycle(names)):
        first = parts[-1].end + blend if parts else 0
        count = math.ceil(MOTIONS[name].seconds * options.fps / options.pace)
        parts.append(Part(name, name, first, max(2, count)))
        if parts[-1].end >= frames:
            break
    return tuple(parts)


def scheduled(person: Person, parts: Sequence[Part], frames: int) -> Chain:
    """States of all frames; between two parts the person goes smoothly from one to the other.

    Before the first part its first state is held, after the last part its last; of a part that
    does not end in time the rest is left out. Parts must not overlap.
    """
    states: list[JointState] = []
    for part in parts:
        own = MOTIONS[part.motion].states(person, part.frames)
        before, count = states[-1] if states else own[0], part.first - len(states)
        shares = (minimum_jerk((k + 1) / (count + 1)) for k in range(count))
        states += [between(before, own[0], share) for share in shares]
        states += own
    states += [states[-1]] * (frames - len(states))
    segments = [Segment(p.name, p.first, min(p.end, frames)) for p in parts if p.first < frames]
    return Chain(tuple(states[:frames]), tuple(segments))

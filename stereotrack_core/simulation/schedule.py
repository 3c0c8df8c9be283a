"""Motions at given frames: what a person does when, and how long each motion takes."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import cycle

from stereotrack_core.errors import InputError
from stereotrack_core.recording.description import Segment
from stereotrack_core.simulation.motions import MOTIONS
from stereotrack_core.simulation.people import Person
from stereotrack_core.simulation.skeleton import JointState, between, minimum_jerk

_BLEND_SECONDS = 0.8


@dataclass(frozen=True)
class Part:
    """A motion that begins at a frame and takes so many; the fewer, the faster.

    `name` is that of its segment, `motion` one of ``MOTIONS``.
    """

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


def scheduled(person: Person, parts: Sequence[Part], frames: int) -> Chain:
    """States of all frames; between two parts the person goes smoothly from one to the other.

    Before the first part its first state is held, after the last part its last. Raises InputError
    for parts that overlap, do not fit, or name an unknown motion.
    """
    _check(parts, frames)
    return _joined(person, parts, frames)


def chain(
    person: Person,
    names: Sequence[str],
    frames: int,
    *,
    fps: float,
    pace: float = 1.0,
    t_pose_first: bool = True,
) -> Chain:
    """Join motions to a sequence of `frames` states.

    The first motion is a T pose unless told otherwise; the chain is repeated until the
    frames are filled. `pace` divides all durations: 0.5 is half as fast.
    """
    blend = max(1, round(_BLEND_SECONDS * fps / pace))
    opening = ["t-pose"] if t_pose_first and names[0] != "t-pose" else []
    parts: list[Part] = []
    for name in itertools.chain(opening, cycle(names)):
        first = parts[-1].end + blend if parts else 0
        count = max(2, math.ceil(MOTIONS[name].seconds * fps / pace))
        parts.append(Part(name, name, first, count))
        if parts[-1].end >= frames:
            break
    return _joined(person, parts, frames)


def _joined(person: Person, parts: Sequence[Part], frames: int) -> Chain:
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


def filled(
    fixed: Sequence[Part], fillers: Sequence[tuple[str, int]], until: int, blend: int
) -> tuple[Part, ...]:
    """Put fillers into the gaps between fixed parts, which are in their order, up to frame `until`.

    Fillers (motion, frames) come in turn and take about so many frames: those of one gap are
    stretched alike until they fill it. Before every part are `blend` frames to go over to it.
    """
    turn = cycle(fillers)
    parts: list[Part] = []
    at = 0
    for part in (*fixed, None):
        end = until if part is None else part.first
        parts += _gap_filled(at, end - (0 if part is None else blend), turn, blend)
        if part is not None:
            parts.append(part)
            at = part.end
    return tuple(parts)


def _gap_filled(at: int, end: int, turn: Iterator[tuple[str, int]], blend: int) -> Iterator[Part]:
    chosen: list[tuple[str, int]] = []
    needed = 0
    while end - at - needed > 0:
        motion, frames = next(turn)
        if chosen and needed + blend + frames / 2 > end - at:
            break
        if not chosen and blend + frames / 2 > end - at:
            return
        chosen.append((motion, frames))
        needed += blend + frames
    moving = sum(frames for _, frames in chosen)
    scale = (end - at - blend * len(chosen)) / moving if moving else 1.0
    for motion, frames in chosen:
        length = max(2, int(frames * scale))
        yield Part(motion, motion, at + blend, length)
        at += blend + length


def _check(parts: Sequence[Part], frames: int) -> None:
    at = 0
    for part in parts:
        if part.motion not in MOTIONS:
            raise InputError(
                f"unknown motion {part.motion!r}",
                where=part.name,
                remedy=f"Use one of {', '.join(MOTIONS)}.",
            )
        if part.first < at or part.frames < 2 or part.end > frames:
            raise InputError(
                f"{part.name} at {part.first}:{part.end} overlaps another motion or does not fit",
                where="parts",
                remedy=f"Motions must follow each other within 0:{frames}, each with at least two "
                "frames.",
            )
        at = part.end
    if not parts:
        raise InputError("there are no motions", where="parts", remedy="Give at least one motion.")

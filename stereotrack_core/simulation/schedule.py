"""Motions at given frames: what a person does when, and how long each motion takes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import cycle

from stereotrack_core.errors import InputError
from stereotrack_core.recording.description import Segment
from stereotrack_core.simulation.motions import MOTIONS, Chain, minimum_jerk
from stereotrack_core.simulation.people import Person
from stereotrack_core.simulation.skeleton import JointState, between


@dataclass(frozen=True)
class Part:
    """A motion that begins at a frame and takes so many.

    Attributes
    ----------
    name : str
        Of the segment.
    motion : str
        A name of ``MOTIONS``.
    first, frames : int
        The fewer frames, the faster the motion.
    """

    name: str
    motion: str
    first: int
    frames: int

    @property
    def end(self) -> int:
        """First frame after it."""
        return self.first + self.frames


def scheduled(person: Person, parts: Sequence[Part], frames: int) -> Chain:
    """States of all frames; between two parts the person goes smoothly from one to the other.

    Before the first part its first state is held, after the last part its last.

    Raises
    ------
    InputError
        For parts that overlap, do not fit, or name an unknown motion.
    """
    _check(parts, frames)
    states: list[JointState] = []
    for part in parts:
        own = MOTIONS[part.motion].states(person, part.frames)
        states += _towards(states[-1] if states else own[0], own[0], part.first - len(states))
        states += own
    states += [states[-1]] * (frames - len(states))
    segments = tuple(Segment(part.name, part.first, part.end) for part in parts)
    return Chain(tuple(states), segments)


def filled(
    fixed: Sequence[Part], fillers: Sequence[tuple[str, int]], until: int, blend: int
) -> tuple[Part, ...]:
    """Put fillers into the gaps between fixed parts, in turn.

    Parameters
    ----------
    fixed : sequence of Part
        In their order.
    fillers : sequence of (motion, frames)
        Each takes about so many frames: those of one gap are stretched alike until they fill it.
    until : int
        Frame up to which gaps are filled.
    blend : int
        Frames before every part to go over to it.
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


def _towards(a: JointState, b: JointState, count: int) -> list[JointState]:
    return [between(a, b, minimum_jerk((k + 1) / (count + 1))) for k in range(count)]


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

"""Somebody else, who walks through the background now and then."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stereotrack_core.simulation.actor import Actor, actor
from stereotrack_core.simulation.options import SceneOptions
from stereotrack_core.simulation.people import PEOPLE, Person
from stereotrack_core.simulation.skeleton import JointState
from stereotrack_core.simulation.walking import line_path, walk

_WAYS = (((-3.9, -2.2), (3.3, -2.4)), ((3.3, 2.3), (-3.0, 2.4)))
"""Beyond the working volume, to and fro, on the floor."""
_PAUSE_SECONDS, _WALK_SECONDS = 2.0, 6.5


@dataclass(frozen=True, eq=False)
class Passer:
    """A second person.

    Attributes
    ----------
    actor : Actor
    states : tuple of JointState or None
        One for each frame; None while away.
    """

    actor: Actor
    states: tuple[JointState | None, ...]

    def state(self, frame: int) -> JointState | None:
        """Joints in a frame, or None while away."""
        return self.states[frame]


def passer_by(main: Person, options: SceneOptions, frames: int) -> Passer:
    """Another person than `main`, who walks past, is away, and comes back elsewhere."""
    names = list(PEOPLE)
    other = PEOPLE[names[(names.index(main.name) + 1) % len(names)]]
    pause = round(_PAUSE_SECONDS * options.fps / options.pace)
    count = max(2, round(_WALK_SECONDS * options.fps / options.pace))
    states: list[JointState | None] = []
    trip = 0
    while len(states) < frames:
        states += [None] * pause
        start, end = _WAYS[trip % len(_WAYS)]
        states += walk(other, line_path(np.array(start), np.array(end)), count)
        trip += 1
    return Passer(actor(other, "striped"), tuple(states[:frames]))

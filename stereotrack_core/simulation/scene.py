"""Who does what in front of which cameras."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from itertools import cycle

import numpy as np

from stereotrack_core.arrays import FloatArray, ImageArray
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.simulation.actor import Actor, actor
from stereotrack_core.simulation.materials import noise_lattice
from stereotrack_core.simulation.options import SceneOptions
from stereotrack_core.simulation.people import PEOPLE, Person
from stereotrack_core.simulation.postures import line_path, walk
from stereotrack_core.simulation.render import CameraRenderer, Posed
from stereotrack_core.simulation.rig import sensor, stereo_rig
from stereotrack_core.simulation.room import room
from stereotrack_core.simulation.schedule import Chain, Part, chain, scheduled
from stereotrack_core.simulation.skeleton import JointState, landmarks, posed_bones

_WAYS = (((-3.9, -2.2), (3.3, -2.4)), ((3.3, 2.3), (-3.0, 2.4)))
"""Beyond the working volume, to and fro, on the floor."""
_PAUSE_SECONDS, _WALK_SECONDS = 2.0, 6.5


def _passer_by(
    main: Person, options: SceneOptions, frames: int
) -> tuple[Actor, Sequence[JointState | None]]:
    """Another person than `main`, who walks past, is away (None), and comes back elsewhere."""
    names = list(PEOPLE)
    other = PEOPLE[names[(names.index(main.name) + 1) % len(names)]]
    pause = round(_PAUSE_SECONDS * options.fps / options.pace)
    count = max(2, round(_WALK_SECONDS * options.fps / options.pace))
    states: list[JointState | None] = []
    for start, end in cycle(_WAYS):
        states += [None] * pause
        states += walk(other, line_path(np.array(start), np.array(end)), count)
        if len(states) >= frames:
            break
    return actor(other, "striped"), states


@dataclass(frozen=True, eq=False)
class Scene:
    """A person in a room, ready to be drawn.

    `passer` is somebody in the background, with the joints in each frame, None while away.
    """

    actor: Actor
    chain: Chain
    passer: tuple[Actor, Sequence[JointState | None]] | None
    cameras: Mapping[str, Camera]
    renderers: Mapping[str, CameraRenderer]

    def people(self, frame: int) -> tuple[list[Posed], FloatArray]:
        """Everybody in a frame, posed, and the landmarks (9, 3) of the one who matters."""
        bones = posed_bones(self.actor.person, self.chain.states[frame])
        people = [Posed(self.actor, *self.actor.posed(bones))]
        if self.passer is not None:
            other, states = self.passer
            if (state := states[frame]) is not None:
                people.append(Posed(other, *other.posed(posed_bones(other.person, state))))
        return people, landmarks(self.actor.person, bones)

    def picture(self, camera: str, people: Sequence[Posed], frame: int) -> ImageArray:
        """What a camera sees in a frame, (H, W) or (H, W, 3) uint8."""
        return self.renderers[camera].picture(people, frame)


def build_scene(
    person: Person,
    motions: Sequence[str],
    frames: int,
    views: tuple[str, ...],
    seed: int,
    options: SceneOptions,
    workers: Executor,
    parts: Sequence[Part] = (),
) -> Scene:
    """Dress the person, plan the motion, set up the cameras and draw the empty room.

    `parts` say what happens when; without any the motions follow each other.
    """
    cameras = stereo_rig(views, options, seed)
    things, lattice = room(furnished=options.furnished), noise_lattice(seed)

    def renderer(name: str) -> CameraRenderer:
        return CameraRenderer(cameras[name], sensor(options, seed, name), things, lattice)

    drawn = workers.map(renderer, cameras)
    if parts:
        moves = scheduled(person, parts, frames)
    else:
        moves = chain(
            person, motions, frames,
            fps=options.fps, pace=options.pace, t_pose_first=options.t_pose_first,
        )  # fmt: skip
    passer = _passer_by(person, options, frames) if options.second_person else None
    dressed = actor(person, options.clothes)
    return Scene(dressed, moves, passer, cameras, dict(zip(cameras, drawn, strict=True)))

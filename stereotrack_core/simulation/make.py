"""Simulated recordings: a person moves in a room, cameras look, the truth is kept."""

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass, field
from functools import partial
from itertools import cycle
from pathlib import Path

import numpy as np

from stereotrack_core.arrays import FloatArray, ImageArray
from stereotrack_core.atomic import filling
from stereotrack_core.compiled import load_before_threads
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.description import Cameras, Recording, Stream, View
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.recording.writing import VideoWriter, write_png, write_recording_description
from stereotrack_core.simulation import skeleton
from stereotrack_core.simulation.actor import Actor, actor
from stereotrack_core.simulation.motions import Chain, Part, motion_names, parts_of, scheduled
from stereotrack_core.simulation.postures import line_path, walk
from stereotrack_core.simulation.render import CameraRenderer, Posed
from stereotrack_core.simulation.rig import SceneOptions, rig, sensor, view_names
from stereotrack_core.simulation.room import noise_lattice, room
from stereotrack_core.simulation.shading import Lamp
from stereotrack_core.work import NO_WORK, Work

_WAYS = (((-3.9, -2.2), (3.3, -2.4)), ((3.3, 2.3), (-3.0, 2.4)))
"""Beyond the working volume, to and fro, on the floor."""
_PAUSE_SECONDS, _WALK_SECONDS = 2.0, 6.5


def _passer_by(
    main: skeleton.Person, options: SceneOptions, frames: int
) -> tuple[Actor, Sequence[skeleton.JointState | None]]:
    """Another person than `main`, who walks past, is away (None), and comes back elsewhere."""
    names = list(skeleton.PEOPLE)
    other = skeleton.PEOPLE[names[(names.index(main.name) + 1) % len(names)]]
    pause = round(_PAUSE_SECONDS * options.fps / options.pace)
    count = max(2, round(_WALK_SECONDS * options.fps / options.pace))
    states: list[skeleton.JointState | None] = []
    for start, end in cycle(_WAYS):
        states += [None] * pause
        states += walk(other, line_path(np.array(start), np.array(end)), count)
        if len(states) >= frames:
            break
    return actor(other, "striped"), states


@dataclass(frozen=True, eq=False)
class Scene:
    """A person in a room, ready to be drawn; `passer`: somebody else's joints, None while away."""

    actor: Actor
    chain: Chain
    passer: tuple[Actor, Sequence[skeleton.JointState | None]] | None
    cameras: Cameras
    renderers: Mapping[str, CameraRenderer]

    def people(self, frame: int) -> tuple[list[Posed], FloatArray]:
        """Everybody in a frame, posed, and the landmarks (9, 3) of the one who matters."""
        bones = skeleton.posed_bones(self.actor.person, self.chain.states[frame])
        people = [Posed(self.actor, *self.actor.posed(bones))]
        if self.passer is not None:
            other, states = self.passer
            if (state := states[frame]) is not None:
                people.append(Posed(other, *other.posed(skeleton.posed_bones(other.person, state))))
        return people, skeleton.landmarks(self.actor.person, bones)


@dataclass(frozen=True)
class Simulation:
    """What to simulate.

    Raises InputError for an unknown name, no frames or a negative seed.

    Examples
    --------
    >>> Simulation(person="P2", frames=60).motion
    'cross-arms'
    """

    person: str = "P1"  # P1 to P4
    motion: str = "cross-arms"
    """A name of ``MOTIONS``, or several joined by ``+``; repeated until the frames are full."""
    frames: int = 120
    views: str = "NOSW"  # some of N, O, S, W
    seed: int = 0  # the same seed gives the same pictures and truth
    options: SceneOptions = field(default_factory=SceneOptions)
    parts: tuple[Part, ...] = ()  # what happens at which frames, instead of `motion`

    def __post_init__(self) -> None:
        if self.frames < 1:
            what = f"{self.frames} frames cannot be simulated"
            raise InputError(what, "--frames", "Give 1 or more.")
        if self.seed < 0:
            raise InputError(f"the seed {self.seed} is negative", "--seed", "Give 0 or more.")
        skeleton.person_named(self.person), motion_names(self.motion), view_names(self.views)

    @property
    def who(self) -> skeleton.Person:
        """The person at the stature of the options."""
        person = skeleton.person_named(self.person)
        return skeleton.grown(person, self.options.stature) if self.options.stature else person


def build_scene(made: Simulation, workers: Executor) -> Scene:
    """Dress the person, plan the motion, draw the room."""
    options, seed, person = made.options, made.seed, made.who
    cameras = rig(view_names(made.views), options, seed)
    things, lattice = room(furnished=options.furnished), noise_lattice(seed)
    lamp = Lamp.of(options.shadow, seed)

    def renderer(camera: Camera) -> CameraRenderer:
        return CameraRenderer(camera, sensor(options, seed, camera.name), things, lattice, lamp)

    renderers = workers.map(renderer, cameras.values())
    parts = made.parts or parts_of(motion_names(made.motion), made.frames, options)
    return Scene(
        actor(person, options.clothes),
        scheduled(person, parts, made.frames),
        _passer_by(person, options, made.frames) if options.second_person else None,
        cameras,
        dict(zip(cameras, renderers, strict=True)),
    )


_WORKERS = 2
_CRF = 16  # leaves the sensor's noise nearly as it is, at less than half the size of lossless


def simulate(folder: Path, simulation: Simulation | None = None, work: Work = NO_WORK) -> None:
    """Make a recording folder with rendered stereo images and truth.

    The folder must not exist yet, or be empty. It appears when everything is finished. Raises
    InputError for one that holds something; Cancelled when stopped; nothing is left behind.

    Examples
    --------
    >>> simulate(Path("recording"), Simulation(person="P2", frames=40, views="NS"))
    """
    folder, made = Path(folder), simulation or Simulation()
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise InputError("the folder is not empty", folder, "Use a new or empty folder.")
    o = made.options
    load_before_threads()
    with filling(folder) as workplace, ThreadPoolExecutor(_WORKERS) as workers:
        scene = build_scene(made, workers)
        crf = 0 if o.lossless else _CRF
        form = partial(
            VideoWriter, fps=o.fps, width=o.width, height=o.height, colour=o.colour, crf=crf
        )
        with ExitStack() as opened:
            paths = {camera: workplace / f"{camera}.mp4" for camera in scene.cameras}
            videos = {camera: opened.enter_context(form(path)) for camera, path in paths.items()}
            if o.background_images:
                for camera, renderer in scene.renderers.items():
                    write_png(workplace / f"{camera}_background.png", renderer.background())
            truth = []
            for frame in range(made.frames):
                work.step(frame / made.frames, f"frame {frame}")
                truth.append(_make_frame(scene, frame, videos, workers))
        _describe(workplace, folder.name, made, scene, np.array(truth))


def _make_frame(
    scene: Scene, frame: int, videos: Mapping[str, VideoWriter], workers: Executor
) -> FloatArray:
    people, points = scene.people(frame)

    def drawn(camera: str) -> ImageArray:
        return scene.renderers[camera].picture(people, frame)

    # Encoded in one thread: two encoders at once made other bits of one frame in a thousand.
    for camera, picture in zip(videos, workers.map(drawn, videos), strict=True):
        videos[camera].write(picture)
    return points


def _describe(folder: Path, name: str, made: Simulation, scene: Scene, truth: FloatArray) -> None:
    """Write what describes the pictures; `truth` is (F, 9, 3) metres, world."""
    o = made.options

    def stream(camera: str) -> Stream:
        background = f"{camera}_background.png" if o.background_images else None
        return Stream(camera, f"{camera}.mp4", background)

    names = dict.fromkeys(camera.partition("_")[0] for camera in scene.cameras)
    views = [
        View(name, "stereo", image=stream(f"{name}_right"), left=stream(f"{name}_left"))
        for name in names
    ]
    frames = np.arange(len(truth), dtype=np.int64)
    write_recording_description(
        Recording(
            folder, name, o.fps, tuple(views), scene.cameras, made.who.subject(),
            LandmarkTrajectory(frames, truth), scene.chain.segments,
        )
    )  # fmt: skip

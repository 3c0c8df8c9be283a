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
from stereotrack_core.simulation.render import CameraRenderer, DepthCamera, Posed, depth_view
from stereotrack_core.simulation.rig import (
    Disturber,
    SceneOptions,
    check_strengths,
    rig,
    sensor,
    view_names,
)
from stereotrack_core.simulation.room import noise_lattice, room
from stereotrack_core.work import NO_WORK, Work

_WAYS = (((-3.9, -2.2), (3.3, -2.4)), ((3.3, 2.3), (-3.0, 2.4)))
"""Beyond the working volume, to and fro, on the floor."""
_PAUSE_SECONDS, _WALK_SECONDS = 2.0, 6.5


def _passer_by(
    main: skeleton.Person, options: SceneOptions, frames: int, distance: float | None
) -> tuple[Actor, Sequence[skeleton.JointState | None]]:
    """Another person than `main`, who walks past, is away (None), and comes back elsewhere.

    With a `distance` from the middle of the room in metres he begins at once, and stays between
    the furniture.
    """
    ways = _WAYS
    if distance is not None:
        ways = ((-2.2, -distance), (3.4, -distance)), ((3.2, distance), (-2.0, distance))
    names = list(skeleton.PEOPLE)
    other = skeleton.PEOPLE[names[(names.index(main.name) + 1) % len(names)]]
    pause = round(_PAUSE_SECONDS * options.fps / options.pace)
    count = max(2, round(_WALK_SECONDS * options.fps / options.pace))
    states: list[skeleton.JointState | None] = []
    for start, end in cycle(ways):
        if states or distance is None:
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
    disturber: Disturber
    turned: Mapping[str, CameraRenderer]  # cameras that are bumped, as they stand from half time on

    def people(self, frame: int) -> tuple[list[Posed], FloatArray]:
        """Everybody in a frame, posed, and the landmarks (9, 3) of the one who matters."""
        bones = skeleton.posed_bones(self.actor.person, self.chain.states[frame])
        people = [Posed(self.actor, *self.actor.posed(bones))]
        if self.passer is not None:
            other, states = self.passer
            if (state := states[frame]) is not None:
                people.append(Posed(other, *other.posed(skeleton.posed_bones(other.person, state))))
        return people, skeleton.landmarks(self.actor.person, bones)

    def picture(self, camera: str, people: Sequence[Posed], frame: int) -> ImageArray:
        """What a camera sees in a frame, (H, W) or (H, W, 3) uint8."""
        bumped = 2 * frame >= self.disturber.frames
        renderers = self.turned if bumped and camera in self.turned else self.renderers
        return renderers[camera].picture(people, frame)


@dataclass(frozen=True)
class Simulation:
    """What to simulate.

    Raises InputError for an unknown name, an impossible strength, no frames or a negative seed.

    Examples
    --------
    >>> Simulation(person="P2", frames=60, disturbances={"exposure": 0.3}).motion
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
    disturbances: Mapping[str, float] = field(default_factory=dict)
    """Strengths by kind; the truth, and what is said of the cameras, stay as they are."""

    def __post_init__(self) -> None:
        if self.frames < 1:
            what = f"{self.frames} frames cannot be simulated"
            raise InputError(what, "--frames", "Give 1 or more.")
        if self.seed < 0:
            raise InputError(f"the seed {self.seed} is negative", "--seed", "Give 0 or more.")
        skeleton.person_named(self.person), motion_names(self.motion), view_names(self.views)
        check_strengths(self.disturbances)
        if self.disturbances and self.options.kind != "stereo":
            what = "only stereo recordings can be disturbed"
            raise InputError(what, "--disturb", "Leave out --set kind=depth.")

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
    disturber = Disturber(made.disturbances, seed, options.fps, made.frames)

    def renderer(camera: Camera) -> CameraRenderer:
        chosen = sensor(options, seed, camera.name)
        return CameraRenderer(camera, chosen, things, lattice, disturber)

    turned = disturber.turned(cameras)
    renderers = list(workers.map(renderer, [*cameras.values(), *turned.values()]))
    parts = made.parts or parts_of(motion_names(made.motion), made.frames, options)
    distance = made.disturbances.get("passer")
    passer = None
    if options.second_person or distance is not None:
        passer = _passer_by(person, options, made.frames, distance)
    return Scene(
        actor(person, options.clothes),
        scheduled(person, parts, made.frames),
        passer,
        cameras,
        dict(zip(cameras, renderers, strict=False)),
        disturber,
        dict(zip(turned, renderers[len(cameras) :], strict=True)),
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
        crf = int(made.disturbances.get("compress", 0 if o.lossless else _CRF))
        form = partial(
            VideoWriter, fps=o.fps, width=o.width, height=o.height, colour=o.colour, crf=crf
        )
        with ExitStack() as opened:
            paths = {camera: workplace / f"{camera}.mp4" for camera in scene.cameras}
            videos = {camera: opened.enter_context(form(path)) for camera, path in paths.items()}
            if o.background_images and o.kind == "stereo":
                for camera, renderer in scene.renderers.items():
                    write_png(workplace / f"{camera}_background.png", renderer.background())
            depth_cameras = scene.renderers if o.kind == "depth" else {}
            sensors = {
                name: DepthCamera(renderer, o.focal, workplace / name, (made.seed, ord(name)))
                for name, renderer in depth_cameras.items()
            }
            truth = []
            for frame in range(made.frames):
                work.step(frame / made.frames, f"frame {frame}")
                truth.append(_make_frame(scene, frame, videos, sensors, workers))
        _describe(workplace, folder.name, made, scene, np.array(truth))


def _make_frame(
    scene: Scene,
    frame: int,
    videos: Mapping[str, VideoWriter],
    sensors: Mapping[str, DepthCamera],
    workers: Executor,
) -> FloatArray:
    people, points = scene.people(frame)
    instants = {name: scene.disturber.instant(name, videos, frame) for name in videos}
    shown = {at: people if at == frame else scene.people(at)[0] for at in {*instants.values()}}

    def drawn(camera: str) -> ImageArray:
        if camera in sensors:
            sensors[camera].write(people, frame)
        return scene.picture(camera, shown[instants[camera]], frame)

    # Encoded in one thread: two encoders at once made other bits of one frame in a thousand.
    for camera, picture in zip(videos, workers.map(drawn, videos), strict=True):
        videos[camera].write(picture)
    return points


def _describe(folder: Path, name: str, made: Simulation, scene: Scene, truth: FloatArray) -> None:
    """Write what describes the pictures; `truth` is (F, 9, 3) metres, world."""
    o = made.options

    def stream(camera: str) -> Stream:
        background = o.background_images and o.kind == "stereo"
        return Stream(camera, f"{camera}.mp4", f"{camera}_background.png" if background else None)

    names = dict.fromkeys(camera.partition("_")[0] for camera in scene.cameras)
    views = [
        depth_view(name, stream(name))
        if o.kind == "depth"
        else View(name, "stereo", image=stream(f"{name}_right"), left=stream(f"{name}_left"))
        for name in names
    ]
    frames = np.arange(len(truth), dtype=np.int64)
    write_recording_description(
        Recording(
            folder, name, o.fps, tuple(views), scene.cameras, made.who.subject(),
            LandmarkTrajectory(frames, truth), scene.chain.segments,
        )
    )  # fmt: skip

"""Simulated recordings: a person moves in a room, cameras look, the truth is kept."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass
from itertools import cycle
from pathlib import Path

import numpy as np
from platformdirs import user_data_path

from stereotrack_core.arrays import FloatArray, ImageArray
from stereotrack_core.atomic import filling
from stereotrack_core.compiled import load_before_threads
from stereotrack_core.errors import Cancelled, InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.description import Recording, Stream, Subject, View
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.recording.writing import (
    VideoWriter,
    write_png,
    write_recording_description,
)
from stereotrack_core.simulation.actor import Actor, actor
from stereotrack_core.simulation.depth_camera import DepthCamera, depth_view
from stereotrack_core.simulation.disturbances import Disturbance, Disturber
from stereotrack_core.simulation.materials import noise_lattice
from stereotrack_core.simulation.motions import Chain, Part, chain, motion_names, scheduled
from stereotrack_core.simulation.people import PEOPLE, Person, grown, person_named
from stereotrack_core.simulation.postures import line_path, walk
from stereotrack_core.simulation.render import CameraRenderer, Posed
from stereotrack_core.simulation.rig import SceneOptions, rig, sensor, view_names
from stereotrack_core.simulation.room import room
from stereotrack_core.simulation.skeleton import JointState, landmarks, posed_bones

_WAYS = (((-3.9, -2.2), (3.3, -2.4)), ((3.3, 2.3), (-3.0, 2.4)))
"""Beyond the working volume, to and fro, on the floor."""
_PAUSE_SECONDS, _WALK_SECONDS = 2.0, 6.5


def _passer_by(
    main: Person, options: SceneOptions, frames: int, distance: float | None
) -> tuple[Actor, Sequence[JointState | None]]:
    """Another person than `main`, who walks past, is away (None), and comes back elsewhere.

    With a `distance` from the middle of the room in metres he begins at once, and stays between
    the furniture.
    """
    ways = _WAYS
    if distance is not None:
        ways = ((-2.2, -distance), (3.4, -distance)), ((3.2, distance), (-2.0, distance))
    names = list(PEOPLE)
    other = PEOPLE[names[(names.index(main.name) + 1) % len(names)]]
    pause = round(_PAUSE_SECONDS * options.fps / options.pace)
    count = max(2, round(_WALK_SECONDS * options.fps / options.pace))
    states: list[JointState | None] = []
    for start, end in cycle(ways):
        if states or distance is None:
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
    disturber: Disturber
    turned: Mapping[str, CameraRenderer]
    """Cameras that are bumped, as they stand from half time on."""

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
        bumped = 2 * frame >= self.disturber.frames
        renderers = self.turned if bumped and camera in self.turned else self.renderers
        return renderers[camera].picture(people, frame)


def build_scene(
    person: Person,
    motions: Sequence[str],
    frames: int,
    views: tuple[str, ...],
    seed: int,
    options: SceneOptions,
    workers: Executor,
    parts: Sequence[Part] = (),
    disturbances: Sequence[Disturbance] = (),
) -> Scene:
    """Dress the person, plan the motion, set up the cameras and draw the empty room.

    `parts` say what happens when; without any the motions follow each other.
    """
    cameras = rig(views, options, seed)
    things, lattice = room(furnished=options.furnished), noise_lattice(seed)
    disturber = Disturber(
        {one.kind: one.strength for one in disturbances}, seed, options.fps, frames
    )

    def renderer(camera: Camera) -> CameraRenderer:
        chosen = sensor(options, seed, camera.name)
        return CameraRenderer(camera, chosen, things, lattice, disturber)

    turned = disturber.turned(cameras)
    drawn = workers.map(renderer, [*cameras.values(), *turned.values()])
    if parts:
        moves = scheduled(person, parts, frames)
    else:
        moves = chain(
            person, motions, frames,
            fps=options.fps, pace=options.pace, t_pose_first=options.t_pose_first,
        )  # fmt: skip
    distance = disturber.strengths.get("passer")
    passer = None
    if options.second_person or distance is not None:
        passer = _passer_by(person, options, frames, distance)
    dressed = actor(person, options.clothes)
    renderers = list(drawn)
    still = dict(zip(cameras, renderers, strict=False))
    bumped = dict(zip(turned, renderers[len(cameras) :], strict=True))
    return Scene(dressed, moves, passer, cameras, still, disturber, bumped)


Progress = Callable[[int, int], None]
_WORKERS = 2
_CRF = 16
"""Leaves the sensor's noise nearly as it is, at less than half the size of a lossless video."""

DEMO_FRAMES = 100


def simulate(
    folder: Path,
    *,
    person: str = "P1",
    motion: str = "cross-arms",
    frames: int = 120,
    views: str = "NOSW",
    seed: int = 0,
    options: SceneOptions | None = None,
    parts: Sequence[Part] = (),
    disturbances: Sequence[Disturbance] = (),
    quick: bool = False,
    on_progress: Progress | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> None:
    """Make a recording folder with rendered stereo images and truth.

    Raises InputError for an unknown name, no frames, or a folder that holds something; Cancelled
    when stopped; nothing is left behind.

    Parameters
    ----------
    folder : must not exist yet, or be empty. It appears when everything is finished.
    person : P1 to P4
    motion : a name of ``MOTIONS``, or several joined by ``+``; repeated until the frames are full
    views : some of N, O, S, W
    seed : same seed, same pictures and truth
    parts : what happens at which frames, instead of `motion`
    disturbances : of the pictures; the truth, and what is said of the cameras, stay as they are
    quick : encode the videos in a tenth of the time, a quarter larger
    on_progress : called with frames done and frames in all
    cancelled : asked before every frame

    Examples
    --------
    >>> simulate(Path("recording"), person="P2", motion="cross-arms", frames=40, views="NS")
    """
    o = options or SceneOptions()
    folder = Path(folder)
    _check(folder, frames, seed)
    if disturbances and o.kind != "stereo":
        raise InputError(
            "only stereo recordings can be disturbed",
            where="--disturb",
            remedy="Leave out --set kind=depth.",
        )
    who, names, where = person_named(person), motion_names(motion), view_names(views)
    if o.stature:
        who = grown(who, o.stature)
    load_before_threads()
    with filling(folder) as workplace, ThreadPoolExecutor(_WORKERS) as workers:
        scene = build_scene(who, names, frames, where, seed, o, workers, parts, disturbances)
        crf = int(scene.disturber.strengths.get("compress", 0 if o.lossless else _CRF))
        with ExitStack() as opened:
            videos = {
                camera: opened.enter_context(_video(workplace / f"{camera}.mp4", o, quick, crf))
                for camera in scene.cameras
            }
            if o.background_images and o.kind == "stereo":
                for camera, renderer in scene.renderers.items():
                    write_png(workplace / f"{camera}_background.png", renderer.background())
            sensors = _depth_cameras(scene, workplace, o, seed)
            truth = []
            for frame in range(frames):
                if cancelled is not None and cancelled():
                    raise Cancelled
                truth.append(_make_frame(scene, frame, videos, sensors, workers))
                if on_progress is not None:
                    on_progress(frame + 1, frames)
        _describe(workplace, folder.name, o, scene, who.subject(), np.array(truth))


def _video(path: Path, o: SceneOptions, quick: bool, crf: int) -> VideoWriter:
    size = {"width": o.width, "height": o.height}
    return VideoWriter(path, fps=o.fps, **size, colour=o.colour, crf=crf, quick=quick)


def _depth_cameras(
    scene: Scene, folder: Path, o: SceneOptions, seed: int
) -> dict[str, DepthCamera]:
    """Those of depth views by their names; none for stereo views."""
    if o.kind != "depth":
        return {}
    return {
        name: DepthCamera(renderer, o.focal, folder / name, (seed, ord(name)))
        for name, renderer in scene.renderers.items()
    }


def _make_frame(
    scene: Scene,
    frame: int,
    videos: Mapping[str, VideoWriter],
    sensors: Mapping[str, DepthCamera],
    workers: Executor,
) -> FloatArray:
    """Draw and store all pictures of a frame; return its landmarks (9, 3)."""
    people, points = scene.people(frame)
    instants = {name: scene.disturber.instant(name, videos, frame) for name in videos}
    shown = {at: people if at == frame else scene.people(at)[0] for at in {*instants.values()}}

    def draw(camera: str) -> None:
        videos[camera].write(scene.picture(camera, shown[instants[camera]], frame))
        if camera in sensors:
            sensors[camera].write(people, frame)

    list(workers.map(draw, videos))
    return points


def _describe(
    folder: Path, name: str, o: SceneOptions, scene: Scene, subject: Subject, truth: FloatArray
) -> None:
    """Write what describes the pictures; `truth` is (F, 9, 3) metres, world."""

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
            folder, name, o.fps, tuple(views), scene.cameras, subject,
            LandmarkTrajectory(frames, truth), scene.chain.segments,
        )
    )  # fmt: skip


def _check(folder: Path, frames: int, seed: int) -> None:
    if frames < 1:
        raise InputError(
            f"{frames} frames cannot be simulated", where="--frames", remedy="Give 1 or more."
        )
    if seed < 0:
        raise InputError(f"the seed {seed} is negative", where="--seed", remedy="Give 0 or more.")
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise InputError(
            "the folder is not empty", where=str(folder), remedy="Use a new or empty folder."
        )


@dataclass(frozen=True)
class DemoPlaces:
    """Where the demo keeps its recording and its run."""

    recording: Path
    run: Path

    @property
    def made(self) -> bool:
        """Whether the recording is there."""
        return (self.recording / "recording.toml").is_file()


def demo_places(folder: Path | None) -> DemoPlaces:
    """Recording and run in `folder`, or in the program's own data folder.

    Raises InputError where that is no folder.
    """
    if folder is None:
        folder = user_data_path("stereotrack", appauthor=False) / "demo"
    if folder.exists() and not folder.is_dir():
        raise InputError(
            "this is not a folder", where=str(folder), remedy="Give the name of a folder."
        )
    return DemoPlaces(folder / "recording", folder / "run.npz")


def make_demo(
    places: DemoPlaces,
    *,
    on_progress: Progress | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> None:
    """Render the demo recording: four views, T pose, crossed arms, pointing.

    Raises InputError where its folder cannot be made, Cancelled when stopped; then nothing is left
    behind.
    """
    try:
        places.recording.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"the folder cannot be created ({error.strerror})",
            where=str(places.recording.parent),
            remedy="Give a folder that you may write to: stereotrack demo DIR.",
        ) from error
    simulate(
        places.recording,
        person="P2",
        motion="t-pose+cross-arms+point",
        frames=DEMO_FRAMES,
        seed=7,
        quick=True,  # somebody waits for the window
        on_progress=on_progress,
        cancelled=cancelled,
    )

"""Simulated rigs that a user may have built: other lenses, distances, people and worlds."""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.calibrate.align import aligned
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.recording.description import Recording, Stream, View
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.recording.writing import (
    VideoWriter,
    write_png,
    write_recording_description,
)
from stereotrack_core.simulation.make import Simulation, build_scene
from stereotrack_core.simulation.people import PEOPLE, Person
from stereotrack_core.simulation.rig import SceneOptions

_COMPASS = "NOSW"
_SEED = 5


@dataclass(frozen=True)
class Rig:
    """Stereo cameras of one kind around somebody in the middle of a room."""

    name: str
    focal: float
    """Pixels."""
    baseline: float
    distance: float
    """`baseline` and `distance`: metres."""
    world: str = "floor"
    """Where the world is: at the ``floor``, ``away`` from the person, ``y-up`` at the floor, at the
    first ``camera`` (x right, y down, z forward), or there with ``camera-y-up``."""
    bearings: tuple[float, ...] = (0.0,)
    """Degrees from north, clockwise, at which the cameras stand."""
    width: int = 640
    height: int = 480
    camera_height: float = 1.5
    looks_at: float = 1.05
    """Metres above the floor at the person."""
    stature: float = 1.75
    background: bool = True
    """Whether there are pictures of the empty room."""
    motion: str = "cross-arms"


_SHORT = 960, 720
_LARGE = 1280, 960

RIGS: tuple[Rig, ...] = (
    Rig("near-wide", 300, 0.06, 0.9, "camera", looks_at=1.25, stature=1.7),
    Rig("nearest", 320, 0.06, 0.6, "camera", looks_at=1.3, camera_height=1.4, stature=1.6),
    Rig("near-12", 400, 0.12, 0.7, "floor", looks_at=1.3, camera_height=1.4, stature=1.7),
    Rig("near-long-base", 420, 0.30, 1.0, "camera", looks_at=1.25, camera_height=1.3),
    Rig("near-y-up", 350, 0.10, 0.8, "y-up", looks_at=1.35, stature=1.9),
    Rig("desk-two", 400, 0.08, 1.0, "camera", (-35, 35), looks_at=1.2, stature=1.5),
    Rig("zed", 700, 0.12, 2.2, "camera", width=960, height=720),
    Rig("zed-down", 700, 0.12, 2.2, "camera", width=960, height=720, camera_height=2.3),
    Rig("realsense", 640, 0.06, 2.0, "y-up", width=960, height=720, camera_height=1.0),
    Rig("gl-camera", 600, 0.12, 2.0, "camera-y-up", width=960, height=720, stature=2.0),
    Rig("away", 500, 0.12, 2.5, "away", background=False),
    Rig("two-y-up", 500, 0.12, 2.5, "y-up", (-45, 45), camera_height=2.0),
    Rig("two-camera", 600, 0.15, 3.0, "camera", (0, 90), 960, 720, stature=1.6),
    Rig("three-camera", 450, 0.12, 2.8, "camera", (0, 120, 240), camera_height=2.2),
    Rig("four-y-up", 400, 0.12, 3.0, "y-up", (0, 90, 180, 270), camera_height=2.1, stature=1.9),
    Rig("four-away", 400, 0.10, 3.0, "away", (0, 90, 180, 270), camera_height=2.1, stature=1.5),
    Rig("far-long-lens", 1600, 0.12, 6.0, "floor", (45,), *_LARGE, stature=1.8),
    Rig("far-camera", 1200, 0.20, 6.0, "camera", (45,), *_SHORT, stature=1.7),
    Rig("far-wide", 400, 0.30, 5.5, "y-up", (45,), stature=2.0),
    Rig("far-short-base", 1600, 0.06, 4.5, "camera", (45,), *_LARGE, stature=1.65),
)


def _cameras(rig: Rig) -> dict[str, Camera]:
    cameras = {}
    for view, bearing in zip(_COMPASS, rig.bearings, strict=False):
        turn = np.radians(bearing)
        off = rig.distance * np.array([np.sin(turn), np.cos(turn)])
        place = np.array([*off, rig.camera_height])
        forward = np.array([0.0, 0.0, rig.looks_at]) - place
        forward /= np.linalg.norm(forward)
        right = np.cross(forward, [0.0, 0.0, 1.0])
        right /= np.linalg.norm(right)
        rotation = np.stack([right, np.cross(forward, right), forward])
        middle = (rig.width - 1) / 2, (rig.height - 1) / 2
        matrix = np.array([[rig.focal, 0, middle[0]], [0, rig.focal, middle[1]], [0, 0, 1.0]])
        for side, shift in (("left", rig.baseline), ("right", 0.0)):
            pose = RigidTransform(rotation, -rotation @ place + [shift, 0.0, 0.0])
            name = f"{view}_{side}"
            cameras[name] = Camera(name, rig.width, rig.height, matrix, np.zeros(5), False, pose)
    return cameras


_Y_UP = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
_GL = np.diag([1.0, -1.0, -1.0])


def world_from_room(rig: Rig, cameras: Mapping[str, Camera]) -> RigidTransform:
    """Where the recording's world is."""
    camera = cameras["N_right"].camera_from_world
    return {
        "floor": RigidTransform.identity(),
        "away": RigidTransform(np.eye(3), np.array([7.0, -4.0, 0.0])),
        "y-up": RigidTransform(_Y_UP, np.zeros(3)),
        "camera": camera,
        "camera-y-up": RigidTransform(_GL, np.zeros(3)) @ camera,
    }[rig.world]


def make_rig(folder: Path, rig: Rig, frames: int) -> None:
    """Render a recording of a rig; subject and truth are those of the person drawn."""
    person = min(PEOPLE, key=lambda name: abs(PEOPLE[name].stature - rig.stature))
    options = SceneOptions(
        width=rig.width, height=rig.height, background_images=rig.background, pace=1.8,
        furnished=False, stature=rig.stature,
    )  # fmt: skip
    made = Simulation(person, rig.motion, frames, seed=_SEED, options=options)
    cameras = _cameras(rig)
    folder.mkdir(parents=True)
    with ThreadPoolExecutor(2) as workers, ExitStack() as opened:
        scene = build_scene(made, workers, cameras)
        size = {"width": rig.width, "height": rig.height}
        videos = {
            name: opened.enter_context(
                VideoWriter(folder / f"{name}.mp4", fps=options.fps, **size, colour=False, crf=16)
            )
            for name in cameras
        }
        truth = []
        for frame in range(frames):
            people, points = scene.people(frame)
            truth.append(points)
            for name, video in videos.items():
                video.write(scene.picture(name, people, frame))
        if rig.background:
            for name, renderer in scene.renderers.items():
                write_png(folder / f"{name}_background.png", renderer.background())
    _describe(folder, rig, made.who, cameras, np.array(truth))


def _describe(
    folder: Path, rig: Rig, person: Person, cameras: Mapping[str, Camera], truth: FloatArray
) -> None:
    def stream(camera: str) -> Stream:
        return Stream(
            camera, f"{camera}.mp4", f"{camera}_background.png" if rig.background else None
        )

    world = world_from_room(rig, cameras)
    views = tuple(
        View(name, "stereo", image=stream(f"{name}_right"), left=stream(f"{name}_left"))
        for name in dict.fromkeys(camera.partition("_")[0] for camera in cameras)
    )
    reference = LandmarkTrajectory(np.arange(len(truth)), world.apply(truth))
    changed = aligned(cameras, world)
    subject = person.subject()
    write_recording_description(
        Recording(folder, rig.name, 10.0, views, changed, subject, reference, ())
    )

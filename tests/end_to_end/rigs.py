"""Simulated rigs that a user may have built: other lenses, distances, people and worlds."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from unittest.mock import patch

import numpy as np

from stereotrack_core.calibrate.align import aligned
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.writing import write_recording_description
from stereotrack_core.simulation import make
from stereotrack_core.simulation.rig import SceneOptions
from stereotrack_core.simulation.skeleton import PEOPLE
from tests.tracking.views import looking

_COMPASS = "NOSW"
_SEED = 5


@dataclass(frozen=True)
class Rig:
    """Stereo cameras of one kind around somebody in the middle of a room."""

    name: str
    focal: float  # pixels
    baseline: float  # metres
    distance: float  # metres
    # Where the world is: at the `floor`, `away` from the person, `y-up` at the floor, at the first
    # `camera` (x right, y down, z forward), or there with `camera-y-up`.
    world: str = "floor"
    bearings: tuple[float, ...] = (0.0,)  # degrees from north, clockwise, of the cameras
    width: int = 640
    height: int = 480
    camera_height: float = 1.5
    looks_at: float = 1.05  # metres above the floor at the person
    stature: float = 1.75
    background: bool = True  # whether there are pictures of the empty room


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
        pose = looking((*off, rig.camera_height), (0.0, 0.0, rig.looks_at)).inverse()
        middle = (rig.width - 1) / 2, (rig.height - 1) / 2
        matrix = np.array([[rig.focal, 0, middle[0]], [0, rig.focal, middle[1]], [0, 0, 1.0]])
        for side, shift in (("left", rig.baseline), ("right", 0.0)):
            own = RigidTransform(pose.rotation, pose.translation + [shift, 0.0, 0.0])
            name = f"{view}_{side}"
            cameras[name] = Camera(name, rig.width, rig.height, matrix, np.zeros(5), False, own)
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
    """Simulate a recording of a rig; subject and truth are those of the person drawn."""
    person = min(PEOPLE, key=lambda name: abs(PEOPLE[name].stature - rig.stature))
    options = SceneOptions(
        width=rig.width, height=rig.height, background_images=rig.background, pace=1.8,
        furnished=False, stature=rig.stature,
    )  # fmt: skip
    cameras = _cameras(rig)
    with patch.object(make, "rig", lambda *_: cameras):
        made = make.Simulation(person, "cross-arms", frames, seed=_SEED, options=options)
        make.simulate(folder, made)
    recording, world = open_recording(folder), world_from_room(rig, cameras)
    truth = replace(recording.reference, points=world.apply(recording.reference.points))
    moved = replace(recording, cameras=aligned(cameras, world), reference=truth)
    write_recording_description(moved)

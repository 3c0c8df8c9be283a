"""Four cameras around a body, and clicks on it."""

from dataclasses import replace

import numpy as np

from stereotrack_core.annotation.click import Click
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.body.model import body_model
from stereotrack_core.body.pose import hanging_pose
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.body.skeleton import PARTS
from stereotrack_core.depth.points import Volume
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.geometry.transform import RigidTransform
from tests.tracking.views import looking

MATRIX = np.array([[520.0, 0, 322.5], [0, 515.0, 236.5], [0, 0, 1]])
LENSES = {
    "plain": (np.zeros(5), False),
    "barrel": (np.array([-0.2, 0.05, 0.001, -0.001, 0.0]), False),
    "rational": (np.array([0.3, -0.1, 0.001, 0.002, 0.02, 0.2, -0.1, 0.03]), False),
    "fisheye": (np.array([0.05, -0.02, 0.005, -0.001]), True),
}
AZIMUTHS = {"N": 95.0, "O": 8.0, "S": 262.0, "W": 187.0}
VOLUME = Volume(np.array([-1.8, -1.8, 0.0]), np.array([1.8, 1.8, 2.4]))


def looking_in(azimuth_deg: float, distance: float = 2.8) -> RigidTransform:
    """camera_from_world 1.7 m high, looking at the middle of the scene."""
    azimuth = np.radians(azimuth_deg)
    place = (distance * np.cos(azimuth), distance * np.sin(azimuth), 1.7)
    return looking(place, (0.0, 0.0, 1.1)).inverse()


def cameras(lens: str = "barrel") -> dict[str, Camera]:
    """Four cameras with one kind of lens, by name."""
    distortions, fisheye = LENSES[lens]
    return {
        name: Camera(name, 640, 480, MATRIX, distortions, fisheye, looking_in(azimuth))
        for name, azimuth in AZIMUTHS.items()
    }


def bodies(frames: int, seed: int = 0) -> np.ndarray:
    """Landmarks (F, 9, 3) of somebody who turns and moves the arms smoothly."""
    rng = np.random.default_rng(seed)
    body = body_model(AVERAGE)
    rates, phases = rng.uniform(0.5, 1.5, (10, 3)), rng.uniform(0, 6, (10, 3))
    found = []
    for frame in range(frames):
        turn = rotation_from_vector(np.array([0.0, 0.0, 0.4 * np.sin(0.1 * frame)]))
        pose = hanging_pose(np.array([0.2 * np.sin(0.07 * frame), 0.1, 0.9]), turn)
        bend = np.tile(np.eye(3), (len(PARTS), 1, 1))
        bend[:10] = rotation_from_vector(0.6 * np.sin(0.1 * frame * rates + phases))
        bend[0] = np.eye(3)
        found.append(NINE.places(body, body.frames(replace(pose, rotations=pose.rotations @ bend))))
    return np.array(found)


def moved_click(click: Click, by) -> Click:
    """A click that is off by so many pixels."""
    return replace(click, position=tuple(np.add(click.position, by)))


def one_camera_off(clicks, camera: str, by) -> list[Click]:
    """The clicks, those of a camera off by so many pixels."""
    return [moved_click(one, by) if one.camera == camera else one for one in clicks]


def clicks_of(points, rig, *, sigma=0.0, seed=0):
    """Clicks of all landmarks (F, 9, 3) in all cameras, with noise of `sigma` pixels per axis."""
    rng = np.random.default_rng(seed)
    found = []
    for frame, landmarks in enumerate(points):
        for camera in rig.values():
            pixels = camera.project(landmarks) + rng.normal(0, sigma, (9, 2))
            found += [
                Click(frame, camera.name, name, (float(x), float(y)))
                for name, (x, y) in zip(NINE.names, pixels, strict=True)
            ]
    return found

"""A small recording by four stereo views, whose images show nothing but noise."""

from pathlib import Path

import numpy as np

from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.recording.description import Recording, Segment, Stream, Subject, View
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.recording.writing import write_png, write_recording_description

SMALL = 8  # frames of the small recording
STANDING = np.array(
    [[-0.2, 0, 1.4], [0.2, 0, 1.4], [-0.5, 0, 1.4], [0.5, 0, 1.4], [-0.8, 0, 1.4],
     [0.8, 0, 1.4], [0, 0, 1.6], [-0.15, 0, 0.9], [0.15, 0, 0.9]]
)  # fmt: skip
"""Landmarks of a person in the T pose, metres."""

VIEWPOINTS = {"N": 90.0, "O": 0.0, "S": 270.0, "W": 180.0}


def looking_at_the_person(azimuth_deg: float, *, aside: float = 0.0) -> RigidTransform:
    """camera_from_world 3 m away, 1.5 m high; `aside` metres to the camera's own right."""
    azimuth = np.radians(azimuth_deg)
    outwards = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    z = -outwards
    y = np.array([0.0, 0.0, -1.0])
    x = np.cross(y, z)
    rotation = np.stack([x, y, z])
    place = 3 * outwards + [0, 0, 1.2] + aside * x
    return RigidTransform(rotation, -rotation @ place)


def written_recording(folder: Path) -> Recording:
    """Four stereo views of 48 x 36 pixels as numbered images, all in order."""
    rng = np.random.default_rng(5)
    matrix = np.array([[40.0, 0, 23.5], [0, 40, 17.5], [0, 0, 1]])
    cameras, views = {}, []
    for name, azimuth in VIEWPOINTS.items():
        for side, aside in (("left", -0.05), ("right", 0.05)):
            place = looking_at_the_person(azimuth, aside=aside)
            camera = Camera(f"{name}_{side}", 48, 36, matrix, np.zeros(5), False, place)
            cameras[camera.name] = camera
            (folder / camera.name).mkdir()
            scene = rng.integers(60, 200, (36, 48))
            for k in range(SMALL):
                image = (scene + rng.integers(-20, 20, scene.shape)).astype(np.uint8)
                write_png(folder / camera.name / f"{k:03d}.png", image)
        pair = (f"{name}_left", f"{name}_right")
        left, right = (Stream(n, f"{n}/%03d.png", background=f"{n}/000.png") for n in pair)
        views.append(View(name, "stereo", right, left=left))
    recording = Recording(
        folder,
        "small",
        10.0,
        tuple(views),
        cameras,
        subject=Subject("P", shoulder_width=0.4, torso_length=0.5),
        reference=LandmarkTrajectory(np.arange(SMALL), np.tile(STANDING, (SMALL, 1, 1))),
        segments=(Segment("t-pose", 0, SMALL),),
    )
    write_recording_description(recording)
    return recording


def filmless(folder: Path, *names: str, size: tuple[int, int] = (64, 48)) -> Recording:
    """A recording that has no films yet: N_left and N_right are a pair, the others mono views."""
    matrix = np.array([[50.0, 0, 31.5], [0, 50, 23.5], [0, 0, 1]])
    place = RigidTransform.identity()
    cameras = {name: Camera(name, *size, matrix, np.zeros(5), False, place) for name in names}
    stream = {name: Stream(name, f"{name}/%d.png") for name in names}
    views = [View(name, "mono", stream[name]) for name in names if not name.startswith("N_")]
    if "N_left" in names:
        views = [View("N", "stereo", stream["N_right"], left=stream["N_left"]), *views]
    return Recording(folder, "walk", 10.0, tuple(views), cameras)

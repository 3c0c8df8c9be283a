"""A recording of ordinary cameras, and where the person in it is."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from stereotrack_core.body.manifold import displaced
from stereotrack_core.body.model import body_model, landmarks
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.recording.description import Recording, Stream, View
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.recording.writing import write_png, write_recording_description
from tests.tracking.recordings import camera_towards_the_middle
from tests.tracking.scenes import CAMERAS, POSES

BODY = body_model(AVERAGE)
FRAMES = 8


def mono_recording(folder: Path) -> Recording:
    """Write four mono views of a person who lifts an arm; the pictures are black."""
    cameras = {n: camera_towards_the_middle(n, at) for n, at in zip("NOSW", CAMERAS, strict=True)}
    for name, camera in cameras.items():
        (folder / name).mkdir()
        for k in range(FRAMES):
            black = np.zeros((camera.height, camera.width), np.uint8)
            write_png(folder / name / f"{k}.png", black)
    views = tuple(View(name, "mono", Stream(name, f"{name}/%d.png")) for name in cameras)
    write_recording_description(Recording(folder, "mono", 10.0, views, cameras))
    return open_recording(folder)


def truth() -> LandmarkTrajectory:
    turn = np.zeros((FRAMES, 14))
    turn[:, 2] = 0.02 * np.arange(FRAMES)
    turn[:, 8] = np.radians(6.0) * np.arange(FRAMES)
    poses = displaced(POSES["pointing"], turn, (2, 3, 4, 5))
    return LandmarkTrajectory(np.arange(FRAMES), landmarks(BODY, poses))

"""A recording of ordinary cameras, and where the person in it is."""

from pathlib import Path

import numpy as np

from stereotrack_core.body.manifold import displaced
from stereotrack_core.body.model import landmarks
from stereotrack_core.body.pose import Pose
from stereotrack_core.recording.description import Recording, Stream, View
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.recording.writing import write_png, write_recording_description
from tests.tracking.keypoints.cases import BODY, VIEWS
from tests.tracking.recordings import rendered_depth
from tests.tracking.scenes import POSES

FRAMES = 8


def mono_recording(folder: Path, *, seen: bool = False) -> Recording:
    """Write four mono views of a person who lifts an arm; the pictures are black.

    Where the person is `seen`, they are grey, the person is white, and there is an empty scene.
    """
    for name, camera in VIEWS.items():
        (folder / name).mkdir()
        for k in range(FRAMES):
            picture = np.full((camera.height, camera.width), 60 if seen else 0, np.uint8)
            if seen:
                picture[np.isfinite(rendered_depth(BODY, poses()[k], camera))] = 220
            write_png(folder / name / f"{k}.png", picture)
        if seen:
            write_png(folder / f"{name}.png", np.full((camera.height, camera.width), 60, np.uint8))
    views = tuple(
        View(name, "mono", Stream(name, f"{name}/%d.png", f"{name}.png" if seen else None))
        for name in VIEWS
    )
    write_recording_description(Recording(folder, "mono", 10.0, views, VIEWS))
    return open_recording(folder)


def poses() -> list[Pose]:
    turn = np.zeros((FRAMES, 14))
    turn[:, 2] = 0.02 * np.arange(FRAMES)
    turn[:, 8] = np.radians(6.0) * np.arange(FRAMES)
    return [displaced(POSES["pointing"], one, (2, 3, 4, 5)) for one in turn]


def truth() -> LandmarkTrajectory:
    points = np.array([landmarks(BODY, pose) for pose in poses()])
    return LandmarkTrajectory(np.arange(FRAMES), points)

"""A small rendered recording that several tests follow through its images."""

import pytest

from stereotrack_core import open_recording
from stereotrack_core.recording.description import Recording
from stereotrack_core.simulation.make import SceneOptions, Simulation, simulate


@pytest.fixture(scope="session")
def clip(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    """Somebody who moves, rendered in two small views."""
    folder = tmp_path_factory.mktemp("clip") / "clip"
    options = SceneOptions(width=320, height=240, focal=200.0, t_pose_first=False)
    simulate(
        folder,
        Simulation(person="P2", motion="travolta", frames=8, views="NO", seed=3, options=options),
    )
    return open_recording(folder)

"""Small recordings: depth views of a cone body, and one stereo view of a rendered person."""

import pytest

from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.simulation.make import Simulation, simulate
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.tuning.clouds import CloudStore
from tests.tracking.recordings import write_depth_recording
from tests.tracking.scenes import moving_pose

FRAMES = 8


@pytest.fixture(scope="package")
def cones(tmp_path_factory):
    body = body_model(AVERAGE, preset("fast").body)
    folder = tmp_path_factory.mktemp("tuning") / "cones"
    return write_depth_recording(folder, body, [moving_pose(k) for k in range(FRAMES)])


@pytest.fixture(scope="package")
def rendered(tmp_path_factory):
    folder = tmp_path_factory.mktemp("tuning") / "rendered"
    simulate(folder, Simulation(person="P2", motion="t-pose", frames=3, views="N", seed=3))
    return open_recording(folder)


@pytest.fixture
def store_of():
    """Function from a recording to a store of its clouds."""
    opened = []

    def make(recording, **keywords):
        reader = FrameReader(recording, colour=False)
        store = CloudStore(recording, reader, **keywords)
        opened.append((store, reader))
        return store

    yield make
    for store, reader in opened:
        store.close()
        reader.close()

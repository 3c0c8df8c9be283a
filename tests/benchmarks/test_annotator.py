"""The scripted annotator clicks all where nothing is proposed, and much less where it is."""

import numpy as np
import pytest

from benchmarks.annotator import NOTICED, Annotator, measured
from stereotrack_core.annotation.click import ACCEPTED
from stereotrack_core.annotation.propose import Proposer
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.simulation.make import Simulation, simulate


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    folder = tmp_path_factory.mktemp("annotator") / "four"
    simulate(folder, Simulation(person="P2", motion="t-pose", frames=3, views="NOSW", seed=3))
    return open_recording(folder)


def test_what_is_proposed_right_needs_no_click(recording):
    annotator = Annotator(recording, range(3), 1, {})
    with FrameReader(recording, read_ahead=0) as reader:
        done = annotator.annotate(reader, Proposer())
    assert done.clicks.keys() == annotator.sees.keys(), "nothing stays open"
    clicks, keys, seconds, right, mean, rms, stated = measured(annotator, done)
    assert clicks == done.by_hand / 3 < 20
    assert seconds == pytest.approx(0.4 * keys + 1.1 * clicks)
    assert right > 60.0
    assert mean <= rms < 30.0
    assert 0.4 < stated / rms < 2.5
    for key, click in done.clicks.items():
        if click.origin == ACCEPTED:
            assert np.linalg.norm(annotator.sees[key] - click.position) <= NOTICED

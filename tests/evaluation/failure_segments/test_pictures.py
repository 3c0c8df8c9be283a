"""Strips: layout, captions, the model where the person is; looks at tiny clouds."""

import numpy as np
import pytest

from stereotrack_core.annotation.predict import hidden_landmarks
from stereotrack_core.errors import Cancelled
from stereotrack_core.evaluation.failure_segments import drawing
from stereotrack_core.evaluation.failure_segments.film import CELL, Film, captions, strip_of
from stereotrack_core.evaluation.failure_segments.find import FailureSearch, find_failures
from stereotrack_core.evaluation.failure_segments.looks import Looker
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.work import Work
from tests.evaluation.failure_segments.runs import recorded


@pytest.fixture(scope="module")
def seen(tmp_path_factory):
    """Recording, run that loses its left forearm in frames 4 to 9, and truth."""
    return recorded(tmp_path_factory.mktemp("pictures"))


def test_captions_tell_the_error_or_what_the_run_says(seen):
    recording, run, truth = seen
    told = captions(Film(recording, (run,), truth, ("left_forearm",), (2, 6, 99)))
    assert told == [
        *(("frame 2", "left forearm 0°"), ("frame 6", "left forearm 80°")),
        ("frame 99", "unknown"),
    ]
    (own,) = captions(Film(recording, (run,), None, ("left_forearm",), (6,)))
    assert own[1] == "left forearm 2 % lost"


def test_the_best_view_is_one_that_sees_the_limb(seen):
    recording, run, _ = seen
    camera = recording.reference_camera(
        recording.view(drawing.best_view(recording, run, range(2, 8), ("left_forearm",)))
    )
    nine = run.landmarks[5:6]
    hand = LANDMARKS.index("left_hand")
    hidden = hidden_landmarks(nine, LANDMARKS, nine, camera.position_world[None])
    assert not hidden[0, 0, hand]
    assert np.isfinite(camera.project(nine[0, hand])).all()


def test_a_strip_shows_a_failure(seen):
    recording, run, truth = seen
    search = FailureSearch(run, recording.fps, truth, recording, pictures=False)
    (failure,) = find_failures(search)
    strip = strip_of(search, recording, failure).astype(int)
    assert strip.shape[1] > 3 * CELL
    coloured = (np.ptp(strip, axis=2) > 40).any(axis=1)
    assert coloured[:CELL].any()  # the run; the reference below is white
    assert not coloured[-CELL:].any()


def test_looks_tell_what_the_views_measure(seen):
    recording, run, truth = seen
    with Looker(recording, run) as looker:
        (look,) = looker.looks([2], truth.points[2:3])
        assert looker.view_names == ("N", "O", "S", "W")
        with pytest.raises(Cancelled):
            looker.looks([2], truth.points[2:3], Work(stopped=lambda: True))
    assert (look.points > 100).all()
    shares = look.agreed + look.before
    assert (shares[:, 2:] < 1.0 + 1e-9).all()
    assert look.agreed[:, 2:].max(axis=0).min() > 0.7
    assert look.stray.max() < 0.02
    assert np.nanmax(np.linalg.norm(look.offset, axis=1)) < 0.012

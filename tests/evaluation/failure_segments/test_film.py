"""Film strips and their captions, where a click in a cell is; looks at tiny clouds."""

import numpy as np
import pytest

from stereotrack_core.annotation.predict import hidden_landmarks
from stereotrack_core.errors import Cancelled
from stereotrack_core.evaluation.failure_segments import film
from stereotrack_core.evaluation.failure_segments.film import CELL, Film
from stereotrack_core.evaluation.failure_segments.find import FailureSearch, find_failures
from stereotrack_core.evaluation.failure_segments.looks import Looker
from stereotrack_core.evaluation.failure_segments.segment import FailureSegment
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.work import Work
from tests.evaluation.failure_segments.runs import recorded

FAILURE = FailureSegment(20, 50, ("right_forearm",), "truth", "error", 90.0, 33, "right_forearm")


@pytest.fixture(scope="module")
def seen(tmp_path_factory):
    """Recording, run that loses its left forearm in frames 4 to 9, and truth."""
    return recorded(tmp_path_factory.mktemp("pictures"))


def test_captions_tell_the_error_or_what_the_run_says(seen):
    recording, run, truth = seen
    told = film.captions(Film(recording, (run,), truth, ("left_forearm",), (2, 6, 99)))
    assert told == [
        *(("frame 2", "left forearm 0°"), ("frame 6", "left forearm 80°")),
        ("frame 99", "unknown"),
    ]
    (own,) = film.captions(Film(recording, (run,), None, ("left_forearm",), (6,)))
    assert own[1] == "left forearm 2 % lost"


def test_the_best_view_is_one_that_sees_the_limb(seen):
    recording, run, _ = seen
    camera = recording.reference_camera(
        recording.view(film.best_view(recording, run, range(2, 8), ("left_forearm",)))
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
    strip = film.strip_of(search, recording, failure).astype(int)
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


def test_frames_are_spread_over_the_failure_and_have_its_worst_one():
    frames = film.film_frames(FAILURE, 10.0, 300)
    assert (frames[0], frames[-1], len(frames)) == (18, 52, 5)
    assert 33 in frames
    assert film.film_frames(FAILURE, 10.0, 51)[-1] == 50


@pytest.mark.parametrize("turns", range(4))
def test_a_click_is_at_the_pixel_that_is_shown_there(turns):
    """A white pixel of the camera's image, at its place in the cell and back."""
    image = np.zeros((100, 100, 3), dtype=np.uint8)
    image[62, 41] = 255
    window = film.Window(20.0, 30.0, 4.0, CELL, CELL)
    picture = np.rot90(window.cut(image), -turns)
    rows, columns = np.nonzero(picture[..., 0] > 200)
    cell = film.FilmCell("N", "N_right", 0, window, turns, (picture,))
    x, y = (columns.mean() + 0.5) / CELL, (rows.mean() + 0.5) / CELL
    assert cell.pixel_at(x, y) == pytest.approx((41.0, 62.0), abs=0.2)
    assert cell.place_of(cell.pixel_at(x, y)) == pytest.approx((x, y))


def test_cells_show_run_and_reference_around_the_limbs(seen):
    recording, run, truth = seen
    shown = Film(recording, (run,), truth, ("left_forearm",), (2, 6))
    with FrameReader(recording) as reader:
        cells = shown.cells(reader)
    views = [view.name for view in recording.views]
    assert [(one.view, one.frame) for one in cells] == [(v, f) for v in views for f in (2, 6)]
    for cell in cells:
        drawn, true = cell.pictures
        assert drawn.shape == true.shape == (CELL, CELL, 3)
        assert (drawn != true).any()
        camera = recording.reference_camera(recording.view(cell.view))
        points = truth.points[truth.frame == cell.frame][0]
        for name in ("left_hand", "left_elbow"):
            pixel = camera.project(points[LANDMARKS.index(name)])
            assert all(0.0 < one < 1.0 for one in cell.place_of(tuple(pixel))), name

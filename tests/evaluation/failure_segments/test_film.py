"""Film strips: which frames, which part of the pictures, and where a click in a cell is."""

import numpy as np
import pytest

from stereotrack_core.evaluation.failure_segments.drawing import Window
from stereotrack_core.evaluation.failure_segments.film import CELL, Film, FilmCell, film_frames
from stereotrack_core.evaluation.failure_segments.segment import FailureSegment
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.recording.reader import FrameReader
from tests.evaluation.failure_segments.runs import recorded

FAILURE = FailureSegment(20, 50, ("right_forearm",), "truth", "error", 90.0, 33, "right_forearm")


def test_frames_are_spread_over_the_failure_and_have_its_worst_one():
    frames = film_frames(FAILURE, 10.0, 300)
    assert (frames[0], frames[-1], len(frames)) == (18, 52, 5)
    assert 33 in frames
    assert film_frames(FAILURE, 10.0, 51)[-1] == 50


@pytest.mark.parametrize("turns", range(4))
def test_a_click_is_at_the_pixel_that_is_shown_there(turns):
    """A white pixel of the camera's image, at its place in the cell and back."""
    image = np.zeros((100, 100, 3), dtype=np.uint8)
    image[62, 41] = 255
    window = Window(20.0, 30.0, 4.0, CELL, CELL)
    picture = np.rot90(window.cut(image), -turns)
    rows, columns = np.nonzero(picture[..., 0] > 200)
    cell = FilmCell("N", "N_right", 0, window, turns, (picture,))
    x, y = (columns.mean() + 0.5) / CELL, (rows.mean() + 0.5) / CELL
    assert cell.pixel_at(x, y) == pytest.approx((41.0, 62.0), abs=0.2)
    assert cell.place_of(cell.pixel_at(x, y)) == pytest.approx((x, y))


def test_cells_show_run_and_reference_around_the_limbs(tmp_path):
    recording, run, truth = recorded(tmp_path)
    film = Film(recording, (run,), truth, ("left_forearm",), (2, 6))
    with FrameReader(recording) as reader:
        cells = film.cells(reader)
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

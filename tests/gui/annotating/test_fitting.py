"""The fit of a whole recording in the background becomes the project's reference."""

import numpy as np
import pytest

from app.context import window_loop
from app.features.annotate.filling.reference_work import ReferenceWork
from app.session.jobs import TaskList
from stereotrack_core.annotation.fit.results import CLICKED, GAP, INTERPOLATED
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.annotation.reference import fit_of_reference
from stereotrack_core.project.clicks import place_clicks
from stereotrack_core.project.entries import load_reference
from stereotrack_core.project.fitting import FITTED
from stereotrack_core.project.marks import FrameFlag, flag_frames

FRAMES = 30


@pytest.fixture
def annotated(project, make):
    """Every fifth frame clicked, a gap in the middle."""
    project.apply(place_clicks(make.clicks_at(range(0, FRAMES, 5), sigma=1.0, seed=2)))
    project.apply(flag_frames(tuple(FrameFlag(frame, "", "gap") for frame in range(11, 15))))
    return project


@pytest.fixture
def work(qapp, annotated, recording):
    problems = []
    tasks = TaskList(window_loop(qapp), problems.append, lambda: None)
    shown = []
    made = ReferenceWork(tasks, lambda: shown.append(made.now), lambda: None)
    made.tasks, made.problems, made.shown = tasks, problems, shown
    made.set_project(annotated, recording, FRAMES)
    annotated.on_change(made.follow)
    yield made
    made.set_project(None, None, 0)
    tasks.shutdown()


def fitted(qtbot, work, frames=None):
    work.shown.clear()
    work.fit(frames)
    qtbot.waitUntil(lambda: any(now is not None for now in work.shown))
    qtbot.waitUntil(lambda: not work.fitting and not work.tasks.tasks)
    assert not work.problems
    return work.now


def test_it_is_near_the_truth_stored_whole_and_can_be_undone(
    qtbot, annotated, recording, work, make
):
    now = fitted(qtbot, work)
    assert now.name == FITTED == annotated.chosen(annotated.references)
    truth = np.stack([make.places_at(frame) for frame in range(FRAMES)])
    assert now.fit is not None
    known = now.fit.kind != GAP
    away = np.linalg.norm(now.fit.landmarks - truth, axis=-1)[known]
    assert np.median(away) < 0.02
    assert now.fit.kind[5] == CLICKED
    assert now.fit.kind[7] == INTERPOLATED
    assert now.fit.kind[12] == GAP
    assert "30 frames: 6 clicked, 20 interpolated, 4 in gaps" in now.words
    assert "limb uncertainty" in now.words
    fit, stored = now.fit, load_reference(annotated.references, FITTED)
    again = fit_of_reference(stored, NINE, annotated.clicks.all(), recording.cameras)
    np.testing.assert_array_equal(again.landmarks, fit.landmarks)
    np.testing.assert_array_equal(again.kind, fit.kind)
    assert again.residual_px.keys() == fit.residual_px.keys()
    for key, residual in fit.residual_px.items():
        np.testing.assert_allclose(again.residual_px[key], residual, atol=1e-6)
    annotated.undo()
    work.shown.clear()
    annotated.undo()
    qtbot.waitUntil(lambda: bool(work.shown))
    assert work.now is None


def test_a_selection_alone_is_filled_in(qtbot, annotated, work, make):
    now = fitted(qtbot, work, range(1, 4))
    assert now.reference.frame.tolist() == [1, 2, 3]
    assert now.fit.kind.tolist() == [INTERPOLATED] * 3
    now = fitted(qtbot, work, range(3, 8))
    assert now.reference.frame.tolist() == [1, 2, 3, 4, 5, 6, 7]


def test_it_can_be_stopped(qtbot, annotated, work):
    work.fit()
    work.tasks.cancel_all()
    qtbot.waitUntil(lambda: not work.fitting)
    assert not work.problems
    assert annotated.references.names() == ()
    assert fitted(qtbot, work).fit is not None  # another process has been started


def test_a_landmarks_own_gap_is_not_filled_in(qtbot, annotated, work):
    gap = range(16, 22)  # frame 20 is clicked
    annotated.apply(flag_frames(tuple(FrameFlag(frame, "left_hand", "gap") for frame in gap)))
    now = fitted(qtbot, work)
    hand, head = (NINE.names.index(name) for name in ("left_hand", "head"))
    known = np.isfinite(now.reference.points).all(axis=-1)
    assert now.reference.frame[~known[:, hand]].tolist() == [11, 12, 13, 14, 16, 17, 18, 19, 21]
    assert known[16:22, head].all()

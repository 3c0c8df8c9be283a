"""Predictions from the fit, a run and neighbours, made and taken with the window's commands."""

import threading
from dataclasses import replace

import numpy as np
import pytest

from app.widgets.timeline.lanes import Mark
from stereotrack_core.annotation.click import Click
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.annotation.propose import ACCEPTED_SIGMA, PROPOSED
from stereotrack_core.project import prefilling
from stereotrack_core.project.clicks import delete_clicks, place_clicks
from stereotrack_core.project.marks import FrameFlag, flag_frames
from stereotrack_core.project.prefilling import FIT
from stereotrack_core.recording.landmarks import LANDMARKS
from tests.gui.hands import trigger, undo_words, view

pytestmark = pytest.mark.window

BETWEEN = range(1, 7)


def done(window, qtbot, name):
    trigger(window, name, qtbot)


def truth(window, frame, landmark, camera):
    recording = window.context.session.document.recording
    row = int(np.searchsorted(recording.reference.frame, frame))
    point = recording.reference.points[row][LANDMARKS.index(landmark)]
    return tuple(float(v) for v in recording.cameras[camera].project(point))


def click_frames(window, frames):
    cameras = [one.image.camera for one in window.context.session.document.recording.views]
    window.context.session.project.project.apply(
        place_clicks(
            tuple(
                Click(frame, camera, name, truth(window, frame, name, camera))
                for frame in frames
                for camera in cameras
                for name in NINE.names
            )
        )
    )


def why_not(window, name):
    window.context.actions.refresh()
    assert not window.context.actions.action(name).isEnabled()
    return window.context.actions.command(name).why_not()


@pytest.fixture
def clicked(annotating, qtbot):
    """The first and the last frame are clicked, those between are selected."""
    click_frames(annotating, (0, 7))
    annotating.context.docks.timeline.set_selection(BETWEEN)
    annotating.features.annotate.panels._show_selection()
    qtbot.waitUntil(annotating.context.tasks.settled)
    return annotating


def off_px(window, predictions):
    return [
        np.hypot(*np.subtract(p.position, truth(window, p.frame, p.landmark, p.camera)))
        for p in predictions
    ]


def test_a_stretch_is_proposed_drawn_and_taken_as_one_edit(clicked, qtbot):
    project = clicked.context.session.project.project
    camera = clicked.context.session.document.recording.views[0].image.camera
    project.apply(flag_frames((FrameFlag(3, "left_hand", "gap"),)))
    project.apply(place_clicks((Click(2, camera, "head", (9.0, 9.0)),)))
    project.apply(delete_clicks((Click(2, camera, "head", (9.0, 9.0)).key,)))
    before = project.clicks.count()
    done(clicked, qtbot, "annotate-propose")
    kept = project.predictions.of_source(PROPOSED)
    places = len(BETWEEN) * len(NINE.names) * 2
    assert {p.frame for p in kept} == set(BETWEEN)
    assert len(kept) == places - 2 - 1, "the gap, and where a click was taken away"
    assert max(off_px(clicked, kept)) < 2.0
    assert project.clicks.count() == before
    clicked.context.session.document.go_to(4)
    qtbot.waitUntil(clicked.context.tasks.settled)
    lanes = {lane.id: lane.values for lane in clicked.context.docks.timeline.lanes}
    assert lanes["head"][5] == Mark.PROPOSED, "hatched"
    drawn = {mark.landmark for mark in view(clicked).marks.predictions}
    assert drawn == set(NINE.names)
    done(clicked, qtbot, "annotate-accept")
    assert project.clicks.count() == before + len(kept)
    assert "accept" in undo_words(clicked)
    done(clicked, qtbot, "undo")
    assert project.clicks.count() == before


def test_the_fit_fills_in_what_is_selected_once_there_is_one(clicked, qtbot):
    assert (
        why_not(clicked, "annotate-fill-fit")
        == "The whole recording has not been fitted yet. Choose Fit whole recording first."
    )
    done(clicked, qtbot, "annotate-fit")
    said = []
    clicked.statusBar().messageChanged.connect(lambda words: words and said.append(words))
    done(clicked, qtbot, "annotate-fill-fit")
    kept = clicked.context.session.project.project.predictions.of_source(FIT)
    assert said[-1] == f"{len(kept)} points predicted from the fit."
    assert {p.frame for p in kept} == set(BETWEEN)
    assert np.median(off_px(clicked, kept)) < 4.0
    assert all(p.sigma is not None and p.sigma > 0 for p in kept)
    before = clicked.context.session.project.project.clicks.count()
    done(clicked, qtbot, "annotate-accept-fit")
    assert clicked.context.session.project.project.clicks.count() == before + len(kept)
    done(clicked, qtbot, "annotate-accept-fit")
    assert "no points from the fit in frames 1 – 6" in clicked.messages.text()


def test_the_tracker_s_run_is_proposed_and_told_to_next(clicked, qtbot):
    assert (
        why_not(clicked, "annotate-fill-run") == "There is no finished run. Run the tracker first."
    )
    trigger(clicked, "run")
    assert clicked.features.annotate.predicting.run is None, "it still grows"
    qtbot.waitUntil(lambda: clicked.context.session.track.entry is None)
    qtbot.waitUntil(clicked.context.tasks.settled)
    entry = clicked.context.session.runs.active
    told = clicked.features.annotate.panels.next._run
    np.testing.assert_array_equal(told.points, entry.trajectory().points)
    clicked.context.actions.refresh()
    name = clicked.context.actions.action("annotate-fill-run").text()
    assert name == f"Fill from run “{entry.name}”"
    done(clicked, qtbot, "annotate-fill-run")
    kept = clicked.context.session.project.project.predictions.of_source(f"run {entry.name}")
    assert {p.frame for p in kept} == set(BETWEEN)
    assert np.median(off_px(clicked, kept)) < 15.0
    before = clicked.context.session.project.project.clicks.count()
    done(clicked, qtbot, "annotate-accept-run")
    certain = sum(p.sigma <= ACCEPTED_SIGMA for p in kept)
    assert 0 < certain < len(kept)
    assert clicked.context.session.project.project.clicks.count() == before + certain
    done(clicked, qtbot, "close")
    assert clicked.features.annotate.predicting.run is None


def test_it_can_be_stopped_and_keeps_nothing_then(clicked, qtbot, monkeypatch):
    """Cancel works between portions of frames; the first is made, the others are not."""
    work = clicked.features.annotate.predicting
    done(clicked, qtbot, "annotate-fit")
    made, cancelled, fit_filling = [], threading.Event(), prefilling.fit_filling

    def slowly(*arguments):
        filling = fit_filling(*arguments)
        whole = filling.make

        def make(frames):
            made.append(frames)
            assert cancelled.wait(30)
            return whole(frames)

        return replace(filling, make=make, at_once=2)

    monkeypatch.setattr(prefilling, "fit_filling", slowly)
    trigger(clicked, "annotate-fill-fit")
    assert work.busy
    qtbot.waitUntil(lambda: len(made) > 0)
    clicked.context.tasks.cancel_all()
    cancelled.set()
    qtbot.waitUntil(lambda: not work.busy)
    qtbot.waitUntil(clicked.context.tasks.settled)
    assert made == [range(1, 3)]
    assert clicked.context.session.project.project.predictions.of_source(FIT) == ()

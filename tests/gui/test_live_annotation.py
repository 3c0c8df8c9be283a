"""While somebody clicks: curves, predictions, the fitted body, mixed-up sides, overlays."""

import math

import numpy as np
import pytest
from PySide6.QtCore import Qt

from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.recording.landmarks import LANDMARKS
from tests.gui.hands import (
    CTRL,
    LEFT,
    SHIFT,
    annotate_all,
    click,
    click_truth,
    clicks,
    key,
    trigger,
    truth,
    undo_words,
    view,
)

pytestmark = pytest.mark.window


def test_one_click_gives_a_curve_two_a_prediction_that_one_key_accepts(annotating, qtbot):
    key(annotating, Qt.Key.Key_F2)  # left images too, so that there are four cameras
    key(annotating, Qt.Key.Key_F2, SHIFT)
    qtbot.waitUntil(annotating.context.tasks.settled, timeout=60_000)
    trigger(annotating, "advance_none")
    click_truth(annotating, "left_hand", "N")
    qtbot.waitUntil(annotating.context.tasks.settled, timeout=60_000)
    curves = view(annotating, "S").marks.curves
    assert [curve.from_view for curve in curves] == ["N"]
    x, y = truth(annotating, "left_hand", "S")
    away = np.linalg.norm(curves[0].points - (x, y), axis=1)
    assert away.min() < 8.0, "the curve passes through the landmark"
    assert view(annotating, "S").marks.predictions == ()
    annotating.context.view_state.choose_kind("left", "S")
    qtbot.waitUntil(annotating.context.tasks.settled, timeout=60_000)
    recording = annotating.context.session.document.recording
    point = recording.reference.points[0][LANDMARKS.index("left_hand")]
    click(annotating, *recording.cameras["S_left"].project(point), "S")
    annotating.context.view_state.choose_kind("image", "S")
    qtbot.waitUntil(annotating.context.tasks.settled, timeout=60_000)
    (prediction,) = [p for p in view(annotating, "S").marks.predictions if p.chosen]
    assert math.hypot(prediction.x - x, prediction.y - y) < 6.0
    assert len(clicks(annotating)) == 2, "a prediction never becomes a click by itself"
    assert np.isfinite(view(annotating, "N").marks.predictions[0].error_px)
    annotating.context.view_state.activate("S")
    key(annotating, Qt.Key.Key_Q, name="S")
    found = clicks(annotating)[("S_right", "left_hand")]
    assert found.origin == "accepted"
    assert found.position == pytest.approx((prediction.x, prediction.y))
    key(annotating, Qt.Key.Key_Q, name="S")
    assert len(annotating.context.session.project.project.history.entries()) == 3


def test_the_body_is_fitted_while_clicking(annotating, qtbot):
    annotating.features.annotate.clicking.toggle_depth()
    annotate_all(annotating, qtbot)
    fit = annotating.features.annotate.clicking.facts.now().fit
    assert fit is not None
    reference = annotating.context.session.document.recording.reference.points[0]
    places = np.array([fit.places[name] for name in LANDMARKS])
    assert np.linalg.norm(places - reference, axis=1).mean() < 0.05
    marks = view(annotating, "N").marks
    assert len(marks.residuals) == 9
    assert {mark.limb for mark in marks.model} >= {"torso", "left_forearm", "head"}
    table = annotating.features.annotate.clicking.landmarks.table.model()
    columns = table.columnCount()
    assert all(float(table.index(row, columns - 2).data()) < 10.0 for row in range(9))
    words = [row[0].text for row in annotating.features.annotate.clicking.body.tree.cells.rows]
    assert "left upper arm" in words
    assert "shoulder width" in words
    key(annotating, Qt.Key.Key_4)
    click(annotating, 20.0, 20.0)
    marks = view(annotating, "N").marks
    rows = annotating.features.annotate.clicking.body.tree.cells.rows
    assert marks.model_is_old, "until the fit to the new click is there"
    assert rows[0][2].text == "before the last click"
    qtbot.waitUntil(annotating.context.tasks.settled, timeout=60_000)
    marks = view(annotating, "N").marks
    rows = annotating.features.annotate.clicking.body.tree.cells.rows
    assert not marks.model_is_old
    assert rows[0][2].text != "before the last click"


def test_the_reference_never_leaks_into_what_is_predicted(annotating, qtbot):
    """Clicks that are all shifted alike are predicted where they say, not where truth is."""
    shift = {(name, landmark): (0.0, 14.0) for name in ("N", "S") for landmark in NINE.names}
    annotating.features.annotate.clicking.toggle_depth()
    annotate_all(annotating, qtbot, shift)
    fit = annotating.features.annotate.clicking.facts.now().fit
    reference = annotating.context.session.document.recording.reference.points[0]
    places = np.array([fit.places[name] for name in LANDMARKS])
    assert (places[:, 2] < reference[:, 2] - 0.03).mean() > 0.8


def test_mixed_up_sides_are_offered_to_be_exchanged(annotating, qtbot):
    annotate_all(annotating, qtbot)
    assert annotating.messages.message is None, annotating.messages.text()
    for landmark, other in (("left_elbow", "right_elbow"), ("right_elbow", "left_elbow")):
        annotating.features.annotate.clicking.annotating.choose(landmark)
        x, y = truth(annotating, other, "N")
        click(annotating, x, y, "N", CTRL)
    qtbot.waitUntil(annotating.context.tasks.settled, timeout=60_000)
    words = annotating.messages.text()
    assert "left elbow and right elbow" in words
    assert annotating.messages.do_button.isVisible()
    edits = len(annotating.context.session.project.project.history.entries())
    qtbot.mouseClick(annotating.messages.do_button, LEFT)
    qtbot.waitUntil(annotating.context.tasks.settled, timeout=60_000)
    assert annotating.messages.message is None
    assert len(annotating.context.session.project.project.history.entries()) == edits + 1
    assert "swap" in undo_words(annotating)


def test_the_reference_is_drawn_as_old_after_a_later_click(annotating, qtbot):
    def old():
        qtbot.waitUntil(annotating.context.tasks.settled, timeout=60_000)
        return view(annotating, "N").picture.overlay.reference_is_old

    def picture():
        return view(annotating, "N").grab().toImage()

    annotating.features.annotate.clicking.toggle_depth()
    annotate_all(annotating, qtbot)
    trigger(annotating, "annotate-fit")
    reference = annotating.features.annotate.panels.reference
    qtbot.waitUntil(lambda: reference.now is not None, timeout=120_000)
    key(annotating, Qt.Key.Key_R)
    assert not old(), "it was fitted a moment ago"
    fresh = picture()
    key(annotating, Qt.Key.Key_4)
    click(annotating, 20.0, 20.0)
    assert old()
    faded = picture()
    assert faded != fresh
    key(annotating, Qt.Key.Key_Z, CTRL)
    assert not old(), "the click is undone"
    key(annotating, Qt.Key.Key_4)
    click(annotating, 30.0, 20.0)
    assert old()
    trigger(annotating, "annotate-fit")
    assert not old(), "it was fitted again"

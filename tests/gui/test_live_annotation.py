"""While somebody clicks: curves, predictions, the fitted body, mixed-up sides, overlays."""

import math

import numpy as np
import pytest
from PySide6.QtCore import Qt

from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.recording.landmarks import LANDMARKS
from tests.gui import hands

pytestmark = pytest.mark.window


def test_one_click_gives_a_curve_two_a_prediction_that_one_key_accepts(annotating, qtbot):
    hands.key(annotating, Qt.Key.Key_F2)  # left images too, so that there are four cameras
    hands.key(annotating, Qt.Key.Key_F2, hands.SHIFT)
    qtbot.waitUntil(annotating.context.tasks.settled)
    hands.trigger(annotating, "advance_none")
    hands.click_truth(annotating, "left_hand", "N")
    qtbot.waitUntil(annotating.context.tasks.settled)
    curves = hands.view(annotating, "S").marks.curves
    assert [curve.from_view for curve in curves] == ["N"]
    x, y = hands.truth(annotating, "left_hand", "S")
    away = np.linalg.norm(curves[0].points - (x, y), axis=1)
    assert away.min() < 8.0, "the curve passes through the landmark"
    assert hands.view(annotating, "S").marks.predictions == ()
    annotating.context.view_state.choose_kind("left", "S")
    qtbot.waitUntil(annotating.context.tasks.settled)
    recording = annotating.context.session.document.recording
    point = recording.reference.points[0][LANDMARKS.index("left_hand")]
    hands.click(annotating, *recording.cameras["S_left"].project(point), "S")
    annotating.context.view_state.choose_kind("image", "S")
    qtbot.waitUntil(annotating.context.tasks.settled)
    (prediction,) = [p for p in hands.view(annotating, "S").marks.predictions if p.chosen]
    assert math.hypot(prediction.x - x, prediction.y - y) < 6.0
    assert len(hands.clicks(annotating)) == 2, "a prediction never becomes a click by itself"
    assert np.isfinite(hands.view(annotating, "N").marks.predictions[0].error_px)
    annotating.context.view_state.activate("S")
    hands.key(annotating, Qt.Key.Key_Q, name="S")
    found = hands.clicks(annotating)[("S_right", "left_hand")]
    assert found.origin == "accepted"
    assert found.position == pytest.approx((prediction.x, prediction.y))
    hands.key(annotating, Qt.Key.Key_Q, name="S")
    assert len(annotating.context.session.project.project.history.entries()) == 3


def test_the_body_is_fitted_while_clicking(annotating, qtbot):
    annotating.features.annotate.clicking.toggle_depth()
    hands.annotate_all(annotating, qtbot)
    fit = annotating.features.annotate.clicking.facts.now().fit
    assert fit is not None
    reference = annotating.context.session.document.recording.reference.points[0]
    places = np.array([fit.places[name] for name in LANDMARKS])
    assert np.linalg.norm(places - reference, axis=1).mean() < 0.05
    marks = hands.view(annotating, "N").marks
    assert len(marks.residuals) == 9
    assert {mark.limb for mark in marks.model} >= {"torso", "left_forearm", "head"}
    table = annotating.features.annotate.clicking.landmarks.table.model()
    columns = table.columnCount()
    assert all(float(table.index(row, columns - 2).data()) < 10.0 for row in range(9))
    words = [row[0].text for row in annotating.features.annotate.clicking.body.tree.cells.rows]
    assert "left upper arm" in words
    assert "shoulder width" in words
    hands.key(annotating, Qt.Key.Key_4)
    hands.click(annotating, 20.0, 20.0)
    marks = hands.view(annotating, "N").marks
    rows = annotating.features.annotate.clicking.body.tree.cells.rows
    assert marks.model_is_old, "until the fit to the new click is there"
    assert rows[0][2].text == "before the last click"
    qtbot.waitUntil(annotating.context.tasks.settled)
    marks = hands.view(annotating, "N").marks
    rows = annotating.features.annotate.clicking.body.tree.cells.rows
    assert not marks.model_is_old
    assert rows[0][2].text != "before the last click"


def test_the_reference_never_leaks_into_what_is_predicted(annotating, qtbot):
    """Clicks that are all shifted alike are predicted where they say, not where truth is."""
    shift = {(name, landmark): (0.0, 14.0) for name in ("N", "S") for landmark in NINE.names}
    annotating.features.annotate.clicking.toggle_depth()
    hands.annotate_all(annotating, qtbot, shift)
    fit = annotating.features.annotate.clicking.facts.now().fit
    reference = annotating.context.session.document.recording.reference.points[0]
    places = np.array([fit.places[name] for name in LANDMARKS])
    assert (places[:, 2] < reference[:, 2] - 0.03).mean() > 0.8


def test_mixed_up_sides_are_offered_to_be_exchanged(annotating, qtbot):
    hands.annotate_all(annotating, qtbot)
    assert annotating.messages.message is None, annotating.messages.text()
    for landmark, other in (("left_elbow", "right_elbow"), ("right_elbow", "left_elbow")):
        annotating.features.annotate.clicking.annotating.choose(landmark)
        x, y = hands.truth(annotating, other, "N")
        hands.click(annotating, x, y, "N", hands.CTRL)
    qtbot.waitUntil(annotating.context.tasks.settled)
    words = annotating.messages.text()
    assert ", frame 0: left elbow and right elbow" in words
    assert "px from the epipolar curves of the other views" in words
    assert annotating.messages.do_button.isVisible()
    edits = len(annotating.context.session.project.project.history.entries())
    qtbot.mouseClick(annotating.messages.do_button, hands.LEFT)
    qtbot.waitUntil(annotating.context.tasks.settled)
    assert annotating.messages.message is None
    assert len(annotating.context.session.project.project.history.entries()) == edits + 1
    assert "swap" in hands.undo_words(annotating)


def test_the_reference_is_drawn_as_old_after_a_later_click(annotating, qtbot):
    def old():
        qtbot.waitUntil(annotating.context.tasks.settled)
        return hands.view(annotating, "N").picture.overlay.reference_is_old

    def picture():
        return hands.view(annotating, "N").grab().toImage()

    annotating.features.annotate.clicking.toggle_depth()
    hands.annotate_all(annotating, qtbot)
    hands.trigger(annotating, "annotate-fit")
    reference = annotating.features.annotate.panels.reference
    qtbot.waitUntil(lambda: reference.now is not None)
    hands.key(annotating, Qt.Key.Key_R)
    assert not old(), "it was fitted a moment ago"
    fresh = picture()
    hands.key(annotating, Qt.Key.Key_4)
    hands.click(annotating, 20.0, 20.0)
    assert old()
    faded = picture()
    assert faded != fresh
    hands.key(annotating, Qt.Key.Key_Z, hands.CTRL)
    assert not old(), "the click is undone"
    hands.key(annotating, Qt.Key.Key_4)
    hands.click(annotating, 30.0, 20.0)
    assert old()
    hands.trigger(annotating, "annotate-fit")
    assert not old(), "it was fitted again"

"""Somebody annotates: real mouse and key events in the real window, edits in a real project."""

from __future__ import annotations

import math

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QInputDialog

from stereotrack_core.annotation.click import UNCERTAIN, ClickKey, Visibility
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.project.project import Project
from stereotrack_core.recording.landmarks import LANDMARKS

pytestmark = pytest.mark.window

NONE = Qt.KeyboardModifier.NoModifier
SHIFT = Qt.KeyboardModifier.ShiftModifier
CTRL = Qt.KeyboardModifier.ControlModifier
LEFT, RIGHT = Qt.MouseButton.LeftButton, Qt.MouseButton.RightButton


@pytest.fixture
def annotating(opened, qtbot):
    """The window in the workspace Annotate, with an empty project."""
    opened.show_workspace_named("annotate")
    qtbot.waitUntil(opened.settled, timeout=60_000)
    assert opened.project.why_no_edit() == ""
    return opened


def view(window, name="N"):
    return window.grid.tiles[name].camera


def at(window, x, y, name="N") -> QPoint:
    return view(window, name).place_of(x, y).toPoint()


def click(window, x, y, name="N", modifiers=NONE, button=LEFT):
    """Click near a raw pixel; the raw pixel that the cursor really was on."""
    place = at(window, x, y, name)
    pixel = view(window, name).pixel_at(place.toPointF())
    QTest.mouseClick(view(window, name), button, modifiers, place)
    return pixel.x(), pixel.y()


def drag(window, start, end, name="N", button=LEFT):
    QTest.mousePress(view(window, name), button, NONE, start)
    QTest.mouseMove(view(window, name), (start + end) / 2)
    QTest.mouseMove(view(window, name), end)
    QTest.mouseRelease(view(window, name), button, NONE, end)


def key(window, code, modifiers=NONE, name="N"):
    """Press a key while a view has the focus, as it has after a click."""
    view(window, name).setFocus()
    QTest.keyClick(view(window, name), code, modifiers)


def clicks(window, frame=None):
    frame = window.document.frame if frame is None else frame
    return {(c.camera, c.landmark): c for c in window.project.project.clicks.at(frame)}


def undo_words(window):
    return window.project.project.history.to_undo().words


def truth(window, landmark, name="N"):
    recording = window.document.recording
    place = int(np.searchsorted(recording.reference.frame, window.document.frame))
    point = recording.reference.points[place][LANDMARKS.index(landmark)]
    pixel = recording.reference_camera(recording.view(name)).project(point)
    return float(pixel[0]), float(pixel[1])


def click_truth(window, landmark, name="N", shift=(0.0, 0.0)):
    window.annotate.annotating.choose(landmark)
    x, y = truth(window, landmark, name)
    return click(window, x + shift[0], y + shift[1], name)


def test_a_click_places_the_chosen_landmark_exactly_and_the_next_is_chosen(annotating):
    key(annotating, Qt.Key.Key_3)
    x, y = click(annotating, 200.0, 150.0)
    found = clicks(annotating)[("N_right", "left_elbow")]
    assert found.position == pytest.approx((x, y), abs=1e-9)
    assert (found.visibility, found.origin) == (Visibility.SEEN, "hand")
    assert annotating.annotate.annotating.choice.landmark == "right_elbow"
    x, y = click(annotating, 300.0, 150.0)
    assert clicks(annotating)[("N_right", "right_elbow")].position == pytest.approx((x, y))
    assert undo_words(annotating) == "place right elbow in N_right, frame 0"


def test_every_landmark_has_its_key(annotating):
    for place, name in enumerate(NINE.names):
        key(annotating, Qt.Key(Qt.Key.Key_1 + place))
        assert annotating.annotate.annotating.choice.landmark == name
        table = annotating.landmarks_panel.table
        assert table.currentIndex().row() == place
        assert table.model().index(place, 0).data() == str(place + 1)


def test_the_panel_chooses_too(annotating, qtbot):
    table = annotating.landmarks_panel.table
    place = table.visualRect(table.model().index(6, 1)).center()
    qtbot.mouseClick(table.viewport(), LEFT, pos=place)
    click(annotating, 210.0, 90.0, "S")
    assert ("S_right", "head") in clicks(annotating)


def test_going_on_waits_for_all_views_or_not_at_all(annotating):
    book, chosen = annotating.actions_book, annotating.annotate.annotating
    book.action("advance_view").trigger()
    key(annotating, Qt.Key.Key_1)
    click(annotating, 200.0, 150.0)
    assert chosen.choice.landmark == "left_shoulder"
    click(annotating, 200.0, 150.0, "S")
    assert chosen.choice.landmark == "right_shoulder"
    book.action("advance_none").trigger()
    click(annotating, 250.0, 150.0)
    assert chosen.choice.landmark == "right_shoulder"
    assert annotating.settings.value("annotate/advance") == "none"


def test_clicks_are_placed_where_a_hand_lies_on_an_elbow(annotating):
    key(annotating, Qt.Key.Key_4)
    click(annotating, 200.0, 150.0)
    assert annotating.annotate.annotating.choice.landmark == "left_hand"
    click(annotating, 201.0, 150.0)
    assert {("N_right", "right_elbow"), ("N_right", "left_hand")} == set(clicks(annotating))


def test_dragging_a_handle_moves_its_click_and_nothing_else(annotating):
    key(annotating, Qt.Key.Key_1)
    click(annotating, 200.0, 150.0)
    click(annotating, 300.0, 150.0)
    before = clicks(annotating)[("N_right", "left_shoulder")]
    start = at(annotating, *before.position) + QPoint(8, -7)  # within 12 px, not on the dot
    drag(annotating, start, start + QPoint(30, 20))
    after = clicks(annotating)[("N_right", "left_shoulder")]
    scale = 1.0 / view(annotating)._scale()
    assert after.position[0] - before.position[0] == pytest.approx(30 * scale, abs=1e-6)
    assert after.position[1] - before.position[1] == pytest.approx(20 * scale, abs=1e-6)
    assert len(clicks(annotating)) == 2
    assert undo_words(annotating) == "move left shoulder in N_right, frame 0"
    key(annotating, Qt.Key.Key_Z, CTRL)
    assert clicks(annotating)[("N_right", "left_shoulder")].position == before.position


def test_a_drag_out_of_the_picture_does_nothing(annotating):
    key(annotating, Qt.Key.Key_1)
    click(annotating, 5.0, 150.0)
    before = clicks(annotating)
    start = at(annotating, 5.0, 150.0)
    drag(annotating, start, QPoint(-40, start.y()))
    assert clicks(annotating) == before
    outside = view(annotating).place_of(-30.0, 100.0).toPoint()
    QTest.mouseClick(view(annotating), LEFT, NONE, outside)
    assert clicks(annotating) == before


def test_arrow_keys_nudge_the_click_in_hand_and_are_one_edit(annotating, qtbot):
    key(annotating, Qt.Key.Key_1)
    click(annotating, 200.0, 150.0)
    x, y = clicks(annotating)[("N_right", "left_shoulder")].position
    key(annotating, Qt.Key.Key_E)
    for code, modifiers, by in (
        (Qt.Key.Key_Right, NONE, (0.5, 0)),
        (Qt.Key.Key_Right, CTRL, (0.1, 0)),
        (Qt.Key.Key_Down, SHIFT, (0, 1.0)),
        (Qt.Key.Key_Left, SHIFT, (-1.0, 0)),
        (Qt.Key.Key_Up, CTRL, (0, -0.1)),
    ):
        key(annotating, code, modifiers)
        x, y = x + by[0], y + by[1]
        found = clicks(annotating)[("N_right", "left_shoulder")].position
        assert found == pytest.approx((x, y), abs=1e-9)
    assert annotating.document.frame == 0
    assert annotating.grid.display.brightness == 0.0, "Ctrl+arrows are the light's otherwise"
    key(annotating, Qt.Key.Key_Z, CTRL)
    back = clicks(annotating)[("N_right", "left_shoulder")].position
    assert back == pytest.approx((x + 0.4, y - 0.9)), "five nudges are one edit"


def test_frame_stepping_keeps_its_keys(annotating, qtbot):
    key(annotating, Qt.Key.Key_1)
    click(annotating, 200.0, 150.0)
    key(annotating, Qt.Key.Key_Right)
    assert annotating.document.frame == 1, "nothing is in hand after placing with going on"
    key(annotating, Qt.Key.Key_Left)
    qtbot.waitUntil(annotating.settled, timeout=60_000)
    key(annotating, Qt.Key.Key_1)
    key(annotating, Qt.Key.Key_E)
    key(annotating, Qt.Key.Key_Period)
    assert annotating.document.frame == 1, "and full stop steps even then"
    key(annotating, Qt.Key.Key_Comma)
    qtbot.waitUntil(annotating.settled, timeout=60_000)
    key(annotating, Qt.Key.Key_E)
    key(annotating, Qt.Key.Key_Escape)
    key(annotating, Qt.Key.Key_Right)
    assert annotating.document.frame == 1
    assert annotating.project.project.history.entries()[0].words.startswith("place")


def test_del_clears_here_and_shift_del_everywhere(annotating):
    for name in ("N", "S"):
        for place in (Qt.Key.Key_1, Qt.Key.Key_2):
            key(annotating, place, name=name)
            click(annotating, 150.0 + 60 * (place == Qt.Key.Key_2), 120.0, name)
    key(annotating, Qt.Key.Key_Delete, name="S")
    assert ("S_right", "right_shoulder") not in clicks(annotating)
    assert annotating.annotate.annotating.choice.landmark == "right_shoulder"
    key(annotating, Qt.Key.Key_Delete, name="S")
    assert len(clicks(annotating)) == 3, "the same key again deletes nothing else"
    key(annotating, Qt.Key.Key_1, name="S")
    key(annotating, Qt.Key.Key_Delete, SHIFT, name="S")
    assert set(clicks(annotating)) == {("N_right", "right_shoulder")}
    assert undo_words(annotating) == "delete left shoulder in 2 cameras, frame 0"
    key(annotating, Qt.Key.Key_Z, CTRL)
    key(annotating, Qt.Key.Key_Z, CTRL)
    assert len(clicks(annotating)) == 4


def test_undo_and_redo_go_back_to_the_frame(annotating, qtbot):
    key(annotating, Qt.Key.Key_1)
    click(annotating, 200.0, 150.0)
    annotating.document.go_to(5)
    qtbot.waitUntil(annotating.settled, timeout=60_000)
    click(annotating, 220.0, 160.0)
    key(annotating, Qt.Key.Key_Z, CTRL)
    assert annotating.document.frame == 5
    key(annotating, Qt.Key.Key_Z, CTRL)
    assert annotating.document.frame == 0
    assert clicks(annotating, 0) == {}
    assert annotating.annotate.annotating.choice.landmark == "left_shoulder"
    key(annotating, Qt.Key.Key_Z, CTRL | SHIFT)
    key(annotating, Qt.Key.Key_Z, CTRL | SHIFT)
    assert annotating.document.frame == 5
    assert len(clicks(annotating, 0)) == len(clicks(annotating, 5)) == 1


def test_flags_on_keys(annotating, qtbot):
    key(annotating, Qt.Key.Key_1)
    click(annotating, 200.0, 150.0)
    place = ("N_right", "left_shoulder")
    key(annotating, Qt.Key.Key_B)
    assert clicks(annotating)[place].visibility == Visibility.GUESSED
    key(annotating, Qt.Key.Key_U)
    assert clicks(annotating)[place].flag == UNCERTAIN
    key(annotating, Qt.Key.Key_U)
    assert clicks(annotating)[place].flag == ""
    key(annotating, Qt.Key.Key_I)
    assert clicks(annotating)[place].visibility == Visibility.SEEN
    key(annotating, Qt.Key.Key_U, SHIFT)
    dialog = annotating.findChild(QInputDialog)
    dialog.setDoubleValue(4.5)
    dialog.accept()
    assert clicks(annotating)[place].sigma == 4.5
    key(annotating, Qt.Key.Key_X)
    found = clicks(annotating)[place]
    assert (found.visibility, found.position) == (Visibility.OUTSIDE, None)
    key(annotating, Qt.Key.Key_9)
    key(annotating, Qt.Key.Key_X)
    assert clicks(annotating)[("N_right", "right_hip")].visibility == Visibility.OUTSIDE
    click(annotating, 100.0, 100.0, modifiers=SHIFT)
    assert any(c.visibility == Visibility.GUESSED for c in clicks(annotating).values())


def test_the_right_button_picks_and_a_click_on_a_placed_landmark_picks(annotating):
    key(annotating, Qt.Key.Key_1)
    click(annotating, 200.0, 150.0)
    click(annotating, 200.0, 150.0, button=RIGHT)
    assert annotating.annotate.annotating.held() == ClickKey(0, "N_right", "left_shoulder")
    key(annotating, Qt.Key.Key_1)
    assert annotating.annotate.annotating.held() is None
    click(annotating, 200.0, 150.0)
    assert annotating.annotate.annotating.held() is not None
    assert len(annotating.project.project.history.entries()) == 1


def test_space_and_other_buttons_move_the_picture(annotating, qtbot):
    camera = view(annotating)
    camera.zoom_by(3.0)
    for button in (Qt.MouseButton.MiddleButton, RIGHT):
        before = camera.place_of(100.0, 100.0)
        drag(annotating, QPoint(150, 100), QPoint(180, 110), button=button)
        assert (camera.place_of(100.0, 100.0) - before).x() == pytest.approx(30, abs=1)
    before = camera.place_of(100.0, 100.0)
    camera.setFocus()
    QTest.keyPress(camera, Qt.Key.Key_Space)
    drag(annotating, QPoint(150, 100), QPoint(180, 110))
    QTest.keyRelease(camera, Qt.Key.Key_Space)
    assert (camera.place_of(100.0, 100.0) - before).x() == pytest.approx(30, abs=1)
    assert clicks(annotating) == {}
    assert not annotating.document.playing
    key(annotating, Qt.Key.Key_Space)
    assert annotating.document.playing, "a tap plays"
    annotating.document.pause()


def test_clicks_are_exact_when_zoomed_in_and_in_the_left_image(annotating, qtbot):
    camera = view(annotating)
    camera.zoom_by(6.0, camera.place_of(200.0, 150.0))
    key(annotating, Qt.Key.Key_1)
    x, y = click(annotating, 201.3, 149.6)
    found = clicks(annotating)[("N_right", "left_shoulder")].position
    assert found == pytest.approx((x, y), abs=1e-9)
    assert math.hypot(found[0] - 201.3, found[1] - 149.6) < 0.2
    key(annotating, Qt.Key.Key_F2)
    qtbot.waitUntil(annotating.settled, timeout=60_000)
    click(annotating, 200.0, 150.0)
    assert ("N_left", "right_shoulder") in clicks(annotating) or (
        "N_left",
        "left_shoulder",
    ) in clicks(annotating)


def test_computed_pictures_take_no_clicks_and_say_why(annotating, qtbot):
    key(annotating, Qt.Key.Key_F3)
    qtbot.waitUntil(annotating.settled, timeout=60_000)
    click(annotating, 200.0, 150.0)
    assert clicks(annotating) == {}
    assert "camera's own image" in annotating.statusBar().currentMessage()
    assert "F1" in annotating.statusBar().currentMessage()


def test_other_workspaces_take_no_clicks(annotating, qtbot):
    annotating.show_workspace_named("track")
    click(annotating, 200.0, 150.0)
    key(annotating, Qt.Key.Key_Delete)
    assert clicks(annotating) == {}
    why_not = annotating.actions_book.command("landmark_1").why_not()
    assert "workspace Annotate" in why_not


def test_one_click_gives_a_curve_two_a_prediction_that_one_key_accepts(annotating, qtbot):
    key(annotating, Qt.Key.Key_F2)  # left images too, so that there are four cameras
    key(annotating, Qt.Key.Key_F1)
    qtbot.waitUntil(annotating.settled, timeout=60_000)
    annotating.actions_book.action("advance_none").trigger()
    click_truth(annotating, "left_hand", "N")
    qtbot.waitUntil(annotating.settled, timeout=60_000)
    curves = view(annotating, "S").marks.curves
    assert [curve.from_view for curve in curves] == ["N"]
    x, y = truth(annotating, "left_hand", "S")
    away = np.linalg.norm(curves[0].points - (x, y), axis=1)
    assert away.min() < 8.0, "the curve passes through the landmark"
    assert view(annotating, "S").marks.predictions == ()
    annotating.grid.tiles["S"].set_kind("left")
    annotating.grid.kinds_changed.emit()
    qtbot.waitUntil(annotating.settled, timeout=60_000)
    recording = annotating.document.recording
    point = recording.reference.points[0][LANDMARKS.index("left_hand")]
    click(annotating, *recording.cameras["S_left"].project(point), "S")
    annotating.grid.tiles["S"].set_kind("image")
    annotating.grid.kinds_changed.emit()
    qtbot.waitUntil(annotating.settled, timeout=60_000)
    (prediction,) = [p for p in view(annotating, "S").marks.predictions if p.chosen]
    assert math.hypot(prediction.x - x, prediction.y - y) < 6.0
    assert len(clicks(annotating)) == 2, "a prediction never becomes a click by itself"
    assert np.isfinite(view(annotating, "N").marks.predictions[0].error_px)
    annotating.grid.set_active("S")
    key(annotating, Qt.Key.Key_A, name="S")
    found = clicks(annotating)[("S_right", "left_hand")]
    assert found.origin == "accepted"
    assert found.position == pytest.approx((prediction.x, prediction.y))
    key(annotating, Qt.Key.Key_A, name="S")
    assert len(annotating.project.project.history.entries()) == 3


def annotate_all(window, qtbot, shifts=None):
    for name in ("N", "S"):
        for landmark in NINE.names:
            click_truth(window, landmark, name, (shifts or {}).get((name, landmark), (0.0, 0.0)))
    qtbot.waitUntil(window.settled, timeout=120_000)


def test_the_body_is_fitted_while_clicking(annotating, qtbot):
    annotating.annotate.toggle_depth()
    annotate_all(annotating, qtbot)
    fit = annotating.annotate.facts.now().fit
    assert fit is not None
    reference = annotating.document.recording.reference.points[0]
    places = np.array([fit.places[name] for name in LANDMARKS])
    assert np.linalg.norm(places - reference, axis=1).mean() < 0.05
    marks = view(annotating, "N").marks
    assert len(marks.residuals) == 9
    assert {limb for limb, _ in marks.model} >= {"torso", "left_forearm", "head"}
    table = annotating.landmarks_panel.table.model()
    columns = table.columnCount()
    assert all(float(table.index(row, columns - 2).data()) < 10.0 for row in range(9))
    words = [
        annotating.body_panel.tree.topLevelItem(i).text(0)
        for i in range(annotating.body_panel.tree.topLevelItemCount())
    ]
    assert "left upper arm" in words
    assert "shoulder width" in words


def test_the_reference_never_leaks_into_what_is_predicted(annotating, qtbot):
    """Clicks that are all shifted alike are predicted where they say, not where truth is."""
    shift = {(name, landmark): (0.0, 14.0) for name in ("N", "S") for landmark in NINE.names}
    annotating.annotate.toggle_depth()
    annotate_all(annotating, qtbot, shift)
    fit = annotating.annotate.facts.now().fit
    reference = annotating.document.recording.reference.points[0]
    places = np.array([fit.places[name] for name in LANDMARKS])
    assert (places[:, 2] < reference[:, 2] - 0.03).mean() > 0.8


def test_mixed_up_sides_are_offered_to_be_exchanged(annotating, qtbot):
    annotate_all(annotating, qtbot)
    assert annotating.messages.message is None, annotating.messages.text()
    for landmark, other in (("left_elbow", "right_elbow"), ("right_elbow", "left_elbow")):
        annotating.annotate.annotating.choose(landmark)
        x, y = truth(annotating, other, "N")
        click(annotating, x, y, "N", CTRL)
    qtbot.waitUntil(annotating.settled, timeout=60_000)
    words = annotating.messages.text()
    assert "left elbow and right elbow" in words
    assert annotating.messages.do_button.isVisible()
    edits = len(annotating.project.project.history.entries())
    qtbot.mouseClick(annotating.messages.do_button, LEFT)
    qtbot.waitUntil(annotating.settled, timeout=60_000)
    assert annotating.messages.message is None
    assert len(annotating.project.project.history.entries()) == edits + 1
    assert "swap" in undo_words(annotating)


def test_overlays_are_switched_one_by_one(annotating, qtbot):
    annotate_all(annotating, qtbot, {("N", "left_hand"): (12.0, 9.0)})
    camera = view(annotating)
    for name in ("clicks", "predictions", "epipolar", "residuals", "fit"):
        with_it = camera.grab().toImage()
        annotating.actions_book.action(f"overlay_{name}").trigger()
        qtbot.waitUntil(annotating.settled, timeout=60_000)
        assert camera.grab().toImage() != with_it, name
        annotating.actions_book.action(f"overlay_{name}").trigger()
        qtbot.waitUntil(annotating.settled, timeout=60_000)


def test_a_click_is_painted_where_it_was_placed(annotating, qtbot):
    key(annotating, Qt.Key.Key_4)
    click(annotating, 200.0, 150.0)
    annotating.annotate.annotating.choose("head")
    place = at(annotating, *clicks(annotating)[("N_right", "right_elbow")].position)
    colour = view(annotating).grab().toImage().pixelColor(place)
    assert colour.name().lower() == NINE["right_elbow"].colour.lower()


def test_every_edit_is_in_the_file_at_once(annotating, qtbot):
    path = annotating.project.path
    key(annotating, Qt.Key.Key_1)
    for frame in range(3):
        annotating.document.go_to(frame)
        qtbot.waitUntil(annotating.settled, timeout=60_000)
        click(annotating, 200.0 + frame, 150.0)
        with Project.open(path, read_only=True) as other:
            assert len(other.clicks.at(frame)) == 1
            assert other.history.to_undo().words.endswith(f"frame {frame}")

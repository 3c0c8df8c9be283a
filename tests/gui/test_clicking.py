"""Somebody annotates: real mouse and key events in the real window, edits in a real project."""

import math

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest

from app.widgets.forms.form_dialog import FormDialog
from app.widgets.forms.numbers import NumberField
from stereotrack_core.annotation.click import UNCERTAIN, ClickKey, Visibility
from stereotrack_core.annotation.landmark_set import NINE
from tests.gui import hands

pytestmark = pytest.mark.window


def test_a_click_places_the_chosen_landmark_exactly_and_then_the_first_missing_one(annotating):
    hands.key(annotating, Qt.Key.Key_3)
    x, y = hands.click(annotating, 200.0, 150.0)
    found = hands.clicks(annotating)[("N_right", "left_elbow")]
    assert found.position == pytest.approx((x, y), abs=1e-9)
    assert (found.visibility, found.origin) == (Visibility.SEEN, "hand")
    assert annotating.features.annotate.clicking.annotating.choice.landmark == "left_shoulder"
    x, y = hands.click(annotating, 300.0, 150.0)
    assert hands.clicks(annotating)[("N_right", "left_shoulder")].position == pytest.approx((x, y))
    assert hands.undo_words(annotating) == "place left shoulder in N_right, frame 0"


@pytest.mark.parametrize("accepted", [True, False])
def test_a_click_is_drawn_before_it_is_stored_and_goes_again_if_it_is_refused(
    annotating, monkeypatch, accepted
):
    project, drawn = annotating.context.session.project, []
    store = project.apply

    def apply(edit, **how):
        drawn.append([mark.landmark for mark in hands.view(annotating).marks.clicks])
        return store(edit, **how) if accepted else None

    monkeypatch.setattr(project, "apply", apply)
    hands.key(annotating, Qt.Key.Key_3)
    hands.click(annotating, 200.0, 150.0)
    assert drawn == [["left_elbow"]]
    left = [mark.landmark for mark in hands.view(annotating).marks.clicks]
    assert left == ["left_elbow"] * accepted
    assert len(hands.clicks(annotating)) == accepted


def test_every_landmark_has_its_key(annotating):
    for place, name in enumerate(NINE.names):
        hands.key(annotating, Qt.Key(Qt.Key.Key_1 + place))
        assert annotating.features.annotate.clicking.annotating.choice.landmark == name
        table = annotating.features.annotate.clicking.landmarks.table
        assert table.currentIndex().row() == place
        assert table.model().index(place, 0).data() == str(place + 1)


def test_clicks_are_placed_where_a_hand_lies_on_an_elbow(annotating):
    hands.key(annotating, Qt.Key.Key_4)
    hands.click(annotating, 200.0, 150.0)
    assert annotating.features.annotate.clicking.annotating.choice.landmark == "left_shoulder"
    hands.click(annotating, 201.0, 150.0)
    assert {("N_right", "right_elbow"), ("N_right", "left_shoulder")} == set(
        hands.clicks(annotating)
    )


def test_dragging_a_handle_moves_its_click_and_nothing_else(annotating):
    hands.key(annotating, Qt.Key.Key_1)
    hands.click(annotating, 200.0, 150.0)
    hands.click(annotating, 300.0, 150.0)
    before = hands.clicks(annotating)[("N_right", "left_shoulder")]
    start = hands.at(annotating, *before.position) + QPoint(8, -7)  # within 12 px, not on the dot
    hands.drag(annotating, start, start + QPoint(30, 20))
    after = hands.clicks(annotating)[("N_right", "left_shoulder")]
    scale = 1.0 / hands.view(annotating)._scale()
    assert after.position[0] - before.position[0] == pytest.approx(30 * scale, abs=1e-6)
    assert after.position[1] - before.position[1] == pytest.approx(20 * scale, abs=1e-6)
    assert len(hands.clicks(annotating)) == 2
    assert hands.undo_words(annotating) == "move left shoulder in N_right, frame 0"
    hands.key(annotating, Qt.Key.Key_Z, hands.CTRL)
    assert hands.clicks(annotating)[("N_right", "left_shoulder")].position == before.position


def test_alt_and_arrow_keys_nudge_the_click_in_hand_and_are_one_edit(annotating, qtbot):
    hands.key(annotating, Qt.Key.Key_1)
    hands.click(annotating, 200.0, 150.0)
    x, y = hands.clicks(annotating)[("N_right", "left_shoulder")].position
    hands.key(annotating, Qt.Key.Key_E)
    for code, modifiers, by in (
        (Qt.Key.Key_Right, hands.ALT, (0.5, 0)),
        (Qt.Key.Key_Right, hands.ALT | hands.CTRL, (0.1, 0)),
        (Qt.Key.Key_Down, hands.ALT | hands.SHIFT, (0, 1.0)),
        (Qt.Key.Key_Left, hands.ALT | hands.SHIFT, (-1.0, 0)),
        (Qt.Key.Key_Up, hands.ALT | hands.CTRL, (0, -0.1)),
    ):
        hands.key(annotating, code, modifiers)
        x, y = x + by[0], y + by[1]
        found = hands.clicks(annotating)[("N_right", "left_shoulder")].position
        assert found == pytest.approx((x, y), abs=1e-9)
    assert annotating.context.session.document.frame == 0
    hands.key(annotating, Qt.Key.Key_Z, hands.CTRL)
    back = hands.clicks(annotating)[("N_right", "left_shoulder")].position
    assert back == pytest.approx((x + 0.4, y - 0.9)), "five nudges are one edit"
    hands.key(annotating, Qt.Key.Key_Right)
    assert annotating.context.session.document.frame == 1, "arrows alone step"
    assert hands.clicks(annotating, 0)[("N_right", "left_shoulder")].position == back


def test_the_last_click_stays_in_hand_whatever_has_the_focus(annotating, qtbot):
    document, features = annotating.context.session.document, annotating.features.annotate
    hands.key(annotating, Qt.Key.Key_1)
    hands.point_and_click(annotating, 200.0, 150.0)
    assert features.clicking.annotating.choice.landmark == "right_shoulder"
    hands.point(annotating, 100.0, 100.0, "S")
    place, clicked = ("N_right", "left_shoulder"), hands.clicks(annotating)
    x, y = clicked[place].position
    lists = (
        *(features.clicking.landmarks.table, features.panels.next_panel.tree),
        annotating.context.docks.timeline,
    )
    for widget in (hands.view(annotating, "S"), *lists):
        widget.setFocus()
        for code, by in ((Qt.Key.Key_Right, (0.5, 0.0)), (Qt.Key.Key_Up, (0.0, -0.5))):
            x, y = x + by[0], y + by[1]
            QTest.keyClick(widget, code, hands.ALT)
            assert hands.clicks(annotating)[place].position == pytest.approx((x, y), abs=1e-9), (
                widget
            )
    assert document.frame == 0
    field = annotating.context.docks.transport.number
    field.setFocus()
    for code in (Qt.Key.Key_Right, Qt.Key.Key_3):
        QTest.keyClick(field, code)
    assert features.clicking.annotating.choice.landmark == "left_shoulder"
    QTest.keyClick(field, Qt.Key.Key_Up)
    assert document.frame > 0
    hands.key(annotating, Qt.Key.Key_Home)
    qtbot.waitUntil(annotating.context.tasks.settled)
    QTest.keyClick(features.clicking.landmarks.table, Qt.Key.Key_Right)
    assert document.frame == 1, "another frame, and nothing is in hand"
    assert hands.clicks(annotating, 0)[place].position == pytest.approx((x, y), abs=1e-9)


def test_single_keys_work_whatever_list_has_the_focus(annotating, qtbot):
    document, features = annotating.context.session.document, annotating.features.annotate
    annotating_ = features.clicking.annotating
    for widget in (
        *(features.clicking.landmarks.table, features.panels.next_panel.tree),
        annotating.context.docks.timeline,
    ):
        widget.setFocus()
        hands.click(annotating, 200.0, 150.0)  # no time passes until the key
        QTest.keyClick(widget, Qt.Key.Key_B)
        assert annotating_.at_hand().visibility == Visibility.GUESSED, widget
        QTest.keyClick(widget, Qt.Key.Key_Delete)
        assert hands.clicks(annotating) == {}, widget
        QTest.keyClick(widget, Qt.Key.Key_5)
        assert annotating_.choice.landmark == "left_hand", widget
        QTest.keyClick(widget, Qt.Key.Key_PageDown)
        assert annotating_.choice.landmark == "right_hand", widget
        QTest.keyClick(widget, Qt.Key.Key_Right)
        assert document.frame == 1, widget
        QTest.keyClick(widget, Qt.Key.Key_Comma)
        assert document.frame == 0, widget
        qtbot.waitUntil(annotating.context.tasks.settled)
        hands.key(annotating, Qt.Key.Key_1)


def test_del_clears_here_and_shift_del_everywhere(annotating):
    for name in ("N", "S"):
        for place in (Qt.Key.Key_1, Qt.Key.Key_2):
            hands.key(annotating, place, name=name)
            hands.click(annotating, 150.0 + 60 * (place == Qt.Key.Key_2), 120.0, name)
    hands.key(annotating, Qt.Key.Key_Delete, name="S")
    assert ("S_right", "right_shoulder") not in hands.clicks(annotating)
    assert annotating.features.annotate.clicking.annotating.choice.landmark == "right_shoulder"
    hands.key(annotating, Qt.Key.Key_Delete, name="S")
    assert len(hands.clicks(annotating)) == 3, "the same key again deletes nothing else"
    hands.key(annotating, Qt.Key.Key_1, name="S")
    hands.key(annotating, Qt.Key.Key_Delete, hands.SHIFT, name="S")
    assert set(hands.clicks(annotating)) == {("N_right", "right_shoulder")}
    assert hands.undo_words(annotating) == "delete left shoulder in 2 cameras, frame 0"
    hands.key(annotating, Qt.Key.Key_Z, hands.CTRL)
    hands.key(annotating, Qt.Key.Key_Z, hands.CTRL)
    assert len(hands.clicks(annotating)) == 4


def test_flags_on_keys(annotating, qtbot):
    hands.key(annotating, Qt.Key.Key_1)
    hands.click(annotating, 200.0, 150.0)
    place = ("N_right", "left_shoulder")
    hands.key(annotating, Qt.Key.Key_B)
    assert hands.clicks(annotating)[place].visibility == Visibility.GUESSED
    hands.key(annotating, Qt.Key.Key_U)
    assert hands.clicks(annotating)[place].flag == UNCERTAIN
    hands.key(annotating, Qt.Key.Key_U)
    assert hands.clicks(annotating)[place].flag == ""
    hands.key(annotating, Qt.Key.Key_I)
    assert hands.clicks(annotating)[place].visibility == Visibility.SEEN
    hands.key(annotating, Qt.Key.Key_U, hands.SHIFT)
    dialog = next(one for one in annotating.findChildren(FormDialog) if one.isVisible())
    QTest.keyClicks(dialog.findChild(NumberField), "4,5")
    dialog.accept_button.click()
    assert hands.clicks(annotating)[place].sigma == 4.5
    hands.key(annotating, Qt.Key.Key_E)
    hands.key(annotating, Qt.Key.Key_X)
    found = hands.clicks(annotating)[place]
    assert (found.visibility, found.position) == (Visibility.OUTSIDE, None)
    hands.key(annotating, Qt.Key.Key_9)
    hands.key(annotating, Qt.Key.Key_X)
    assert hands.clicks(annotating)[("N_right", "right_hip")].visibility == Visibility.OUTSIDE
    hands.click(annotating, 100.0, 100.0, modifiers=hands.SHIFT)
    assert any(c.visibility == Visibility.GUESSED for c in hands.clicks(annotating).values())


def test_the_right_button_picks_and_a_click_on_a_placed_landmark_picks(annotating):
    hands.key(annotating, Qt.Key.Key_1)
    hands.click(annotating, 200.0, 150.0)
    hands.click(annotating, 200.0, 150.0, button=hands.RIGHT)
    assert annotating.features.annotate.clicking.annotating.held() == ClickKey(
        0, "N_right", "left_shoulder"
    )
    hands.key(annotating, Qt.Key.Key_1)
    assert annotating.features.annotate.clicking.annotating.held() is None
    hands.click(annotating, 200.0, 150.0)
    assert annotating.features.annotate.clicking.annotating.held() is not None
    assert len(annotating.context.session.project.project.history.entries()) == 1


def test_the_middle_and_the_right_button_move_the_picture(annotating, qtbot):
    camera = hands.view(annotating)
    camera.zoom_by(3.0)
    before = camera.place_of(100.0, 100.0)
    for moved, button in enumerate((Qt.MouseButton.MiddleButton, hands.RIGHT), start=1):
        hands.drag(annotating, QPoint(150, 100), QPoint(180, 110), button=button)
        assert (camera.place_of(100.0, 100.0) - before).x() == pytest.approx(30 * moved, abs=1)
    assert hands.clicks(annotating) == {}
    camera.setFocus()
    hands.key(annotating, Qt.Key.Key_Space)
    assert annotating.context.session.document.playing
    annotating.context.session.document.pause()


def test_clicks_are_exact_when_zoomed_in_and_in_the_left_image(annotating, qtbot):
    camera = hands.view(annotating)
    camera.zoom_by(6.0, camera.place_of(200.0, 150.0))
    hands.key(annotating, Qt.Key.Key_1)
    x, y = hands.click(annotating, 201.3, 149.6)
    found = hands.clicks(annotating)[("N_right", "left_shoulder")].position
    assert found == pytest.approx((x, y), abs=1e-9)
    assert math.hypot(found[0] - 201.3, found[1] - 149.6) < 0.2
    hands.key(annotating, Qt.Key.Key_F2)
    qtbot.waitUntil(annotating.context.tasks.settled)
    hands.click(annotating, 200.0, 150.0)
    assert ("N_left", "right_shoulder") in hands.clicks(annotating) or (
        "N_left",
        "left_shoulder",
    ) in hands.clicks(annotating)


def test_computed_pictures_take_no_clicks_and_say_why(annotating, qtbot):
    hands.key(annotating, Qt.Key.Key_F3)
    qtbot.waitUntil(annotating.context.tasks.settled)
    hands.click(annotating, 200.0, 150.0)
    assert hands.clicks(annotating) == {}
    assert "this image is computed" in annotating.statusBar().currentMessage()
    assert "Shift+F2" in annotating.statusBar().currentMessage()

"""Which landmark a click places: the first that the view under the cursor has not, said before."""

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from stereotrack_core.annotation.click import ClickKey, Visibility
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.project.marks import mark_keyframes
from tests.gui import hands

pytestmark = pytest.mark.window

VIEWS = "NOSW"


def annotate_view(window, name, landmarks=NINE.names):
    """Click landmarks in this order where they are in a view; where the cursor really was."""
    return {
        (f"{name}_right", landmark): hands.point_and_click(
            window, *hands.truth(window, landmark, name), name
        )
        for landmark in landmarks
    }


def said(window, name):
    """What stands at the cursor in a view."""
    return hands.view(window, name).label.words


def positions(window):
    return {key: click.position for key, click in hands.clicks(window).items()}


def test_a_frame_of_four_views_needs_36_clicks_and_no_key(four, qtbot):
    document, project = four.context.session.document, four.context.session.project.project
    wanted = {0: {}, 1: {}}
    for name in "NOSW":
        wanted[0] |= annotate_view(four, name)
    assert document.frame == 0
    assert len(project.history.entries()) == 36, "a click, an edit"
    hands.key(four, Qt.Key.Key_Z, hands.CTRL, "W")
    assert said(four, "W") == "right hip", "what was taken back is the next one again"
    hands.trigger(four, "advance_frame")
    wanted[0] |= annotate_view(four, "W", ["right_hip"])
    for place, name in enumerate("WSNO"):
        assert document.frame == 1
        qtbot.waitUntil(four.context.tasks.settled)
        assert place or said(four, "W") == "left shoulder", "without a move of the mouse"
        wanted[1] |= annotate_view(four, name)
    assert document.frame == 2
    for frame, places in wanted.items():
        found = hands.clicks(four, frame)
        assert len(found) == 36
        for place, pixel in places.items():
            assert found[place].position == pytest.approx(pixel, abs=1e-9), place
    assert project.clicks.count() == 72
    qtbot.waitUntil(four.context.tasks.settled)
    hands.key(four, Qt.Key.Key_Z, hands.CTRL, "O")
    qtbot.waitUntil(four.context.tasks.settled)
    assert document.frame == 1
    assert said(four, "O") == "right hip", "also in the frame before"
    hands.key(four, Qt.Key.Key_X, name="O")
    assert document.frame == 2, "what is marked as outside is done as well"
    hands.trigger(four, "advance_frame")


def test_one_landmark_goes_through_the_keyframes(four, qtbot):
    document, project = four.context.session.document, four.context.session.project.project
    project.apply(mark_keyframes((0, 2)))
    for name in ("advance_none", "advance_frame"):
        hands.trigger(four, name)
    for frame in (0, 2):
        assert document.frame == frame
        qtbot.waitUntil(four.context.tasks.settled)
        for name in VIEWS:
            hands.point_and_click(four, 100.0, 100.0, name)
    assert "No keyframe follows" in four.statusBar().currentMessage()
    hands.point_and_click(four, 140.0, 140.0, "N")
    assert document.frame == 2, "a click that is moved finishes nothing"
    assert len(hands.clicks(four, 0)) == len(hands.clicks(four, 2)) == 4
    hands.trigger(four, "advance_frame")


def test_the_name_stands_at_the_cursor_before_the_click(four, qtbot):
    label = hands.view(four, "O").label
    assert not label.isVisible()
    hands.point(four, 100.0, 100.0, "O")
    assert said(four, "O") == "left shoulder"
    assert label.colour == NINE["left_shoulder"].colour
    before = label.pos()
    hands.point(four, 140.0, 100.0, "O")
    assert label.pos().x() > before.x(), "it follows the mouse"
    assert said(four, "N") == ""
    hands.point(four, 100.0, 100.0, "N")
    assert (said(four, "O"), said(four, "N")) == ("", "left shoulder")
    place = four.context.docks.timeline.mapTo(four, four.context.docks.timeline.rect().center())
    QTest.mouseMove(four.windowHandle(), place)
    QApplication.processEvents()
    assert said(four, "N") == "", "gone with the mouse"
    four.context.view_state.choose_kind("disparity", "N")
    qtbot.waitUntil(four.context.tasks.settled)
    hands.point(four, 100.0, 100.0, "N")
    assert said(four, "N") == "", "a computed picture takes no clicks"
    four.context.docks.show_named("track")
    hands.point(four, 100.0, 100.0, "O")
    assert said(four, "O") == ""


@pytest.mark.parametrize("loupe", [False, True])
def test_the_name_stays_inside_its_view(four, loupe):
    camera = hands.view(four, "W")
    if loupe:
        hands.key(four, Qt.Key.Key_L, name="W")
    for landmarks in (0, 9):
        if landmarks:
            annotate_view(four, "W")
        height, width = camera.picture.pixels.shape[:2]
        for x in (0.0, 0.5, 1.0):
            for y in (0.0, 0.5, 1.0):
                hands.point(four, 1.0 + x * (width - 3.0), 1.0 + y * (height - 3.0), "W")
                assert said(four, "W"), (x, y)
                assert camera.rect().contains(camera.label.geometry())
                place = hands.at(four, 1.0 + x * (width - 3.0), 1.0 + y * (height - 3.0), "W")
                assert not camera.label.geometry().contains(place), "the pixel is not hidden"


def test_a_key_wins_for_one_click_in_whichever_view(four):
    hands.point_and_click(four, 100.0, 100.0, "N")
    hands.key(four, Qt.Key.Key_6, name="N")
    assert said(four, "N") == "right hand"
    hands.point(four, 100.0, 100.0, "S")
    assert said(four, "S") == "right hand"
    hands.click(four, 100.0, 100.0, "S")
    assert set(hands.clicks(four)) == {("N_right", "left_shoulder"), ("S_right", "right_hand")}
    assert said(four, "S") == "left shoulder"
    hands.point(four, 130.0, 100.0, "N")
    assert said(four, "N") == "right shoulder"
    hands.key(four, Qt.Key.Key_1, name="N")
    assert said(four, "N") == "move left shoulder here"
    hands.click(four, 150.0, 120.0)
    assert hands.undo_words(four) == "place left shoulder in N_right, frame 0"
    assert len(hands.clicks(four)) == 2


def test_when_all_is_clicked_a_click_changes_nothing_and_it_is_said(four):
    annotate_view(four, "N")
    before, edits = positions(four), len(four.context.session.project.project.history.entries())
    words = "all nine are clicked here: drag to move, 1-9 to select one"
    hands.point(four, 20.0, 200.0, "N")
    assert said(four, "N") == words
    hands.point_and_click(four, 20.0, 200.0, "N")
    hands.point_and_click(four, 20.0, 200.0, "N", hands.CTRL)
    assert positions(four) == before
    assert len(four.context.session.project.project.history.entries()) == edits
    assert words[1:] in four.statusBar().currentMessage()
    x, y = before[("N_right", "left_hand")]
    hands.point(four, x, y, "N")
    assert said(four, "N") == "left hand: click to select, drag to move"
    hands.click(four, x, y)
    assert four.features.annotate.clicking.annotating.held() == ClickKey(0, "N_right", "left_hand")
    assert positions(four) == before
    hands.key(four, Qt.Key.Key_Escape)
    start = hands.at(four, x, y)
    hands.drag(four, start, start + QPoint(20, 10))
    moved = positions(four)
    assert {name for name in before if before[name] != moved[name]} == {("N_right", "left_hand")}
    hands.key(four, Qt.Key.Key_2)
    hands.point_and_click(four, 20.0, 200.0, "N")
    again = positions(four)
    assert {name for name in before if again[name] != moved[name]} == {
        ("N_right", "right_shoulder")
    }
    assert said(four, "N") != "", "and then all are clicked once more"
    hands.point_and_click(four, 25.0, 220.0, "N")
    assert positions(four) == again


def test_outside_is_what_is_named_and_not_the_click_before(four):
    hands.point_and_click(four, 100.0, 100.0, "N")
    hands.key(four, Qt.Key.Key_X)
    found = hands.clicks(four)
    assert found[("N_right", "left_shoulder")].position is not None
    assert found[("N_right", "right_shoulder")].visibility == Visibility.OUTSIDE
    assert said(four, "N") == "left elbow"


def test_the_choice_stays_where_the_person_wants_it_to(four):
    hands.trigger(four, "advance_none")
    hands.key(four, Qt.Key.Key_3)
    for name in "NS":
        hands.point_and_click(four, 100.0, 100.0, name)
        assert said(four, name).startswith("left elbow: click to select")
        hands.point(four, 160.0, 140.0, name)
        assert said(four, name) == "move left elbow here"
    four.context.session.document.go_to(1)
    assert four.features.annotate.clicking.annotating.choice.landmark == "left_elbow"
    assert {landmark for _, landmark in hands.clicks(four, 0)} == {"left_elbow"}


def test_a_second_click_on_a_picture_that_is_about_to_change_moves_nothing(four):
    camera, place = hands.view(four, "N"), hands.at(four, 100.0, 100.0)
    QTest.mouseClick(camera, hands.LEFT, hands.NONE, place)
    four.context.session.document.go_to(2)  # its pictures are still on their way
    for shift in (QPoint(20, 0), QPoint(40, 0)):
        QTest.mouseClick(camera, hands.LEFT, hands.NONE, place + shift)
    found = {landmark: one.position for (_, landmark), one in hands.clicks(four, 0).items()}
    wanted = camera.pixel_at((place + QPoint(20, 0)).toPointF())
    assert set(found) == {"left_shoulder", "right_shoulder"}
    assert found["right_shoulder"][0] == pytest.approx(wanted.x())

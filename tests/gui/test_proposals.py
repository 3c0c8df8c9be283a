"""No frame starts empty: proposals come by themselves, are accepted with keys, and corrected."""

from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import Qt

from app.session.changes import Part
from app.widgets.timeline.lanes import Mark
from stereotrack_core.annotation.click import ACCEPTED, Click, ClickKey, Visibility
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.interop.labels import read_clicks, write_clicks
from stereotrack_core.project.clicks import mark_clicks, place_clicks
from stereotrack_core.project.prefilling import set_accepted_sigma
from tests.gui.hands import (
    ALT,
    CTRL,
    SHIFT,
    at,
    clicks,
    drag,
    key,
    point,
    point_and_click,
    settle,
    truth,
    undo_words,
    view,
)

pytestmark = pytest.mark.window

VIEWS = "NOSW"


def click_all_but_one(window, frame=0):
    """All landmarks in all views where they are, but the last view's head."""
    places = [(f"{view}_right", name, truth(window, name, view)) for view in VIEWS
              for name in NINE.names]  # fmt: skip
    made = tuple(Click(frame, *place) for place in places if place[:2] != ("W_right", "head"))
    window.context.session.project.project.apply(place_clicks(made))


def proposed(window, name):
    return {m.landmark: (m.x, m.y) for m in view(window, name).marks.predictions if m.proposed}


def origins(window, name):
    return [one.origin for one in clicks(window).values() if one.camera == f"{name}_right"]


def test_the_next_frame_is_there_to_be_accepted_and_corrected(four, qtbot, monkeypatch):
    project = four.context.session.project.project
    monkeypatch.setattr(four.features.annotate.clicking.annotating, "goes_on", True)
    click_all_but_one(four)
    point_and_click(four, *truth(four, "head", "W"), "W")
    assert four.context.session.document.frame == 1, "the frame is clicked, the next one follows"
    settle(four, qtbot)
    for name in VIEWS:
        found = proposed(four, name)
        assert set(found) == set(NINE.names)
        for landmark, place in found.items():
            assert place == pytest.approx(truth(four, landmark, name), abs=3.0)
    assert project.clicks.at(1) == (), "a proposal is no click"
    lanes = {lane.id: lane.values for lane in four.context.docks.timeline.lanes}
    assert {lanes[name][1] for name in NINE.names} == {Mark.PROPOSED}, "hatched"

    point(four, 100.0, 100.0, "N")
    key(four, Qt.Key.Key_Q, SHIFT, name="N")
    assert origins(four, "N") == [ACCEPTED] * 9
    assert len(clicks(four)) == 9
    settle(four, qtbot)
    key(four, Qt.Key.Key_Z, CTRL, name="N")
    assert len(clicks(four)) == 0, "taken back as one step"
    settle(four, qtbot)

    before = {name: proposed(four, name)["left_hand"] for name in "NSW"}
    start = proposed(four, "O")["left_hand"]
    drag(four, at(four, *start, "O"), at(four, start[0] + 16.0, start[1] + 9.0, "O"), "O")
    settle(four, qtbot)
    (own,) = clicks(four).values()
    assert (own.landmark, own.camera, own.origin) == ("left_hand", "O_right", "hand")
    assert own.position == pytest.approx((start[0] + 16.0, start[1] + 9.0), abs=4.0)
    moved = {n: np.hypot(*np.subtract(proposed(four, n)["left_hand"], before[n])) for n in before}
    assert max(moved.values()) > 4.0, "the other views of the landmark follow"

    key(four, Qt.Key.Key_Q, name="N")
    assert "accept" in undo_words(four)
    assert sorted(click.origin for click in clicks(four, 1).values()) == [ACCEPTED] * 35 + ["hand"]
    assert four.context.session.document.frame == 2, "all is clicked, so it goes on"
    settle(four, qtbot)
    assert set(proposed(four, "S")) == set(NINE.names)
    four.context.session.document.visit(1)
    settle(four, qtbot)
    assert not proposed(four, "S")
    key(four, Qt.Key.Key_Z, CTRL, name="N")
    assert len(clicks(four)) == 1


def test_what_is_uncertain_stays_open_and_visibility_survives(four, qtbot, monkeypatch, tmp_path):
    project = four.context.session.project.project
    clicking = four.features.annotate.clicking
    monkeypatch.setattr(clicking.annotating, "goes_on", True)
    places = [(f"{view}_right", name, truth(four, name, view)) for view in VIEWS
              for name in NINE.names]  # fmt: skip
    project.apply(place_clicks(tuple(Click(0, *place) for place in places)))
    guessed = [ClickKey(0, "N_right", name) for name in ("left_shoulder", "left_elbow", "left_hip")]
    project.apply(mark_clicks(tuple(guessed), visibility=Visibility.GUESSED))
    outside = ClickKey(0, "O_right", "left_hand")
    project.apply(mark_clicks((outside,), visibility=Visibility.OUTSIDE))
    four.context.session.document.visit(1)
    settle(four, qtbot)
    assert "left_hand" not in proposed(four, "O"), "it is proposed as outside"
    assert view(four, "O").marks.proposed_outside == (NINE["left_hand"].label,)
    sigma = {one.key: one.sigma for one in clicking.proposals.now()}
    assert len(sigma) == 36
    limit = float(np.median([value for key, value in sigma.items() if key.landmark != "head"]))
    set_accepted_sigma(project, limit)
    clicking.show()
    marks = [mark for name in VIEWS for mark in view(four, name).marks.predictions]
    uncertain = {key for key, value in sigma.items() if value > limit}
    drawn = {key for key in uncertain if key[1:] != outside[1:]}
    assert sum(not mark.certain for mark in marks) == len(drawn) > 5
    faint = [mark.opacity for mark in marks if not mark.certain]
    assert max(faint) < min(mark.opacity for mark in marks if mark.certain)

    said = []
    four.statusBar().messageChanged.connect(said.append)
    key(four, Qt.Key.Key_Q, name="N")
    there = clicks(four, 1)
    assert {one.key for one in there.values()} == set(sigma) - uncertain
    assert four.context.session.document.frame == 1, "there is something left to do"
    assert f"{len(uncertain) - 2} more to check" in said[-1], "one is shown, one is outside"
    settle(four, qtbot)
    lanes = {lane.id: lane.values for lane in four.context.docks.timeline.lanes}
    open_everywhere = {name for name in NINE.names if name not in {one[1] for one in there}}
    assert {lanes[name][1] for name in open_everywhere} <= {Mark.PROPOSED}
    key(four, Qt.Key.Key_Z, CTRL, name="N")
    settle(four, qtbot)

    set_accepted_sigma(project, 50.0)
    key(four, Qt.Key.Key_Q, name="N")
    recording = four.context.session.document.recording
    write_clicks(tmp_path / "clicks.csv", project.clicks.all(), recording)
    exported = read_clicks(tmp_path / "clicks.csv", recording).checked()
    for found in (clicks(four, 1), {one.key: one for one in exported if one.frame == 1}):
        assert len(found) == 36
        assert {one.key[1:] for one in found.values() if one.visibility == Visibility.GUESSED} == {
            one[1:] for one in guessed
        }
        assert [one.key[1:] for one in found.values() if one.position is None] == [outside[1:]]
        assert {one.origin for one in found.values()} == {ACCEPTED}


def test_doubtful_proposals_are_gone_through_each_enlarged(four, qtbot, monkeypatch):
    proposals, walk = (
        four.features.annotate.clicking.proposals,
        four.features.annotate.clicking.walk,
    )
    click_all_but_one(four)
    point_and_click(four, *truth(four, "head", "W"), "W")
    four.context.session.document.visit(1)
    settle(four, qtbot)
    proposals.set_wanted(0.8 * proposals.answer.known.accuracy_mm)
    settle(four, qtbot)
    doubtful = proposals.doubtful()
    ringed = [m for name in VIEWS for m in view(four, name).marks.predictions if not m.certain]
    assert len(ringed) == len(doubtful) > 1
    words = four.features.annotate.clicking.body.words.text()
    assert words.startswith("Accuracy now ")
    assert "more click" in words
    before = {name: view(four, name).zoom for name in VIEWS}
    point(four, *truth(four, "head", "O"), "O")
    for code in (Qt.Key.Key_3, Qt.Key.Key_Return):
        key(four, code, name="O")
    assert walk.at is None, "a landmark that was chosen goes before doubtful ones"
    assert view(four, "O").crosshair is not None
    assert view(four, "O").marks.offer.landmark == "left_elbow"
    key(four, Qt.Key.Key_Escape, name="O")

    key(four, Qt.Key.Key_Q, name="N")
    settle(four, qtbot)
    assert len(clicks(four)) == 36 - len(doubtful)
    first = walk.at
    assert first is not None
    name = first.camera[0]
    shown = view(four, name)
    assert shown.zoom > 3.0 * before[name]
    assert shown.crosshair.toTuple() == first.position
    assert shown.rect().contains(shown.place_of(*first.position).toPoint())
    assert shown.marks.curves, "epipolar curves of the other views"
    moved = replace(first, position=(first.position[0] + 0.5, first.position[1]))
    with monkeypatch.context() as patched:
        patched.setattr(proposals, "doubtful", lambda: (moved,))
        four.context.session.changes.tell(Part.PROPOSALS)
        assert shown.crosshair.toTuple() == moved.position, "it has moved by another click"
        key(four, Qt.Key.Key_Return, name=name)
    assert clicks(four)[first.key[1:]].position == pytest.approx(moved.position)
    assert clicks(four)[first.key[1:]].origin == ACCEPTED
    settle(four, qtbot)
    second = walk.at
    assert second.key != first.key
    assert view(four, name).zoom == before[name] or second.camera[0] == name
    point_and_click(four, *truth(four, second.landmark, second.camera[0]), second.camera[0])
    assert clicks(four)[second.key[1:]].origin == "hand"
    for _ in range(36):
        settle(four, qtbot)
        if walk.at is None:
            break
        key(four, Qt.Key.Key_Return, name=walk.at.camera[0])
    assert walk.at is None
    assert {name: view(four, name).zoom for name in VIEWS} == before
    if len(clicks(four)) < 36:
        key(four, Qt.Key.Key_Q, name="N")
    assert len(clicks(four)) == 36


def test_by_keyboard_alone_a_crosshair_on_the_epipolar_curve_places(four, qtbot):
    landmark = "left_hand"
    point_and_click(four, 5.0, 5.0, "N")
    key(four, Qt.Key.Key_Z, CTRL)
    four.features.annotate.clicking.annotating.choose(landmark)
    point_and_click(four, *truth(four, landmark, "N"), "N")
    four.features.annotate.clicking.annotating.choose(landmark)
    point(four, *truth(four, "head", "O"), "O")
    settle(four, qtbot)
    key(four, Qt.Key.Key_Return, name="O")
    shown = view(four, "O")
    start = shown.crosshair
    assert (shown.marks.on_curve(start) - start).manhattanLength() < 1e-6
    key(four, Qt.Key.Key_Right, ALT, name="O")
    moved = shown.crosshair
    assert moved != start
    assert (shown.marks.on_curve(moved) - moved).manhattanLength() < 1e-6, "it stays on the curve"
    key(four, Qt.Key.Key_Right, ALT | CTRL, name="O")
    fine = shown.crosshair
    assert (fine - moved).x() == pytest.approx(1.0 / shown._scale())
    key(four, Qt.Key.Key_Return, name="O")
    (own,) = [one for one in clicks(four).values() if one.camera == "O_right"]
    assert (own.landmark, own.origin) == (landmark, "hand")
    assert own.position == pytest.approx(fine.toTuple())
    key(four, Qt.Key.Key_Escape, name="O")
    assert shown.crosshair is None

"""Lanes, Next and second readings around the clicking; and a window that is killed."""

import os
import shutil
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from PySide6.QtCore import QPoint, Qt

from app.session.changes import Part
from app.widgets.timeline.lanes import Mark
from stereotrack_core.annotation.click import ClickKey
from stereotrack_core.project.clicks import place_clicks
from stereotrack_core.project.project import Project
from tests.gui import hands

pytestmark = pytest.mark.window

PROGRAM = Path(__file__).with_name("annotating_process.py")


def test_no_fit_of_another_recording_is_shown(annotating, qtbot, small_recording, tmp_path):
    """Both have clicks in the same frame, so that the one might be taken for the other."""
    facts = annotating.features.annotate.clicking.facts
    hands.annotate_all(annotating, qtbot)
    qtbot.waitUntil(lambda: facts.now().fit is not None)
    folder = shutil.copytree(small_recording, tmp_path / "other")
    path, moved = tmp_path / "other.stereotrack", []
    for one in annotating.context.session.project.project.clicks.at(0):
        x, y = one.position
        moved.append(replace(one, position=(x + 3.0, y)))
    with Project.create(path, folder) as project:
        project.apply(place_clicks(tuple(moved)))
    seen = []
    watch = annotating.context.session.changes.watch
    watch(Part.RECORDING_OPENED, lambda: seen.append(facts.now().fit))
    watch(Part.HINTS | Part.PROPOSALS, lambda: seen and seen.append(facts.now().fit))
    annotating.context.session.open(path)
    qtbot.waitUntil(lambda: bool(seen) and seen[-1] is not None)
    known = [one.question.clicks for one in seen if one is not None]
    assert seen[0] is None
    assert {one.position for each in known for one in each} == {one.position for one in moved}


def test_lanes_follow_a_click_and_suggestions_lead_to_their_view(annotating, qtbot):
    hands.key(annotating, Qt.Key.Key_7)
    hands.click(annotating, 200.0, 100.0)
    lanes = {lane.id: lane.values for lane in annotating.context.docks.timeline.lanes}
    assert lanes["head"][0] == Mark.PARTLY
    annotating.context.session.document.go_to(4)
    annotating.features.annotate.clicking.go_to(0, "S_right", "left_elbow")
    qtbot.waitUntil(annotating.context.tasks.settled)
    assert annotating.context.session.document.frame == 0
    assert annotating.context.view_state.active_view == "S"
    assert annotating.features.annotate.clicking.annotating.choice.landmark == "left_elbow"
    annotating.features.annotate.clicking.go_to(2, "N_left", "head")
    qtbot.waitUntil(annotating.context.tasks.settled)
    assert annotating.context.view_state.kinds["N"] == "left"


def test_lanes_stay_when_the_recording_is_opened_again(annotating, qtbot):
    hands.key(annotating, Qt.Key.Key_7)
    hands.click(annotating, 200.0, 100.0)
    folder = annotating.context.session.document.recording.folder
    hands.trigger(annotating, "close")
    annotating.context.session.open(folder)
    qtbot.waitUntil(lambda: annotating.context.session.document.recording is not None)
    qtbot.waitUntil(annotating.context.tasks.settled)
    lanes = {lane.id: lane.values for lane in annotating.context.docks.timeline.lanes}
    assert lanes["head"][0] == Mark.PARTLY
    assert [mark.landmark for mark in hands.view(annotating).marks.clicks] == ["head"]


def test_a_second_reading_is_blind_and_leaves_the_first_alone(annotating, qtbot):
    for landmark in ("left_shoulder", "right_shoulder", "head", "left_elbow"):
        for name in ("N", "S"):
            hands.click_truth(annotating, landmark, name)
    qtbot.waitUntil(annotating.context.tasks.settled)
    first = hands.clicks(annotating)
    assert "reference" not in hands.view(annotating)._display.overlays, "nobody has asked for it"
    hands.key(annotating, Qt.Key.Key_R)
    assert "reference" in hands.view(annotating)._display.overlays
    hands.trigger(annotating, "annotate-repeat-now", qtbot)
    marks = hands.view(annotating).marks
    assert (marks.clicks, marks.predictions, marks.model, marks.residuals) == ((), (), (), ())
    assert "reference" not in hands.view(annotating)._display.overlays
    hands.key(annotating, Qt.Key.Key_R)
    assert "reference" not in hands.view(annotating)._display.overlays, "not even on request"
    x, y = hands.click_truth(annotating, "head", shift=(4.0, 0.0))
    hands.key(annotating, Qt.Key.Key_B)
    hands.key(annotating, Qt.Key.Key_E)
    hands.key(annotating, Qt.Key.Key_Right, hands.ALT)
    assert hands.clicks(annotating) == first
    (again,) = annotating.context.session.project.project.clicks.again_at(0)
    assert again.position == pytest.approx((x + 0.5, y))
    hands.click_truth(annotating, "left_elbow")
    hands.key(annotating, Qt.Key.Key_Delete)
    assert len(annotating.context.session.project.project.clicks.again_at(0)) == 1
    hands.trigger(annotating, "annotate-repeat-finish")
    assert "Agreement" in annotating.statusBar().currentMessage()
    qtbot.waitUntil(annotating.context.tasks.settled)
    assert len(hands.view(annotating).marks.clicks) == 4
    assert hands.clicks(annotating) == first
    action = annotating.context.actions.action
    for space, shown in (("annotate", False), ("track", True), ("annotate", False)):
        hands.show_workspace(annotating, qtbot, space)
        overlays = hands.view(annotating)._display.overlays
        assert ({"reference", "outline", "others"} <= overlays) == shown
        assert ({"reference", "outline", "others"} & overlays != set()) == shown
        assert action("overlay_reference").isChecked() == shown


def test_every_picture_size_places_the_click_under_the_cursor(annotating, qtbot):
    """Also in the smallest window, one view alone, and turned recordings' raw pixels."""
    annotating.resize(annotating.minimumSize())
    hands.trigger(annotating, "arrange_single", qtbot)
    hands.key(annotating, Qt.Key.Key_1)
    place = QPoint(57, 43)
    expected = hands.view(annotating).pixel_at(place.toPointF())
    if not hands.view(annotating).inside(expected):
        place = hands.view(annotating).rect().center()
        expected = hands.view(annotating).pixel_at(place.toPointF())
    qtbot.mouseClick(hands.view(annotating), hands.LEFT, pos=place)
    found = hands.clicks(annotating)[("N_right", "left_shoulder")].position
    assert found == pytest.approx((expected.x(), expected.y()))


def test_a_turned_view_is_nudged_the_way_the_person_sees_it(window, qtbot, shared_recording):
    docks = window.context.docks
    window.context.session.open(shared_recording("seated-4cam-rotated"))
    qtbot.waitUntil(lambda: window.context.session.document.frame_set is not None)
    hands.show_workspace(window, qtbot, "annotate")
    name = next(n for n, tile in docks.views.tiles.items() if tile.camera.picture.rotation)
    camera = docks.views.tiles[name].camera
    window.features.annotate.clicking.annotating.choose("head")
    qtbot.mouseClick(camera, hands.LEFT, pos=camera.rect().center())
    raw = camera.picture.camera
    (before,) = window.context.session.project.project.clicks.at(0)
    seen = camera.place_of(*before.position)
    hands.key(window, Qt.Key.Key_E, name=name)
    hands.key(window, Qt.Key.Key_Right, hands.ALT | hands.SHIFT, name=name)
    after = window.context.session.project.project.clicks.get(ClickKey(0, raw, "head"))
    moved = camera.place_of(*after.position) - seen
    assert moved.x() == pytest.approx(camera._scale(), rel=1e-6)
    assert moved.y() == pytest.approx(0.0, abs=1e-6)


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="there is no SIGKILL here")
def test_a_window_that_is_killed_loses_no_click_that_was_on_screen(
    small_recording, tmp_path, window, qtbot
):
    process = subprocess.Popen(
        [sys.executable, str(PROGRAM), str(small_recording), str(tmp_path)],
        stdout=subprocess.PIPE,
        text=True,
        cwd=PROGRAM.parents[2],
        env={**os.environ, "PYTHONPATH": str(PROGRAM.parents[2])},
    )
    painted = []
    for line in process.stdout:
        frame, camera, landmark, x, y = line.split()
        painted.append((int(frame), camera, landmark, float(x), float(y)))
        if len(painted) == 25:
            os.kill(process.pid, signal.SIGKILL)
            break
    process.wait()
    process.stdout.close()
    (path,) = tmp_path.glob("*.stereotrack")
    window.context.session.open(path)
    qtbot.waitUntil(lambda: window.context.session.document.recording is not None)
    qtbot.waitUntil(window.context.tasks.settled)
    assert "did not close it; all edits are saved" in window.messages.text()
    project: Project = window.context.session.project.project
    for frame, camera, landmark, x, y in painted:
        found = project.clicks.get(ClickKey(frame, camera, landmark))
        assert found is not None
        assert found.position == pytest.approx((x, y))
    count = project.clicks.count()
    window.context.actions.refresh()
    hands.trigger(window, "undo")
    assert project.clicks.count() == count - 1

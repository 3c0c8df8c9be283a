"""The installed detector looks by itself at the frames that are annotated, and stores nothing."""

import threading

import pytest
from PySide6.QtCore import Qt

from app.features.annotate.clicking import detecting
from stereotrack_core.annotation.click import Prediction
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.pose_model.detect import DETECTOR_NAME
from stereotrack_core.project.marks import mark_keyframes
from tests.gui.hands import SHIFT, clicks, key, point, point_and_click, trigger, truth, view

pytestmark = pytest.mark.window


class Detector:
    """In place of the process: sees all landmarks right, as soon as it may go on."""

    def __init__(self, places):
        self.places, self.asked = places, []
        self.may_go_on = threading.Event()
        self.stopped = threading.Event()

    def __call__(self, todo, cancelled):
        self.asked.append(todo.frame)
        while not self.may_go_on.wait(0.01):
            if cancelled():
                self.stopped.set()
                break
        return tuple(
            Prediction(todo.frame, camera, name, DETECTOR_NAME, place, 1.5)
            for (camera, name), place in self.places.items()
        )

    def close(self):
        """There is no process."""


@pytest.fixture
def detector(annotating, monkeypatch):
    places = {(f"{v}_right", n): truth(annotating, n, v) for v in "NS" for n in NINE.names}
    found = Detector(places)
    detections = annotating.features.annotate.clicking.detections
    monkeypatch.setattr(detecting, "is_installed", lambda: True)
    monkeypatch.setattr(detections, "_process", found)
    monkeypatch.setattr(detections, "_known", {})
    annotating.context.session.document.visit(1)
    yield found
    found.may_go_on.set()


def predicted(window, name):
    return {mark.landmark for mark in view(window, name).marks.predictions}


def test_the_first_frame_is_detected_without_a_click_and_nothing_is_stored(
    annotating, detector, qtbot
):
    session, body = annotating.context.session, annotating.features.annotate.clicking.body
    qtbot.waitUntil(lambda: detector.asked == [1])
    qtbot.waitUntil(lambda: "Detecting landmarks in this frame …" in body.words.text())
    x, y = truth(annotating, "left_shoulder", "N")
    own = point_and_click(annotating, x + 2.0, y, "N")  # meanwhile a person goes on
    assert clicks(annotating)
    detector.may_go_on.set()
    qtbot.waitUntil(lambda: predicted(annotating, "S") == set(NINE.names))
    project = session.project.project
    assert project.predictions.at(1) == ()
    assert not project.keypoints.sources()
    (placed,) = clicks(annotating).values()
    assert placed.position == pytest.approx(own), "what a person placed stays"
    assert placed.landmark not in predicted(annotating, "N")
    annotating.context.docks.show_named("review")
    qtbot.waitUntil(lambda: not predicted(annotating, "S"))
    annotating.context.docks.show_named("annotate")
    qtbot.waitUntil(lambda: predicted(annotating, "S") == set(NINE.names))

    proposals = annotating.features.annotate.clicking.proposals
    proposals.set_wanted(1000.0)  # so no more clicks are asked for
    qtbot.waitUntil(lambda: proposals.settled() and not proposals.doubtful())
    point(annotating, 100.0, 100.0, "S")
    key(annotating, Qt.Key.Key_Q, SHIFT, name="S")
    accepted = [one for one in clicks(annotating).values() if one.camera == "S_right"]
    assert len(accepted) == 9
    assert placed in clicks(annotating).values()


def test_frames_of_the_rhythm_follow_once_a_person_begins(annotating, detector, qtbot):
    project = annotating.context.session.project.project
    project.apply(mark_keyframes((0, 1, 3, 5, 7)))
    detector.may_go_on.set()
    qtbot.waitUntil(lambda: detector.asked == [1])
    qtbot.waitUntil(annotating.context.tasks.settled)
    assert detector.asked == [1], "nobody annotates yet"
    point_and_click(annotating, 100.0, 100.0, "N")
    qtbot.waitUntil(lambda: len(detector.asked) == 4)
    qtbot.waitUntil(annotating.context.tasks.settled)
    assert detector.asked == [1, 3, 5, 0]


def test_it_is_stopped_with_the_recording_and_switched_off(annotating, detector, qtbot):
    detections = annotating.features.annotate.clicking.detections
    qtbot.waitUntil(lambda: detector.asked == [1])
    annotating.context.session.document.close()
    assert detector.stopped.wait(10.0)
    assert detections.at(1) == ()


def test_the_switch_takes_what_was_detected_away(annotating, detector, qtbot):
    detector.may_go_on.set()
    qtbot.waitUntil(lambda: predicted(annotating, "N") == set(NINE.names))
    trigger(annotating, "detect_landmarks")
    qtbot.waitUntil(lambda: not predicted(annotating, "N"))
    annotating.context.session.document.visit(2)
    qtbot.waitUntil(annotating.context.tasks.settled)
    assert detector.asked == [1]
    trigger(annotating, "detect_landmarks")
    qtbot.waitUntil(lambda: detector.asked == [1, 2])


def test_without_a_detector_a_line_says_what_it_would_bring(annotating):
    words = annotating.features.annotate.clicking.body.words.text()
    assert "would predict landmarks before the first click" in words
    action = annotating.context.actions.action("detect_landmarks")
    assert not action.isEnabled()
    assert "Install pose detector" in action.statusTip()

"""Three frames of a real person, seated, are annotated through the real window.

The places were read off the pictures by eye, to some ten pixels of 1280 x 720; the pictures
themselves are no part of this project.
"""

import numpy as np
import pytest
from PySide6.QtCore import QPointF, Qt
from PySide6.QtTest import QTest

from stereotrack_core.annotation.landmark_set import NINE
from tests.gui.hands import CTRL, LEFT, key, show_workspace

pytestmark = pytest.mark.window

FRAMES = {
    8: {
        "head": {"cam_1": (804, 132), "cam_2": (791, 300), "cam_3": (760, 212)},
        "left_hand": {"cam_0": (862, 185), "cam_1": (1067, 413), "cam_3": (589, 493)},
        "right_hand": {"cam_0": (489, 290), "cam_2": (401, 625), "cam_3": (466, 449)},
        "left_shoulder": {"cam_0": (1213, 211), "cam_2": (958, 493), "cam_3": (909, 396)},
        "right_elbow": {"cam_0": (738, 527), "cam_1": (566, 598)},
        "left_elbow": {"cam_0": (1266, 571), "cam_3": (944, 687)},
    },
    20: {
        "head": {"cam_0": (1050, 149), "cam_2": (747, 367), "cam_3": (851, 286)},
        "left_hand": {"cam_0": (1064, 241), "cam_1": (927, 390), "cam_2": (883, 611)},
        "right_hand": {"cam_0": (673, 322), "cam_2": (513, 549), "cam_3": (601, 426)},
        "left_shoulder": {"cam_0": (1213, 334), "cam_2": (879, 493), "cam_3": (988, 432)},
        "right_elbow": {"cam_0": (724, 542), "cam_1": (394, 612)},
    },
    38: {
        "head": {"cam_2": (730, 374), "cam_3": (865, 309)},
        "left_hand": {
            "cam_0": (914, 171), "cam_1": (666, 273), "cam_2": (695, 409), "cam_3": (742, 335),
        },
        "right_hand": {"cam_0": (654, 360), "cam_2": (443, 493), "cam_3": (628, 423)},
        "left_elbow": {"cam_0": (1213, 308), "cam_1": (821, 422)},
        "right_elbow": {"cam_0": (760, 536), "cam_3": (698, 520)},
    },
}  # fmt: skip
"""Raw pixels by frame, landmark and camera."""


@pytest.fixture
def seated(window, qtbot, shared_recording):
    window.context.session.open(shared_recording("seated-4cam"))
    qtbot.waitUntil(lambda: window.context.session.document.frame_set is not None)
    show_workspace(window, qtbot, "annotate")
    return window


def go_by_keys(window, qtbot, frame):
    while window.context.session.document.frame != frame:
        further = frame - window.context.session.document.frame
        ten = abs(further) >= 10
        code = Qt.Key.Key_Right if further > 0 else Qt.Key.Key_Left
        modifier = Qt.KeyboardModifier.ShiftModifier if ten else Qt.KeyboardModifier.NoModifier
        key(window, code, modifier, "cam_0")
    qtbot.waitUntil(window.context.tasks.settled)


def annotate(window, qtbot, frame):
    """Every landmark by its key, every click by the mouse; what the cursor was really on."""
    go_by_keys(window, qtbot, frame)
    placed = {}
    for landmark, places in FRAMES[frame].items():
        for camera, (x, y) in places.items():
            view = window.context.docks.views.tiles[camera].camera
            key(window, Qt.Key(Qt.Key.Key_1 + NINE.names.index(landmark)), name=camera)
            spot = view.place_of(x, y).toPoint()
            QTest.mouseClick(view, LEFT, CTRL, spot)
            pixel = view.pixel_at(QPointF(spot))
            assert abs(pixel.x() - x) < 2.0
            placed[camera, landmark] = (pixel.x(), pixel.y())
    qtbot.waitUntil(window.context.tasks.settled)
    return placed


def test_three_frames_of_a_real_person(seated, qtbot):
    project = seated.context.session.project.project
    for frame in FRAMES:
        placed = annotate(seated, qtbot, frame)
        there = {(one.camera, one.landmark): one.position for one in project.clicks.at(frame)}
        assert set(there) == set(placed)
        for place, position in placed.items():
            assert there[place] == pytest.approx(position)
        facts = seated.features.annotate.clicking.facts.now()
        points = facts.hints.points
        assert set(points) == set(FRAMES[frame])
        assert max(point.rms_px for point in points.values()) < 45.0
        assert np.median([point.rms_px for point in points.values()]) < 20.0
        assert points["left_hand"].world[2] < points["head"].world[2]
        for bone in facts.hints.lengths:
            assert 0.5 < bone.clicked / bone.subject < 1.6, bone
        assert facts.fit is not None
        off = [np.hypot(*residual) for residual in facts.fit.residuals.values()]
        assert len(off) == len(placed)
        assert np.median(off) < 20.0
        assert np.mean(off) < 25.0
        assert max(facts.fit.outliers.values()) < 0.5
        assert seated.context.docks.views.tiles["cam_1"].camera.marks.model
    assert project.clicks.frames().tolist() == sorted(FRAMES)
    count = project.clicks.count()
    for _ in range(count):
        seated.context.session.edits.undo()
    assert project.clicks.count() == 0
    assert seated.context.session.document.frame == min(FRAMES)

"""Undo, redo and what a person has dismissed."""

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from stereotrack_core.annotation.click import Click
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.project.clicks import place, place_clicks
from tests.gui.hands import CTRL, key, truth

pytestmark = pytest.mark.window


def test_a_swap_that_was_dismissed_is_not_offered_again_and_leaves_redo(four, qtbot):
    names, mixed = four.context.docks.views.tiles, {"left_elbow", "right_elbow"}
    clicks = []
    for view in names:
        camera = four.context.session.document.recording.view(view).image.camera
        for landmark in NINE.names:
            (other,) = mixed - {landmark} if landmark in mixed else {landmark}
            seen = truth(four, other if view == "S" else landmark, view)
            clicks.append(Click(0, camera, landmark, seen))
    four.context.session.project.apply(place_clicks(tuple(clicks)))
    four.context.session.project.apply(place(Click(2, "N_right", "head", (100.0, 100.0))))
    undone = four.context.session.edits.to_undo().words
    key(four, Qt.Key.Key_Z, CTRL)
    four.context.session.document.visit(0)
    qtbot.waitUntil(lambda: "swapped" in four.messages.text())
    qtbot.waitUntil(four.context.tasks.settled)
    (said,) = (one for one in four.messages._messages if "swapped" in one.what)
    while said in four.messages._messages:  # others may lie above it
        QTest.mouseClick(four.messages.close_button, Qt.MouseButton.LeftButton)
    assert four.context.session.edits.to_redo().words == undone
    four.context.session.document.visit(1)
    four.context.session.document.visit(0)
    qtbot.waitUntil(four.context.tasks.settled)
    assert said.what not in [one.what for one in four.messages._messages], "it was dismissed"

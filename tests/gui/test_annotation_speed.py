"""With a hundred thousand clicks in the project, frames step and clicks appear at once.

The window's own computing is counted, in the thread that paints: what other programs do to the
machine meanwhile is not asked for. ``python -m app.bench RECORDING --clicks 100000`` measures the
time on the clock.
"""

from __future__ import annotations

import statistics
import time

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest

from stereotrack_core.annotation.click import Click
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.project.click_edits import PlaceClicks
from stereotrack_core.project.project import Project
from tests.gui.hands import CTRL, LEFT, key

pytestmark = pytest.mark.window

CLICKS = 100_000
MOST_MS = 50.0


@pytest.fixture
def full(window, qtbot, small_recording, tmp_path):
    """The window with a project of many clicks: in every frame, and in thousands beyond."""
    path = tmp_path / "full.stereotrack"
    cameras = ("N_right", "S_right", "N_left", "S_left")
    random = np.random.default_rng(0)
    with Project.create(path, small_recording) as project:
        for first in range(0, CLICKS // 36 + 1, 500):
            places = random.uniform(60.0, 400.0, (500, 36, 2)).tolist()
            names = [(camera, name) for camera in cameras for name in NINE.names]
            project.apply(
                PlaceClicks(
                    tuple(
                        Click(first + k, camera, name, (x, y))
                        for k, row in enumerate(places)
                        for (camera, name), (x, y) in zip(names, row, strict=True)
                    )
                )
            )
        assert project.clicks.count() >= CLICKS
    window.files.open(path)
    qtbot.waitUntil(lambda: window.document.frame_set is not None, timeout=60_000)
    window.show_workspace_named("annotate")
    window.messages.clear()
    qtbot.waitUntil(window.settled, timeout=120_000)
    return window


def painted(window):
    return {tile.camera.painted_frame for tile in window.grid.tiles.values()}


def test_a_frame_step(full, qtbot):
    times = []
    for step in range(14):
        code = Qt.Key.Key_Right if step < 7 else Qt.Key.Key_Left
        wanted = full.document.frame + (1 if step < 7 else -1)
        begun = time.thread_time()
        key(full, code)
        qtbot.waitUntil(lambda wanted=wanted: painted(full) == {wanted}, timeout=30_000)
        times.append(1000.0 * (time.thread_time() - begun))
        assert len(full.grid.tiles["N"].camera.marks.clicks) == 9
    assert statistics.median(times) < MOST_MS


def test_nothing_is_worked_out_about_frames_that_are_only_passed_by(full, qtbot):
    """Threads of this process share the interpreter with the one that paints."""
    hints = full.annotate.facts._hints
    asked, question = [], hints._question
    hints._question = lambda: asked.append(full.document.frame) or question()
    first = full.document.frame
    for _ in range(4):
        key(full, Qt.Key.Key_Right)
    assert asked == []
    qtbot.waitUntil(lambda: hints.at(first + 4) is not None, timeout=30_000)
    assert set(asked) == {first + 4}


def test_from_the_click_to_its_paint_and_into_the_file(full):
    camera = full.grid.tiles["N"].camera
    times = []
    for step in range(12):
        full.annotate.annotating.choose(NINE.names[step % 9])
        begun = time.thread_time()
        QTest.mouseClick(camera, LEFT, CTRL, QPoint(200 + 9 * step, 150))
        camera.repaint()
        times.append(1000.0 * (time.thread_time() - begun))
        newest = full.project.project.history.to_undo()
        assert newest.words.startswith("place")
    assert len(full.project.project.history.entries(20)) >= 12
    assert statistics.median(times) < MOST_MS

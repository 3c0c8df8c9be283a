"""With a hundred thousand clicks in the project, frames step and clicks appear as with few.

The window's own computing is compared, in the thread that paints: how fast the machine is, and
what other programs do to it meanwhile, is not asked for.
"""

import functools
import shutil
import statistics
import time

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest

from stereotrack_core.annotation.click import Click
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.project.clicks import place_clicks
from stereotrack_core.project.project import Project
from tests.gui.hands import CTRL, LEFT, key

pytestmark = pytest.mark.window

FEW, MANY = 8, 2780
"""Frames with 36 clicks each; the recording has eight, and many frames hold 100,000 clicks."""


def slower(few_ms, many_ms):
    """Whether it takes longer with 350 times as many clicks, by more than a busy machine makes."""
    return many_ms > 4.0 * few_ms + 40.0


@pytest.fixture(scope="module")
def clicked(small_recording, tmp_path_factory):
    """Function from a number of frames to a project with clicks in them."""

    @functools.cache
    def made(frames):
        path = tmp_path_factory.mktemp("clicked") / f"{frames}.stereotrack"
        cameras = ("N_right", "S_right", "N_left", "S_left")
        random = np.random.default_rng(0)
        with Project.create(path, small_recording) as project:
            for first in range(0, frames, 500):
                places = random.uniform(60.0, 400.0, (min(500, frames - first), 36, 2)).tolist()
                names = [(camera, name) for camera in cameras for name in NINE.names]
                project.apply(
                    place_clicks(
                        tuple(
                            Click(first + k, camera, name, (x, y))
                            for k, row in enumerate(places)
                            for (camera, name), (x, y) in zip(names, row, strict=True)
                        )
                    )
                )
            assert project.clicks.count() == 36 * frames
        return path

    return made


@pytest.fixture
def show(window, qtbot, clicked, tmp_path):
    """Function that shows a project with clicks in so many frames."""

    def shown(frames):
        path = tmp_path / f"{frames}.stereotrack"
        shutil.copy(clicked(frames), path)
        window.context.session.open(path)
        qtbot.waitUntil(lambda: window.context.session.project.path == path)
        qtbot.waitUntil(lambda: window.context.session.document.frame_set is not None)
        window.context.docks.show_named("annotate")
        window.messages.clear()
        qtbot.waitUntil(window.context.tasks.settled)
        return window

    return shown


def painted(window):
    return {tile.camera.painted_frame for tile in window.context.docks.views.tiles.values()}


def step_ms(window, qtbot):
    times = []
    for step in range(14):
        code = Qt.Key.Key_Right if step < 7 else Qt.Key.Key_Left
        wanted = window.context.session.document.frame + (1 if step < 7 else -1)
        begun = time.thread_time()
        key(window, code)
        qtbot.waitUntil(lambda wanted=wanted: painted(window) == {wanted})
        times.append(1000.0 * (time.thread_time() - begun))
        assert len(window.context.docks.views.tiles["N"].camera.marks.clicks) == 9
    return statistics.median(times)


def click_ms(window):
    camera = window.context.docks.views.tiles["N"].camera
    times = []
    for step in range(12):
        window.features.annotate.clicking.annotating.choose(NINE.names[step % 9])
        begun = time.thread_time()
        QTest.mouseClick(camera, LEFT, CTRL, QPoint(200 + 9 * step, 150))
        camera.repaint()
        times.append(1000.0 * (time.thread_time() - begun))
        newest = window.context.session.project.project.history.to_undo()
        assert newest.words.startswith("place")
    assert len(window.context.session.project.project.history.entries(20)) >= 12
    return statistics.median(times)


def test_a_frame_step(show, qtbot):
    few, many = (step_ms(show(frames), qtbot) for frames in (FEW, MANY))
    assert not slower(few, many), (few, many)


def test_from_the_click_to_its_paint_and_into_the_file(show):
    few, many = (click_ms(show(frames)) for frames in (FEW, MANY))
    assert not slower(few, many), (few, many)

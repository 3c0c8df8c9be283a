"""The inside of a frame in the real window: looked into, stepped through by keys."""

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from app.session.runs import RunEntry
from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import proportions_of
from stereotrack_core.recording.selection import usable_views
from stereotrack_core.tracking.frame import TrackedFrame
from stereotrack_core.tracking.inspection import beginning_at
from stereotrack_core.tracking.model import cameras_of, model_for
from stereotrack_core.tracking.presets import preset

pytestmark = pytest.mark.window

FRAME = 2


def look(window, qtbot):
    QTest.keyClick(window, Qt.Key.Key_F12)
    qtbot.waitUntil(lambda: window.context.session.inspection.known is not None)
    qtbot.waitUntil(window.context.tasks.settled)


@pytest.fixture
def with_run(newly_opened, qtbot):
    """The window with a run of two frames by the thesis's tracker."""
    session = newly_opened.context.session
    recording, settings = session.document.recording, preset("thesis")
    session.track.settings = settings
    body = body_model(proportions_of(recording.subject), settings.body)
    cameras = cameras_of(recording, usable_views(recording, None))
    frames, state = {}, None
    model = model_for(body, settings, cameras, recording.fps, 0)
    for frame in (FRAME - 1, FRAME):
        session.clouds.ask(frame)
        qtbot.waitUntil(lambda frame=frame: session.clouds.cloud(frame) is not None)
        cloud = session.clouds.cloud(frame)
        state = beginning_at(model, cloud)[0] if state is None else state
        state, estimate = model.step(state, cloud)
        frames[frame] = TrackedFrame(frame, estimate, np.full((9, 3), np.nan), cloud, {})
    session.runs.add(RunEntry("stored", "thesis", settings, body, range(1, 3), frames))
    session.document.go_to(FRAME)
    qtbot.waitUntil(newly_opened.context.tasks.settled)
    return newly_opened


def test_keys_go_through_the_steps_and_each_is_shown(with_run, qtbot):
    window = with_run
    look(window, qtbot)
    inside, panel = window.context.session.inspection, window.features.inspect.panel
    assert panel.isVisible()
    assert not panel.visibleRegion().isEmpty()
    assert "stored for the previous frame" in panel.beginning.toolTip()
    seen = []
    for _ in range(40):
        page = panel.page
        seen.append(inside.step.kind)
        overlay = window.context.docks.views.tiles["N"].camera.picture.overlay
        assert page.title.text()
        assert len(page.words.text()) > 40
        assert page.source.text()
        assert panel.steps.currentItem().text().strip() == inside.step.title
        if inside.step.kind in {"pairs", "cross"}:
            assert overlay.inside.lines
            assert window.context.docks.scene.content.inside.lines
        if inside.step.kind == "sigma" and inside.step.correction == 0:
            assert len(overlay.inside.ghosts) > 50
        if inside.step.kind == "points":
            assert overlay.inside.dots
        if inside.index == len(inside.known.steps) - 1:
            break
        QTest.keyClick(window, Qt.Key.Key_F7)
        qtbot.waitUntil(window.context.tasks.settled)
    assert seen[:6] == ["predict", "points", "pairs", "sigma", "cross", "correct"]
    assert seen[-2:] == ["collisions", "result"]
    assert len(seen) == 1 + 4 * 5 + 2
    QTest.keyClick(window, Qt.Key.Key_F7, Qt.KeyboardModifier.ShiftModifier)
    assert inside.step.kind == "collisions"


def test_the_step_stays_when_another_frame_is_shown_and_the_run_comes_back(with_run, qtbot):
    window, dock = with_run, with_run.context.docks.dock
    heights = [dock(name).height() for name in ("scene", "runs", "plot")]
    inside = window.context.session.inspection
    window.features.inspect.toggle()
    assert inside.known is None, "the tracker's step is done in a thread of its own"
    qtbot.waitUntil(lambda: inside.known is not None)
    qtbot.waitUntil(window.context.tasks.settled)
    qtbot.waitUntil(lambda: dock("inside").height() > heights[1] + 100)
    inside.go(4)
    assert inside.step.kind == "cross"
    QTest.keyClick(window, Qt.Key.Key_Left)
    qtbot.waitUntil(
        lambda: inside.known.done.trace.frame == FRAME - 1 and window.context.tasks.settled()
    )
    assert (inside.step.kind, inside.step.correction) == ("cross", 0)
    assert "pose of this frame" in inside.known.done.words
    QTest.keyClick(window, Qt.Key.Key_F12)
    qtbot.waitUntil(window.context.tasks.settled)
    assert window.context.view_state.drawing is None
    assert "Measuring" not in window.features.inspect.panel.nothing.text()
    assert window.context.docks.views.tiles["N"].camera.picture.overlay.inside is None
    qtbot.waitUntil(
        lambda: [dock(name).height() for name in ("scene", "inside", "plot")] == heights
    )
    pose = window.context.session.runs.active.at(FRAME - 1).pose
    assert pose is not None
    assert window.context.session.instant.told.meshes

"""What is shown comes back with the project, and a project for reading only is left alone."""

import pytest
from PySide6.QtCore import QSettings, Qt

from app.session.tracking import Chosen
from stereotrack_core.project.project import Project
from stereotrack_core.tracking.presets import preset
from tests.gui.hands import key, trigger, view, window_with
from tests.gui.kept_window import open_recording

pytestmark = pytest.mark.window


def look(window, qtbot):
    """Frame 5 in Annotate, left images, brighter, a selection; `fast` with one change in Tune."""
    window.context.docks.show_named("annotate")
    window.context.view_state.select(range(2, 7))
    window.context.view_state.set_threshold(30.0)
    track = window.context.session.track
    track.choose("fast", preset("fast"))
    track.use(track.settings.replaced(iterations=3))
    key(window, Qt.Key.Key_F2)
    for _ in range(6):
        trigger(window, "brighter")
    trigger(window, "more_contrast")
    window.context.session.document.go_to(5)
    qtbot.waitUntil(window.context.tasks.settled)


def shown(window):
    kinds = dict(window.context.view_state.kinds)
    display = window.context.view_state.display
    light = display.brightness, display.contrast
    state, session = window.context.view_state, window.context.session
    used = state.selection, state.threshold, session.track.chosen
    return session.document.frame, window.context.docks.workspace, kinds, light, used


def chosen(name, *changes):
    return Chosen(name, preset(name), preset(name, changes))


def another_window(qtbot, tmp_path, name="other.ini"):
    """A window of somebody who has never used the program."""
    settings = QSettings(str(tmp_path / name), QSettings.Format.IniFormat)
    settings.setValue("projects_folder", str(tmp_path / "projects"))
    made = window_with(settings)
    qtbot.addWidget(made)
    made.resize(1366, 768)
    made.show()
    return made


def test_it_comes_back_in_another_window(opened, qtbot, small_recording, tmp_path):
    look(opened, qtbot)
    before = shown(opened)
    assert before[0] == 5
    assert before[3] == (0.3, 1.15)
    assert before[4] == (range(2, 7), 30.0, chosen("fast", "iterations=3"))
    opened.close()
    other = another_window(qtbot, tmp_path)
    open_recording(other, qtbot, small_recording)
    qtbot.waitUntil(lambda: view(other).painted_frame == 5)
    assert shown(other) == before
    assert other.context.session.project.project.history.entries() == (), "looking is no edit"
    other.close()


def test_opening_in_tune_tracks_nothing_by_itself(opened, qtbot, small_recording, tmp_path):
    """Settings that come back are no change to try: each opening would add a run."""
    look(opened, qtbot)
    opened.context.docks.show_named("tune")
    opened.close()
    again = another_window(qtbot, tmp_path)
    open_recording(again, qtbot, small_recording)
    assert (again.context.docks.workspace, shown(again)[0]) == ("tune", 5)
    assert again.context.session.trials.settled(), "none begins soon"
    assert again.context.session.runs.entries == ()
    again.close()


def test_what_is_asked_for_is_shown(opened, qtbot, small_recording, tmp_path):
    look(opened, qtbot)
    trigger(opened, "close")
    open_recording(opened, qtbot, small_recording, frame=2, workspace="calibrate")
    assert shown(opened)[:2] == (2, "calibrate")
    assert set(shown(opened)[2].values()) == {"left"}


def test_it_is_written_while_the_window_is_open(opened, qtbot):
    look(opened, qtbot)
    stored = opened.context.session.project.project.view_settings
    qtbot.waitUntil(lambda: (stored.get("window") or {}).get("frame") == 5)
    assert stored.get("window")["workspace"] == "annotate"


def test_a_project_for_reading_is_shown_so_and_stays_as_it_is(
    opened, qtbot, small_recording, tmp_path
):
    look(opened, qtbot)
    path = opened.context.session.project.path
    qtbot.waitUntil(
        lambda: (
            (opened.context.session.project.project.view_settings.get("window") or {}).get("frame")
            == 5
        )
    )
    reading = another_window(qtbot, tmp_path)
    open_recording(reading, qtbot, small_recording)
    assert reading.context.session.project.project.read_only
    qtbot.waitUntil(lambda: view(reading).painted_frame == 5)
    reading.context.session.document.go_to(1)
    qtbot.waitUntil(reading.context.tasks.settled)
    reading.close()
    opened.close()
    with Project.open(path, read_only=True) as project:
        assert project.view_settings.get("window")["frame"] == 5

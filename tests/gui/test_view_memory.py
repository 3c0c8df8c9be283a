"""What is shown comes back with the project, and a project for reading only is left alone."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QSettings, Qt

from app.shell.main_window import MainWindow
from stereotrack_core.project.project import Project
from tests.gui.hands import key, view

pytestmark = pytest.mark.window


def open_path(window, qtbot, path, **wanted):
    window.files.open(path, **wanted)
    qtbot.waitUntil(lambda: window.document.frame_set is not None, timeout=30_000)
    qtbot.waitUntil(window.settled, timeout=60_000)


def look(window, qtbot):
    """Frame 5 in Annotate, the left images, all brighter, S darker and with more contrast."""
    window.show_workspace_named("annotate")
    key(window, Qt.Key.Key_F2)
    window.display_panel.brightness.setValue(30)
    window.grid.set_active("S")
    window.display_panel.only_this.setChecked(True)
    window.display_panel.brightness.setValue(-20)
    window.display_panel.contrast.setValue(50)
    window.document.go_to(5)
    qtbot.waitUntil(window.settled, timeout=60_000)


def shown(window):
    kinds = {name: tile.kind for name, tile in window.grid.tiles.items()}
    lights = {name: window.grid.light(name) for name in window.grid.tiles}
    return window.document.frame, window.workspace.name, kinds, lights


def another_window(qtbot, tmp_path, name="other.ini"):
    """A window of somebody who has never used the program."""
    settings = QSettings(str(tmp_path / name), QSettings.Format.IniFormat)
    settings.setValue("projects_folder", str(tmp_path / "projects"))
    made = MainWindow(settings)
    qtbot.addWidget(made)
    made.resize(1366, 768)
    made.show()
    return made


def test_it_comes_back_in_another_window(opened, qtbot, small_recording, tmp_path):
    look(opened, qtbot)
    before = shown(opened)
    assert before[0] == 5
    assert before[3]["N"] == (0.3, 1.0)
    assert before[3]["S"] == (-0.2, 2.0)
    opened.close()
    other = another_window(qtbot, tmp_path)
    open_path(other, qtbot, small_recording)
    qtbot.waitUntil(lambda: view(other).painted_frame == 5, timeout=10_000)
    assert shown(other) == before
    assert other.display_panel.values()[0] == pytest.approx(0.3)
    assert other.project.project.history.entries() == (), "looking is no edit"
    other.close()


def test_what_is_asked_for_is_shown(opened, qtbot, small_recording, tmp_path):
    look(opened, qtbot)
    opened.actions_book.action("close").trigger()
    open_path(opened, qtbot, small_recording, frame=2, workspace="calibrate")
    assert shown(opened)[:2] == (2, "calibrate")
    assert set(shown(opened)[2].values()) == {"left"}


def test_it_is_written_while_the_window_is_open(opened, qtbot):
    look(opened, qtbot)
    stored = opened.project.project.view_settings
    qtbot.waitUntil(lambda: (stored.get("window") or {}).get("frame") == 5, timeout=5_000)
    assert stored.get("window")["workspace"] == "annotate"


def test_a_project_for_reading_is_shown_so_and_stays_as_it_is(
    opened, qtbot, small_recording, tmp_path
):
    look(opened, qtbot)
    path = opened.project.path
    qtbot.waitUntil(
        lambda: (opened.project.project.view_settings.get("window") or {}).get("frame") == 5,
        timeout=5_000,
    )
    reading = another_window(qtbot, tmp_path)
    open_path(reading, qtbot, small_recording)
    assert reading.project.project.read_only
    qtbot.waitUntil(lambda: view(reading).painted_frame == 5, timeout=10_000)
    reading.document.go_to(1)
    qtbot.waitUntil(reading.settled, timeout=60_000)
    reading.close()
    opened.close()
    with Project.open(path, read_only=True) as project:
        assert project.view_settings.get("window")["frame"] == 5


@pytest.mark.parametrize(
    "stored",
    [
        "nonsense",
        {"frame": "x", "workspace": 3, "pictures": [1], "light": {"": [9, "y"], "N": [None]}},
        {"frame": 10_000, "workspace": "gone", "pictures": {"Q": "left", "N": "gone"}},
        {"frame": -4, "light": {"": [99.0, -5.0], "Q": [0.1, 1.0]}},
    ],
)
def test_what_makes_no_sense_is_passed_over(window, qtbot, small_recording, tmp_path, stored):
    path = tmp_path / "mine.stereotrack"
    with Project.create(path, small_recording) as project:
        project.view_settings.set("window", stored)
    open_path(window, qtbot, path)
    frame, _, kinds, lights = shown(window)
    assert 0 <= frame < window.document.frame_count
    assert set(kinds.values()) == {"image"}
    assert all(-0.8 <= b <= 0.8 and 0.25 <= c <= 4.0 for b, c in lights.values())
    assert window.messages.text() == ""

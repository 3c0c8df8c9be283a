"""Whatever has become of the settings file, the window starts."""

from __future__ import annotations

import random

import pytest
from PySide6.QtCore import QByteArray, QSettings
from PySide6.QtWidgets import QMainWindow

from app.program import stored_theme
from app.services.stored import stored_bytes, stored_text, stored_texts
from app.widgets.camera.picture import Display
from app.widgets.style.theme import THEME_NAMES
from tests.gui.hands import window_with
from tests.reading.mutations import TOKENS, mutated_bytes, mutated_lines

VALUES = (
    *(b"@Variant(\\0\\0\\0\\x7f\\0\\0\\0\\xe)", b"@Variant(\\0\\0\\0\\b\\xff\\xff\\xff\\xff)"),
    *(b"@Invalid()", b"@ByteArray(\\x1\\xd9\\xd0\\xcb", b"@Rect(1 2 3 4)", b"a, b, c", b"maybe"),
    *(
        b"@Variant(\\0\\0\\0\\t\\0\\0\\0\\x1\\0\\0\\0\\n\\0\\0\\0\\x2\\0\\x61)",
        b"/\\0, /recordings/x",
    ),
)
FEW, WINDOWS, MANY = 30, 40, 2000


@pytest.fixture
def sound(qtbot, tmp_path) -> bytes:
    """The settings of a window that was used."""
    path, widget = tmp_path / "used.ini", QMainWindow()
    qtbot.addWidget(widget)
    settings = QSettings(str(path), QSettings.Format.IniFormat)
    settings.setValue("geometry", widget.saveGeometry())
    settings.setValue("workspaces/track", widget.saveState(1))
    settings.setValue("recent", [str(tmp_path), str(tmp_path / "b")])
    settings.setValue("overlays_shown", ["model", "points"])
    settings.setValue("tune/live", True)
    settings.setValue("shortcuts/open", "Ctrl+O")
    for key in ("annotator", "theme", "workspace", "projects_folder", "annotate/advance"):
        settings.setValue(key, "track")
    settings.sync()
    return path.read_bytes()


def damaged(content: bytes, number: int) -> bytes:
    choose = random.Random(number)
    lines = content.split(b"\n")
    if choose.random() < 0.6:
        at = choose.randrange(len(lines))
        lines[at] = lines[at].split(b"=")[0] + b"=" + choose.choice((*VALUES, *TOKENS))
        return b"\n".join(lines)
    return choose.choice([mutated_bytes, mutated_lines])(content, choose)


def settings_of(path, content: bytes) -> QSettings:
    path.write_bytes(content)
    return QSettings(str(path), QSettings.Format.IniFormat)


def read_all(settings: QSettings) -> None:
    for key in settings.allKeys():
        texts, data = stored_texts(settings, key), stored_bytes(settings, key)
        assert isinstance(stored_text(settings, key), str)
        assert texts is None or all(isinstance(text, str) for text in texts)
        assert data is None or isinstance(data, QByteArray)
    assert stored_theme(settings) in THEME_NAMES


def test_values_of_other_kinds_are_as_if_they_were_not_there(qtbot, dark, failures, tmp_path):
    lines = ("geometry=a, b", "recent=@Rect(1 2 3 4)", "overlays_shown=@Size(1 2)", "theme=a, b")
    content = "\n".join(("[General]", *lines, "workspace=@Rect(1 2 3 4)", "tune\\live=a, b"))
    content += "\n[workspaces]\ntrack=3\n[shortcuts]\nopen=@Rect(1 2 3 4)\n"
    settings = settings_of(tmp_path / "other.ini", content.encode())
    window = window_with(settings)
    qtbot.addWidget(window)
    assert window.context.session.opening.recent() == []
    assert window.context.view_state.display == Display()
    assert stored_theme(settings) == "system"
    window.close()
    assert failures == []


@pytest.mark.slow
def test_the_window_starts_with_any_settings(sound, qtbot, dark, failures, tmp_path):
    for number in range(WINDOWS):
        window = window_with(settings_of(tmp_path / f"{number}.ini", damaged(sound, number)))
        qtbot.addWidget(window)
        window.show()
        window.close()
    assert failures == []


@pytest.mark.parametrize("numbers", [range(FEW), pytest.param(range(MANY), marks=pytest.mark.slow)])
def test_every_value_is_of_its_kind(numbers, sound, tmp_path):
    for number in numbers:
        read_all(settings_of(tmp_path / f"{number}.ini", damaged(sound, number)))

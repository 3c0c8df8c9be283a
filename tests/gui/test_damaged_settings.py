"""Whatever has become of the settings file, the window starts."""

from PySide6.QtCore import QSettings

from app.program import stored_theme
from app.session.view_state import Display
from tests.gui.hands import window_with


def settings_of(path, content: bytes) -> QSettings:
    path.write_bytes(content)
    return QSettings(str(path), QSettings.Format.IniFormat)


def test_values_of_other_kinds_are_as_if_they_were_not_there(qtbot, dark, failures, tmp_path):
    lines = ("geometry=a, b", "recent=@Rect(1 2 3 4)", "overlays_shown=@Size(1 2)", "theme=a, b")
    content = "\n".join(("[General]", *lines, "workspace=@Rect(1 2 3 4)", "tune\\live=a, b"))
    content += "\n[workspaces]\ntrack=3\n[shortcuts]\nopen=@Rect(1 2 3 4)\n"
    settings = settings_of(tmp_path / "other.ini", content.encode())
    window = window_with(settings)
    qtbot.addWidget(window)
    assert window.context.session.recents() == []
    assert window.context.view_state.display == Display()
    assert stored_theme(settings) == "system"
    window.close()
    assert failures == []

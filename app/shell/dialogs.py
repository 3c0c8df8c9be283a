"""The window's own dialogs; none of them blocks the rest."""

from __future__ import annotations

from html import escape
from pathlib import Path

from PySide6.QtCore import QBuffer, QIODevice, Qt, QTimer
from PySide6.QtGui import QPixmap
from PySide6.QtWidgets import QMainWindow, QMessageBox

from stereotrack_core import __version__
from stereotrack_core.atomic import write_file
from stereotrack_core.errors import InputError

from ..context import Context
from ..services.failures import log_path
from ..widgets.forms.form_dialog import ask_to_save
from .command_lists import CommandPalette, ShortcutEditor


def write_picture(path: Path, picture: QPixmap) -> None:
    """Write a picture, by the suffix of the name.

    Raises
    ------
    InputError
        Where the file cannot be written, or Qt writes no pictures of this kind.
    """
    buffer = QBuffer()
    buffer.open(QIODevice.OpenModeFlag.WriteOnly)
    if not picture.save(buffer, path.suffix.removeprefix(".")):
        raise InputError(
            "an image cannot be written to this type of file",
            where=str(path),
            remedy="Choose a file name that ends in .png.",
        )
    write_file(path, bytes(buffer.data().data()))


class Dialogs:
    """Palette, shortcuts, about, a picture of the window."""

    def __init__(self, window: QMainWindow, context: Context) -> None:
        self._window, self._context = window, context

    def show_palette(self) -> None:
        """Search all commands, and do the one that is chosen."""
        actions = self._context.actions
        actions.refresh()
        palette = CommandPalette(actions, self._window)
        palette.accepted.connect(lambda: self._run_chosen(palette))
        palette.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        palette.open()

    def _run_chosen(self, palette: CommandPalette) -> None:
        chosen = palette.chosen()
        if chosen is not None:
            # the palette is gone by then, so that a dialog of the command stands on its own
            QTimer.singleShot(0, self._context.actions.action(chosen.id).trigger)

    def show_shortcuts(self) -> None:
        """Change shortcuts."""
        editor = ShortcutEditor(self._context.actions, self._window)
        editor.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        editor.open()

    def show_about(self) -> None:
        """Say which version this is."""
        box = QMessageBox(self._window)
        box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        box.setWindowTitle("About stereotrack")
        box.setTextFormat(Qt.TextFormat.RichText)
        box.setText(f"<b>stereotrack {__version__}</b>")
        box.setInformativeText(
            "A workbench for tracking the movement of a person's upper body in multi-view stereo "
            f"recordings.<br><br>Details of errors are logged in {escape(str(log_path()))}."
        )
        box.open()

    def ask_for_picture(self) -> None:
        """Let the person choose where a picture of the window is kept."""
        picture = self._window.grab()

        def save(path: Path) -> None:
            path = path if path.suffix else path.with_suffix(".png")
            self._context.notifier.attempt(lambda: write_picture(path, picture))

        ask_to_save(self._window, "Save screenshot", "stereotrack.png", "PNG image (*.png)", save)

    def close_later(self) -> None:
        """Close the window when the command that asked for it has returned."""
        QTimer.singleShot(0, self._window.close)

"""The window's dialogs; none of them blocks the rest."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt, QTimer
from PySide6.QtWidgets import QMessageBox

from stereotrack_core import __version__

from ..services.failures import log_path
from .command_palette import CommandPalette
from .shortcut_editor import ShortcutEditor

if TYPE_CHECKING:
    from .main_window import MainWindow


class Dialogs:
    """Palette, shortcuts, about."""

    def __init__(self, window: MainWindow) -> None:
        self._w = window

    def show_palette(self) -> None:
        """Search all commands, and do the one that is chosen."""
        book = self._w.actions_book
        book.refresh()
        palette = CommandPalette(book, self._w)
        palette.accepted.connect(lambda: self._run_chosen(palette))
        palette.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        palette.open()

    def _run_chosen(self, palette: CommandPalette) -> None:
        chosen = palette.chosen()
        if chosen is not None:
            # the palette is gone by then, so that a dialog of the command stands on its own
            QTimer.singleShot(0, self._w.actions_book.action(chosen.id).trigger)

    def show_shortcuts(self) -> None:
        """Change shortcuts."""
        editor = ShortcutEditor(self._w.actions_book, self._w)
        editor.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        editor.open()

    def show_about(self) -> None:
        """Say which version this is."""
        box = QMessageBox(self._w)
        box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        box.setWindowTitle("About stereotrack")
        box.setTextFormat(Qt.TextFormat.RichText)
        box.setText(f"<b>stereotrack {__version__}</b>")
        box.setInformativeText(
            "A workbench for tracking the movement of a person's upper body in recordings of "
            f"several cameras.<br><br>Details of failures are in {escape(str(log_path()))}."
        )
        box.open()

"""The window's own dialogs: the palette of commands, shortcuts, about; none blocks the rest."""

from dataclasses import replace
from html import escape
from pathlib import Path

from PySide6 import QtWidgets
from PySide6.QtCore import QBuffer, QEvent, QIODevice, QObject, Qt, QTimer
from PySide6.QtGui import QKeyEvent, QKeySequence, QPixmap

from stereotrack_core import __version__
from stereotrack_core.atomic import write_file
from stereotrack_core.errors import InputError

from ..services.actions import ActionRegistry, Command
from ..services.failures import Notifier
from ..session.messages import log_path
from ..widgets.forms.form_dialog import ask_to_save, line_edit, push_button, say_in
from ..widgets.style.building import Item, hbox, label, vbox
from ..widgets.tables.table import STRETCH, Cell, CellRow, CellTable, Column, swatch

_MOVES = {Qt.Key.Key_Down: 1, Qt.Key.Key_Up: -1, Qt.Key.Key_PageDown: 10, Qt.Key.Key_PageUp: -10}


class _CommandList(QtWidgets.QDialog):
    def __init__(self, title: str, book: ActionRegistry, parent: QtWidgets.QWidget | None) -> None:
        super().__init__(parent)
        self._book = book
        self.setWindowTitle(title)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.search = line_edit("Search commands", placeholder="Search commands")
        columns = Column("Command", width=STRETCH), Column("Menu"), Column("Shortcut")
        self.list = CellTable("Commands", columns, self._cells, single=True)
        self.list.setAlternatingRowColors(False)
        self.list.selectionModel().currentRowChanged.connect(self._on_current)

    def _lay_out(self, *below: Item, height: int) -> None:
        self.setLayout(vbox(self.search, (self.list, 1), *below, margins=(9, 9, 9, 9)))
        self.resize(640, height)

    def _cells(self, command: Command) -> CellRow:
        return (
            Cell(command.title, command.tip),
            Cell(command.place, command.tip),
            Cell(self._book.key_words(command.id), command.tip),
        )

    def _current(self) -> Command | None:
        row = self.list.currentIndex().row()
        return self.list.cells.rows[row] if row >= 0 else None

    def _go_to(self, row: int) -> None:
        self.list.setCurrentIndex(self.list.cells.index(row, 0))

    def _on_current(self) -> None:
        """Say something about the command that has become the current one."""


class CommandPalette(_CommandList):
    """Type some letters of a command, choose it, and it is done."""

    def __init__(self, book: ActionRegistry, parent: QtWidgets.QWidget | None = None) -> None:
        super().__init__("Command palette", book, parent)
        book.refresh()
        self.search.setClearButtonEnabled(True)
        self.list.setHeaderHidden(True)
        self.list.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self._why = label("", "muted")
        self._why.setMinimumHeight(36)
        self._lay_out(self._why, height=420)
        self.search.installEventFilter(self)
        self.search.textChanged.connect(self._fill)
        self.search.returnPressed.connect(self._choose)
        self.list.clicked.connect(self._choose)
        self._fill("")

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if isinstance(event, QKeyEvent) and event.type() == QEvent.Type.KeyPress:
            by = _MOVES.get(Qt.Key(event.key()), 0)
            last = len(self.list.cells.rows) - 1
            if by:
                self._go_to(min(max(self.list.currentIndex().row() + by, 0), last))
                return True
        return super().eventFilter(watched, event)

    def _fill(self, text: str) -> None:
        ranked = [(match_rank(text, one), one) for one in self._book.commands if one.shown()]
        found = [
            # first what is meant exactly, if only to say why it cannot be done; then what can be
            ((rank > 0, not self._book.action(command.id).isEnabled(), rank), command)
            for rank, command in ranked
            if rank is not None
        ]
        self.list.show_rows([one for _, one in sorted(found, key=lambda row: row[0])])
        self._go_to(0)
        if found:
            self._on_current()
        else:
            self._why.setText("No command matches.")

    def _cells(self, command: Command) -> CellRow:
        action = self._book.action(command.id)
        colour = "" if action.isEnabled() else "disabled"
        # names of commands without an icon stand in line with the others
        icon = swatch("", 16) if action.icon().isNull() else action.icon().pixmap(16, 16)
        name, *others = (replace(cell, colour=colour) for cell in super()._cells(command))
        return replace(name, swatch=icon), *others

    def _on_current(self) -> None:
        if (command := self._current()) is not None:
            why_not = command.why_not()
            text = f"Unavailable: {why_not}" if why_not else command.tip
            say_in(self._why, text, error=bool(why_not))

    def _choose(self) -> None:
        command = self._current()
        if command is not None and not command.why_not():
            self.accept()
            # the palette is gone by then, so that a dialog of the command stands on its own
            QTimer.singleShot(0, self._book.action(command.id).trigger)


def match_rank(text: str, command: Command) -> int | None:
    """How well a command fits what was typed: smaller is better, None is not at all."""
    wanted = text.strip().lower()
    name, title, menu = command.text.lower(), command.title.lower(), command.place.lower()
    if wanted in {name.removesuffix(" …"), title.removesuffix(" …")}:
        return 0
    if name.startswith(wanted):
        return 1
    if all(word in title for word in wanted.split()):
        return 2
    if all(word in f"{menu} {title} {command.tip.lower()}" for word in wanted.split()):
        return 3
    letters = iter(name)
    return 4 if all(letter in letters for letter in wanted.replace(" ", "")) else None


class ShortcutEditor(_CommandList):
    """Choose a command, press its new keys; a sequence that is taken is said, not stolen."""

    def __init__(self, book: ActionRegistry, parent: QtWidgets.QWidget | None = None) -> None:
        super().__init__("Shortcuts", book, parent)
        self.keys = QtWidgets.QKeySequenceEdit()
        self.keys.setMaximumSequenceLength(1)
        self.keys.setAccessibleName("New shortcut")
        self.set_button = push_button("Set", lambda: self._set(self.keys.keySequence().toString()))
        default = push_button("Default", lambda: self._set(None))
        none = push_button("None", lambda: self._set(""))
        self.note = label(" ")
        box = QtWidgets.QDialogButtonBox(QtWidgets.QDialogButtonBox.StandardButton.Close)
        box.rejected.connect(self.reject)
        heading = label("New shortcut:", wraps=False)
        keys = hbox(heading, (self.keys, 1), self.set_button, default, none)
        self._lay_out(keys, self.note, box, height=480)
        self.search.textChanged.connect(self._filter)
        self._filter("")

    def choose(self, name: str) -> None:
        self._go_to([command.id for command in self.list.cells.rows].index(name))

    def _filter(self, text: str) -> None:
        def said(command: Command) -> str:
            return " ".join(cell.text for cell in self._cells(command)).lower()

        wanted = text.strip().lower()
        seen = (one for one in self._book.commands if one.shown())
        self.list.show_rows([one for one in seen if wanted in said(one)])
        self._go_to(0)

    def _on_current(self) -> None:
        if (command := self._current()) is not None:
            self.keys.setKeySequence(QKeySequence(self._book.shortcut(command.id)))
            self.note.setText(command.tip)

    def _set(self, keys: str | None) -> None:
        """Give the current command these keys; None for its usual ones."""
        if (command := self._current()) is None:
            return
        keys = command.shortcut if keys is None else keys
        taken = self._book.user_of(keys, besides=command.id)
        if taken is not None:
            words = f"{keys} is already used by {taken.title}. Change that shortcut first."
            self.note.setText(words)
            return
        self._book.set_shortcut(command.id, keys)
        self.keys.setKeySequence(QKeySequence(keys))
        told = f"Shortcut of {command.title}: {keys}."
        self.note.setText(told if keys else f"{command.title} has no shortcut.")
        self.list.cells.look_again()


def write_picture(path: Path, picture: QPixmap) -> None:
    """Write a picture, by the suffix of the name; InputError if that cannot be done."""
    buffer = QBuffer()
    buffer.open(QIODevice.OpenModeFlag.WriteOnly)
    if not picture.save(buffer, path.suffix.removeprefix(".")):
        raise InputError(
            "an image cannot be written to this type of file",
            where=str(path),
            remedy="Choose a file name that ends in .png.",
        )
    write_file(path, bytes(buffer.data().data()))


def show_about(window: QtWidgets.QMainWindow) -> None:
    """Say which version this is, and where errors are logged."""
    box = QtWidgets.QMessageBox(window)
    box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    box.setWindowTitle("About stereotrack")
    box.setTextFormat(Qt.TextFormat.RichText)
    box.setText(f"<b>stereotrack {__version__}</b>")
    box.setInformativeText(
        "A workbench for tracking the movement of a person's upper body in multi-view stereo "
        f"recordings.<br><br>Details of errors are logged in {escape(str(log_path()))}."
    )
    box.open()


def ask_for_picture(window: QtWidgets.QMainWindow, notifier: Notifier) -> None:
    """Let the person choose where a picture of the window as it is now is kept."""
    picture = window.grab()

    def save(path: Path) -> None:
        path = path if path.suffix else path.with_suffix(".png")
        notifier.attempt(lambda: write_picture(path, picture))

    ask_to_save(window, "Save screenshot", "stereotrack.png", "PNG image (*.png)", save)

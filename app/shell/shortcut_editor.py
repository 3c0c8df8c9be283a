"""The dialog in which shortcuts are changed."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtGui import QKeySequence
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QHBoxLayout,
    QHeaderView,
    QKeySequenceEdit,
    QLabel,
    QLineEdit,
    QPushButton,
    QTreeWidget,
    QTreeWidgetItem,
    QVBoxLayout,
    QWidget,
)

from ..services.actions import ActionRegistry

_ID = Qt.ItemDataRole.UserRole


class ShortcutEditor(QDialog):
    """Choose a command, press its new keys; a sequence that is taken is said, not stolen."""

    def __init__(self, book: ActionRegistry, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._book = book
        self.setWindowTitle("Shortcuts")
        self.search = QLineEdit()
        self.search.setPlaceholderText("Search commands")
        self.list = QTreeWidget()
        self.list.setHeaderLabels(["Command", "Menu", "Shortcut"])
        self.list.setRootIsDecorated(False)
        self.list.header().setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
        self.keys = QKeySequenceEdit()
        self.keys.setMaximumSequenceLength(1)
        self.keys.setAccessibleName("New shortcut")
        self.set_button = QPushButton("Set")
        self.default_button = QPushButton("Default")
        self.none_button = QPushButton("None")
        self.note = QLabel(" ")
        self.note.setWordWrap(True)
        self._lay_out()
        for command in book.commands:
            item = QTreeWidgetItem([command.text, command.place, ""])
            item.setData(0, _ID, command.id)
            self.list.addTopLevelItem(item)
        self._refresh()
        self.search.textChanged.connect(self._filter)
        self.list.currentItemChanged.connect(self._on_current)
        self.set_button.clicked.connect(lambda: self._set(self.keys.keySequence().toString()))
        self.none_button.clicked.connect(lambda: self._set(""))
        self.default_button.clicked.connect(self._set_default)
        self.choose(book.commands[0].id)

    def choose(self, name: str) -> None:
        """Choose a command by its id."""
        for row in range(self.list.topLevelItemCount()):
            item = self.list.topLevelItem(row)
            if item is not None and item.data(0, _ID) == name:
                self.list.setCurrentItem(item)

    def _lay_out(self) -> None:
        row = QHBoxLayout()
        row.addWidget(QLabel("New shortcut:"))
        row.addWidget(self.keys, 1)
        for button in (self.set_button, self.default_button, self.none_button):
            button.setAutoDefault(False)
            row.addWidget(button)
        box = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        box.rejected.connect(self.reject)
        layout = QVBoxLayout(self)
        layout.addWidget(self.search)
        layout.addWidget(self.list, 1)
        layout.addLayout(row)
        layout.addWidget(self.note)
        layout.addWidget(box)
        self.resize(640, 480)

    def _refresh(self) -> None:
        for row in range(self.list.topLevelItemCount()):
            item = self.list.topLevelItem(row)
            if item is not None:
                keys = QKeySequence(self._book.shortcut(item.data(0, _ID)))
                item.setText(2, keys.toString(QKeySequence.SequenceFormat.NativeText))

    def _filter(self, text: str) -> None:
        for row in range(self.list.topLevelItemCount()):
            item = self.list.topLevelItem(row)
            if item is not None:
                words = f"{item.text(0)} {item.text(1)} {item.text(2)}".lower()
                item.setHidden(text.strip().lower() not in words)

    def _on_current(self, item: QTreeWidgetItem | None) -> None:
        if item is not None:
            self.keys.setKeySequence(QKeySequence(self._book.shortcut(item.data(0, _ID))))
            self.note.setText(self._book.command(item.data(0, _ID)).tip)

    def _set_default(self) -> None:
        item = self.list.currentItem()
        if item is not None:
            self._set(self._book.command(item.data(0, _ID)).shortcut)

    def _set(self, keys: str) -> None:
        item = self.list.currentItem()
        if item is None:
            return
        name = item.data(0, _ID)
        taken = self._book.user_of(keys, besides=name)
        if taken is not None:
            self.note.setText(
                f"{keys} is already used by {taken.text}. Change that shortcut first."
            )
            return
        self._book.set_shortcut(name, keys)
        self.keys.setKeySequence(QKeySequence(keys))
        self.note.setText(
            f"Shortcut of {item.text(0)}: {keys}." if keys else f"{item.text(0)} has no shortcut."
        )
        self._refresh()

"""All commands in one searchable list."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QIcon, QKeyEvent, QPixmap
from PySide6.QtWidgets import (
    QDialog,
    QLabel,
    QLineEdit,
    QTreeWidget,
    QTreeWidgetItem,
    QVBoxLayout,
    QWidget,
)

from ..services.actions import ActionRegistry, Command

_ID = Qt.ItemDataRole.UserRole


class CommandPalette(QDialog):
    """Type some letters of a command, choose it, and it is done."""

    def __init__(self, book: ActionRegistry, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._book = book
        self._chosen: Command | None = None
        self._blank = _blank_icon()
        self.setWindowTitle("Command palette")
        self.search = QLineEdit()
        self.search.setPlaceholderText("Search commands")
        self.search.setClearButtonEnabled(True)
        self.list = QTreeWidget()
        self.list.setRootIsDecorated(False)
        self.list.setHeaderHidden(True)
        self.list.setColumnCount(3)
        self.list.setUniformRowHeights(True)
        self.list.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self._why = QLabel()
        self._why.setWordWrap(True)
        self._why.setProperty("role", "muted")
        self._why.setMinimumHeight(36)
        layout = QVBoxLayout(self)
        layout.addWidget(self.search)
        layout.addWidget(self.list, 1)
        layout.addWidget(self._why)
        self.resize(640, 420)
        self.search.installEventFilter(self)
        self.search.textChanged.connect(self._fill)
        self.search.returnPressed.connect(self._choose)
        self.list.itemActivated.connect(self._choose)
        self.list.itemClicked.connect(self._choose)
        self.list.currentItemChanged.connect(self._explain)
        self._fill("")

    def chosen(self) -> Command | None:
        """The command that was chosen."""
        return self._chosen

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if isinstance(event, QKeyEvent) and event.type() == QEvent.Type.KeyPress:
            moves = {Qt.Key.Key_Down: 1, Qt.Key.Key_Up: -1, Qt.Key.Key_PageDown: 10}
            by = moves.get(Qt.Key(event.key()), -10 if event.key() == Qt.Key.Key_PageUp else 0)
            if by:
                self._move(by)
                return True
        return super().eventFilter(watched, event)

    def _move(self, by: int) -> None:
        count = self.list.topLevelItemCount()
        if count:
            self._go_to(min(max(self.list.currentIndex().row() + by, 0), count - 1))

    def _go_to(self, row: int) -> None:
        item = self.list.topLevelItem(row)
        if item is not None:
            self.list.setCurrentItem(item)

    def _fill(self, text: str) -> None:
        self.list.clear()
        ranked = [(match_rank(text, command), command) for command in self._book.commands]
        found = [(rank, command) for rank, command in ranked if rank is not None]
        found.sort(key=lambda row: row[0])
        for _, command in found:
            self.list.addTopLevelItem(self._item(command))
        for column in (0, 1, 2):
            self.list.resizeColumnToContents(column)
        if found:
            self._go_to(0)
        else:
            self._why.setText("No command matches.")

    def _item(self, command: Command) -> QTreeWidgetItem:
        action = self._book.action(command.id)
        text = command.says() if command.says is not None else command.text
        item = QTreeWidgetItem([text, command.place, self._book.key_words(command.id)])
        item.setData(0, _ID, command.id)
        item.setIcon(0, self._blank if action.icon().isNull() else action.icon())
        if not action.isEnabled():
            muted = self.palette().brush(
                self.palette().ColorGroup.Disabled, self.palette().ColorRole.Text
            )
            for column in range(3):
                item.setForeground(column, muted)
        return item

    def _explain(self, item: QTreeWidgetItem | None) -> None:
        if item is None:
            return
        command = self._book.command(item.data(0, _ID))
        why_not = command.why_not()
        self._why.setText(f"Unavailable: {why_not}" if why_not else command.tip)
        self._why.setProperty("role", "error" if why_not else "muted")
        self._why.style().polish(self._why)

    def _choose(self, *_: object) -> None:
        item = self.list.currentItem()
        if item is None:
            return
        command = self._book.command(item.data(0, _ID))
        if command.why_not():
            self._explain(item)
            return
        self._chosen = command
        self.accept()


def _blank_icon() -> QIcon:
    """Keep the names of commands without an icon in line with the others."""
    pixmap = QPixmap(16, 16)
    pixmap.fill(Qt.GlobalColor.transparent)
    return QIcon(pixmap)


def match_rank(text: str, command: Command) -> int | None:
    """How well a command fits what was typed: smaller is better, None is not at all."""
    wanted = text.strip().lower()
    name, menu = command.text.lower(), command.place.lower()
    if name.startswith(wanted):
        return 0
    if all(word in name for word in wanted.split()):
        return 1
    if all(word in f"{menu} {name} {command.tip.lower()}" for word in wanted.split()):
        return 2
    letters = iter(name)
    return 3 if all(letter in letters for letter in wanted.replace(" ", "")) else None

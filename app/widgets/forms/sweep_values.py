"""What a sweep varies: a line per parameter with the values that are tried."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QGridLayout,
    QHBoxLayout,
    QLineEdit,
    QWidget,
)

from ..style.building import choice, hbox, label, scrolled, searchable, tool_button, vbox


class SweepValues(QWidget):
    """Lines of names and values, and a field that adds one.

    `names` are what can be varied, each with a sentence about it; `hint` says in words which values
    a name takes, and `form` how they are written.
    """

    changed = Signal()

    def __init__(
        self,
        names: Sequence[tuple[str, str]],
        hint: Callable[[str], str],
        form: str = "a,b,c",
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self._about = dict(names)
        self._hint, self._form = hint, form
        self._fields: dict[str, QLineEdit] = {}
        self._lines: dict[str, list[QWidget]] = {}
        self._inside = QWidget()
        self._grid = QGridLayout(self._inside)
        self._grid.setContentsMargins(4, 4, 4, 4)
        self._grid.setColumnStretch(1, 1)
        self._nothing = label("No parameters yet. Choose one below and add it.", "muted")
        holder = QWidget()
        holder.setLayout(vbox(self._nothing, self._inside, None))
        scroll = scrolled(holder, "Values")
        scroll.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAsNeeded)
        scroll.setMinimumHeight(120)
        self.setLayout(vbox((scroll, 1), self._adder()))

    def varied(self) -> tuple[tuple[str, str], ...]:
        """Names and their values as they were typed; lines without values are left out."""
        return tuple(
            (name, field.text().strip())
            for name, field in self._fields.items()
            if field.text().strip()
        )

    def field(self, name: str) -> QLineEdit:
        """Where the values of a name are typed."""
        return self._fields[name]

    def add(self, name: str, values: str = "") -> None:
        """Add a line, or go to the one that is there."""
        if name not in self._about:
            return
        if name not in self._fields:
            self._new_line(name)
        if values:
            self._fields[name].setText(values)
        self._fields[name].setFocus()
        self._nothing.hide()
        self.changed.emit()

    def remove(self, name: str) -> None:
        """Take a line away."""
        for widget in self._lines.pop(name):
            self._grid.removeWidget(widget)
            widget.deleteLater()
        del self._fields[name]
        self._nothing.setVisible(not self._fields)
        self.changed.emit()

    def _new_line(self, name: str) -> None:
        title = label(name.replace("_", " "), wraps=False)
        title.setToolTip(self._about[name])
        field = QLineEdit()
        field.setAccessibleName(f"Values of {title.text()}")
        field.setPlaceholderText(self._form)
        field.setToolTip(f"{self._about[name]} {self._hint(name)}")
        field.textEdited.connect(self.changed)
        hint = label(self._hint(name), "muted", wraps=False)
        away = tool_button(f"Do not vary {title.text()}", "close")
        away.clicked.connect(lambda: self.remove(name))
        row = self._grid.rowCount()
        widgets = [title, field, hint, away]
        for column, widget in enumerate(widgets):
            self._grid.addWidget(widget, row, column)
        self._fields[name], self._lines[name] = field, widgets

    def _adder(self) -> QHBoxLayout:
        names = ((name, name.replace("_", " ")) for name in self._about)
        self.chooser = searchable(choice("Parameter to vary", names))
        for place, words in enumerate(self._about.values()):
            self.chooser.setItemData(place, words, Qt.ItemDataRole.ToolTipRole)
        self.chooser.setCurrentIndex(-1)
        line = self.chooser.lineEdit()
        if line is not None:
            line.setPlaceholderText("Search parameters")
            line.returnPressed.connect(self._add_chosen)
        self.add_button = tool_button("Vary this parameter", "add", "Add")
        self.add_button.setAutoRaise(False)
        self.add_button.clicked.connect(self._add_chosen)
        return hbox((self.chooser, 1), self.add_button)

    def _add_chosen(self) -> None:
        place = self.chooser.findText(self.chooser.currentText().strip())
        if place >= 0:
            self.add(str(self.chooser.itemData(place)))
            self.chooser.setCurrentIndex(-1)

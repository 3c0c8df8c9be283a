"""What a sweep varies: a line per parameter with the values that are tried."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QComboBox,
    QCompleter,
    QFrame,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QScrollArea,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from ..style.icons import set_icon


class SweepValues(QWidget):
    """Lines of names and values, and a field that adds one.

    Parameters
    ----------
    names : sequence of (str, str)
        What can be varied, with a sentence about it.
    hint : callable
        Which values a name takes, in words.
    form : str
        How values are written.

    Signals
    -------
    changed : ()
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
        self._nothing = QLabel("No parameters yet. Choose one below and add it.")
        self._nothing.setProperty("role", "muted")
        column = QVBoxLayout()
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(self._nothing)
        column.addWidget(self._inside)
        column.addStretch(1)
        holder = QWidget()
        holder.setLayout(column)
        scroll = QScrollArea()
        scroll.setWidgetResizable(True)
        scroll.setFrameShape(QFrame.Shape.NoFrame)
        scroll.setWidget(holder)
        scroll.setMinimumHeight(120)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(scroll, 1)
        layout.addLayout(self._adder())

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
        label = QLabel(name.replace("_", " "))
        label.setToolTip(self._about[name])
        field = QLineEdit()
        field.setAccessibleName(f"Values of {label.text()}")
        field.setPlaceholderText(self._form)
        field.setToolTip(f"{self._about[name]} {self._hint(name)}")
        field.textEdited.connect(self.changed)
        hint = QLabel(self._hint(name))
        hint.setProperty("role", "muted")
        away = QToolButton()
        away.setAutoRaise(True)
        away.setToolTip(f"Do not vary {label.text()}")
        set_icon(away, "close")
        away.clicked.connect(lambda: self.remove(name))
        row = self._grid.rowCount()
        widgets = [label, field, hint, away]
        for column, widget in enumerate(widgets):
            self._grid.addWidget(widget, row, column)
        self._fields[name], self._lines[name] = field, widgets

    def _adder(self) -> QHBoxLayout:
        self.chooser = QComboBox()
        self.chooser.setEditable(True)
        self.chooser.setInsertPolicy(QComboBox.InsertPolicy.NoInsert)
        self.chooser.setAccessibleName("Parameter to vary")
        for place, (name, words) in enumerate(self._about.items()):
            self.chooser.addItem(name.replace("_", " "), name)
            self.chooser.setItemData(place, words, Qt.ItemDataRole.ToolTipRole)
        self.chooser.setCurrentIndex(-1)
        line = self.chooser.lineEdit()
        if line is not None:
            line.setPlaceholderText("Search parameters")
            line.returnPressed.connect(self._add_chosen)
        completer = self.chooser.completer()
        if completer is not None:
            completer.setFilterMode(Qt.MatchFlag.MatchContains)
            completer.setCompletionMode(QCompleter.CompletionMode.PopupCompletion)
        self.add_button = QToolButton()
        self.add_button.setText("Add")
        self.add_button.setToolTip("Vary this parameter")
        self.add_button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        set_icon(self.add_button, "add")
        self.add_button.clicked.connect(self._add_chosen)
        row = QHBoxLayout()
        row.addWidget(self.chooser, 1)
        row.addWidget(self.add_button)
        return row

    def _add_chosen(self) -> None:
        place = self.chooser.findText(self.chooser.currentText().strip())
        if place >= 0:
            self.add(str(self.chooser.itemData(place)))
            self.chooser.setCurrentIndex(-1)

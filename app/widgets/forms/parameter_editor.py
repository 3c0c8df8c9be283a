"""The field in which one parameter's value is given, by its type."""

from __future__ import annotations

from typing import Protocol

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QKeyEvent, QWheelEvent
from PySide6.QtWidgets import QCheckBox, QComboBox, QLineEdit, QWidget

from stereotrack_core.parameters import ParameterRow, Value


class ParameterEditor(Protocol):
    """What the panel needs of a field, whatever the type of its parameter."""

    def show_value(self, value: Value) -> None:
        """Show a value without asking for it."""


def value_text(value: Value) -> str:
    """Write a value as a person types it."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:g}" if isinstance(value, float) else str(value)


class NumberField(QLineEdit):
    """A number as text; nothing is clamped in silence.

    Signals
    -------
    value_given : str
        The person typed something else and left the field or pressed Enter.
    editing_dropped
        The person pressed Esc.
    """

    value_given = Signal(object)
    editing_dropped = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._shown = ""
        self.setAlignment(Qt.AlignmentFlag.AlignRight)
        self.editingFinished.connect(self._on_finished)

    def show_value(self, value: Value) -> None:
        """Show a value without asking for it."""
        self._shown = value_text(value)
        self.setText(self._shown)
        self.setCursorPosition(0)

    def _on_finished(self) -> None:
        if self.text() != self._shown:
            self._shown = self.text()
            self.value_given.emit(self.text().strip())

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() == Qt.Key.Key_Escape:
            self.editing_dropped.emit()
        else:
            super().keyPressEvent(event)


class SwitchField(QCheckBox):
    """Yes or no; see :class:`NumberField` for the signals."""

    value_given = Signal(object)
    editing_dropped = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.clicked.connect(lambda: self.value_given.emit(self.isChecked()))
        self.toggled.connect(self._write)
        self._write(False)

    def show_value(self, value: Value) -> None:
        """Show a value without asking for it."""
        self.setChecked(bool(value))

    def _write(self, checked: bool) -> None:
        self.setText(value_text(checked))


class ChoiceField(QComboBox):
    """One of several words; see :class:`NumberField` for the signals."""

    value_given = Signal(object)
    editing_dropped = Signal()

    def __init__(self, choices: tuple[str, ...], parent: QWidget | None = None) -> None:
        super().__init__(parent)
        for choice in choices:
            self.addItem(choice.replace("_", " "), choice)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.activated.connect(lambda: self.value_given.emit(self.currentData()))

    def show_value(self, value: Value) -> None:
        """Show a value without asking for it."""
        self.setCurrentIndex(self.findData(value))

    def wheelEvent(self, event: QWheelEvent) -> None:
        # the wheel scrolls the panel and must not change what it passes
        event.ignore()


def editor_for(row: ParameterRow, parent: QWidget) -> NumberField | SwitchField | ChoiceField:
    """Make the field that fits a parameter's type."""
    field: NumberField | SwitchField | ChoiceField
    if row.type is bool:
        field = SwitchField(parent)
    elif row.choices:
        field = ChoiceField(row.choices, parent)
    else:
        field = NumberField(parent)
    words = f"{row.name.replace('_', ' ')} {row.unit}".strip()
    field.setAccessibleName(words)
    field.setAccessibleDescription(row.help)
    return field

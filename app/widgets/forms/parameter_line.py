"""One parameter in the tuning panel, generated from its declaration."""

import textwrap
from collections.abc import Callable

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QFont, QKeyEvent, QMouseEvent
from PySide6.QtWidgets import QCheckBox, QComboBox, QGridLayout, QLineEdit, QWidget

from stereotrack_core.errors import InputError
from stereotrack_core.parameters import ParameterRow, Value, value_text

from ..style.building import ElidedLabel, choice, label, label_of, show_text, tool_button
from ..style.theme import set_look

_EDITOR_WIDTH = 116
_UNIT_WIDTH = 34
_TIP_WIDTH = 80


class ParameterLine(QWidget):
    """Name, field and unit of a parameter, what it does, its range and defaults, and a way back.

    Folded, it shows the beginning of what it does; it unfolds when a person goes to it. What is
    above it stays in its place then, and so does the field under the mouse. `changed` is called
    with the name and a value that the person gave and the row takes.
    """

    def __init__(
        self, row: ParameterRow, changed: Callable[[str, Value], object], parent: QWidget
    ) -> None:
        super().__init__(parent)
        self.row, self._changed = row, changed
        self._value: Value = row.default
        self._base: Value = row.default
        self._base_word = "preset"
        self.editor = self._make_editor()
        self.editor.setFixedWidth(_EDITOR_WIDTH)
        self.editor.setAccessibleName(f"{row.name.replace('_', ' ')} {row.unit}".strip())
        self.editor.setAccessibleDescription(row.help)
        self.revert_button = tool_button("", "reset", role="plain", do=self.revert)
        self.revert_button.setAccessibleName(f"Revert {row.name.replace('_', ' ')}")
        self._name = label_of(self.editor, row.name.replace("_", " "))
        self._name.setMinimumWidth(60)
        self._summary = ElidedLabel(row.help, self)
        self._help = label(row.help, "muted")
        self._facts = label("", "muted")
        self._facts.setTextFormat(Qt.TextFormat.RichText)
        self._facts.linkActivated.connect(lambda: self._on_given(row.thesis))
        self._refusal = label("", "error")
        self._refusal.hide()
        self.setToolTip(f"{textwrap.fill(row.help, _TIP_WIDTH)}\n\n--set {row.name}=…")
        unit = label(self.row.unit, "muted", wraps=False)
        unit.setFixedWidth(_UNIT_WIDTH)
        grid = QGridLayout(self)
        grid.setContentsMargins(8, 3, 4, 3)
        grid.setHorizontalSpacing(6)
        grid.setVerticalSpacing(1)
        grid.setColumnStretch(0, 1)
        for place, part in enumerate((self._name, self.editor, unit, self.revert_button)):
            grid.addWidget(part, 0, place)
        below = self._summary, self._help, self._facts, self._refusal
        for place, part in enumerate(below, start=1):
            grid.addWidget(part, place, 0, 1, 4)
        self.unfold(unfolded=False)
        self._show()
        self.editor.installEventFilter(self)

    def unfold(self, *, unfolded: bool = True) -> None:
        self._summary.setVisible(not unfolded)
        self._help.setVisible(unfolded)
        self._facts.setVisible(unfolded)

    def mousePressEvent(self, _event: QMouseEvent) -> None:
        self.unfold()

    def eventFilter(self, _editor: QObject, event: QEvent) -> bool:
        if event.type() in (QEvent.Type.FocusIn, QEvent.Type.MouseButtonPress):
            self.unfold()
        pressed = event.key() if isinstance(event, QKeyEvent) else None
        if event.type() != QEvent.Type.KeyPress or pressed != Qt.Key.Key_Escape:
            return False
        self._show()
        return True

    @property
    def is_changed(self) -> bool:
        """Whether the value differs from what revert goes back to."""
        return self._value != self._base

    @property
    def refusal(self) -> str:
        """Why the text in the field was not taken; empty where it was."""
        return self._refusal.text()

    def show_values(self, value: Value, base: Value, base_word: str = "preset") -> None:
        """Show the value, and what revert goes back to; `base_word` says whose value that is."""
        shown = value, base, base_word
        # Most lines stay as they are when one value is given, and writing them anew takes time.
        if shown != (self._value, self._base, self._base_word) or self.refusal:
            self._value, self._base, self._base_word = shown
            self._show()

    def revert(self) -> None:
        self._on_given(self._base)

    def _make_editor(self) -> QWidget:
        if self.row.type is bool:
            switch = QCheckBox()
            switch.clicked.connect(self._on_given)
            return switch
        if self.row.choices:
            options = [(one, one.replace("_", " ")) for one in self.row.choices]
            return choice("", options, chosen=self._on_given)
        field = QLineEdit(alignment=Qt.AlignmentFlag.AlignRight)  # nothing is clamped in silence

        def on_typed() -> None:
            if field.isModified():
                field.setModified(False)
                self._on_given(field.text().strip())

        field.editingFinished.connect(on_typed)
        return field

    def _on_given(self, given: Value | None) -> None:
        if given is None:
            return
        try:
            value = self.row.checked(given)
        except InputError as problem:
            show_text(self._refusal, f"{problem.what}. {problem.remedy}")
            set_look(self.editor, "refused", True)
            return
        changed = value != self._value
        self._value = value
        self._show()
        if changed:
            self._changed(self.row.name, value)

    def _show(self) -> None:
        match self.editor:
            case QCheckBox() as switch:
                switch.setChecked(bool(self._value))
                switch.setText(value_text(bool(self._value)))
            case QComboBox() as box:
                box.setCurrentIndex(box.findData(self._value))
            case QLineEdit() as field:
                field.setText(value_text(self._value))
                field.setCursorPosition(0)
        show_text(self._refusal, "")
        set_look(self.editor, "refused", None)
        font = QFont(self.font())
        font.setBold(self.is_changed)
        self._name.setFont(font)
        self._name.setText(self.row.name.replace("_", " ") + (" ●" if self.is_changed else ""))
        self.revert_button.setEnabled(self.is_changed)
        nothing = f"Nothing to revert: this is the value of the {self._base_word}"
        back = f"Revert to {value_text(self._base)}" if self.is_changed else nothing
        self.revert_button.setToolTip(back)
        self._facts.setText(self._facts_text())

    def _facts_text(self) -> str:
        row = self.row
        parts = []
        if not row.choices and row.type is not bool and (row.minimum, row.maximum) != (None, None):
            parts.append(row.range_text())
        parts.append(f"default {value_text(row.default)}")
        if row.thesis is not None:
            thesis = value_text(row.thesis)
            same = row.thesis == self._value
            parts.append(f"thesis {thesis}" if same else f'<a href="thesis">thesis {thesis}</a>')
        if self._base != row.default and self._base_word != "thesis":
            parts.append(f"{self._base_word} {value_text(self._base)}")
        return " · ".join(parts).replace("_", " ")

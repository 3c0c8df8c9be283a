"""The tuning panel, generated from the declared parameters: a line for each."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

from PySide6.QtCore import Qt, QTimer, Signal, Slot
from PySide6.QtGui import QAction, QFont, QKeyEvent, QResizeEvent, QWheelEvent
from PySide6.QtWidgets import (
    QBoxLayout,
    QCheckBox,
    QComboBox,
    QGridLayout,
    QLabel,
    QLineEdit,
    QMenu,
    QPushButton,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from stereotrack_core.errors import InputError
from stereotrack_core.parameters import ParameterGroup, ParameterRow, Value, value_text
from stereotrack_core.tracking.presets import PRESETS
from stereotrack_core.tracking.tuning.search import finds

from ..style.building import choice, hbox, label, scrolled, tool_button, vbox

_EDITOR_WIDTH = 116
_UNIT_WIDTH = 34
_TIP_WIDTH = 80
_ONE_ROW_WIDTH = 520
"""Pixels from which the preset and what it is compared with have room in one row."""
_ABOVE = 6


class _Number(QLineEdit):
    """A number as text; nothing is clamped in silence."""

    dropped = Signal()
    """The person pressed Esc."""

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() == Qt.Key.Key_Escape:
            self.dropped.emit()
        else:
            super().keyPressEvent(event)


class _Choice(QComboBox):
    """One of several words."""

    def wheelEvent(self, event: QWheelEvent) -> None:
        # the wheel scrolls the panel and must not change what it passes
        event.ignore()


class ParameterLine(QWidget):
    """Name, field and unit of a parameter, what it does, its range and defaults, and a way back."""

    value_changed = Signal(str, object)
    """The person gave a value that the row accepts."""

    def __init__(self, row: ParameterRow, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.row = row
        self._value: Value = row.default
        self._base: Value = row.default
        self._base_word = "preset"
        self._written = False
        self.editor = self._make_editor()
        self.editor.setFixedWidth(_EDITOR_WIDTH)
        self.editor.setAccessibleName(f"{row.name.replace('_', ' ')} {row.unit}".strip())
        self.editor.setAccessibleDescription(row.help)
        self.revert_button = tool_button("", "reset", role="plain")
        self.revert_button.setAccessibleName(f"Revert {row.name.replace('_', ' ')}")
        self.revert_button.clicked.connect(self.revert)
        self._name = label(row.name.replace("_", " "), wraps=False)
        self._name.setBuddy(self.editor)
        self._name.setMinimumWidth(60)
        self._help = label(row.help, "muted")
        self._facts = label("", "muted")
        self._facts.setTextFormat(Qt.TextFormat.RichText)
        self._facts.linkActivated.connect(lambda: self._on_given(row.thesis))
        self._refusal = label("", "error")
        self._refusal.hide()
        self.setToolTip(f"{textwrap.fill(row.help, _TIP_WIDTH)}\n\n--set {row.name}=…")
        self._lay_out()

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
        if shown != (self._value, self._base, self._base_word) or self.refusal or not self._written:
            self._value, self._base, self._base_word = shown
            self._show()

    def revert(self) -> None:
        """Go back to the base's value."""
        self._on_given(self._base)

    def _make_editor(self) -> QWidget:
        """Make the field that fits the parameter's type."""
        if self.row.type is bool:
            switch = QCheckBox()
            switch.clicked.connect(self._on_given)
            return switch
        if self.row.choices:
            box = _Choice()
            for choice in self.row.choices:
                box.addItem(choice.replace("_", " "), choice)
            box.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
            box.activated.connect(lambda: self._on_given(box.currentData()))
            return box
        field = _Number()
        field.setAlignment(Qt.AlignmentFlag.AlignRight)
        field.editingFinished.connect(lambda: self._on_typed(field))
        field.dropped.connect(self._show)
        return field

    def _on_typed(self, field: QLineEdit) -> None:
        if field.isModified():
            field.setModified(False)
            self._on_given(field.text().strip())

    def _lay_out(self) -> None:
        unit = label(self.row.unit, "muted", wraps=False)
        unit.setFixedWidth(_UNIT_WIDTH)
        grid = QGridLayout(self)
        grid.setContentsMargins(8, 3, 4, 3)
        grid.setHorizontalSpacing(6)
        grid.setVerticalSpacing(1)
        grid.setColumnStretch(0, 1)
        for place, part in enumerate((self._name, self.editor, unit, self.revert_button)):
            grid.addWidget(part, 0, place)
        for place, part in enumerate((self._help, self._facts, self._refusal), start=1):
            grid.addWidget(part, place, 0, 1, 4)

    def _on_given(self, given: Value | None) -> None:
        if given is None:
            return
        try:
            value = self.row.checked(given)
        except InputError as problem:
            self._refuse(f"{problem.what}. {problem.remedy}")
            return
        changed = value != self._value
        self._value = value
        self._show()
        if changed:
            self.value_changed.emit(self.row.name, value)

    def _refuse(self, sentence: str) -> None:
        self._refusal.setText(sentence)
        self._refusal.show()
        self._mark(refused=True)

    def _show(self) -> None:
        self._written = True
        match self.editor:
            case QCheckBox() as switch:
                switch.setChecked(bool(self._value))
                switch.setText(value_text(bool(self._value)))
            case QComboBox() as box:
                box.setCurrentIndex(box.findData(self._value))
            case QLineEdit() as field:
                field.setText(value_text(self._value))
                field.setCursorPosition(0)
        self._refusal.clear()
        self._refusal.hide()
        self._mark(refused=False)
        font = QFont(self.font())
        font.setBold(self.is_changed)
        self._name.setFont(font)
        self._name.setText(self.row.name.replace("_", " ") + (" ●" if self.is_changed else ""))
        self.revert_button.setEnabled(self.is_changed)
        self.revert_button.setToolTip(
            f"Revert to {value_text(self._base)}"
            if self.is_changed
            else f"Nothing to revert: this is the value of the {self._base_word}"
        )
        self._facts.setText(self._facts_text())

    def _mark(self, *, refused: bool) -> None:
        if self.editor.property("refused") != refused:
            self.editor.setProperty("refused", refused)
            self.editor.style().polish(self.editor)

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


AGAINST: dict[str, str] = {
    "preset": "the preset",
    "run": "the active run",
    "thesis": "the thesis",
}
"""What settings may be compared with, as a word and as a person reads it."""


class ParameterPanel(QWidget):
    """Every parameter by group, with search, presets and a way back for each."""

    settings_changed = Signal(object)
    """New settings after the person gave a value; the panel shows them already."""
    preset_requested = Signal(str)
    """The person chose a preset; the caller answers with :meth:`set_settings`."""
    against_requested = Signal(str)
    """The person wants differences from something else, a key of :data:`AGAINST`; the caller
    answers with :meth:`set_settings`."""
    touched = Signal(str)
    """The person gave this parameter a value."""

    def __init__(self, parent: QWidget | None = None, *, presets: Sequence[str] = PRESETS) -> None:
        super().__init__(parent)
        self.settings: ParameterGroup | None = None
        self._base: ParameterGroup | None = None
        self._against = "preset"
        self._rows: tuple[ParameterRow, ...] = ()
        self._behind = self._seen = False
        self.last_touched = ""
        """The parameter that the panel opens at."""
        self._opening = QTimer(self, singleShot=True, interval=0)
        self._opening.timeout.connect(self._open_at_last)
        self._lines: dict[str, ParameterLine] = {}
        self._groups: dict[str, QWidget] = {}
        self._nothing = label("", "muted")
        self._nothing.setAlignment(Qt.AlignmentFlag.AlignHCenter)
        self._scroll = scrolled(QWidget(), "Parameters")
        head = self._make_head(presets)
        self.setLayout(vbox(head, (self._scroll, 1), margins=(6, 6, 0, 0), spacing=4))
        self.setMinimumWidth(260)
        self._fill()

    # ---- what is shown

    def line(self, name: str) -> ParameterLine:
        """Return the line of a parameter."""
        self._catch_up()
        return self._lines[name]

    @Slot(bool)
    def set_seen(self, seen: bool) -> None:
        """Make the lines when they are seen first: there are a hundred of them."""
        self._seen = seen
        if seen:
            self._catch_up()

    def set_settings(
        self, settings: ParameterGroup, base: ParameterGroup, against: str = "preset"
    ) -> None:
        """Show `settings`; what differs from `base` is marked and can be reverted.

        `against` says what the base is, a key of :data:`AGAINST`.
        """
        self.settings, self._base, self._against = settings, base, against
        self.against_box.setCurrentIndex(self.against_box.findData(against))
        self.revert_all.setToolTip(f"Revert all parameters to the values of {AGAINST[against]}")
        self.only_changed.setToolTip(f"Show only parameters that differ from {AGAINST[against]}")
        self._behind = True
        if self._seen:
            self._catch_up()

    def set_presets(self, names: Sequence[str]) -> None:
        """Offer these presets; which one is shown stays."""
        shown = self.preset_box.currentText()
        self.preset_box.clear()
        self.preset_box.addItems(list(names))
        self.set_preset(shown)

    def set_menu(self, actions: Sequence[QAction]) -> None:
        """Offer commands about presets beside the list of them."""
        menu = QMenu(self.menu_button)
        menu.setToolTipsVisible(True)
        menu.addActions(list(actions))
        self.menu_button.setMenu(menu)
        self.menu_button.show()

    def focus_search(self) -> None:
        """Let the person type what is looked for."""
        self.search.setFocus(Qt.FocusReason.ShortcutFocusReason)
        self.search.selectAll()

    def set_preset(self, name: str) -> None:
        """Show which preset the base is; an empty name stands for none."""
        self.preset_box.setCurrentIndex(self.preset_box.findText(name))

    # ---- inside

    def _make_head(self, presets: Sequence[str]) -> QVBoxLayout:
        self.preset_box = choice("Preset", tip="Set all parameters from a preset")
        self.preset_box.addItems(list(presets))
        self.preset_box.setCurrentIndex(-1)
        self.preset_box.setPlaceholderText("custom settings")
        self.preset_box.textActivated.connect(self.preset_requested)
        self.revert_all = QPushButton("Revert all", self)
        self.revert_all.clicked.connect(self._on_revert_all)
        self.search = QLineEdit(self)
        self.search.setPlaceholderText("Search names, descriptions and topics")
        self.search.setToolTip(
            "Type part of a name or description, or what it is about, such as cross, lost, jitter, "
            "noise or speed."
        )
        self.search.setAccessibleName("Search parameters")
        self.search.setClearButtonEnabled(True)
        self.search.textChanged.connect(self._on_search)
        self.only_changed = tool_button("", "filter", "Changed")
        self.only_changed.setAutoRaise(False)
        self.only_changed.setCheckable(True)
        self.only_changed.toggled.connect(self._sift)
        self.menu_button = tool_button("Save, load and delete your own presets", "save")
        self.menu_button.setAutoRaise(False)
        self.menu_button.setAccessibleName("Your own presets")
        self.menu_button.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        self.menu_button.hide()
        tip = "The values to compare with and to revert to"
        self.against_box = choice("Compare with", AGAINST.items(), tip)
        self.against_box.activated.connect(
            lambda: self.against_requested.emit(self.against_box.currentData())
        )
        self._rows_above = hbox(
            (hbox(QLabel("Preset", self), (self.preset_box, 1), self.menu_button), 1),
            (hbox(QLabel("Compare with", self), (self.against_box, 1), self.revert_all), 1),
            spacing=4,
        )
        find = hbox((self.search, 1), self.only_changed)
        return vbox(self._rows_above, find, margins=(0, 0, 6, 0), spacing=4)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        wide = self.width() >= _ONE_ROW_WIDTH
        way = QBoxLayout.Direction.LeftToRight if wide else QBoxLayout.Direction.TopToBottom
        self._rows_above.setDirection(way)

    def _catch_up(self) -> None:
        """Show in the lines what was given while nobody saw them."""
        if not self._behind or self.settings is None or self._base is None:
            return
        self._behind = False
        rows = self.settings.rows()
        if rows != self._rows:
            self._rows = rows
            self._fill()
            self._opening.start()
        values, bases = self.settings.values(), self._base.values()
        for name, line in self._lines.items():
            line.show_values(values[name], bases[name], self._against)
        self._sift()

    def _fill(self) -> None:
        self._lines, self._groups = {}, {}
        inside, column = QWidget(), vbox(self._nothing, margins=(0, 0, 4, 8), spacing=0)
        inside.setLayout(column)
        for row in self._rows:
            if row.group not in self._groups:
                heading = label(row.group, "heading", wraps=False, margins=(0, 10, 0, 2))
                self._groups[row.group] = heading
                column.addWidget(heading)
            line = ParameterLine(row, inside)
            line.value_changed.connect(self._on_value)
            self._lines[row.name] = line
            column.addWidget(line)
        column.addStretch(1)
        self._scroll.setWidget(inside)
        self._sift()

    def _sift(self) -> None:
        words, only_changed = self.search.text(), self.only_changed.isChecked()
        seen = set()
        for line in self._lines.values():
            visible = finds(line.row, words) and (line.is_changed or not only_changed)
            line.setVisible(visible)
            if visible:
                seen.add(line.row.group)
        for group, heading in self._groups.items():
            heading.setVisible(group in seen)
        count = sum(line.is_changed for line in self._lines.values())
        self.only_changed.setText(f"{count} changed")
        self.revert_all.setEnabled(count > 0)
        self._nothing.setVisible(not seen)
        self._nothing.setText(
            f"No parameter differs from {AGAINST[self._against]}."
            if only_changed and not words
            else f"No parameter matches “{words}”."
            if self._lines
            else "No settings are loaded."
        )

    @Slot(str)
    def _on_search(self, words: str) -> None:
        self._sift()
        if not words:
            self._opening.start()

    @Slot()
    def _open_at_last(self) -> None:
        """Show the parameter that was touched last at the top, among the others."""
        line = self._lines.get(self.last_touched)
        if line is not None and not line.isHidden():
            self._scroll.verticalScrollBar().setValue(line.y() - _ABOVE)

    def _on_value(self, name: str, value: Value) -> None:
        self.last_touched = name
        self.touched.emit(name)
        if self.settings is not None:
            self._take(self.settings.replaced(**{name: value}))

    def _on_revert_all(self) -> None:
        if self.settings is not None and self._base is not None:
            self._take(self._base)

    def _take(self, settings: ParameterGroup) -> None:
        if self._base is not None:
            self.set_settings(settings, self._base, self._against)
            self.settings_changed.emit(settings)

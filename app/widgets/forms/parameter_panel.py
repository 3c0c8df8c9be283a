"""The tuning panel, generated from the declared parameters: a line for each."""

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from html import escape

from PySide6 import QtWidgets
from PySide6.QtCore import QEvent, QObject, Qt, QTimer, Signal, Slot
from PySide6.QtGui import QAction, QFont, QKeyEvent, QMouseEvent

from stereotrack_core.errors import InputError
from stereotrack_core.parameters import ParameterGroup, ParameterRow, Value, value_text
from stereotrack_core.tracking.presets import PRESETS

from ..style import building
from ..style.theme import set_look
from .form_dialog import line_edit

_EDITOR_WIDTH = 116
_UNIT_WIDTH = 34
_REVERT_WIDTH = 26


class ParameterLine(QtWidgets.QWidget):
    """Name, field and unit of a parameter, what it does, its range and defaults, and a way back.

    Folded, it shows the beginning of what it does; it unfolds when a person goes to it. What is
    above it stays in its place then, and so does the field under the mouse. `changed` is called
    with the name and a value that the person gave and the row takes.
    """

    def __init__(
        self, row: ParameterRow, changed: Callable[[str, Value], object], parent: QtWidgets.QWidget
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
        self.revert_button = building.tool_button("", "reset", role="plain", do=self.revert)
        self.revert_button.setAccessibleName(f"Revert {row.name.replace('_', ' ')}")
        self._name = building.label_of(self.editor, row.name.replace("_", " "))
        self._name.setMinimumWidth(60)
        self._summary = building.ElidedLabel(row.help, self)
        # Made when they are needed: a hundred lines are made together, and few are unfolded.
        self._more: QtWidgets.QLabel | None = None
        self._refusal: QtWidgets.QLabel | None = None
        self.setToolTip(f"<p>{escape(row.help)}</p><p>--set {row.name}=…</p>")
        grid = self._grid = QtWidgets.QGridLayout(self)
        grid.setContentsMargins(8, 3, 4, 3)
        grid.setHorizontalSpacing(6)
        grid.setVerticalSpacing(1)
        grid.setColumnStretch(0, 1)
        grid.setColumnMinimumWidth(2, _UNIT_WIDTH)
        grid.setColumnMinimumWidth(3, _REVERT_WIDTH)
        for place, part in ((0, self._name), (1, self.editor), (3, self.revert_button)):
            grid.addWidget(part, 0, place)
        if row.unit:
            grid.addWidget(building.label(row.unit, "muted", wraps=False), 0, 2)
        grid.addWidget(self._summary, 1, 0, 1, 4)
        self._show()
        self.editor.installEventFilter(self)

    def unfold(self) -> None:
        """Show all that is known of the parameter instead of its beginning."""
        if self._more is None:
            self._more = building.label("", "muted")
            self._more.setTextFormat(Qt.TextFormat.RichText)
            self._more.linkActivated.connect(lambda: self._on_given(self.row.thesis))
            self._grid.addWidget(self._more, 2, 0, 1, 4)
            self._more.show()
            self._summary.hide()
        self._more.setText(f"{escape(self.row.help)}<br>{self._facts_text()}")

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
        return "" if self._refusal is None else self._refusal.text()

    def show_values(self, value: Value, base: Value, base_word: str = "preset") -> None:
        """Show the value, and what revert goes back to; `base_word` says whose value that is."""
        shown = value, base, base_word
        # Most lines stay as they are when one value is given, and writing them anew takes time.
        if shown != (self._value, self._base, self._base_word) or self.refusal:
            self._value, self._base, self._base_word = shown
            self._show()

    def revert(self) -> None:
        if self.revert_button.hasFocus():  # it is hidden now, and the next line would unfold
            self.editor.setFocus()
        self._on_given(self._base)

    def _make_editor(self) -> QtWidgets.QWidget:
        if self.row.type is bool:
            switch = QtWidgets.QCheckBox()
            switch.clicked.connect(self._on_given)
            return switch
        if self.row.choices:
            options = [(one, one.replace("_", " ")) for one in self.row.choices]
            return building.choice("", options, chosen=self._on_given)
        # nothing is clamped in silence, as fields for numbers do
        field = QtWidgets.QLineEdit(alignment=Qt.AlignmentFlag.AlignRight)

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
            if self._refusal is None:
                self._refusal = building.label("", "error")
                self._grid.addWidget(self._refusal, 3, 0, 1, 4)
            building.show_text(self._refusal, f"{problem.what}. {problem.remedy}")
            set_look(self.editor, "refused", True)
            return
        changed = value != self._value
        self._value = value
        self._show()
        if changed:
            self._changed(self.row.name, value)

    def _show(self) -> None:
        match self.editor:
            case QtWidgets.QCheckBox() as switch:
                switch.setChecked(bool(self._value))
                switch.setText(value_text(bool(self._value)))
            case QtWidgets.QComboBox() as box:
                box.setCurrentIndex(box.findData(self._value))
            case QtWidgets.QLineEdit() as field:
                field.setText(value_text(self._value))
                field.setCursorPosition(0)
        if self._refusal is not None:
            building.show_text(self._refusal, "")
        set_look(self.editor, "refused", None)
        font = QFont(self.font())
        font.setBold(self.is_changed)
        self._name.setFont(font)
        self._name.setText(self.row.name.replace("_", " ") + (" ●" if self.is_changed else ""))
        self.revert_button.setVisible(self.is_changed)
        self.revert_button.setToolTip(f"Revert to {value_text(self._base)}")
        if self._more is not None:
            self.unfold()

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


_FEW = 4  # parameters that a search finds, up to which all of their explanations are shown
_PRESSED_MS = 100  # pause after which a mouse button may be released


AGAINST: dict[str, str] = {"preset": "the preset", "run": "the active run", "thesis": "the thesis"}


class ParameterPanel(QtWidgets.QWidget):
    """Changed parameters, then the others by group, with search, presets and a way back for each.

    Who hears that a person chooses in `preset_box` or `against_box` answers with
    :meth:`set_settings`.
    """

    settings_changed = Signal(object)
    """New settings after the person gave a value; the panel shows them already."""

    def __init__(self) -> None:
        super().__init__()
        self.settings: ParameterGroup | None = None
        self._base: ParameterGroup | None = None
        self._against = "preset"
        self._rows: tuple[ParameterRow, ...] = ()
        self._behind = self._seen = False
        self._acts: Callable[[str], bool] = lambda _name: True
        self._lines: dict[str, ParameterLine] = {}
        self._groups: dict[str, QtWidgets.QWidget] = {}
        self._pinned: list[ParameterLine] = []
        self._idle = building.label("", "muted")
        self._idle.hide()
        self._nothing = building.label("", "muted", align=Qt.AlignmentFlag.AlignHCenter)
        self._scroll = building.scrolled(QtWidgets.QWidget(), "Parameters")
        parts = (self._make_head(), self._idle, (self._scroll, 1))
        self.setLayout(building.vbox(*parts, margins=(6, 6, 0, 0), spacing=4))
        self.setMinimumWidth(260)
        self._fill()
        self._sift()

    def line(self, name: str) -> ParameterLine:
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
        self._behind = True
        if self._seen:
            self._catch_up()

    def set_acting(self, acts: Callable[[str], bool], why: str) -> None:
        """Show only parameters that change anything; `why` says why the others do not."""
        self._acts = acts
        building.show_text(self._idle, why)
        self._sift()

    def set_presets(self, names: Sequence[str]) -> None:
        shown = self.preset_box.currentText()
        self.preset_box.clear()
        self.preset_box.addItems(list(names))
        self.set_preset(shown)

    def set_menu(self, actions: Sequence[QAction]) -> None:
        building.menu_of(self.menu_button).addActions(list(actions))
        self.menu_button.show()

    def focus_search(self) -> None:
        self.search.setFocus(Qt.FocusReason.ShortcutFocusReason)
        self.search.selectAll()

    def _focus_found(self) -> None:
        found = [line for line in self._lines.values() if line.isVisible()]
        if found:
            min(found, key=QtWidgets.QWidget.y).editor.setFocus(Qt.FocusReason.ShortcutFocusReason)

    def set_preset(self, name: str) -> None:
        """Show which preset the base is; an empty name stands for none."""
        self.preset_box.setCurrentIndex(self.preset_box.findText(name))

    def _make_head(self) -> QtWidgets.QVBoxLayout:
        self.preset_box = building.choice("Preset", tip="Set all parameters from a preset")
        self.preset_box.addItems(list(PRESETS))
        self.preset_box.setCurrentIndex(-1)
        self.preset_box.setPlaceholderText("custom settings")
        self.revert_all = QtWidgets.QPushButton("Revert all", self)
        self.revert_all.clicked.connect(lambda: self._take(self._base))
        tip = "Type part of a name or description. Enter goes to the first value that is found."
        self.search = line_edit("Search parameters", "", "Search names and descriptions", tip)
        self.search.setClearButtonEnabled(True)
        self.search.textChanged.connect(self._sift)
        self.search.returnPressed.connect(self._focus_found)
        self.menu_button = building.tool_button("Save, load and delete your own presets", "save")
        self.menu_button.setAutoRaise(False)
        self.menu_button.setAccessibleName("Your own presets")
        self.menu_button.hide()
        tip = "The values to compare with and to revert to"
        self.against_box = building.choice("Compare with", AGAINST.items(), tip)
        use = building.hbox(
            QtWidgets.QLabel("Preset", self), (self.preset_box, 1), self.menu_button
        )
        compare = building.hbox(
            QtWidgets.QLabel("Compare with", self), (self.against_box, 1), self.revert_all
        )
        return building.vbox(use, compare, self.search, margins=(0, 0, 6, 0), spacing=4)

    def _catch_up(self) -> None:
        """Show in the lines what was given while nobody saw them."""
        if not self._behind or self.settings is None or self._base is None:
            return
        self._behind = False
        if (rows := self.settings.rows()) != self._rows:
            self._rows = rows
            self._fill()
        values, bases = self.settings.values(), self._base.values()
        for name, line in self._lines.items():
            line.show_values(values[name], bases[name], self._against)
        self._sift()
        self._pin()

    def _fill(self) -> None:
        heading = partial(building.label, role="heading", wraps=False, margins=(0, 10, 0, 2))
        self._lines, self._groups, self._pinned = {}, {}, []
        self.changed_words = heading("")
        self._column = building.vbox(
            self._nothing, self.changed_words, margins=(0, 0, 4, 8), spacing=0
        )
        inside = building.holder(self._column)
        for row in self._rows:
            if row.group not in self._groups:
                self._groups[row.group] = heading(row.group)
                self._column.addWidget(self._groups[row.group])
            line = ParameterLine(row, self._on_value, inside)
            self._lines[row.name] = line
            self._column.addWidget(line)
        self._column.addStretch(1)
        self._scroll.setWidget(inside)
        self._chain(self._lines.values())

    def _chain(self, lines: Iterable[ParameterLine]) -> None:
        """Let Tab go from the head to the lines; else it walks the whole window first."""
        stop: QtWidgets.QWidget = self._scroll
        for line in lines:
            self.setTabOrder(stop, line.editor)
            self.setTabOrder(line.editor, line.revert_button)
            stop = line.revert_button

    def _pin(self) -> None:
        """Put the changed lines first, where they are in sight, and the others by group."""
        lines = self._lines.values()
        changed = [line for line in lines if line.is_changed]
        if changed == self._pinned:
            return
        if QtWidgets.QApplication.mouseButtons():  # what is pressed stays under the mouse
            QTimer.singleShot(_PRESSED_MS, self, self._pin)
            return
        focused, self._pinned = self.focusWidget(), changed
        order: list[QtWidgets.QWidget] = [self.changed_words, *changed]
        for group, heading in self._groups.items():
            others = (one for one in lines if one.row.group == group and one not in changed)
            order += [heading, *others]
        for place, widget in enumerate(order, start=1):
            if self._column.indexOf(widget) != place:
                self._column.insertWidget(place, widget)
        self._chain(one for one in order if isinstance(one, ParameterLine))
        self._column.activate()
        if focused is not None and self._scroll.isAncestorOf(focused):
            self._scroll.ensureWidgetVisible(focused)

    def _sift(self) -> None:
        words, lines = self.search.text(), self._lines.values()
        acting = [line for line in lines if self._acts(line.row.name)]
        found = [line for line in acting if line.row.matches(words)]
        for line in lines:
            line.setVisible(line in found)
        for line in found if len(found) <= _FEW else ():
            line.unfold()
        seen = {line.row.group for line in found if not line.is_changed}
        for group, heading in self._groups.items():
            heading.setVisible(group in seen)
        changed = sum(line.is_changed for line in acting)
        other = f"{changed} changed from {AGAINST[self._against]}" if changed else ""
        building.show_text(self.changed_words, other)
        self.revert_all.setEnabled(any(line.is_changed for line in lines))
        self._nothing.setVisible(not found)
        none = f"No parameter matches “{words}”."
        self._nothing.setText(none if self._lines else "No settings are loaded.")

    def _on_value(self, name: str, value: Value) -> None:
        self._take(self.settings and self.settings.replaced(**{name: value}))

    def _take(self, settings: ParameterGroup | None) -> None:
        if self._base is not None and settings is not None:
            self.set_settings(settings, self._base, self._against)
            self.settings_changed.emit(settings)

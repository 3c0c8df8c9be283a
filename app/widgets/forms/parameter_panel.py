"""The tuning panel, generated from the declared parameters: a line for each."""

from collections.abc import Callable, Sequence
from functools import partial
from itertools import pairwise

from PySide6.QtCore import Qt, QTimer, Signal, Slot
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QApplication, QLabel, QPushButton, QVBoxLayout, QWidget

from stereotrack_core.parameters import ParameterGroup, ParameterRow, Value
from stereotrack_core.tracking.presets import PRESETS

from ..style.building import (
    choice,
    hbox,
    holder,
    label,
    menu_of,
    scrolled,
    show_text,
    tool_button,
    vbox,
)
from .form_dialog import line_edit
from .parameter_line import ParameterLine

_FEW = 4  # parameters that a search finds, up to which all of their explanations are shown
_PRESSED_MS = 100  # pause after which a mouse button may be released


AGAINST: dict[str, str] = {"preset": "the preset", "run": "the active run", "thesis": "the thesis"}


class ParameterPanel(QWidget):
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
        self._groups: dict[str, QWidget] = {}
        self._pinned: list[ParameterLine] = []
        self._idle = label("", "muted")
        self._idle.hide()
        self._nothing = label("", "muted", align=Qt.AlignmentFlag.AlignHCenter)
        self._scroll = scrolled(QWidget(), "Parameters")
        parts = (self._make_head(), self._idle, (self._scroll, 1))
        self.setLayout(vbox(*parts, margins=(6, 6, 0, 0), spacing=4))
        self.setMinimumWidth(260)
        self._fill()

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
        show_text(self._idle, why)
        self._sift()

    def set_presets(self, names: Sequence[str]) -> None:
        shown = self.preset_box.currentText()
        self.preset_box.clear()
        self.preset_box.addItems(list(names))
        self.set_preset(shown)

    def set_menu(self, actions: Sequence[QAction]) -> None:
        menu_of(self.menu_button).addActions(list(actions))
        self.menu_button.show()

    def focus_search(self) -> None:
        self.search.setFocus(Qt.FocusReason.ShortcutFocusReason)
        self.search.selectAll()

    def _focus_found(self) -> None:
        found = [line for line in self._lines.values() if line.isVisible()]
        if found:
            min(found, key=QWidget.y).editor.setFocus(Qt.FocusReason.ShortcutFocusReason)

    def set_preset(self, name: str) -> None:
        """Show which preset the base is; an empty name stands for none."""
        self.preset_box.setCurrentIndex(self.preset_box.findText(name))

    def _make_head(self) -> QVBoxLayout:
        self.preset_box = choice("Preset", tip="Set all parameters from a preset")
        self.preset_box.addItems(list(PRESETS))
        self.preset_box.setCurrentIndex(-1)
        self.preset_box.setPlaceholderText("custom settings")
        self.revert_all = QPushButton("Revert all", self)
        self.revert_all.clicked.connect(lambda: self._take(self._base))
        tip = "Type part of a name or description. Enter goes to the first value that is found."
        self.search = line_edit("Search parameters", "", "Search names and descriptions", tip)
        self.search.setClearButtonEnabled(True)
        self.search.textChanged.connect(self._sift)
        self.search.returnPressed.connect(self._focus_found)
        self.menu_button = tool_button("Save, load and delete your own presets", "save")
        self.menu_button.setAutoRaise(False)
        self.menu_button.setAccessibleName("Your own presets")
        self.menu_button.hide()
        tip = "The values to compare with and to revert to"
        self.against_box = choice("Compare with", AGAINST.items(), tip)
        use = hbox(QLabel("Preset", self), (self.preset_box, 1), self.menu_button)
        compare = hbox(QLabel("Compare with", self), (self.against_box, 1), self.revert_all)
        return vbox(use, compare, self.search, margins=(0, 0, 6, 0), spacing=4)

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
        heading = partial(label, role="heading", wraps=False, margins=(0, 10, 0, 2))
        self._lines, self._groups, self._pinned = {}, {}, []
        self.changed_words = heading("")
        self._column = vbox(self._nothing, self.changed_words, margins=(0, 0, 4, 8), spacing=0)
        inside = holder(self._column)
        for row in self._rows:
            if row.group not in self._groups:
                self._groups[row.group] = heading(row.group)
                self._column.addWidget(self._groups[row.group])
            line = ParameterLine(row, self._on_value, inside)
            self._lines[row.name] = line
            self._column.addWidget(line)
        self._column.addStretch(1)
        self._scroll.setWidget(inside)
        self._sift()

    def _pin(self) -> None:
        """Put the changed lines first, where they are in sight, and the others by group."""
        lines = self._lines.values()
        changed = [line for line in lines if line.is_changed]
        if changed == self._pinned:
            return
        if QApplication.mouseButtons():  # what is pressed stays under the mouse
            QTimer.singleShot(_PRESSED_MS, self, self._pin)
            return
        focused, self._pinned = self.focusWidget(), changed
        order: list[QWidget] = [self.changed_words, *changed]
        for group, heading in self._groups.items():
            others = (one for one in lines if one.row.group == group and one not in changed)
            order += [heading, *others]
        for place, widget in enumerate(order, start=1):
            if self._column.indexOf(widget) != place:
                self._column.insertWidget(place, widget)
        for before, after in pairwise(one for one in order if isinstance(one, ParameterLine)):
            self.setTabOrder(before.editor, before.revert_button)
            self.setTabOrder(before.revert_button, after.editor)
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
        show_text(self.changed_words, other)
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

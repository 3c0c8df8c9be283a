"""Steps of a longer piece of work with ticks for those that are done, and what one has come to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QButtonGroup, QPushButton, QSizePolicy, QWidget

from ..style.building import label, vbox
from ..style.theme import Dressed, current_theme

_DONE, _OLD, _OPEN = "✓", "↻", "\u2003"


@dataclass(frozen=True)
class StepShown:
    """One step; `why_not` says why it cannot be taken."""

    key: str
    title: str
    done: bool = False
    stale: bool = False
    """Whether it was done with other things than those that are chosen now."""
    why_not: str = ""


class StepList(Dressed):
    """A button per step, from top to bottom."""

    chosen = Signal(str)
    """Key of the step that was pressed."""

    def __init__(self, name: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAccessibleName(name)
        self.buttons: dict[str, QPushButton] = {}
        self._steps: tuple[StepShown, ...] = ()
        self._group = QButtonGroup(self)
        self._column = vbox(spacing=2)
        self.setLayout(vbox(self._column, None))

    def show_steps(self, steps: Sequence[StepShown], current: str) -> None:
        """Show these, and which one is open."""
        self._steps = tuple(steps)
        for number, step in enumerate(steps, start=1):
            button = self.buttons.get(step.key) or self._add(step)
            tick = _DONE if step.done else _OLD if step.stale else _OPEN
            button.setText(f"{tick}  {number}  {step.title}")
            said = "done" if step.done else "to be calculated again" if step.stale else "to do"
            button.setAccessibleName(f"Step {number}, {step.title}, {said}")
            unavailable = f"Unavailable: {step.why_not}" if step.why_not else said.capitalize()
            button.setToolTip(f"{step.title}. {unavailable}")
            button.setEnabled(not step.why_not)
            button.setChecked(step.key == current)
        self._dress()

    def _add(self, step: StepShown) -> QPushButton:
        button = QPushButton(step.title)
        button.setFlat(True)
        button.setAutoDefault(False)
        button.setCheckable(True)
        button.setMinimumWidth(150)
        button.clicked.connect(lambda _checked=False, key=step.key: self.chosen.emit(key))
        self._group.addButton(button)
        self._column.addWidget(button)
        self.buttons[step.key] = button
        return button

    def _dress(self) -> None:
        theme = current_theme()
        for step in self._steps:
            colour = theme.good if step.done else theme.warning if step.stale else theme.text
            colour = theme.disabled if step.why_not else colour
            chosen = f"background: {theme.selection}; border: 1px solid {theme.accent};"
            sheet = (
                f"QPushButton {{ color: {colour}; text-align: left; padding: 6px 8px;"
                f" border: 1px solid transparent; border-radius: {theme.radius}px; }}"
                f" QPushButton:hover {{ background: {theme.hover}; }}"
                f" QPushButton:checked {{ {chosen} }}"
                f" QPushButton:focus {{ border-color: {theme.accent}; }}"
            )
            if self.buttons[step.key].styleSheet() != sheet:
                self.buttons[step.key].setStyleSheet(sheet)


_MOST_REMARKS = 4


class VerdictBox(Dressed):
    """A raised box whose edge has the verdict's colour."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.setAccessibleName("Verdict")
        self._colour = "muted"
        self.words = label("", "heading")
        self.remarks = label()
        for one in (self.words, self.remarks):
            one.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Maximum)
        self.setLayout(vbox(self.words, self.remarks, margins=(12, 8, 12, 8), spacing=4))
        self._dress()

    def show_verdict(self, words: str, remarks: Sequence[str], colour: str) -> None:
        """Show a sentence and remarks; `colour` is the theme's: good, warning, error, muted."""
        shown = [f"• {one}" for one in remarks[:_MOST_REMARKS]]
        if len(remarks) > _MOST_REMARKS:
            shown.append(f"• and {len(remarks) - _MOST_REMARKS} more")
        self.words.setText(words)
        self.remarks.setText("\n".join(shown))
        self.remarks.setToolTip("\n".join(remarks))
        self.remarks.setVisible(bool(shown))
        self.setAccessibleDescription(" ".join((words, *remarks)))
        self._colour = colour
        self._dress()

    def _dress(self) -> None:
        theme = current_theme()
        sheet = (
            f"VerdictBox {{ background: {theme.raised}; border: none;"
            f" border-left: 5px solid {getattr(theme, self._colour)}; }}"
        )
        if sheet != self.styleSheet():
            self.setStyleSheet(sheet)

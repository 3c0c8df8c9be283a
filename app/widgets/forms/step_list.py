"""Steps of a longer piece of work with ticks for those that are done, and what one has come to."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from PySide6.QtWidgets import QButtonGroup, QPushButton, QSizePolicy, QWidget

from ..style.building import Raised, label, show_text, vbox
from ..style.theme import set_look
from .form_dialog import push_button

_DONE, _OLD, _OPEN = "✓", "↻", "\u2003"


@dataclass(frozen=True)
class StepShown:
    """One step; `why_not` says why it cannot be taken."""

    key: str
    title: str
    done: bool = False
    stale: bool = False  # whether it was done with other things than those that are chosen now
    why_not: str = ""


class StepList(QWidget):
    """A button per step, from top to bottom."""

    def __init__(self, name: str, choose: Callable[[str], object]) -> None:
        super().__init__()
        self._choose = choose
        self.setAccessibleName(name)
        self.buttons: dict[str, QPushButton] = {}
        self._group = QButtonGroup(self)
        self._column = vbox(spacing=2)
        self.setLayout(vbox(self._column, None))

    def show_steps(self, steps: Sequence[StepShown], current: str) -> None:
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
            set_look(button, "state", "done" if step.done else "stale" if step.stale else "")

    def _add(self, step: StepShown) -> QPushButton:
        button = push_button(step.title, lambda: self._choose(step.key))
        button.setFlat(True)
        button.setCheckable(True)
        button.setMinimumWidth(150)
        button.setProperty("role", "step")
        self._group.addButton(button)
        self._column.addWidget(button)
        self.buttons[step.key] = button
        return button


_MOST_REMARKS = 4


class VerdictBox(Raised):
    """A raised box whose edge has the verdict's colour."""

    def __init__(self) -> None:
        super().__init__("box")
        self.setAccessibleName("Verdict")
        self.words, self.remarks = label("", "heading", copied=True), label(copied=True)
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Maximum)
        self.setLayout(vbox(self.words, self.remarks, margins=(12, 8, 12, 8), spacing=4))

    def show_verdict(self, words: str, remarks: Sequence[str], colour: str) -> None:
        """Show a sentence and remarks; `colour` is the theme's: good, warning, error, muted."""
        shown = [f"• {one}" for one in remarks[:_MOST_REMARKS]]
        if len(remarks) > _MOST_REMARKS:
            shown.append(f"• and {len(remarks) - _MOST_REMARKS} more")
        self.words.setText(words)
        show_text(self.remarks, "\n".join(shown))
        self.remarks.setToolTip("\n".join(remarks))
        self.setAccessibleDescription(" ".join((words, *remarks)))
        set_look(self, "edge", colour)

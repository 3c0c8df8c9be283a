"""The steps of a calibration with ticks for those that are done, and what one has come to."""

from collections.abc import Callable, Sequence
from functools import partial

from PySide6.QtWidgets import QButtonGroup, QPushButton, QSizePolicy, QWidget

from ...widgets.forms.form_dialog import push_button
from ...widgets.style.building import Raised, label, named, show_text, vbox
from ...widgets.style.theme import set_look
from .state import DOING, STEPS, Calibration, StepName

_LOOKS = {"done": ("✓", "done"), "stale": ("↻", "to be calculated again"), "": ("\u2003", "to do")}
"""Sign and words for each state of a step: done, done with other things than chosen now, open."""


class StepList(QWidget):
    """A button per step, from top to bottom."""

    def __init__(self, choose: Callable[[str], object]) -> None:
        super().__init__()
        self.setAccessibleName("Steps of the calibration")
        self.buttons: dict[str, QPushButton] = {}
        group, column = QButtonGroup(self), vbox(spacing=2)
        for name in STEPS:
            button = self.buttons[name] = push_button("", partial(choose, name))
            button.setFlat(True)
            button.setCheckable(True)
            button.setMinimumWidth(150)
            button.setProperty("role", "step")
            group.addButton(button)
            column.addWidget(button)
        self.setLayout(vbox(column, None))

    def show_state(self, state: Calibration) -> None:
        for number, (name, title) in enumerate(STEPS.items(), start=1):
            look = "done" if state.is_done(name) else "stale" if state.is_stale(name) else ""
            (sign, said), why_not = _LOOKS[look], state.why_not(name)
            unavailable = f"Unavailable: {why_not}" if why_not else said.capitalize()
            button = self.buttons[name]
            named(button, f"Step {number}, {title}, {said}", f"{title}. {unavailable}")
            button.setText(f"{sign}  {number}  {title}")
            button.setEnabled(not why_not)
            button.setChecked(name == state.step)
            set_look(button, "state", look)


_HINTS: dict[StepName, tuple[str, tuple[str, ...]]] = {
    "board": (
        "Choose the pictures of each camera, and describe the board.",
        (
            "Film 15 to 30 positions for each camera, sharp, tilted by 30 to 45 degrees to all "
            "sides, near and far, and into every corner of the image.",
            "For several cameras, carry the board to where two of them see it at the same time. "
            "Picture k of all cameras must show the same instant.",
        ),
    ),
    "pictures": (
        "Find the board in the pictures.",
        ("Other descriptions of the board are tried too, and the one that fits is taken.",),
    ),
    "lenses": (
        "Calculate the lenses.",
        ("Each camera is calibrated from its own pictures; all lens models are tried.",),
    ),
    "world": (
        "Place all cameras in one world.",
        ("All cameras and all boards are adjusted together.",),
    ),
    "axes": ("Choose where up, north and the origin are, and save the calibration.", ()),
}
_STALE = "Other pictures are ticked now, or another lens model is chosen: calculate again."
_COLOURS = {"good": "good", "doubtful": "warning", "bad": "error"}
_MOST_REMARKS = 4


def _verdict(state: Calibration) -> tuple[str, Sequence[str], str]:
    """Sentence, remarks and colour (good, warning, error, muted) of the step that is shown."""
    if state.busy == state.step:
        return f"{DOING[state.step]} …", (), "accent"
    if state.step == "axes" and state.saved:
        return state.saved, (), "good"
    found = state.verdict(state.step)
    if found is None:
        return *_HINTS[state.step], "muted"
    if state.is_stale(state.step):  # in place of the words: a higher box would move the list
        return _STALE, found.remarks, "warning"
    return found.words, found.remarks, _COLOURS[found.grade]


class VerdictBox(Raised):
    """A raised box whose edge has the verdict's colour."""

    def __init__(self) -> None:
        super().__init__("box")
        self.setAccessibleName("Verdict")
        self.words, self.remarks = label("", "heading", copied=True), label(copied=True)
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Maximum)
        self.setLayout(vbox(self.words, self.remarks, margins=(12, 8, 12, 8), spacing=4))

    def show_state(self, state: Calibration) -> None:
        words, remarks, colour = _verdict(state)
        shown = [f"• {one}" for one in remarks[:_MOST_REMARKS]]
        if len(remarks) > _MOST_REMARKS:
            shown.append(f"• and {len(remarks) - _MOST_REMARKS} more")
        self.words.setText(words)
        show_text(self.remarks, "\n".join(shown))
        self.remarks.setToolTip("\n".join(remarks))
        self.setAccessibleDescription(" ".join((words, *remarks)))
        set_look(self, "edge", colour)

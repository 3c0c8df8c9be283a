"""Fields for numbers, which read what is typed in one way, whatever the locale.

Both ``.`` and ``,`` are the decimal sign, nothing groups digits, and a text that is no number is
refused with a sentence. Qt's own fields drop signs that are not the locale's: 25.5 becomes 255.
"""

from collections.abc import Callable
from typing import Any

from PySide6.QtCore import QLocale, QPoint, Qt, Signal, Slot
from PySide6.QtGui import QFocusEvent, QKeyEvent, QValidator, QWheelEvent
from PySide6.QtWidgets import QDoubleSpinBox, QToolTip, QWidget

from stereotrack_core.counting import typed_number, typed_whole_number

from ..style.theme import set_look

_MOST_DECIMALS = 6
_REFUSAL_MS = 10_000


class NumberField(QDoubleSpinBox):
    """A field for a number.

    `digits` are the decimals that are always shown; more are shown if they were typed. The number
    that is shown is the stored one times `per_unit`, such as 1000 for millimetres. `properties` are
    those of Qt's field, such as ``maximum`` and ``suffix``.

    A text that cannot be read stays in the field while it is typed. Enter refuses it and leaves it
    there to be corrected; without the focus the field shows its last number again.
    """

    refusal = ""  # why the last text was not taken; empty once another one is typed
    _agreed = ""
    _parsed: Callable[[str], float] = staticmethod(typed_number)
    _wanted = "a number. Write digits, with one . or , as the decimal sign"

    def __init__(self, *, digits: int = 1, per_unit: float = 1.0, **properties: Any) -> None:
        self._digits, self._per_unit = digits, per_unit
        self._stored: tuple[float, float] | None = None
        focus = {"focusPolicy": Qt.FocusPolicy.StrongFocus}  # the wheel gives none
        super().__init__(decimals=_MOST_DECIMALS, **focus | properties)
        locale = QLocale.c()
        locale.setNumberOptions(QLocale.NumberOption.OmitGroupSeparator)
        self.setLocale(locale)
        self._agree()
        self.editingFinished.connect(self._agree)
        self.lineEdit().textEdited.connect(self._on_edited)

    def show_stored(self, stored: float) -> None:
        """Show a stored number, rounded; :meth:`stored` returns it until another is typed."""
        self.setValue(round(self._per_unit * stored, self._digits))
        self._stored = stored, self.value()

    def stored(self) -> float:
        """The number in the unit in which it is stored."""
        if self._stored is not None and self.value() == self._stored[1]:
            return self._stored[0]
        return self.value() / self._per_unit

    def setValue(self, value: float) -> None:
        super().setValue(value)
        self._agree()

    def textFromValue(self, value: float) -> str:
        whole, _, decimals = f"{value + 0.0:.{_MOST_DECIMALS}f}".partition(".")
        decimals = decimals.rstrip("0").ljust(self._digits, "0")
        return f"{whole}.{decimals}" if decimals else whole

    def valueFromText(self, text: str) -> float:
        return self.minimum() if text == self.specialValueText() else self.number_in(text)

    def number_in(self, text: str) -> float:
        """Number that a text stands for; ValueError with a sentence if it cannot be taken."""
        prefix, suffix = self.prefix().strip(), self.suffix().strip()
        typed = text.strip().removeprefix(prefix)
        for _ in range(2):  # the field's own, and one that is pasted with the number
            typed = typed.removesuffix(suffix).strip()
        try:
            value = self._parsed(typed)
        except ValueError:
            raise ValueError(f"“{typed}” is not {self._wanted}.") from None
        if not self.minimum() <= value <= self.maximum():
            low, high = map(self.textFromValue, (self.minimum(), self.maximum()))
            raise ValueError(f"{typed} is not between {low} and {high}{self.suffix()}.")
        return value

    def validate(self, text: str, pos: int) -> tuple[QValidator.State, str, int]:
        state = QValidator.State.Acceptable
        if not self.specialValueText() or text != self.specialValueText():
            try:
                self.number_in(text)
            except ValueError:
                state = QValidator.State.Intermediate
        return state, text, pos

    def fixup(self, text: str) -> str:
        """Refuse what cannot be read; the number from before the typing stands again."""
        self._refuse(text)
        return self._agreed

    def wheelEvent(self, event: QWheelEvent) -> None:
        event.ignore()  # it scrolls what the field stands in

    def stepBy(self, steps: int) -> None:
        super().stepBy(steps)
        self._agree()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        enters = event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter)
        if enters and not self.hasAcceptableInput():
            self._refuse(self.text())
            event.accept()
        else:
            super().keyPressEvent(event)

    def focusInEvent(self, event: QFocusEvent) -> None:
        if self.hasAcceptableInput():
            self._agree()
        super().focusInEvent(event)

    @Slot()
    def _agree(self) -> None:
        self._agreed = self.text()

    @Slot()
    def _on_edited(self) -> None:
        self.refusal = ""
        set_look(self, "refused", None)

    def _refuse(self, text: str) -> None:
        try:
            self.number_in(text)
        except ValueError as problem:
            self.refusal = f"{problem} The field keeps {self._agreed.strip() or 'its number'}."
        set_look(self, "refused", self.hasFocus() or None)
        if self.isVisible():
            below = self.mapToGlobal(QPoint(0, self.height() // 2))
            QToolTip.showText(below, self.refusal, self, self.rect(), _REFUSAL_MS)


class WholeNumberField(NumberField):
    """A field for a whole number."""

    changed = Signal(int)  # signal like Qt's ``valueChanged``, which tells a number with decimals
    _parsed = staticmethod(typed_whole_number)
    _wanted = "a whole number. Write digits only"

    def __init__(self, **properties: Any) -> None:
        super().__init__(digits=0, **properties)
        self.valueChanged.connect(lambda value: self.changed.emit(round(value)))

    def value(self) -> int:
        return round(super().value())


def refusal_in(form: QWidget) -> str:
    """Take over what is typed in a form's fields; why one of them refuses it, told only once."""
    said = ""
    for field in form.findChildren(NumberField):
        field.interpretText()
        said, field.refusal = said or field.refusal, ""
    return said

"""Fields for numbers: both decimal signs in every locale, and nothing is guessed or rounded."""

import pytest
from PySide6.QtCore import QLocale, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QAbstractSpinBox,
    QApplication,
    QDoubleSpinBox,
    QLineEdit,
    QWidget,
)

from app.widgets.forms.form_dialog import FormDialog
from app.widgets.forms.numbers import NumberField, WholeNumberField
from app.widgets.style.building import vbox

LOCALES = ("de_DE", "C", "fr_CH")


@pytest.fixture(params=LOCALES)
def locale(request):
    """The program in the locale of a person."""
    before = QLocale()
    QLocale.setDefault(QLocale(request.param))
    yield request.param
    QLocale.setDefault(before)


@pytest.fixture
def form(shown):
    """A field of each kind beside another one; that of millimetres shows 25.00 mm."""
    holder = QWidget()
    holder.number = NumberField(digits=2, per_unit=1000.0, maximum=50_000.0, suffix=" mm")
    holder.number.show_stored(0.025)
    holder.whole = WholeNumberField(maximum=50_000, value=25, prefix="frame ")
    holder.other = QLineEdit()
    holder.setLayout(vbox(holder.number, holder.whole, holder.other))
    return shown(holder, 300, 200)


def write(field, text, pasted=False):
    field.setFocus()
    field.selectAll()
    if not text:
        QTest.keyClick(field, Qt.Key.Key_Delete)
    elif pasted or not text.isascii():
        QApplication.clipboard().setText(text)
        QTest.keyClick(field, Qt.Key.Key_V, Qt.KeyboardModifier.ControlModifier)
    else:
        QTest.keyClicks(field, text)


NUMBERS = {
    "25.5": 25.5, "25,5": 25.5, "30.00": 30.0, ",5": 0.5, "1.5 mm": 1.5, "0,125": 0.125,
    "1.500": 1.5, "1234": 1234.0, "2e3": 2000.0,
}  # fmt: skip
NO_NUMBERS = (
    "1.234,5", "1,234.5", "1 234", "1\u2019234", "1..5", "x", "60000", "-1", "nan", "5_0", "",
)  # fmt: skip
NOT_WHOLE = ("25.5", "25,5", "1.000", "1,000", "1 000", "1\u2019000", "60000", "")


@pytest.mark.parametrize("pasted", [False, True])
@pytest.mark.parametrize("tracking", [False, True])
def test_both_signs_are_the_decimal_sign(form, locale, tracking, pasted):
    form.number.setKeyboardTracking(tracking)
    for text, value in NUMBERS.items():
        write(form.number, text, pasted)
        QTest.keyClick(form.number, Qt.Key.Key_Return)
        assert (form.number.value(), form.number.stored()) == (value, value / 1000.0)
        assert form.number.refusal == ""


@pytest.mark.parametrize("tracking", [False, True])
def test_what_could_mean_two_numbers_is_refused(form, locale, tracking):
    form.number.setKeyboardTracking(tracking)
    for text in NO_NUMBERS:
        write(form.number, text)
        QTest.keyClick(form.number, Qt.Key.Key_Return)
        assert form.number.text() == f"{text} mm", "it stays to be corrected"
        assert form.number.refusal.endswith("The field keeps 25.00 mm."), text
        assert form.number.property("refused")
        form.other.setFocus()
        assert (form.number.value(), form.number.text()) == (25.0, "25.00 mm")
        assert not form.number.property("refused")


@pytest.mark.parametrize("tracking", [False, True])
def test_a_whole_number_has_no_sign_in_it(form, locale, tracking):
    form.whole.setKeyboardTracking(tracking)
    for text in NOT_WHOLE:
        write(form.whole, text)
        form.other.setFocus()
        assert (form.whole.value(), form.whole.text()) == (25, "frame 25")
        assert "The field keeps frame 25." in form.whole.refusal
    write(form.whole, "1000")
    form.other.setFocus()
    assert (form.whole.value(), form.whole.text()) == (1000, "frame 1000")
    assert form.whole.refusal == ""


@pytest.mark.parametrize("digits", [0, 2])
def test_a_stored_number_that_nobody_changes_is_kept_in_full(form, digits):
    field, stored = (
        NumberField(parent=form, digits=digits, per_unit=1000.0, maximum=1500.0),
        0.283451234567,
    )
    field.show_stored(stored)
    assert field.text() == ("283", "283.45")[digits // 2]
    field.show()
    field.setFocus()
    QTest.keyClick(field, Qt.Key.Key_Return)
    form.other.setFocus()
    assert field.stored() == stored
    write(field, "284,25")
    form.other.setFocus()
    assert (field.stored(), field.text()) == (0.28425, "284.25")


def test_a_dialog_is_not_accepted_with_a_number_that_was_refused(qtbot, shown):
    taken = []
    dialog = FormDialog("Length", "OK", lambda: taken.append(field.value()))
    qtbot.addWidget(dialog)
    field = NumberField(maximum=100.0, value=25.0)
    dialog.lay_out(field, size=(300, 100))
    dialog.show()
    write(field, "1.234,5")
    QTest.keyClick(field, Qt.Key.Key_Return)
    assert not taken
    QTest.mouseClick(dialog.accept_button, Qt.MouseButton.LeftButton)
    assert not taken
    assert "1.234,5" in dialog.words.text()
    QTest.mouseClick(dialog.accept_button, Qt.MouseButton.LeftButton)
    assert taken == [25.0], "said once"
    write(field, "26,5")
    QTest.keyClick(field, Qt.Key.Key_Return)
    assert taken == [25.0, 26.5]


@pytest.mark.window
def test_every_number_field_of_the_window_reads_both_signs(opened, qtbot, locale):
    docks, seen = opened.context.docks, set()
    for space in docks.workspaces:
        docks.show_named(space.name)
        qtbot.waitUntil(opened.context.tasks.settled)
    for field in opened.findChildren(QAbstractSpinBox):
        assert isinstance(field, NumberField), field.accessibleName()
        blocked = field.blockSignals(True)
        before, seen = field.value(), seen | {field.accessibleName()}
        whole = isinstance(field, WholeNumberField)
        for sign in ".,":
            text = f"{int(field.minimum())}{sign}5" if whole else f"{field.minimum() + 0.5}"
            field.lineEdit().setText(text if whole else text.replace(".", sign))
            field.interpretText()
            expected = before if whole else field.minimum() + 0.5
            assert field.value() == pytest.approx(expected), field.accessibleName()
            field.setValue(before)
        field.blockSignals(blocked)
    assert seen >= {"Frame", "Side of a square", "Columns of the board"}
    assert not [one for one in opened.findChildren(QDoubleSpinBox) if type(one) is QDoubleSpinBox]

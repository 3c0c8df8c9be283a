"""The wheel scrolls pages, and changes no field."""

import pytest
from PySide6.QtCore import QPoint, QPointF
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QAbstractSpinBox, QApplication, QComboBox, QLineEdit, QTabBar, QWidget

from app.widgets.forms.numbers import NumberField, WholeNumberField
from app.widgets.style.building import choice, scrolled, vbox
from tests.gui.hands import show_workspace, view

pytestmark = pytest.mark.window

FIELDS = (QAbstractSpinBox, QComboBox, QTabBar)


def turn(widget, notches=-1):
    """Turn the wheel over the middle of a widget, as the window system tells it."""
    window = widget.window()
    place = QPointF(widget.mapTo(window, widget.rect().center()))
    QTest.wheelEvent(window.windowHandle(), place, QPoint(0, 120 * notches))
    QApplication.processEvents()


def value_of(field):
    return field.value() if isinstance(field, QAbstractSpinBox) else field.currentIndex()


def fields_in(window):
    found = (one for one in window.findChildren(QWidget) if isinstance(one, FIELDS))
    return [one for one in found if one.isVisibleTo(window)]


def test_no_field_of_any_workspace_changes_under_the_wheel(opened, qtbot):
    docks, seen = opened.context.docks, set()
    for space in docks.workspaces:
        show_workspace(opened, qtbot, space.name)
        view(opened, "N").setFocus()
        for field in fields_in(opened):
            before = value_of(field)
            under = opened.childAt(field.mapTo(opened, field.rect().center()))
            if under is field or field.isAncestorOf(under):
                seen.add(type(field).__name__)
            for notches in (-1, 2, -3):
                turn(field, notches)
                assert value_of(field) == before, field.accessibleName()
        assert QApplication.focusWidget() is view(opened, "N")
    assert seen >= {"WholeNumberField", "NumberField", "Choice", "QTabBar"}


def test_the_page_scrolls_where_the_wheel_passes_a_field(shown):
    spare, combo = QLineEdit("other"), choice("Words", [(one, one) for one in "abcdef"])
    fields = [NumberField(value=5.0), WholeNumberField(value=5), combo]
    inside = QWidget()
    inside.setLayout(vbox(spare, *fields, spacing=60))
    area = scrolled(inside, "Page")
    shown(area, 220, 120)
    area.activateWindow()
    QApplication.processEvents()
    assert area.verticalScrollBar().maximum() > 40
    for field in fields:
        area.ensureWidgetVisible(field)
        spare.setFocus()
        before, at = value_of(field), area.verticalScrollBar().value()
        turn(field, 1 if at else -1)
        assert value_of(field) == before
        assert area.verticalScrollBar().value() != at
        assert QApplication.focusWidget() is spare

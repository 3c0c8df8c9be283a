"""The wheel scrolls pages, and changes no field."""

import pytest
from PySide6.QtCore import QDate, QPoint, QPointF, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QAbstractSlider,
    QAbstractSpinBox,
    QApplication,
    QComboBox,
    QDateEdit,
    QLineEdit,
    QScrollBar,
    QSlider,
    QTabBar,
    QWidget,
)

from app.services.focus import WheelGuard
from app.widgets.forms.numbers import NumberField, WholeNumberField
from app.widgets.style.building import choice, scrolled, vbox
from tests.gui.hands import view

pytestmark = pytest.mark.window

FIELDS = (QAbstractSpinBox, QComboBox, QAbstractSlider, QTabBar)


def turn(widget, notches=-1):
    """Turn the wheel over the middle of a widget, as the window system tells it."""
    window = widget.window()
    place = QPointF(widget.mapTo(window, widget.rect().center()))
    QTest.wheelEvent(window.windowHandle(), place, QPoint(0, 120 * notches))
    QApplication.processEvents()


def value_of(field):
    if isinstance(field, QComboBox | QTabBar):
        return field.currentIndex()
    return field.text() if isinstance(field, QAbstractSpinBox) else field.value()


def fields_in(window):
    found = [one for one in window.findChildren(QWidget) if isinstance(one, FIELDS)]
    return [one for one in found if not isinstance(one, QScrollBar) and one.isVisibleTo(window)]


def test_no_field_of_any_workspace_changes_under_the_wheel(opened, qtbot):
    docks, seen = opened.context.docks, set()
    for space in docks.workspaces:
        docks.show_named(space.name)
        qtbot.waitUntil(opened.context.tasks.settled)
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
    assert seen >= {"WholeNumberField", "NumberField", "QComboBox", "QTabBar"}


@pytest.fixture
def page(qtbot, shown):
    """A page that scrolls, with a field of each kind, under the rule."""
    inside = QWidget()
    tabs, combo, date = (
        QTabBar(),
        choice("Words", [(one, one) for one in "abcdef"]),
        QDateEdit(QDate(2000, 5, 15)),
    )
    slider, spare = QSlider(Qt.Orientation.Horizontal), QLineEdit("other")
    for k in range(5):
        tabs.addTab(f"tab {k}")
    inside.setLayout(vbox(spare, NumberField(value=5.0), WholeNumberField(value=5), combo, slider,
                          tabs, date, spacing=40))  # fmt: skip
    area = scrolled(inside, "Page")
    WheelGuard(area)
    shown(area, 220, 160)
    area.activateWindow()
    QApplication.processEvents()
    assert area.verticalScrollBar().maximum() > 100
    area.fields = [one for one in fields_in(inside) if one is not spare]
    area.spare = spare
    return area


def test_the_page_scrolls_where_the_wheel_passes_a_field(page):
    assert len(page.fields) == 6
    for field in page.fields:
        page.ensureWidgetVisible(field)
        page.spare.setFocus()
        before, at = value_of(field), page.verticalScrollBar().value()
        turn(field, 1 if at else -1)
        assert value_of(field) == before
        assert page.verticalScrollBar().value() != at
        assert QApplication.focusWidget() is page.spare


def test_a_window_that_is_opened_later_is_guarded_as_well(page, shown):
    field = NumberField(value=5.0)
    shown(field, 100, 30)
    field.activateWindow()
    QTest.qWaitForWindowActive(field)
    turn(field)
    assert field.value() == 5.0

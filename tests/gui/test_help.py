"""F1, Shift+F1, and the user guide: by keys and mouse."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QCursor
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QWhatsThis

from tests.gui.hands import LEFT, SHIFT

pytestmark = pytest.mark.window
NONE = Qt.KeyboardModifier.NoModifier


@pytest.fixture
def guide(opened):
    place = opened.pos()
    yield opened.help.panel
    opened.move(place)
    opened.help.panel.close()
    QWhatsThis.leaveWhatsThisMode()


def rest_on(widget):
    """Let the mouse rest on a widget, wherever the screen without a screen ends."""
    window = widget.window()
    window.move(QPoint(300, 300) - widget.mapTo(window, widget.rect().center()))
    QApplication.processEvents()
    QCursor.setPos(widget.mapToGlobal(widget.rect().center()))


def test_f1_opens_the_page_of_the_panel_under_the_cursor(opened, guide):
    docks = opened.context.docks
    for widget, address, heading in (
        (docks.timeline, "window.md#timeline", "Timeline"),
        (docks.scene, "window.md#3-d-scene", "3-D scene"),
        (docks.views.tiles["S"].camera, "window.md#views", "Views"),
    ):
        guide.close()
        rest_on(widget)
        QTest.keyClick(opened, Qt.Key.Key_F1)
        assert guide.isVisible()
        assert (guide.page.address(), guide.page.heading_at_top()) == (address, heading)
    QTest.keyClick(guide, Qt.Key.Key_Escape)
    assert not guide.isVisible()


def test_f1_goes_by_the_focus_where_the_cursor_is_on_nothing(opened, guide, qtbot):
    rest_on(opened.menuBar())
    opened.context.docks.bring_up("parameters")
    search = opened.features.tune.parameters.search
    search.setFocus()
    qtbot.waitUntil(search.hasFocus)
    QTest.keyClick(search, Qt.Key.Key_F1)
    assert guide.page.heading_at_top() == "Run a trial"
    opened.context.docks.views.active_camera().setFocus()


def test_every_panel_is_explained(opened):
    docks = opened.context.docks
    for name, title in docks.titles().items():
        assert docks.dock(name).whatsThis().endswith("."), title


def test_the_contents_lead_to_pages_and_back(opened, guide):
    QTest.keyClick(opened, Qt.Key.Key_F1, Qt.KeyboardModifier.ControlModifier)
    assert guide.page.address() == "index.md"
    guide.open("annotating.md#quality-check")
    assert guide.page.heading_at_top() == "Quality check"
    QTest.mouseClick(guide.back, LEFT)
    assert guide.page.address() == "index.md"


def test_pictures_are_as_wide_as_the_page_at_most(guide, opened):
    opened.help._show("window.md")
    look = next(
        block.begin().fragment().charFormat().toImageFormat()
        for block in guide.page._blocks()
        if block.length() > 1 and block.begin().fragment().charFormat().isImageFormat()
    )
    assert 200 < look.width() <= guide.page.viewport().width()


def explained():
    shown = [w for w in QApplication.topLevelWidgets() if w.isVisible()]
    return [w for w in shown if w.metaObject().className() == "QWhatsThat"]


def test_a_control_that_is_clicked_is_explained_and_not_pressed(opened, guide, qtbot):
    run = opened.bars.track.widgetForAction(opened.context.actions.action("run"))
    spin = opened.context.docks.transport.number  # has a tooltip alone
    for widget in (run, spin, opened.context.docks.timeline):
        opened.activateWindow()
        qtbot.waitUntil(opened.isActiveWindow)
        QTest.keyClick(opened, Qt.Key.Key_F1, SHIFT)
        assert QWhatsThis.inWhatsThisMode()
        QTest.mouseClick(widget, LEFT, NONE, widget.rect().center())
        assert not QWhatsThis.inWhatsThisMode()
        assert len(explained()) == 1
        assert not opened.context.session.track.running
        QWhatsThis.hideText()
        QApplication.processEvents()

"""F1, and the user guide: by keys and mouse."""

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QCursor
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from app.session.messages import Message
from tests.gui.hands import LEFT

pytestmark = pytest.mark.window


@pytest.fixture
def guide(opened):
    place = opened.pos()
    yield opened.help
    opened.move(place)
    opened.help.close()


def rest_on(widget):
    """Let the mouse rest on a widget, wherever the screen without a screen ends."""
    window = widget.window()
    window.move(QPoint(300, 300) - widget.mapTo(window, widget.rect().center()))
    QApplication.processEvents()
    QCursor.setPos(widget.mapToGlobal(widget.rect().center()))


def address(guide):
    return "#".join(filter(None, (guide.page.source().fileName(), guide.page.source().fragment())))


def test_f1_opens_the_page_of_the_panel_under_the_cursor(opened, guide):
    docks = opened.context.docks
    for widget, page in (
        (docks.timeline, "window.md#timeline"),
        (docks.scene, "window.md#3-d-scene"),
        (docks.views.tiles["S"].camera, "window.md#views"),
    ):
        guide.close()
        rest_on(widget)
        QTest.keyClick(opened, Qt.Key.Key_F1)
        assert guide.isVisible()
        assert address(guide) == page
    opened.context.notifier.show(Message("note", "the message that Esc would close in the window"))
    QTest.keyClick(guide.page, Qt.Key.Key_Escape)
    assert not guide.isVisible()
    assert opened.messages.isVisible()
    QTest.keyClick(opened, Qt.Key.Key_Escape)


def test_f1_goes_by_the_focus_where_the_cursor_is_on_nothing(opened, guide, qtbot):
    rest_on(opened.menuBar())
    opened.context.docks.bring_up("parameters")
    search = opened.features.tune.parameters.search
    search.setFocus()
    qtbot.waitUntil(search.hasFocus)
    QTest.keyClick(search, Qt.Key.Key_F1)
    assert address(guide) == "tuning.md#run-a-trial"
    opened.context.docks.views.active_camera().setFocus()


def test_every_panel_is_explained(opened):
    docks = opened.context.docks
    for name, title in docks.titles().items():
        assert docks.dock(name).property("help_page"), title


def test_the_contents_lead_to_pages_and_back(opened, guide):
    QTest.keyClick(opened, Qt.Key.Key_F1, Qt.KeyboardModifier.ControlModifier)
    assert address(guide) == "index.md"
    guide.open("annotating.md#quality-check")
    assert address(guide) == "annotating.md#quality-check"
    QTest.mouseClick(guide.back, LEFT)
    assert address(guide) == "index.md"

"""F1, Shift+F1, the user guide with its search, and the tour: by keys and mouse."""

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
    opened.tour.end()
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


def test_every_panel_is_explained_and_leads_to_a_section(opened):
    docks = opened.context.docks
    for name, title in docks.titles().items():
        assert docks.dock(name).whatsThis().endswith("."), title
    known = {section.address for section in opened.help._guide.sections}
    parts = opened.help._guide.parts
    assert {part.address for part in parts.values() if "#" in part.address} <= known


def test_words_are_found_in_all_pages(opened, guide, qtbot):
    QTest.keyClick(opened, Qt.Key.Key_F1, Qt.KeyboardModifier.ControlModifier)
    assert guide.page.address() == "index.md"
    qtbot.keyClicks(guide.search, "blind repeat sched")
    assert guide.hits.currentItem().text().startswith("Annotating › Quality check")
    QTest.keyClick(guide.search, Qt.Key.Key_Return)
    assert guide.page.address() == "annotating.md#quality-check"
    assert guide.stack.currentWidget() is guide.page
    QTest.mouseClick(guide.back, LEFT)
    assert guide.page.address() == "index.md"
    qtbot.keyClicks(guide.search, "zyxw")
    assert guide.stack.currentWidget() not in (guide.page, guide.hits)


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


def test_the_tour_points_at_the_real_widgets_and_ends_at_any_time(opened, guide, qtbot):
    tour, docks = opened.tour, opened.context.docks
    opened.context.actions.action("tour").trigger()
    qtbot.waitUntil(lambda: tour.card is not None and tour.card.isVisible())
    titles, around = [], []
    for _ in range(5):
        titles.append(tour.card.title.text())
        around.append(tour.ring.geometry().center())
        assert opened.rect().contains(tour.card.geometry())
        assert tour.card.place.text() == f"{len(titles)} of 5"
        QTest.keyClick(tour.card, Qt.Key.Key_Right)
    assert titles == ["Views", "Timeline", "Tracker", "Workspaces", "Commands and help"]
    for at, widget in zip(around, (docks.views, docks.timeline), strict=False):
        assert widget.rect().contains(widget.mapFrom(opened, at))
    assert tour.card is None, "the last step ends it"
    frame = opened.context.session.document.frame
    for end in (
        lambda: QTest.keyClick(tour.card, Qt.Key.Key_Escape),
        lambda: QTest.mouseClick(tour.card.leave, LEFT),
    ):
        tour.start()
        qtbot.waitUntil(lambda: tour.card is not None and tour.card.isVisible())
        end()
        assert tour.card is None
    assert opened.context.session.document.frame == frame


def test_the_tour_is_offered_on_the_very_first_start_alone(window, small_recording, qtbot):
    window.tour.offer()
    assert window.messages.message.button == "Start tour"
    window.context.session.opening.open(small_recording)
    qtbot.waitUntil(lambda: window.context.session.document.frame_set is not None)
    qtbot.waitUntil(lambda: window.messages.message is not None)
    assert window.messages.message.button == "Start tour", "opening does not take it away"
    QTest.mouseClick(window.messages.do_button, LEFT)
    qtbot.waitUntil(lambda: window.tour.card is not None and window.tour.card.isVisible())
    window.tour.end()
    window.tour.offer()
    assert window.messages.message is None or window.messages.message.button != "Start tour"
    window.context.settings.remove("tour_offered")
    window.context.settings.setValue("geometry", window.saveGeometry())
    window.tour.offer()
    assert not window.context.settings.contains("tour_offered"), "this window was there before"

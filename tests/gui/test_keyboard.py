"""Everything can be reached by keys, has a name for who cannot see it, and hidden pages wait."""

import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QAccessible
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractItemView,
    QAbstractSlider,
    QAbstractSpinBox,
    QApplication,
    QComboBox,
    QDockWidget,
    QHeaderView,
    QLabel,
    QLineEdit,
    QPlainTextEdit,
    QScrollBar,
    QTabBar,
    QTextEdit,
    QToolBar,
    QWidget,
)

from tests.gui.hands import CTRL, NONE, show_workspace, view

pytestmark = pytest.mark.window

CONTROLS = (
    *(QAbstractButton, QLineEdit, QComboBox, QAbstractSpinBox, QAbstractSlider, QTabBar),
    *(QAbstractItemView, QTextEdit, QPlainTextEdit),
)
PARTS = (QScrollBar, QHeaderView)
"""Parts of controls that have no name of their own."""


def is_part(widget):
    """Whether Qt has made it inside a control: the field of a spin box, the list of a choice."""
    parents = [widget.parentWidget()]
    while parents[-1] is not None:
        parents.append(parents[-1].parentWidget())
    inside = (QComboBox, QAbstractSpinBox, QLineEdit, QAbstractItemView)
    return (
        isinstance(widget, PARTS)
        or widget.objectName().startswith("qt_")
        or any(isinstance(parent, inside) for parent in parents)
    )


def is_control(widget):
    if is_part(widget) or (isinstance(widget, QLabel) and not widget.text()):
        return False
    if isinstance(widget, QTabBar) and not widget.count():
        return False
    takes_keys = widget.focusPolicy() & Qt.FocusPolicy.TabFocus == Qt.FocusPolicy.TabFocus
    return isinstance(widget, CONTROLS) or takes_keys


def name_of(widget):
    interface = QAccessible.queryAccessibleInterface(widget)
    return interface.text(QAccessible.Text.Name) if interface is not None else ""


def way_to(widget):
    names = []
    while widget is not None:
        names.append(type(widget).__name__)
        widget = widget.parentWidget()
    return " in ".join(names)


def test_every_control_of_every_workspace_has_a_name(opened, qtbot):
    docks, seen, nameless = opened.context.docks, set(), set()
    for space in docks.workspaces:
        docks.show_named(space.name)
        for panel in docks.titles():
            if docks.is_shown(panel):
                docks.bring_up(panel)
        qtbot.waitUntil(opened.context.tasks.settled)
        controls = [widget for widget in opened.findChildren(QWidget) if is_control(widget)]
        there = [widget for widget in controls if widget.isVisibleTo(opened)]
        seen |= set(there)
        nameless |= {way_to(widget) for widget in there if not name_of(widget)}
    assert len(seen) > 150
    assert not nameless, "\n".join(sorted(nameless))


def walked(window, keys=Qt.Key.Key_Tab):
    """All controls that a key leads to, until they come round again."""
    first = QApplication.focusWidget()
    found = []
    while len(found) < 500:
        QTest.keyClick(QApplication.focusWidget(), keys)
        now = QApplication.focusWidget()
        if now is first or now in found:
            break
        found.append(now)
    return [*found, first]


def test_tab_reaches_views_and_toolbars_and_nothing_that_is_hidden(opened, qtbot):
    docks = opened.context.docks
    show_workspace(opened, qtbot, "review")
    view(opened, "N").setFocus()
    reached = walked(opened)
    assert view(opened, "S") in reached
    run = opened.bars.track.widgetForAction(opened.context.actions.action("run"))
    assert run in reached
    bars = {
        bar for widget in reached for bar in [widget.parentWidget()] if isinstance(bar, QToolBar)
    }
    assert bars >= {opened.bars.workspaces, opened.bars.play, opened.bars.track, opened.bars.view}
    for widget in reached:
        holders = [one for one in opened.findChildren(QDockWidget) if one.isAncestorOf(widget)]
        assert all(docks.is_seen(holder.objectName()) for holder in holders), way_to(widget)
    view(opened, "N").setFocus()
    back = walked(opened, Qt.Key.Key_Backtab)
    assert set(back) == set(reached), "the same way back"


def test_tab_goes_from_the_search_of_parameters_to_what_it_found(opened, qtbot):
    """Not through all toolbars first: the lines are made after the rest of the window."""
    show_workspace(opened, qtbot, "tune")
    QTest.keyClick(opened, Qt.Key.Key_F, Qt.KeyboardModifier.ControlModifier)
    QTest.keyClicks(QApplication.focusWidget(), "arms apart")
    for _ in range(2):  # the list that scrolls stands between
        QTest.keyClick(QApplication.focusWidget(), Qt.Key.Key_Tab)
    assert QApplication.focusWidget().accessibleName().startswith("arms apart")


def test_f6_walks_the_views_and_the_panels_that_are_seen(opened, qtbot):
    docks = opened.context.docks
    show_workspace(opened, qtbot, "review")
    view(opened, "N").setFocus()

    def where():
        focus = QApplication.focusWidget()
        holders = [one for one in opened.findChildren(QDockWidget) if one.isAncestorOf(focus)]
        return holders[0].objectName() if holders else "views"

    visited = [where()]
    for _ in range(12):
        QTest.keyClick(opened, Qt.Key.Key_F6)
        if where() == visited[0]:
            break
        visited.append(where())
    assert where() == "views", "round and round"
    assert {"scene", "failures", "timeline"} <= set(visited)
    assert all(docks.is_seen(name) for name in visited if name != "views")
    QTest.keyClick(opened, Qt.Key.Key_F6, Qt.KeyboardModifier.ShiftModifier)
    assert where() == visited[-1]
    QTest.keyClick(opened, Qt.Key.Key_F6)
    QTest.keyClick(opened, Qt.Key.Key_Tab)
    assert opened.context.view_state.active_view == "S", "keys act on the view that has them"


def test_space_presses_the_button_that_keys_have_gone_to_and_else_plays(opened, qtbot):
    opened.context.docks.show_named("annotate")
    depth = opened.features.annotate.clicking.body.with_depth
    was, document = depth.isChecked(), opened.context.session.document
    view(opened, "N").setFocus()
    while QApplication.focusWidget() is not depth:
        QTest.keyClick(QApplication.focusWidget(), Qt.Key.Key_Tab)
    QTest.keyClick(depth, Qt.Key.Key_Space)
    assert depth.isChecked() != was
    assert not document.playing
    opened.context.docks.timeline.setFocus(Qt.FocusReason.MouseFocusReason)
    QTest.keyClick(opened, Qt.Key.Key_Space)
    assert document.playing
    document.pause()


def test_no_button_has_the_focus_that_nobody_went_to(newly_opened, qtbot):
    docks, document = newly_opened.context.docks, newly_opened.context.session.document
    assert not isinstance(QApplication.focusWidget(), QAbstractButton)
    QTest.keyClick(newly_opened.windowHandle(), Qt.Key.Key_Space)
    assert document.playing, "the space bar plays, and opens no workspace"
    document.pause()
    docks.show_named("annotate")
    newly_opened.features.annotate.clicking.body.with_depth.setFocus()
    docks.show_named("review")
    assert QApplication.focusWidget() is view(newly_opened, "N"), "the panel is hidden"


def test_single_keys_mean_the_same_while_the_scene_has_the_focus(opened, qtbot):
    opened.context.docks.show_named("review")
    scene, document = opened.context.docks.scene, opened.context.session.document
    document.go_to(5)
    scene.setFocus()
    overlays, orbit = opened.context.view_state.display.overlays, scene.orbit
    QTest.keyClick(scene, Qt.Key.Key_R)
    QTest.keyClick(scene, Qt.Key.Key_S)
    assert opened.context.view_state.display.overlays == overlays ^ {"reference", "shading"}
    QTest.keyClick(scene, Qt.Key.Key_Home)
    assert document.frame == 0
    assert scene.orbit == orbit
    QTest.keyClick(scene, Qt.Key.Key_4, CTRL | Qt.KeyboardModifier.AltModifier)
    assert scene.orbit.toward_eye[2] == pytest.approx(1.0), "seen from above"
    qtbot.waitUntil(opened.context.tasks.settled)


def test_the_keys_of_a_command_that_cannot_be_done_say_why(opened, qtbot):
    docks, said = opened.context.docks, opened.statusBar().currentMessage
    show_workspace(opened, qtbot, "review")
    assert not opened.context.actions.action("next_failure").isEnabled()
    view(opened, "N").setFocus()
    QTest.keyClick(view(opened, "N"), Qt.Key.Key_N, Qt.KeyboardModifier.ShiftModifier)
    assert said().startswith("Next failure: unavailable. There is no run yet.")
    opened.statusBar().clearMessage()
    docks.bring_up("parameters")
    opened.features.tune.search_parameters()
    QTest.keyClick(opened.features.tune.parameters.search, Qt.Key.Key_N, NONE)
    assert (opened.features.tune.parameters.search.text(), said()) == ("n", "")
    opened.features.tune.parameters.search.clear()

"""Where keys go: Tab walks through controls, F6 through panels."""

from collections.abc import Mapping

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QAbstractButton, QDockWidget, QMainWindow, QWidget

from ..widgets.camera.camera_grid import CameraGrid

_TAB = Qt.FocusPolicy.TabFocus


def is_in_front(dock: QDockWidget) -> bool:
    """Whether a panel that is there is seen: Qt puts those behind it aside, and calls all visible.

    Neither does the visible region tell it: that of a panel full of opaque widgets is empty.
    """
    return dock.isFloating() or dock.geometry().right() >= 0


class FocusWalk(QObject):
    """Gives the focus to what comes next.

    Panels behind others are visible to Qt, whose own walk would go through all that nobody sees.
    """

    def __init__(
        self, window: QMainWindow, views: CameraGrid, docks: Mapping[str, QDockWidget]
    ) -> None:
        super().__init__(window)
        self._window, self._views, self._docks = window, views, docks

    def step(self, forward: bool) -> bool:
        """Go to the next or previous control; False where there is none."""
        start = self._window.focusWidget()
        if start is None or not (start.isVisible() and start.isEnabled()):
            # nobody pressed Tab: Qt asks when the window opens, or what had the focus is hidden
            view = self._views.active_camera()
            (view if view is not None and view.isVisible() else self._window).setFocus()
            return True
        reasons = Qt.FocusReason
        reason = reasons.TabFocusReason if forward else reasons.BacktabFocusReason

        def after(widget: QWidget) -> QWidget:
            following = widget.nextInFocusChain() if forward else widget.previousInFocusChain()
            return following or start

        each = after(start)
        while each is not start and not self._takes_tab(each):
            each = after(each)
        if each is not start:
            self._give(each, reason)
        return each is not start

    def walk(self, by: int) -> None:
        """Go to the next (1) or previous (-1) panel; the views are one of them."""
        seen = [dock for dock in self._docks.values() if dock.isVisible() and is_in_front(dock)]
        stops: list[QWidget] = sorted(seen, key=lambda dock: (dock.y(), dock.x()))
        if self._views.active_camera() is not None and self._views.isVisible():
            stops.insert(0, self._views)
        now = self._window.focusWidget()
        place = next((k for k, stop in enumerate(stops) if _holds(stop, now)), -1 if by > 0 else 0)
        onward = (stops[(place + k * by) % len(stops)] for k in range(1, len(stops) + 1))
        if inside := next(filter(None, map(self._first_in, onward)), None):
            self._give(inside, Qt.FocusReason.ShortcutFocusReason)

    def eventFilter(self, button: QObject, event: QEvent) -> bool:
        """The space bar presses the button that somebody has gone to by keys."""
        space = isinstance(event, QKeyEvent) and event.key() == Qt.Key.Key_Space
        if space and event.type() == QEvent.Type.ShortcutOverride:
            event.accept()
            return True
        if event.type() == QEvent.Type.FocusOut:
            button.removeEventFilter(self)
        return False

    def _give(self, widget: QWidget, reason: Qt.FocusReason) -> None:
        widget.setFocus(reason)
        if isinstance(widget, QAbstractButton):
            widget.installEventFilter(self)

    def _first_in(self, stop: QWidget) -> QWidget | None:
        if stop is self._views:
            return self._views.active_camera()
        return next((each for each in stop.findChildren(QWidget) if self._takes_tab(each)), None)

    def _takes_tab(self, widget: QWidget) -> bool:
        if widget.focusPolicy() & _TAB != _TAB or widget.focusProxy() is not None:
            return False
        if not (widget.isVisible() and widget.isEnabled() and widget.window() is self._window):
            return False
        return all(is_in_front(dock) for dock in self._docks.values() if _holds(dock, widget))


def _holds(place: QWidget, widget: QWidget | None) -> bool:
    return widget is not None and (place is widget or place.isAncestorOf(widget))

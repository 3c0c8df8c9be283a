"""One rule for the mouse wheel: it scrolls the page and does not change fields on its way."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject, Qt, QTimer
from PySide6.QtGui import QFocusEvent, QKeyEvent
from PySide6.QtWidgets import (
    QAbstractSlider,
    QAbstractSpinBox,
    QApplication,
    QComboBox,
    QScrollBar,
    QTabBar,
    QWidget,
)

_FIELDS = (QAbstractSpinBox, QComboBox, QAbstractSlider, QTabBar)
_KIND = QEvent.Type
_EVENTS = (_KIND.Wheel, _KIND.FocusIn, _KIND.FocusOut, _KIND.Polish)
_PRESSES = (_KIND.KeyPress, _KIND.KeyRelease, _KIND.MouseButtonPress)
_TABS = (Qt.Key.Key_Tab, Qt.Key.Key_Backtab)


class WheelGuard(QObject):
    """Lets the wheel change a field only if a person has clicked it, or gone to it by keys.

    It filters the events of the whole application, so that no dialog and no field that Qt makes
    itself is forgotten. It begins when the window is made, since that takes many events.
    """

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self._window = window
        self._entered: QObject | None = None
        self._tabbing = False
        QTimer.singleShot(0, self, self._begin)

    def _begin(self) -> None:
        app = QApplication.instance()
        if app is not None:
            app.installEventFilter(self)
        for kind in (QAbstractSpinBox, QComboBox):
            for field in self._window.findChildren(kind):
                _take_no_focus_by_wheel(field)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        kind = event.type()
        if kind in _PRESSES:
            key = event.key() if isinstance(event, QKeyEvent) else None
            self._tabbing = kind == _KIND.KeyPress and key in _TABS
        if kind not in _EVENTS or not isinstance(watched, _FIELDS):
            return False
        if kind == _KIND.Wheel:
            if watched is self._entered or isinstance(watched, QScrollBar):
                return False
            event.ignore()  # so that Qt hands it to what the field stands in
            return True
        if kind == _KIND.Polish:
            _take_no_focus_by_wheel(watched)
        elif isinstance(event, QFocusEvent):
            self._follow(watched, event)
        return False

    def _follow(self, field: QObject, event: QFocusEvent) -> None:
        """Remember which field a person is in; choosing from a list that pops up leaves it.

        A dialog gives the focus to its first field as if by Tab, so the key counts as well.
        """
        reason, reasons = event.reason(), Qt.FocusReason
        if not event.gotFocus():
            if reason != reasons.ActiveWindowFocusReason:
                self._entered = None
        elif (
            (reason == reasons.MouseFocusReason and QApplication.mouseButtons().value)
            or reason == reasons.ShortcutFocusReason
            or self._tabbing
        ):
            self._entered = field


def _take_no_focus_by_wheel(field: QWidget) -> None:
    if field.focusPolicy() == Qt.FocusPolicy.WheelFocus:
        field.setFocusPolicy(Qt.FocusPolicy.StrongFocus)

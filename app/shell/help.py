"""The user guide in the window: the page of a panel, and words on a single control."""

from __future__ import annotations

from collections.abc import Mapping

from PySide6.QtCore import QEvent, QObject, QPoint
from PySide6.QtGui import QCursor, QHelpEvent
from PySide6.QtWidgets import QApplication, QMainWindow, QWhatsThis, QWidget

from ..context import Context
from ..services.guide import CONTENTS, anchor_of, parts_of
from ..widgets.forms.help_panel import HelpPanel
from ..widgets.style.icons import data_folder

_PAGE = "help_page"
_WIDTH = 520
_ASKING = (QEvent.Type.WhatsThis, QEvent.Type.QueryWhatsThis)


class Help(QObject):
    """Opens the user guide where it explains what the person is looking at."""

    def __init__(self, window: QMainWindow, context: Context) -> None:
        super().__init__(window)
        self._window, self._docks = window, context.docks
        self.panel = HelpPanel(data_folder("docs"), CONTENTS, anchor_of, window)

    def explain(self, others: Mapping[str, QWidget]) -> None:
        """Let every panel, and other parts of the window by name, say what the guide says."""
        docks, parts = self._docks, parts_of(data_folder("docs"))
        titled = {title: docks.dock(name) for name, title in docks.titles().items()}
        for title, widget in {**titled, **others}.items():
            widget.setProperty(_PAGE, parts[title].address)
            widget.setWhatsThis(parts[title].about)

    def show_contents(self) -> None:
        """Open the guide at its contents."""
        self._show(CONTENTS)

    def show_for_panel(self) -> None:
        """Open the page of the panel under the cursor, or of the one with the focus."""
        under = _page_of(QApplication.widgetAt(QCursor.pos()))
        self._show(under or _page_of(self._window.focusWidget()) or CONTENTS)

    def explain_control(self) -> None:
        """Let the person click a control, and say what it is for."""
        app = QApplication.instance()
        if app is not None:
            app.installEventFilter(self)
            QWhatsThis.enterWhatsThisMode()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """While a control is chosen: one that has only a tooltip is explained by that."""
        if event.type() == QEvent.Type.LeaveWhatsThisMode:
            QApplication.instance().removeEventFilter(self)  # type: ignore[union-attr]
        if event.type() not in _ASKING or not isinstance(watched, QWidget):
            return False
        tip = watched.toolTip()
        if watched.whatsThis() or not tip:
            return False
        if event.type() == QEvent.Type.WhatsThis and isinstance(event, QHelpEvent):
            QWhatsThis.showText(QPoint(event.globalX(), event.globalY()), tip, watched)
        event.accept()
        return True

    def _show(self, address: str) -> None:
        if self.panel.isHidden():
            inside = self._window.geometry()
            self.panel.resize(min(_WIDTH, inside.width() // 2), round(0.8 * inside.height()))
            self.panel.move(inside.right() - self.panel.width() - 24, inside.top() + 80)
        self.panel.show()
        self.panel.open(address)
        self.panel.raise_()
        self.panel.activateWindow()


def _page_of(widget: QWidget | None) -> str:
    """Where the guide explains a widget, or what it stands in; empty where nowhere."""
    while widget is not None:
        page = widget.property(_PAGE)
        if page:
            return str(page)
        widget = widget.parentWidget()
    return ""

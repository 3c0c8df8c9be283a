"""The user guide in the window: its contents, and the page of a panel."""

import re
from collections.abc import Iterator, Mapping

from PySide6 import QtGui
from PySide6.QtCore import QEvent, Qt, QUrl
from PySide6.QtWidgets import QApplication, QFrame, QMainWindow, QTextBrowser, QWidget

from ..context import Context
from ..widgets.redraw import takes_key
from ..widgets.style.building import hbox, tool_button, vbox
from ..widgets.style.theme import current_theme, data_folder

_PAGE = "help_page"
_WIDTH = 520
_MARGIN, _ABOVE = 14, 4

CONTENTS = "index.md"
WINDOW = "window.md"
"""The page whose table names the parts of the window, each with a link and a sentence or two."""
_PART = re.compile(r"^\| \[([^\]]+)\]\(([^)]+)\) \| .+? \|$", re.MULTILINE)
_MARKUP = re.compile(r"!?\[([^\]]*)\]\([^)]*\)|[*`|]")


def anchor_of(heading: str) -> str:
    """What links call a heading: lower case, hyphens for spaces, no other signs."""
    plain = _MARKUP.sub(lambda found: found.group(1) or "", heading)
    return re.sub(r"[^\w\- ]", "", plain.lower()).strip().replace(" ", "-")


class Page(QTextBrowser):
    """One page in Markdown; links lead to headings of it and of other pages."""

    def __init__(self) -> None:
        super().__init__()
        self._folder = data_folder("docs")
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setOpenExternalLinks(True)
        self.setAccessibleName("Page of the user guide")
        self.document().setDocumentMargin(_MARGIN)

    def open(self, address: str) -> None:
        page, _, anchor = address.partition("#")
        url = QUrl.fromLocalFile(str(self._folder / page))
        if anchor:
            url.setFragment(anchor)
        self.setSource(url)

    def doSetSource(
        self,
        name: QUrl | str,
        type: QtGui.QTextDocument.ResourceType = QtGui.QTextDocument.ResourceType.UnknownResource,  # noqa: A002
    ) -> None:
        super().doSetSource(name, type)
        self._dress()
        headings = (block for block in self._blocks() if block.blockFormat().headingLevel())
        anchor = QUrl(name).fragment()
        if at := next((one for one in headings if anchor_of(one.text()) == anchor), None):
            top = self.document().documentLayout().blockBoundingRect(at).top()
            self.verticalScrollBar().setValue(round(top) - _ABOVE)

    def _blocks(self) -> Iterator[QtGui.QTextBlock]:
        block = self.document().begin()
        while block.isValid():
            yield block
            block = block.next()

    def _dress(self) -> None:
        """Give tables lines and code a ground, which Markdown says nothing about."""
        theme = current_theme()
        for frame in self.document().rootFrame().childFrames():
            if isinstance(frame, QtGui.QTextTable):
                grid = frame.format()
                grid.setBorder(1)
                grid.setBorderBrush(QtGui.QColor(theme.border))
                grid.setBorderStyle(QtGui.QTextFrameFormat.BorderStyle.BorderStyle_Solid)
                grid.setBorderCollapse(True)
                grid.setCellPadding(4)
                grid.setCellSpacing(0)
                grid.setWidth(QtGui.QTextLength(QtGui.QTextLength.Type.PercentageLength, 100))
                frame.setFormat(grid)
        for block in self._blocks():
            look = block.blockFormat()
            if look.hasProperty(QtGui.QTextFormat.Property.BlockCodeFence):
                look.setBackground(QtGui.QColor(theme.raised))
                QtGui.QTextCursor(block).setBlockFormat(look)

    def loadResource(self, kind: int, name: QUrl | str) -> object:
        """Pictures are as wide as the page at most."""
        if kind != QtGui.QTextDocument.ResourceType.ImageResource.value:
            return super().loadResource(kind, name)
        picture = QtGui.QImage(str(self._folder / QUrl(name).fileName()))
        ratio = self.devicePixelRatioF()
        room = self.viewport().width() - 2 * _MARGIN - 2
        if picture.width() > room > 0:
            smooth = Qt.TransformationMode.SmoothTransformation
            picture = picture.scaledToWidth(round(room * ratio), smooth)
            picture.setDevicePixelRatio(ratio)
        return picture


class Help(QWidget):
    """A window with the user guide, opened where it explains what the person is looking at."""

    def __init__(self, window: QMainWindow, context: Context) -> None:
        super().__init__(window, Qt.WindowType.Tool)  # so that workspaces leave it alone
        self._window, self._docks = window, context.docks
        self.setWindowTitle("User guide")
        self.page = Page()
        self.back = tool_button("Previous page", "previous", do=self.page.backward)
        self.forward = tool_button("Next page", "next", do=self.page.forward)
        contents = tool_button("Contents of the user guide", "help", do=self.open)
        buttons = hbox(contents, self.back, self.forward, None)
        self.setLayout(vbox(buttons, (self.page, 1), margins=(4, 4, 0, 0)))
        for button in (self.back, self.forward):
            button.setEnabled(False)
        self.page.backwardAvailable.connect(self.back.setEnabled)
        self.page.forwardAvailable.connect(self.forward.setEnabled)

    def explain(self, others: Mapping[str, QWidget]) -> None:
        """Let every panel, and other parts of the window by name, know their page of the guide."""
        parts = _PART.findall((data_folder("docs") / WINDOW).read_text(encoding="utf-8"))
        pages = {title: WINDOW + at if at.startswith("#") else at for title, at in parts}
        docks = self._docks
        titled = {title: docks.dock(name) for name, title in docks.titles().items()}
        for title, widget in {**titled, **others}.items():
            widget.setProperty(_PAGE, pages[title])

    def show_for_panel(self) -> None:
        """Open the page of the panel under the cursor, or of the one with the focus."""
        under = _page_of(QApplication.widgetAt(QtGui.QCursor.pos()))
        self.open(under or _page_of(self._window.focusWidget()) or CONTENTS)

    def open(self, address: str = CONTENTS) -> None:
        """Show a page at a heading, such as ``tuning.md#undo``."""
        if self.isHidden():
            inside = self._window.geometry()
            self.resize(min(_WIDTH, inside.width() // 2), round(0.8 * inside.height()))
            self.move(inside.right() - self.width() - 24, inside.top() + 80)
        self.show()
        self.page.open(address)
        self.raise_()
        self.activateWindow()

    def event(self, event: QEvent) -> bool:
        # without this the main window, whose tool this is, would take it for a message
        escape = takes_key(event, lambda key: key.key() == Qt.Key.Key_Escape)
        return escape or super().event(event)

    def keyPressEvent(self, event: QtGui.QKeyEvent) -> None:
        if event.key() == Qt.Key.Key_Escape:
            self.close()
        else:
            super().keyPressEvent(event)


def _page_of(widget: QWidget | None) -> str:
    while widget is not None and not widget.property(_PAGE):
        widget = widget.parentWidget()
    return str(widget.property(_PAGE)) if widget is not None else ""

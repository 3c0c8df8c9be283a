"""A window with the pages of the user guide."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import Qt, QUrl
from PySide6.QtGui import (
    QColor,
    QImage,
    QKeyEvent,
    QTextBlock,
    QTextCursor,
    QTextDocument,
    QTextFormat,
    QTextFrameFormat,
    QTextLength,
    QTextTable,
)
from PySide6.QtWidgets import (
    QFrame,
    QTextBrowser,
    QWidget,
)

from ..style.building import hbox, tool_button, vbox
from ..style.theme import current_theme

_MARGIN, _ABOVE = 14, 4


class Page(QTextBrowser):
    """One page in Markdown; links lead to headings of it and of other pages.

    `anchor_of` says what links call a heading.
    """

    def __init__(self, folder: Path, anchor_of: Callable[[str], str]) -> None:
        super().__init__()
        self._folder, self._anchor_of = folder, anchor_of
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setOpenExternalLinks(True)
        self.setAccessibleName("Page of the user guide")
        self.document().setDocumentMargin(_MARGIN)

    def open(self, address: str) -> None:
        """Show a page, at one of its headings where the address has one."""
        page, _, anchor = address.partition("#")
        url = QUrl.fromLocalFile(str(self._folder / page))
        if anchor:
            url.setFragment(anchor)
        self.setSource(url)

    def address(self) -> str:
        """What is shown, as links name it."""
        url = self.source()
        return f"{url.fileName()}{'#' if url.hasFragment() else ''}{url.fragment()}"

    def heading_at_top(self) -> str:
        """The heading that the page was opened at; its title where it was at none."""
        block = self._heading(self.source().fragment())
        return (block or self.document().firstBlock()).text()

    def doSetSource(
        self,
        name: QUrl | str,
        type: QTextDocument.ResourceType = QTextDocument.ResourceType.UnknownResource,  # noqa: A002
    ) -> None:
        super().doSetSource(name, type)
        self._dress()
        block = self._heading(QUrl(name).fragment())
        if block is not None:
            top = self.document().documentLayout().blockBoundingRect(block).top()
            self.verticalScrollBar().setValue(round(top) - _ABOVE)

    def _blocks(self) -> list[QTextBlock]:
        block, found = self.document().begin(), []
        while block.isValid():
            found.append(block)
            block = block.next()
        return found

    def _heading(self, anchor: str) -> QTextBlock | None:
        headings = (block for block in self._blocks() if block.blockFormat().headingLevel())
        return next((one for one in headings if self._anchor_of(one.text()) == anchor), None)

    def _dress(self) -> None:
        """Give tables lines and code a ground, which Markdown says nothing about."""
        theme = current_theme()
        for frame in self.document().rootFrame().childFrames():
            if isinstance(frame, QTextTable):
                grid = frame.format()
                grid.setBorder(1)
                grid.setBorderBrush(QColor(theme.border))
                grid.setBorderStyle(QTextFrameFormat.BorderStyle.BorderStyle_Solid)
                grid.setBorderCollapse(True)
                grid.setCellPadding(4)
                grid.setCellSpacing(0)
                grid.setWidth(QTextLength(QTextLength.Type.PercentageLength, 100))
                frame.setFormat(grid)
        for block in self._blocks():
            look = block.blockFormat()
            if look.hasProperty(QTextFormat.Property.BlockCodeFence):
                look.setBackground(QColor(theme.raised))
                QTextCursor(block).setBlockFormat(look)

    def loadResource(self, kind: int, name: QUrl | str) -> object:
        """Pictures are as wide as the page at most."""
        if kind != QTextDocument.ResourceType.ImageResource.value:
            return super().loadResource(kind, name)
        picture, ratio = QImage(str(self._folder / QUrl(name).fileName())), self.devicePixelRatioF()
        room = self.viewport().width() - 2 * _MARGIN - 2
        if picture.width() > room > 0:
            smooth = Qt.TransformationMode.SmoothTransformation
            picture = picture.scaledToWidth(round(room * ratio), smooth)
            picture.setDevicePixelRatio(ratio)
        return picture


class HelpPanel(QWidget):
    """A page of the user guide, in a window beside its parent.

    `home` is the page that is shown first.
    """

    def __init__(
        self, folder: Path, home: str, anchor_of: Callable[[str], str], parent: QWidget
    ) -> None:
        super().__init__(parent, Qt.WindowType.Tool)  # so that workspaces leave it alone
        self.setWindowTitle("User guide")
        self.page = Page(folder, anchor_of)
        self.back = tool_button("Previous page", "previous")
        self.forward = tool_button("Next page", "next")
        self.contents = tool_button("Contents of the user guide", "help")
        buttons = hbox(self.contents, self.back, self.forward, None)
        self.setLayout(vbox(buttons, (self.page, 1), margins=(4, 4, 0, 0)))
        self.contents.clicked.connect(lambda: self.page.open(home))
        for button, do, there in (
            (self.back, self.page.backward, self.page.backwardAvailable),
            (self.forward, self.page.forward, self.page.forwardAvailable),
        ):
            button.setEnabled(False)
            button.clicked.connect(do)
            there.connect(button.setEnabled)

    def open(self, address: str) -> None:
        """Show a page at a heading, such as ``tuning.md#undo``."""
        self.page.open(address)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() == Qt.Key.Key_Escape:
            self.close()
        else:
            super().keyPressEvent(event)

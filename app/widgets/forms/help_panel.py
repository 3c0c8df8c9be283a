"""A window with the pages of the user guide, and a search over all of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from PySide6.QtCore import Qt, QUrl, Signal, Slot
from PySide6.QtGui import (
    QColor,
    QImage,
    QKeyEvent,
    QResizeEvent,
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
    QLineEdit,
    QListWidget,
    QListWidgetItem,
    QStackedWidget,
    QTextBrowser,
    QWidget,
)

from ..style.building import empty_label, hbox, tool_button, vbox
from ..style.theme import current_theme

_ADDRESS = Qt.ItemDataRole.UserRole
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

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit_pictures()

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
        self._fit_pictures()

    def _fit_pictures(self) -> None:
        """Make pictures, which stand in paragraphs of their own, as wide as the page at most."""
        room = self.viewport().width() - 2 * _MARGIN - 2
        for block in self._blocks():
            look = block.begin().fragment().charFormat() if block.length() > 1 else None
            if look is None or not look.isImageFormat():
                continue
            picture = look.toImageFormat()
            name, ratio = picture.name(), self.devicePixelRatioF()
            full = QImage(str(self._folder / name))
            wanted = min(room, full.width())
            if wanted > 0 and picture.width() != wanted:
                picture.setWidth(wanted)
                smooth = Qt.TransformationMode.SmoothTransformation
                shown = full.scaledToWidth(round(wanted * ratio), smooth)
                kind = QTextDocument.ResourceType.ImageResource
                self.document().addResource(kind.value, QUrl(name), shown)
                cursor = QTextCursor(block)
                cursor.movePosition(
                    QTextCursor.MoveOperation.NextCharacter, QTextCursor.MoveMode.KeepAnchor
                )
                cursor.setCharFormat(picture)


class HelpPanel(QWidget):
    """A page of the user guide below a search, in a window beside its parent.

    What is found takes the page's place.

    `home` is the page that is shown first.
    """

    searched = Signal(str)
    """Words to be looked for; :meth:`show_hits` shows where they are."""

    def __init__(
        self, folder: Path, home: str, anchor_of: Callable[[str], str], parent: QWidget
    ) -> None:
        super().__init__(parent, Qt.WindowType.Tool)  # so that workspaces leave it alone
        self.setWindowTitle("User guide")
        self._home = home
        self.page = Page(folder, anchor_of)
        self.search = QLineEdit()
        self.search.setPlaceholderText("Search the user guide")
        self.search.setAccessibleName("Search the user guide")
        self.search.setClearButtonEnabled(True)
        self.hits = QListWidget()
        self.hits.setAccessibleName("Sections found")
        self.hits.setFrameShape(QFrame.Shape.NoFrame)
        self.hits.setWordWrap(True)
        self.hits.setSpacing(3)
        self._none = empty_label("No section contains all of these words.")
        self.stack = QStackedWidget()
        for each in (self.page, self.hits, self._none):
            self.stack.addWidget(each)
        self.back = tool_button("Previous page", "previous")
        self.forward = tool_button("Next page", "next")
        self.contents = tool_button("Contents of the user guide", "help")
        buttons = hbox(self.contents, self.back, self.forward, (self.search, 1))
        self.setLayout(vbox(buttons, (self.stack, 1), margins=(4, 4, 0, 0)))
        self._connect()

    def _connect(self) -> None:
        page = self.page
        for button, do in (
            (self.back, page.backward),
            (self.forward, page.forward),
            (self.contents, lambda: self.open(self._home)),
        ):
            button.clicked.connect(self.search.clear)
            button.clicked.connect(do)
        self.back.setEnabled(False)
        self.forward.setEnabled(False)
        page.backwardAvailable.connect(self.back.setEnabled)
        page.forwardAvailable.connect(self.forward.setEnabled)
        self.search.textChanged.connect(self._on_typed)
        self.search.returnPressed.connect(self._on_return)
        for chosen in (self.hits.itemClicked, self.hits.itemActivated):
            chosen.connect(self._on_chosen)

    def open(self, address: str) -> None:
        """Show a page at a heading, such as ``tuning.md#undo``."""
        self.search.clear()
        self.page.open(address)

    def show_hits(self, hits: Sequence[tuple[str, str, str]]) -> None:
        """List sections by address, title and some words of each."""
        self.hits.clear()
        for address, title, snippet in hits:
            item = QListWidgetItem(f"{title}\n{snippet}")
            item.setData(_ADDRESS, address)
            self.hits.addItem(item)
        self.hits.setCurrentRow(0)
        self.stack.setCurrentWidget(self.hits if hits else self._none)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() == Qt.Key.Key_Escape:
            self.close()
        else:
            super().keyPressEvent(event)

    @Slot(str)
    def _on_typed(self, text: str) -> None:
        if text.strip():
            self.searched.emit(text)
        else:
            self.stack.setCurrentWidget(self.page)

    @Slot()
    def _on_return(self) -> None:
        item = self.hits.currentItem()
        if item is not None and self.stack.currentWidget() is self.hits:
            self._on_chosen(item)

    @Slot(QListWidgetItem)
    def _on_chosen(self, item: QListWidgetItem) -> None:
        self.open(item.data(_ADDRESS))
        self.page.setFocus()

"""The panel that goes through the steps inside a frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QAction, QColor, QResizeEvent, QWheelEvent
from PySide6.QtWidgets import (
    QHeaderView,
    QListWidget,
    QListWidgetItem,
    QScrollArea,
    QSplitter,
    QStackedLayout,
    QTableView,
    QWidget,
)

from ..style.building import ElidedLabel, action_button, hbox, label, vbox
from ..style.colours import LIMB_COLOURS
from ..style.theme import Dressed, current_theme
from ..tables.table import LEFT, RIGHT, Cell, Column, TableModel, dress_table
from .step_plots import HeatMap, HeatMapView


@dataclass(frozen=True)
class Table:
    """Words and numbers in rows."""

    title: str
    headings: tuple[str, ...]
    """The first column is words, all others numbers."""
    rows: tuple[tuple[str, ...], ...]
    limbs: tuple[str, ...] = ()
    """Limb of each row, whose colour stands before it; empty for none."""
    strong: tuple[int, ...] = ()
    """Rows that are chosen."""
    tips: tuple[str, ...] = ()
    """What each heading means; as many as there are headings, or none."""


@dataclass(frozen=True, eq=False)
class StepContent:
    """One step in words and numbers."""

    title: str
    words: str
    """One or two plain sentences."""
    source: str
    """Where the thesis has it, or what it takes the place of."""
    map: HeatMap | None = None
    tables: tuple[Table, ...] = ()


@dataclass(frozen=True)
class StepName:
    """A step in the list."""

    title: str
    heading: str = ""
    """Written before the first step of an iteration or stage; empty elsewhere."""


_STEP = Qt.ItemDataRole.UserRole
_NOTHING = (
    "Inspect a step ({keys}) to see how the tracker processes the current frame: what it "
    "predicts, which points it pairs, and how they correct the model, iteration by iteration."
)


class InsidePanel(Dressed):
    """Steps at the left; what belongs to the chosen one at the right."""

    step_chosen = Signal(int)
    """Index of the step that was chosen in the list."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.steps = QListWidget(self)
        self.steps.setAccessibleName("Stages of the step")
        self.steps.setMinimumWidth(110)
        self.steps.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.steps.currentItemChanged.connect(self._on_chosen)
        self.beginning = ElidedLabel(parent=self)
        self.page = StepPage(self)
        self._filling = False
        self._names: tuple[StepName, ...] = ()
        self._buttons = hbox(spacing=2)
        self._nothing = label(_NOTHING.format(keys=""), "muted", margins=(16, 8, 16, 8))
        self._nothing.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self.setAutoFillBackground(True)  # tab bars that lie behind would show through
        self._stack = QStackedLayout(self)
        self._stack.addWidget(self._nothing)
        self._stack.addWidget(self._body())

    def _body(self) -> QWidget:
        split = QSplitter(Qt.Orientation.Horizontal, self)
        split.addWidget(self.steps)
        split.addWidget(self.page)
        split.setStretchFactor(0, 0)
        split.setStretchFactor(1, 1)
        split.setSizes([136, 400])
        split.setChildrenCollapsible(False)
        top = hbox((self.beginning, 1), self._buttons, margins=(6, 2, 4, 0))
        body = QWidget(self)
        body.setLayout(vbox(top, (split, 1), spacing=2))
        return body

    def set_actions(self, actions: Sequence[QAction], keys: str) -> None:
        """Offer commands at the top; `keys` look inside."""
        for action in actions:
            button = action_button(action)
            button.setAutoRaise(True)
            button.setIconSize(QSize(16, 16))
            self._buttons.addWidget(button)
        self._nothing.setText(_NOTHING.format(keys=keys))

    def show_nothing(self, words: str = "") -> None:
        """Show no frame; `words` say what is being waited for."""
        if words:
            self._nothing.setText(words)
        self._stack.setCurrentIndex(0)

    def show_steps(self, names: tuple[StepName, ...], index: int) -> None:
        """List the steps, one of which is shown."""
        self._filling = True
        if names != self._names:
            self._names = names
            self._fill(names)
        for row in range(self.steps.count()):
            item = self.steps.item(row)
            if item.data(_STEP) == index:
                self.steps.setCurrentItem(item)
                self.steps.scrollToItem(item)
        self._filling = False
        self._stack.setCurrentIndex(1)

    def show_content(self, content: StepContent, beginning: str, *, busy: bool) -> None:
        """Show one step."""
        self.beginning.set_words("Computing …" if busy else beginning)
        self.page.show_content(content)

    def _fill(self, names: tuple[StepName, ...]) -> None:
        self.steps.clear()
        for index, name in enumerate(names):
            if name.heading:
                heading = QListWidgetItem(name.heading)
                heading.setFlags(Qt.ItemFlag.NoItemFlags)
                heading.setForeground(QColor(current_theme().muted))
                heading.setToolTip(name.heading)
                self.steps.addItem(heading)
            item = QListWidgetItem(f"   {name.title}")
            item.setData(_STEP, index)
            self.steps.addItem(item)

    def _on_chosen(self, item: QListWidgetItem | None, _before: object = None) -> None:
        if item is not None and item.data(_STEP) is not None and not self._filling:
            self.step_chosen.emit(item.data(_STEP))

    def _dress(self) -> None:
        for row in range(self.steps.count()):
            item = self.steps.item(row)
            if item.data(_STEP) is None:
                item.setForeground(QColor(current_theme().muted))


class StepPage(QScrollArea):
    """What belongs to one step, from top to bottom."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAccessibleName("Step")
        self.setWidgetResizable(True)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setFrameShape(QScrollArea.Shape.NoFrame)
        self.title, self.words, self.source = label("", "heading"), label(), label("", "muted")
        for text in (self.title, self.words, self.source):
            text.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.tables = [InsideTable()]
        self.heat = HeatMapView()
        self.pointed = label("", "muted")
        self.pointed.setMinimumHeight(2 * self.fontMetrics().height() + 2)
        self.pointed.setAlignment(Qt.AlignmentFlag.AlignTop)
        self.heat.pointed.connect(self._on_pointed)
        first, page = self.tables[0], QWidget()
        words = (self.title, self.words, self.source, first.title, first)
        self._column = vbox(*words, self.pointed, self.heat, None, margins=(6, 4, 4, 8), spacing=4)
        page.setLayout(self._column)
        self.setWidget(page)
        self._shown: StepContent | None = None

    def show_content(self, content: StepContent) -> None:
        """Show another step."""
        before, self._shown = self._shown, content
        self.title.setText(content.title)
        self.words.setText(content.words)
        self.source.setText(content.source)
        for each in (self.heat, self.pointed):
            each.setVisible(content.map is not None)
        self.heat.show_map(content.map)
        self._show_tables(content)
        if before is None or before.title != content.title:
            self.verticalScrollBar().setValue(0)

    def _on_pointed(self, words: str) -> None:
        self.pointed.setText(words or "Point at the matrix to read its values.")

    def _show_tables(self, content: StepContent) -> None:
        while len(self.tables) < len(content.tables):
            table = InsideTable()
            self.tables.append(table)
            for part in (table.title, table):
                self._column.insertWidget(self._column.count() - 1, part)
        for index, table in enumerate(self.tables):
            there = index < len(content.tables)
            table.title.setVisible(there)
            table.setVisible(there)
            if there:
                table.show_table(content.tables[index])


_NARROWEST_WORDS = 72


class InsideTable(QTableView):
    """A table that is as high as its rows and scrolls with the page, not by itself."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.title = label("", "muted", margins=(0, 4, 0, 0))
        self._rows: TableModel[Sequence[Cell]] = TableModel((), lambda cells: cells)
        self.setModel(self._rows)
        dress_table(self, "Numbers of the step", room=5)
        self.setTextElideMode(Qt.TextElideMode.ElideMiddle)  # names differ at their ends
        self.setVerticalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.horizontalHeader().setMinimumSectionSize(24)
        self.horizontalHeader().setStyleSheet("QHeaderView::section { padding: 2px 5px; }")

    def wheelEvent(self, event: QWheelEvent) -> None:
        event.ignore()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()

    def _fit(self) -> None:
        """Give words the room that numbers leave, and be as high as all rows."""
        header = self.horizontalHeader()
        if not header.count():
            return
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        left = self.viewport().width() - header.length() + header.sectionSize(0)
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.Fixed)
        header.resizeSection(0, max(left, _NARROWEST_WORDS))
        rows = self.verticalHeader().length() + header.sizeHint().height()
        bar = self.horizontalScrollBar()
        under = bar.sizeHint().height() if header.length() > self.width() else 0
        self.setFixedHeight(rows + under + 4)

    def show_table(self, shown: Table) -> None:
        """Show other rows."""
        self.title.setText(shown.title)
        self.setAccessibleName(shown.title)
        tips = shown.tips or shown.headings
        columns = [
            Column(heading, tip, RIGHT if place else LEFT)
            for place, (heading, tip) in enumerate(zip(shown.headings, tips, strict=True))
        ]
        self._rows.show([_cells(shown, row) for row in range(len(shown.rows))], columns)
        self._fit()


def _cells(shown: Table, row: int) -> Sequence[Cell]:
    name, *numbers = shown.rows[row]
    colour = LIMB_COLOURS.get(shown.limbs[row], "") if shown.limbs else None
    bold = row in shown.strong
    return [Cell(name, name, swatch=colour, bold=bold), *(Cell(n, bold=bold) for n in numbers)]

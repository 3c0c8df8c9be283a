"""The panel that goes through the steps inside a frame."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from PySide6 import QtWidgets
from PySide6.QtCore import QSignalBlocker, QSize, Qt
from PySide6.QtGui import QAction, QColor

from ...session.inspection import Step
from ..style import building
from ..style.colours import LIMB_COLOURS
from ..style.theme import Dressed, current_theme
from ..tables.table import LEFT, RIGHT, STRETCH, Cell, Column, PlainTable


@dataclass(frozen=True)
class Table:
    """Words and numbers in rows."""

    title: str
    headings: tuple[str, ...]  # the first column is words, all others numbers
    rows: tuple[tuple[str, ...], ...]
    limbs: tuple[str, ...] = ()  # limb of each row, whose colour stands before it; empty for none
    strong: tuple[int, ...] = ()
    tips: tuple[str, ...] = ()  # what each heading means; as many as there are headings, or none


@dataclass(frozen=True, eq=False)
class StepContent:
    """One step in words and numbers."""

    title: str
    words: str
    source: str  # where the thesis has it, or what it takes the place of
    tables: tuple[Table, ...] = ()
    parameters: tuple[str, ...] = ()  # names of those that it points to


_STEP = Qt.ItemDataRole.UserRole
_NOTHING = (
    "Inspect a step ({keys}) to see how the tracker processes the current frame: what it "
    "predicts, which points it pairs, and how they correct the model, iteration by iteration."
)


class InsidePanel(Dressed):
    """Steps at the left; what belongs to the chosen one at the right.

    `choose` is called with the index of a step that a person has chosen in the list, `show` with
    the name of a parameter that was clicked.
    """

    def __init__(self, choose: Callable[[int], object], show: Callable[[str], object]) -> None:
        super().__init__()
        self._choose = choose
        self.steps = building.named(QtWidgets.QListWidget(self), "Stages of the step")
        self.steps.setMinimumWidth(110)
        self.steps.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.steps.currentItemChanged.connect(self._on_chosen)
        self.beginning = building.ElidedLabel(parent=self)
        self.page = StepPage()
        self.page.parameters.linkActivated.connect(show)
        self._shown: tuple[Step, ...] = ()
        self._buttons, self._usual = building.hbox(spacing=2), ""
        centre = Qt.AlignmentFlag.AlignCenter
        self.nothing = building.label("", "muted", margins=(16, 8, 16, 8), align=centre)
        self.setAutoFillBackground(True)  # tab bars that lie behind would show through
        self._stack = QtWidgets.QStackedLayout(self)
        self._stack.addWidget(self.nothing)
        self._stack.addWidget(self._body())

    def _body(self) -> QtWidgets.QWidget:
        split = building.splitter(Qt.Orientation.Horizontal, (self.steps, 0), (self.page, 1))
        split.setSizes([136, 400])
        top = building.hbox((self.beginning, 1), self._buttons, margins=(6, 2, 4, 0))
        return building.holder(building.vbox(top, (split, 1), spacing=2))

    def set_actions(self, actions: Sequence[QAction], keys: str) -> None:
        """Offer commands at the top; `keys` look inside."""
        for action in actions:
            button = building.action_button(action)
            button.setAutoRaise(True)
            button.setIconSize(QSize(16, 16))
            self._buttons.addWidget(button)
        self._usual = _NOTHING.format(keys=keys)
        self.show_nothing()

    def show_nothing(self, words: str = "") -> None:
        """Show no frame; `words` say what is being waited for."""
        self.nothing.setText(words or self._usual)
        self._stack.setCurrentIndex(0)

    def show_steps(self, steps: tuple[Step, ...], index: int) -> None:
        with QSignalBlocker(self.steps):
            if steps != self._shown:
                self._shown = steps
                self._fill(steps)
            for item in map(self.steps.item, range(self.steps.count())):
                if item.data(_STEP) == index:
                    self.steps.setCurrentItem(item)
                    self.steps.scrollToItem(item)
        self._stack.setCurrentIndex(1)

    def show_content(self, content: StepContent, beginning: str, *, busy: bool) -> None:
        self.beginning.set_words("Computing …" if busy else beginning)
        self.page.show_content(content)

    def _fill(self, steps: tuple[Step, ...]) -> None:
        self.steps.clear()
        for index, step in enumerate(steps):
            if step.heading:
                heading = QtWidgets.QListWidgetItem(step.heading, self.steps)
                heading.setFlags(Qt.ItemFlag.NoItemFlags)
                heading.setToolTip(step.heading)
            item = QtWidgets.QListWidgetItem(f"   {step.title}", self.steps)
            item.setData(_STEP, index)
        self._dress()

    def _on_chosen(self, item: QtWidgets.QListWidgetItem | None, _before: object = None) -> None:
        if item is not None and item.data(_STEP) is not None:
            self._choose(item.data(_STEP))

    def _dress(self) -> None:
        for item in map(self.steps.item, range(self.steps.count())):
            if item.data(_STEP) is None:
                item.setForeground(QColor(current_theme().muted))


class StepPage(QtWidgets.QScrollArea):
    """What belongs to one step, from top to bottom."""

    def __init__(self) -> None:
        super().__init__()
        self.setAccessibleName("Step")
        self.setWidgetResizable(True)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setFrameShape(QtWidgets.QScrollArea.Shape.NoFrame)
        roles = "heading", "", "muted"
        self.title, self.words, self.source = (
            building.label("", role, copied=True) for role in roles
        )
        self.parameters = building.label()
        self.parameters.setTextFormat(Qt.TextFormat.RichText)
        self.parameters.setTextInteractionFlags(Qt.TextInteractionFlag.LinksAccessibleByMouse)
        self.tables: list[PlainTable] = []
        parts = (self.title, self.words, self.parameters, self.source, None)
        self._column = building.vbox(*parts, margins=(6, 4, 4, 8), spacing=4)
        self.setWidget(building.holder(self._column))

    def show_content(self, content: StepContent) -> None:
        if self.title.text() != content.title:
            self.verticalScrollBar().setValue(0)
        self.title.setText(content.title)
        self.words.setText(content.words)
        self.source.setText(content.source)
        building.show_text(self.parameters, building.parameter_links(content.parameters))
        while len(self.tables) < len(content.tables):
            self.tables.append(PlainTable("Numbers of the step", most=1000, role="muted"))
            self._column.insertWidget(self._column.count() - 1, self.tables[-1])
        for table in self.tables[len(content.tables) :]:
            table.hide()
        for table, shown in zip(self.tables, content.tables, strict=False):
            tips = shown.tips or shown.headings
            columns = [
                Column(heading, tip, RIGHT if place else LEFT, width=0 if place else STRETCH)
                for place, (heading, tip) in enumerate(zip(shown.headings, tips, strict=True))
            ]
            rows = [_cells(shown, row) for row in range(len(shown.rows))]
            table.show_cells(shown.title, columns, rows)


def _cells(shown: Table, row: int) -> Sequence[Cell]:
    name, *numbers = shown.rows[row]
    colour = LIMB_COLOURS.get(shown.limbs[row], "") if shown.limbs else None
    bold = row in shown.strong
    return [Cell(name, name, swatch=colour, bold=bold), *(Cell(n, bold=bold) for n in numbers)]

"""A table of clicks that contradict each other, each with its decision."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from PySide6.QtCore import QModelIndex, Qt, Signal
from PySide6.QtWidgets import QAbstractItemView, QHeaderView, QTableView, QWidget

from stereotrack_core.annotation.agreement import Difference
from stereotrack_core.annotation.click import Click, Visibility
from stereotrack_core.project.merging import Decision, has_mean

from .table import RIGHT, Cell, Column, TableModel, dress_table, selected_rows

_COLUMNS = (
    Column("Frame", align=RIGHT),
    *(Column(heading) for heading in ("Camera", "Landmark", "Mine", "Theirs", "Mean")),
    Column("Distance [px]", align=RIGHT),
    Column("Annotator"),
)
_CLICK = "000.0, 000.0  guessed"
_WIDEST = ("00000", "W_right", "left shoulder", _CLICK, _CLICK, "mean", "")
_CHOICES: dict[int, Decision] = {3: "mine", 4: "theirs", 5: "mean"}
_KEYS: dict[int, Decision] = {Qt.Key.Key_M: "mine", Qt.Key.Key_T: "theirs", Qt.Key.Key_B: "mean"}
_TIP = "Click Mine, Theirs or Mean to choose; double-click to go to the frame."


class DecisionTable(QTableView):
    """Contradicting clicks; a click on one side takes it, keys decide the selected rows.

    What is decided is kept by somebody else.
    """

    decided = Signal(list, str)
    """The person wants these rows decided so."""
    visit_requested = Signal(int)
    """The person wants to see the click of this row."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._decision: Callable[[int], Decision] = lambda _row: "mine"
        self._rows: TableModel[tuple[int, Difference]] = TableModel(_COLUMNS, self._cells)
        self.setModel(self._rows)
        dress_table(self, "Clicks that differ")
        self.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        self.setAccessibleDescription(
            "Press M for mine, T for theirs, B for the mean of both. Applies to all selected rows."
        )
        header, width = self.horizontalHeader(), self.fontMetrics().horizontalAdvance
        header.setStretchLastSection(True)
        header.setSectionResizeMode(QHeaderView.ResizeMode.Interactive)
        for place, (text, column) in enumerate(zip(_WIDEST, _COLUMNS, strict=False)):
            header.resizeSection(place, max(width(text), width(column.heading)) + 24)
        self.clicked.connect(self._on_clicked)
        self.doubleClicked.connect(lambda index: self.visit_requested.emit(index.row()))

    def show_rows(self, rows: Sequence[Difference], decision: Callable[[int], Decision]) -> None:
        """Show these rows, with the function that tells the decision of a row."""
        self._decision = decision
        self._rows.show(tuple(enumerate(rows)))

    def show_decisions(self) -> None:
        """Show what is decided now."""
        if self._rows.rows:
            self._rows.tell(0, len(self._rows.rows) - 1)

    def _cells(self, numbered: tuple[int, Difference]) -> Sequence[Cell]:
        place, one = numbered
        frame, camera, landmark = one.key
        decision = self._decision(place)
        mean = "mean" if has_mean(one) else "–"
        sides = {"mine": _said(one.first), "theirs": _said(one.second), "mean": mean}
        distance = "–" if one.distance is None else f"{one.distance:.1f}"
        who = " / ".join(click.who for click in (one.first, one.second) if click and click.who)
        return (
            *(Cell(text, _TIP) for text in (str(frame), camera, landmark.replace("_", " "))),
            *(_side(side, text, side == decision) for side, text in sides.items()),
            *(Cell(text, _TIP) for text in (distance, who)),
        )

    def keyPressEvent(self, event: Any) -> None:
        decision = _KEYS.get(event.key())
        if decision is not None and not event.modifiers():
            self.decided.emit(selected_rows(self), decision)
        elif event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter) and self.currentIndex().isValid():
            self.visit_requested.emit(self.currentIndex().row())
        else:
            super().keyPressEvent(event)

    def _on_clicked(self, index: QModelIndex) -> None:
        decision = _CHOICES.get(index.column())
        if decision is not None:
            self.decided.emit([index.row()], decision)


def _side(side: str, text: str, chosen: bool) -> Cell:
    said = f"{text}, {side}{', chosen' if chosen else ''}"
    if not chosen:
        return Cell(text, _TIP, "muted", said=said)
    return Cell(text, _TIP, "text", bold=True, background="selection", said=said)


def _said(click: Click | None) -> str:
    """What a click says: its place, or why it has none."""
    if click is None:
        return "nothing"
    if click.deleted:
        return "deleted"
    if click.position is None:
        return "outside"
    marks = (
        f"{click.position[0]:.1f}, {click.position[1]:.1f}",
        "guessed" if click.visibility == Visibility.GUESSED else "",
        click.flag,
        "" if click.sigma is None else f"± {click.sigma:g} px",
    )
    return "  ".join(filter(None, marks))

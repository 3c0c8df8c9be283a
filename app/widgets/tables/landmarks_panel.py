"""The landmarks with their keys and how each camera sees them, and what to click next."""

import os
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Literal, TypeAlias

from PySide6.QtCore import QSignalBlocker, Qt
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QPushButton, QWidget

from stereotrack_core.annotation.click import ClickKey
from stereotrack_core.annotation.next_clicks import KIND_WORDS, StopSign, Suggestion

from ..forms.numbers import NumberField
from ..style.building import choice, hbox, holder, label, named, vbox
from ..style.theme import set_look
from .table import RIGHT, STRETCH, Cell, CellRow, CellTable, Column

CellState: TypeAlias = Literal["clicked", "guessed", "doubted", "outside", "predicted", "missing"]

CELL_STATES: dict[CellState, tuple[str, str]] = {
    "clicked": ("●", "clicked"),
    "guessed": ("○", "occluded, position estimated"),
    "doubted": ("◌", "clicked, flagged as uncertain"),
    "outside": ("⊠", "outside the image"),
    "predicted": ("×", "not clicked; a prediction is available"),
    "missing": ("–", "not clicked"),
}
"""States of a landmark in one camera, as a sign and in words."""

_LABEL = 1
_NUMBER = 50


class LandmarksPanel(QWidget):
    """Table of the landmarks; `choose` is called with the place of one that is chosen there."""

    def __init__(self, choose: Callable[[int], object]) -> None:
        super().__init__()
        self._chosen = -1
        self.table = CellTable("Landmarks", single=True)
        self.table.setAlternatingRowColors(False)
        self.setLayout(vbox(self.table))
        self.table.selectionModel().currentRowChanged.connect(
            lambda index: index.row() in (-1, self._chosen) or choose(index.row())
        )
        # also the row that is chosen already
        self.table.pressed.connect(lambda index: choose(index.row()))

    def show_rows(self, cameras: Sequence[str], rows: Sequence[CellRow], chosen: int) -> None:
        """Show the landmarks: key, name, a cell for each of the `cameras`, and two numbers."""
        self._chosen = chosen
        self.table.show_rows(rows, _columns(cameras))
        if chosen >= 0 and self.table.currentIndex().row() != chosen:
            self.table.setCurrentIndex(self.table.cells.index(chosen, _LABEL))


def _columns(cameras: Sequence[str]) -> tuple[Column, ...]:
    """Columns of the table; cameras without what all their names begin with."""
    same = os.path.commonprefix(cameras).rstrip("0123456789")  # noqa: RUF071 - letters are meant
    whole = len(cameras) < 2 or any(name == same for name in cameras)
    start = 0 if whole else len(same)
    number = (RIGHT, True, _NUMBER)
    return (
        Column("", "Key that selects the landmark", width=34),
        Column("Landmark", "Select a landmark here to place it with the next click", width=STRETCH),
        *(
            Column(name[start:], f"Visibility in {name}", Qt.AlignmentFlag.AlignCenter)
            for name in cameras
        ),
        Column("px", "Root mean square distance of its clicks from the fitted model", *number),
        Column("mm", "Distance between the triangulated clicks and the model", *number),
    )


_COLUMNS = (
    Column("Frame", align=RIGHT),
    Column("View"),
    Column("Landmark"),
    Column(
        "Gain [°]",
        "Expected reduction of the angular uncertainty of the limbs, over all frames that benefit. "
        "The list is sorted by this; clicks to be checked come first, occluded landmarks and views "
        "that disagree with the others last.",
        RIGHT,
    ),
    Column("Reason", width=STRETCH),
)
_REASON = len(_COLUMNS) - 1
_NONE = "Lists where further clicks help most once frames are clicked, the most useful first."
_NARROW = 460
_KEPT = 1000


class NextPanel(QWidget):
    """A stop sign in words, the wanted accuracy, and the suggestions below.

    `visit` is called with the frame, camera and landmark to go to; `nothing_left` if no click is
    suggested that one could go to.
    """

    def __init__(
        self, visit: Callable[[int, str, str], object], nothing_left: Callable[[], object]
    ) -> None:
        super().__init__()
        self._visit, self._nothing_left = visit, nothing_left
        self._colours: Mapping[str, str] = {}
        self._views: Mapping[str, str] = {}
        self._visited: set[ClickKey] = set()
        self.sign = label()
        tip = "Target uncertainty. Suggestions stop when all limbs are within this angle."
        self.wanted = NumberField(
            minimum=0.1, maximum=45.0, value=3.0, singleStep=0.5, prefix="± ", suffix="°",
            keyboardTracking=False, accessibleName="Target uncertainty", toolTip=tip,
        )  # fmt: skip
        tip = "Show suggestions of one kind alone"
        self.kinds = choice("Kind of suggestion", (), tip, lambda _kind: self._show_kind())
        self.next_button = QPushButton("Go to next")
        self.next_button.clicked.connect(self.go_to_next)
        tip = "Fit the body model to the clicked frames"
        self.fit_button = named(QPushButton("Suggest clicks"), tip=tip)
        self.reason = label("", "muted", margins=(8, 3, 8, 4))
        self.tree = CellTable("Suggested clicks", _COLUMNS, self._cells, single=True)
        for chosen in (self.tree.clicked, self.tree.activated):
            chosen.connect(lambda index: self._go_to(index.row()))
        self.tree.selectionModel().currentRowChanged.connect(self._show_reason)
        self._lay_out()
        self._sign: StopSign | None = None
        self._every: Sequence[Suggestion] = ()
        self.awaited = False  # whether to go to the best place as soon as one is known
        self.show_ranking((), None, {})

    def _lay_out(self) -> None:
        tools = hbox(self.next_button, (self.kinds, 1), self.wanted)
        self._head = holder(vbox(self.sign, tools, margins=(8, 4, 8, 4), spacing=4))
        fit, margins = hbox(self.fit_button, None), (10, 10, 10, 10)
        self._unfitted = holder(vbox(label(_NONE, "muted"), fit, None, margins=margins))
        parts = (self._unfitted, 1), self._head, (self.tree, 1), self.reason
        self.setLayout(vbox(*parts, spacing=0))

    def show_wanted(self, degrees: float) -> None:
        with QSignalBlocker(self.wanted):
            self.wanted.setValue(degrees)

    def show_ranking(
        self,
        rows: Sequence[Suggestion],
        sign: StopSign | None,
        colours: Mapping[str, str],
        views: Mapping[str, str] | None = None,
    ) -> None:
        """Show what to click next; without a stop sign nothing is fitted yet."""
        self._sign, self._every = sign, rows
        rows = self._of_kind()
        self._unfitted.setVisible(sign is None)
        self._head.setVisible(sign is not None)
        self.tree.setVisible(sign is not None)
        current = self.tree.currentIndex()
        key = self.tree.cells.rows[current.row()].key if current.isValid() else None
        self._colours, self._views = colours, views or {}
        self.tree.show_rows(rows)
        places = (place for place, one in enumerate(rows[:_KEPT]) if one.key == key)
        self.tree.setCurrentIndex(self.tree.cells.index(next(places, -1), 0))
        self._show_reason()
        self.reason.setVisible(sign is not None and bool(rows))
        self.next_button.setEnabled(bool(rows))
        if sign is not None:
            words, doubted = sign.words(), sign.reached and any(one.click_there for one in rows)
            doubt = ", once the outlying clicks are corrected" if doubted else ""
            self.sign.setText(f"{words[:1].upper()}{words[1:]}{doubt}.")
            role = "doubted" if doubted else "reached" if sign.reached else "heading"
            set_look(self.sign, "role", role)
            if self.awaited and rows:
                self.go_to_next()

    def _of_kind(self) -> Sequence[Suggestion]:
        """The suggestions of the kind that is chosen; offers the kinds that there are."""
        count, chosen = Counter(one.kind for one in self._every), self.kinds.currentData()
        chosen = chosen if chosen in count else None
        with QSignalBlocker(self.kinds):
            self.kinds.clear()
            self.kinds.addItem("All kinds", None)
            for kind, words in KIND_WORDS.items():
                if count[kind]:
                    self.kinds.addItem(f"{words} ({count[kind]})", kind)
            self.kinds.setCurrentIndex(max(self.kinds.findData(chosen), 0))
        return [one for one in self._every if chosen in (None, one.kind)]

    def _show_kind(self) -> None:
        self.tree.show_rows(self._of_kind())
        self.next_button.setEnabled(bool(self.tree.cells.rows))
        self._show_reason()

    def go_to_next(self) -> None:
        """Go to the best place that nobody went to yet; where none is known, fit to find one."""
        rows: Sequence[Suggestion] = self.tree.cells.rows
        if all(one.key in self._visited for one in rows):
            self._visited.clear()
        row = next((k for k, one in enumerate(rows) if one.key not in self._visited), None)
        self.awaited = row is None
        if row is not None:
            self._go_to(row)
        elif self._sign is None:
            self.fit_button.click()
        else:
            self._nothing_left()

    def _cells(self, one: Suggestion) -> Sequence[Cell]:
        gain, tip = f"{one.over_frames_deg:.1f}", f"{one.reason}\nExpected gain of a click here: "
        tip += f"{one.gain_deg:.2f}° in this frame, {gain}° over all frames."
        if one.kind == "unknown":
            gain, tip = "all", f"{one.reason}\nNothing is known here before a click."
        colour = "muted" if one.key in self._visited or not one.clear else ""
        doubt = colour or ("warning" if one.click_there else "")
        swatch = self._colours.get(one.landmark, "#808080")
        return (
            Cell(str(one.frame), tip, colour),
            Cell(self._views.get(one.camera, one.camera), tip, colour),
            Cell(one.landmark.replace("_", " "), tip, colour, swatch),
            Cell(gain, tip, colour),
            Cell(f"check: {one.reason}" if one.click_there else one.reason, tip, doubt),
        )

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        # what is left out is said below the list
        self.tree.setColumnHidden(_REASON, self.width() < _NARROW)

    def _show_reason(self) -> None:
        """Write the reason of the chosen row, or of the best one, where there is room for it."""
        row = max(self.tree.currentIndex().row(), 0)
        if row < len(self.tree.cells.rows):
            frame, view, landmark, _, reason = (c.text for c in self.tree.cells.row_cells(row))
            self.reason.setText(f"{frame}, {landmark} in {view}: {reason}.")

    def _go_to(self, row: int) -> None:
        one = self.tree.cells.rows[row]
        self.tree.setCurrentIndex(self.tree.cells.index(row, 0))
        self._visited.add(one.key)
        self.tree.cells.look_again()
        self._visit(one.frame, one.camera, one.landmark)

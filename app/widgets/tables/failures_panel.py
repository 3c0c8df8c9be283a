"""The list of failures: a filter, a row for each, and what speaks for its cause."""

from collections.abc import Callable, Sequence
from html import escape

from PySide6.QtCore import QSignalBlocker, Qt, QUrl
from PySide6.QtGui import QImage, QResizeEvent, QTextDocument
from PySide6.QtWidgets import QSplitter, QTextBrowser, QWidget

from stereotrack_core.arrays import ImageArray
from stereotrack_core.evaluation.failure_segments.segment import (
    CAUSE_WORDS,
    FOUND_WORDS,
    FailureSegment,
    Verdict,
    limbs_words,
)

from ..camera.picture import image_of
from ..forms.form_dialog import line_edit
from ..style.building import hbox, label, show_text, vbox
from ..style.colours import LIMB_COLOURS
from .table import RIGHT, STRETCH, Cell, CellTable, Column

_NONE = (
    "Select a failure to see the evidence for its cause. Press Enter to go to its worst frame; "
    "Loop failure plays it in a loop."
)
_STRENGTH = "Evidence for causes, the strongest first. The bars show how strong it is."
_BAR = 8
_PICTURE = "picture"


class EvidenceView(QTextBrowser):
    """A heading, a line for each piece of evidence, and a picture as wide as there is room."""

    def __init__(self) -> None:
        super().__init__()
        self.setAccessibleName("Evidence")
        self.setFrameShape(QTextBrowser.Shape.NoFrame)
        # the room for the picture must not depend on whether there is a bar
        self.setVerticalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOn)
        self.setMinimumHeight(80)
        self._words = ""
        self.picture = QImage()
        """Before, worst and after."""
        self.show_words("", None)

    def show_words(self, heading: str, verdict: Verdict | None) -> None:
        """Show what is known of a failure and of its causes; without a verdict none is chosen."""
        lines = [escape(heading or _NONE)]
        if verdict is not None:
            lines.append(_STRENGTH if verdict.evidence else "No evidence for a cause.")
            for one in verdict.evidence:
                full = round(_BAR * min(max(one.strength, 0.0), 1.0))
                bar = "█" * full + "░" * (_BAR - full)
                cause = escape(CAUSE_WORDS[one.cause])
                name = f"<b>{cause}</b>" if one.cause == verdict.cause else cause
                lines.append(f"<tt>{bar}</tt> {name}: {escape(one.words)}")
        self._words = "".join(f"<p style='margin:0 0 4px 0'>{line}</p>" for line in lines)
        self._write()

    def show_picture(self, pixels: ImageArray | None) -> None:
        """Show a picture (H, W, 3) BGR, or none."""
        self.picture = QImage() if pixels is None else image_of(pixels).copy()
        self._write()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._write()

    def _write(self) -> None:
        room = self.viewport().width() - 2 * round(self.document().documentMargin())
        width = min(room, self.picture.width())
        html = self._words
        if width > 0:
            smooth = Qt.TransformationMode.SmoothTransformation
            shown = self.picture.scaledToWidth(round(width * self.devicePixelRatioF()), smooth)
            kind = QTextDocument.ResourceType.ImageResource
            self.document().addResource(kind.value, QUrl(_PICTURE), shown)
            html += f"<img src='{_PICTURE}' width='{width}'>"
        self.setHtml(html)


_CHANCE_TIP = "Largest failure probability of a limb; found without the reference."
_PEAKS = {
    "error": Column(
        "Error °", "Largest error of a limb; found with the reference.", RIGHT, width=54
    ),
    "chance": Column("Prob. %", _CHANCE_TIP, RIGHT, width=54),
}
"""Columns of the peak, by its measure: none mixes units."""
_COLUMNS = (
    Column("Frames", "First and last frame", width=78),
    Column("Limbs", "Limbs that fail", width=STRETCH),
    *_PEAKS.values(),
    Column("Probable cause", "The cause that most of the evidence speaks for"),
    Column("Conf. %", "Confidence in the cause: its share of all evidence", RIGHT, width=54),
)


class FailuresPanel(QWidget):
    """A filter above, the rows below, then words and pictures of the one that is chosen.

    `chosen` is called with the place of a row in what was handed on, -1 for none; `activated` when
    a row is double-clicked, or Enter pressed on it; `filtered` with words that rows shall have.
    """

    def __init__(
        self,
        chosen: Callable[[int], object],
        activated: Callable[[int], object],
        filtered: Callable[[str], object],
    ) -> None:
        super().__init__()
        tip = "Words of limbs, cause or way of detection, such as left, crossing or error"
        self.filter = line_edit("Filter", "", "Filter: words of limbs, cause or detection", tip)
        self.filter.setClearButtonEnabled(True)
        self.filter.textChanged.connect(filtered)
        self.words = label("", "muted", margins=(8, 0, 8, 0))
        self._fps = 1.0
        self.tree = CellTable("Failures", _COLUMNS, self._cells, least=96, sorts=True, single=True)
        self.tree.sortByColumn(0, Qt.SortOrder.AscendingOrder)
        self.tree.setMinimumHeight(56)
        self.tree.selectionModel().currentRowChanged.connect(
            lambda index: chosen(self.tree.place_of(index))
        )
        self.tree.activated.connect(lambda index: activated(self.tree.place_of(index)))
        self.evidence = EvidenceView()
        both = QSplitter(Qt.Orientation.Vertical, childrenCollapsible=False)
        both.addWidget(self.tree)
        both.addWidget(self.evidence)
        both.setStretchFactor(0, 2)
        both.setStretchFactor(1, 3)
        above = hbox(self.filter, margins=(6, 0, 6, 0))
        self.setLayout(vbox(above, self.words, (both, 1), margins=(0, 4, 0, 0), spacing=4))
        self.show_rows((), 1.0, -1, "")

    def show_rows(
        self, failures: Sequence[FailureSegment], fps: float, chosen: int, words: str
    ) -> None:
        """Show these, one of them `chosen` or -1; `words` are said about all of them."""
        show_text(self.words, words)
        if (tuple(failures), fps) != (self.tree.cells.rows, self._fps):
            self._fps = fps
            with QSignalBlocker(self.tree.selectionModel()):
                self.tree.show_rows(tuple(failures))
            self._fit_tree()
        self.choose(chosen)

    def _fit_tree(self) -> None:
        """Let the list be as high as its rows, so that the evidence has the rest."""
        rows = max(len(self.tree.cells.rows), 1) + 1  # one spare: more may come
        row = max(self.tree.sizeHintForRow(0), self.tree.fontMetrics().height() + 2)
        self.tree.setMaximumHeight(self.tree.header().sizeHint().height() + rows * row)

    def choose(self, place: int) -> None:
        """Choose a row without a signal."""
        index = self.tree.sorted.mapFromSource(self.tree.cells.index(place, 0))
        with QSignalBlocker(self.tree.selectionModel()):
            self.tree.setCurrentIndex(index)
            self.tree.scrollTo(index)
        self.tree.viewport().update()
        failure = self.tree.cells.rows[place] if index.isValid() else None
        heading = _heading(failure, self._fps) if failure else ""
        self.evidence.show_words(heading, failure.verdict if failure else None)

    def _cells(self, failure: FailureSegment) -> Sequence[Cell]:
        tip = f"{_heading(failure, self._fps)} Double-click or press Enter to go there."
        confidence = failure.verdict.confidence
        sure = f"{100.0 * confidence:.0f}" if confidence > 0 else ""
        limb = LIMB_COLOURS[failure.peak_limb]
        peak = failure.peak if failure.measure == "error" else 100.0 * failure.peak
        shown, other = Cell(f"{peak:.0f}", tip, value=peak), Cell("", tip, value=-1.0)
        peaks = (shown if failure.measure == measure else other for measure in _PEAKS)
        return (
            Cell(f"{failure.first}–{failure.last}", tip, value=failure.first),
            Cell(limbs_words(failure.limbs), tip, swatch=limb),
            *peaks,
            Cell(CAUSE_WORDS[failure.verdict.cause], tip),
            Cell(sure, tip, value=confidence),
        )


def _heading(failure: FailureSegment, fps: float) -> str:
    chance = "" if failure.measure == "error" else " failure probability"
    return (
        f"Frames {failure.first} to {failure.last} ({len(failure.frames) / fps:.1f} s), detected "
        f"{FOUND_WORDS[failure.found]}: {limbs_words(failure.limbs)}, worst in frame "
        f"{failure.peak_frame} with {failure.peak_words}{chance}."
    )

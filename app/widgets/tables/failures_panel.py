"""The list of failures: a filter, a row for each, and what speaks for its cause."""

from collections.abc import Callable, Sequence
from html import escape

from PySide6.QtCore import QSignalBlocker, Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QTextBrowser, QWidget

from stereotrack_core.evaluation.failure_segments import segment

from ..forms.form_dialog import line_edit
from ..style.building import hbox, label, offer, parameter_links, show_text, splitter, vbox
from ..style.colours import LIMB_COLOURS
from .table import RIGHT, STRETCH, Cell, CellTable, Column

_NONE = (
    "Select a failure to see the evidence for its cause. Press Enter to go to its worst frame; "
    "Loop failure plays it in a loop."
)
_STRENGTH = "Evidence for causes, the strongest first. The bars show how strong it is."
_BAR = 8


class EvidenceView(QTextBrowser):
    """A heading, and a line for each piece of evidence.

    `show` is called with the name of a parameter whose link was clicked.
    """

    def __init__(self, show: Callable[[str], object]) -> None:
        super().__init__()
        self.setOpenLinks(False)
        self.anchorClicked.connect(lambda url: show(url.toString()))
        self.setAccessibleName("Evidence")
        self.setFrameShape(QTextBrowser.Shape.NoFrame)
        self.setMinimumHeight(80)
        self.show_words("", None)

    def show_words(self, heading: str, failure: segment.FailureSegment | None) -> None:
        """Show what is known of a failure and of its causes, or how to choose one."""
        lines = [escape(heading or _NONE)]
        if failure is not None:
            verdict, reason = failure.verdict, failure.reason
            if reason is not None:
                lines.append(f"<b>In frame {failure.first}: {escape(reason.words)}</b>")
            lines.append(parameter_links(failure.parameters))
            lines.append(_STRENGTH if verdict.evidence else "No evidence for a cause.")
            for one in verdict.evidence:
                full = round(_BAR * min(max(one.strength, 0.0), 1.0))
                bar = "█" * full + "░" * (_BAR - full)
                cause = escape(segment.CAUSE_WORDS[one.cause])
                name = f"<b>{cause}</b>" if one.cause == verdict.cause else cause
                lines.append(f"<tt>{bar}</tt> {name}: {escape(one.words)}")
        self.setHtml("".join(f"<p style='margin:0 0 4px 0'>{line}</p>" for line in lines))


_COLUMNS = (
    Column("Frames", "First and last frame", width=78),
    Column("Limbs", "Limbs that fail", width=STRETCH),
    Column(
        "Error °", "Largest error of one of the limbs, where a reference is known", RIGHT, width=54
    ),
    Column("Prob. %", "Largest failure probability of one of the limbs", RIGHT, width=54),
    Column("Probable cause", "The cause that most of the evidence speaks for"),
    Column("Why", "What the arm search did where it begins. Choose Find out why."),
)


class FailuresPanel(QWidget):
    """A filter above, the rows below, then words on the one that is chosen.

    `chosen` is called with the place of a row in what was handed on, -1 for none; `activated` when
    a row is double-clicked, or Enter pressed on it; `filtered` with words that rows shall have;
    `show` with the name of a parameter.
    """

    def __init__(
        self,
        chosen: Callable[[int], object],
        activated: Callable[[int], object],
        filtered: Callable[[str], object],
        show: Callable[[str], object],
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
        self.evidence = EvidenceView(show)
        both = splitter(Qt.Orientation.Vertical, (self.tree, 2), (self.evidence, 3))
        above = hbox(self.filter, margins=(6, 0, 6, 0))
        self._buttons = hbox(margins=(6, 0, 6, 0))
        parts = (above, self.words, self._buttons, (both, 1))
        self.setLayout(vbox(*parts, margins=(0, 4, 0, 0), spacing=4))
        self.show_rows((), 1.0, -1, "")

    def set_actions(self, actions: Sequence[QAction], buttons: Sequence[QAction]) -> None:
        """Offer commands in the list's context menu, some of them by buttons as well."""
        offer(self._buttons, buttons)
        self.tree.setContextMenuPolicy(Qt.ContextMenuPolicy.ActionsContextMenu)
        self.tree.addActions(actions)

    def show_rows(
        self, failures: Sequence[segment.FailureSegment], fps: float, chosen: int, words: str
    ) -> None:
        """Show these, one of them `chosen` or -1; `words` are said about all of them."""
        show_text(self.words, words)
        if (tuple(failures), fps) != (self.tree.cells.rows, self._fps):
            self._fps = fps
            with QSignalBlocker(self.tree.selectionModel()):
                self.tree.show_rows(tuple(failures))
            # as high as its rows, so that the evidence has the rest
            rows = max(len(failures), 1) + 1  # one spare: more may come
            row = max(self.tree.sizeHintForRow(0), self.tree.fontMetrics().height() + 2)
            self.tree.setMaximumHeight(self.tree.header().sizeHint().height() + rows * row)
        self.choose(chosen)

    def choose(self, place: int) -> None:
        """Choose a row without a signal."""
        index = self.tree.sorted.mapFromSource(self.tree.cells.index(place, 0))
        with QSignalBlocker(self.tree.selectionModel()):
            self.tree.setCurrentIndex(index)
            self.tree.scrollTo(index)
        self.tree.viewport().update()
        failure = self.tree.cells.rows[place] if index.isValid() else None
        heading = _heading(failure, self._fps) if failure else ""
        self.evidence.show_words(heading, failure)

    def _cells(self, failure: segment.FailureSegment) -> Sequence[Cell]:
        tip = f"{_heading(failure, self._fps)} Double-click or press Enter to go there."
        verdict, reason, limb = failure.verdict, failure.reason, LIMB_COLOURS[failure.peak_limb]
        sure = f" Confidence {100.0 * verdict.confidence:.0f} %." if verdict.confidence else ""
        values = failure.error_deg, failure.chance and 100.0 * failure.chance
        peaks = (
            Cell("", tip, value=-1.0) if value is None else Cell(f"{value:.0f}", tip, value=value)
            for value in values
        )
        return (
            Cell(f"{failure.first}–{failure.last}", tip, value=failure.first),
            Cell(segment.limbs_words(failure.limbs), tip, swatch=limb),
            *peaks,
            Cell(segment.CAUSE_WORDS[verdict.cause], f"{verdict.words}.{sure}"),
            Cell()
            if reason is None
            else Cell("correct" if reason.why == "right" else reason.brief, reason.words),
        )


def _heading(failure: segment.FailureSegment, fps: float) -> str:
    chance = "" if failure.measure == "error" else " failure probability"
    return (
        f"Frames {failure.first} to {failure.last} ({len(failure.frames) / fps:.1f} s), detected "
        f"{segment.FOUND_WORDS[failure.found]}: {segment.limbs_words(failure.limbs)}, worst in "
        f"frame {failure.peak_frame} with {failure.peak_words}{chance}."
    )

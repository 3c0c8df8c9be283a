"""Everything that looks wrong about the recording, with its remedy."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtWidgets import QTreeView, QWidget

from stereotrack_core.recording.findings import Finding

from ..style.building import label, vbox
from .table import TOP, Cell, Column, TableModel, dress_list

_ORDER = {"error": 0, "warning": 1, "note": 2}
_COLOURS = {"error": "error", "warning": "warning", "note": "muted"}


class FindingsPanel(QWidget):
    """A verdict in words, and below it each finding: where, what, and what to do."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.verdict = label(margins=(8, 6, 8, 6))
        columns = (Column("Run on", align=TOP), Column("Problem and remedy"))
        self.model = TableModel(columns, _cells)
        self.tree = QTreeView()
        self.tree.setModel(self.model)
        dress_list(self.tree, "Recording checks", (110, None))
        self.tree.setUniformRowHeights(False)
        self.tree.setWordWrap(True)
        self.setLayout(vbox(self.verdict, (self.tree, 1), spacing=0))

    def show_findings(self, findings: Sequence[Finding] | None) -> None:
        """Show what was found; None while it is still being looked for."""
        self.model.show(sorted(findings or (), key=lambda found: _ORDER[found.severity]))
        self.verdict.setText("Checking the recording …" if findings is None else verdict(findings))


def _cells(found: Finding) -> Sequence[Cell]:
    words = f"{found.what}\n{found.remedy}" if found.remedy else found.what
    return Cell(found.where, found.where, _COLOURS[found.severity]), Cell(words, words)


def verdict(findings: Sequence[Finding]) -> str:
    """Say in words how usable the recording is."""
    errors = sum(found.severity == "error" for found in findings)
    warnings = sum(found.severity == "warning" for found in findings)
    if errors:
        return f"Not usable yet: {_count(errors, 'error')}, {_count(warnings, 'warning')}."
    if warnings:
        return f"Usable, with {_count(warnings, 'warning')}."
    return "Usable; no problems found."


def _count(number: int, word: str) -> str:
    return f"{number} {word}{'' if number == 1 else 's'}"

"""Everything that looks wrong about the recording, with its remedy."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QEvent, Qt
from PySide6.QtGui import QColor
from PySide6.QtWidgets import (
    QHeaderView,
    QLabel,
    QTreeWidget,
    QTreeWidgetItem,
    QVBoxLayout,
    QWidget,
)

from stereotrack_core.recording.findings import Finding

from ..style.theme import current_theme

_ORDER = {"error": 0, "warning": 1, "note": 2}


class FindingsPanel(QWidget):
    """A verdict in words, and below it each finding: where, what, and what to do."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._findings: tuple[Finding, ...] = ()
        self.verdict = QLabel()
        self.verdict.setWordWrap(True)
        self.verdict.setContentsMargins(8, 6, 8, 6)
        self.tree = QTreeWidget()
        self.tree.setHeaderLabels(["Run on", "Problem and remedy"])
        self.tree.setRootIsDecorated(False)
        self.tree.setWordWrap(True)
        self.tree.setAccessibleName("Recording checks")
        header = self.tree.header()
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.Interactive)
        header.setSectionResizeMode(1, QHeaderView.ResizeMode.Stretch)
        self.tree.setColumnWidth(0, 110)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(0)
        layout.addWidget(self.verdict)
        layout.addWidget(self.tree, 1)

    def show_findings(self, findings: Sequence[Finding] | None) -> None:
        """Show what was found; None while it is still being looked for."""
        self.tree.clear()
        if findings is None:
            self._findings = ()
            self.verdict.setText("Checking the recording …")
            return
        self._findings = tuple(sorted(findings, key=lambda found: _ORDER[found.severity]))
        self.verdict.setText(verdict(self._findings))
        for found in self._findings:
            words = f"{found.what}\n{found.remedy}" if found.remedy else found.what
            item = QTreeWidgetItem([found.where, words])
            item.setToolTip(0, found.where)
            item.setToolTip(1, words)
            item.setTextAlignment(0, Qt.AlignmentFlag.AlignTop | Qt.AlignmentFlag.AlignLeft)
            self.tree.addTopLevelItem(item)
        self._dress()

    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange:
            self._dress()

    def _dress(self) -> None:
        theme = current_theme()
        colours = {"error": theme.error, "warning": theme.warning, "note": theme.muted}
        for row, found in enumerate(self._findings):
            item = self.tree.topLevelItem(row)
            if item is not None:
                item.setForeground(0, QColor(colours[found.severity]))


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

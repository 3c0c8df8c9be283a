"""How well two readings agree: the same person again, or somebody else's project."""

from __future__ import annotations

from PySide6.QtCore import Signal
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QDialog, QWidget

from ....widgets.forms.form_dialog import push_button
from ....widgets.style.building import hbox, label, vbox
from ....widgets.tables.agreement_table import AgreementTable
from .agreement import AgreementReport


class AgreementDialog(QDialog):
    """A verdict, what to do about it, and the numbers of each landmark."""

    other_project_requested = Signal()
    """The person wants to choose another project to compare with."""
    again_requested = Signal()
    """The person wants to see the frames that were annotated again."""
    differences_requested = Signal()
    """The person wants to look at every click that differs, and to merge."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle("Annotator agreement")
        self._words, self.verdict, self.remedy = label("", "muted"), label("", "heading"), label()
        again_button = push_button(
            "&Blind repeats",
            self.again_requested.emit,
            "Compare the first and second passes of the blind repeats",
        )
        self.other_button = push_button(
            "&Other project …",
            self.other_project_requested.emit,
            "Compare with another annotator's project of this recording",
        )
        self.table = AgreementTable()
        self.copy_button = push_button("&Copy table", self._copy)
        self.look_button = push_button("&Show differences …", self.differences_requested.emit)
        below = hbox(self.copy_button, self.look_button, None, push_button("Close", self.reject))
        top = hbox((self._words, 1), again_button, self.other_button)
        parts = (top, self.verdict, self.remedy, (self.table, 1), below)
        self.setLayout(vbox(*parts, margins=(9, 9, 9, 9)))
        self.resize(1020, 430)

    def show_report(self, compared: str, report: AgreementReport) -> None:
        """Show how well two readings agree; `compared` says which."""
        self._words.setText(compared)
        self.verdict.setText(report.verdict)
        self.remedy.setText(report.remedy)
        self.remedy.setVisible(bool(report.remedy))
        self.table.show_rows(report.rows)
        self.look_button.setEnabled(bool(report.found))

    def _copy(self) -> None:
        QGuiApplication.clipboard().setText(self.table.as_text())

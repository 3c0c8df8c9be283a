"""How well two readings agree: the same person again, or somebody else's project."""

from __future__ import annotations

from PySide6.QtCore import Signal
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from ....widgets.tables.agreement_table import AgreementTable
from .agreement import AgreementReport


class AgreementDialog(QDialog):
    """A verdict, what to do about it, and the numbers of each landmark.

    Signals
    -------
    other_project_requested : ()
        The person wants to choose another project to compare with.
    again_requested : ()
        The person wants to see the frames that were annotated again.
    differences_requested : ()
        The person wants to look at every click that differs, and to merge.
    """

    other_project_requested = Signal()
    again_requested = Signal()
    differences_requested = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle("Annotator agreement")
        self._words = QLabel()
        self._words.setProperty("role", "muted")
        self._words.setWordWrap(True)
        self.again_button = QPushButton("&Blind repeats")
        self.again_button.setToolTip("Compare the first and second passes of the blind repeats")
        self.other_button = QPushButton("&Other project …")
        self.other_button.setToolTip("Compare with another annotator's project of this recording")
        self.again_button.clicked.connect(self.again_requested)
        self.other_button.clicked.connect(self.other_project_requested)
        top = QHBoxLayout()
        top.addWidget(self._words, 1)
        top.addWidget(self.again_button)
        top.addWidget(self.other_button)
        self.verdict = QLabel()
        self.verdict.setProperty("role", "heading")
        self.verdict.setWordWrap(True)
        self.remedy = QLabel()
        self.remedy.setWordWrap(True)
        self.table = AgreementTable()
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        self.copy_button = buttons.addButton("&Copy table", QDialogButtonBox.ButtonRole.ActionRole)
        self.look_button = buttons.addButton(
            "&Show differences …", QDialogButtonBox.ButtonRole.ActionRole
        )
        self.copy_button.clicked.connect(self._copy)
        self.look_button.clicked.connect(self.differences_requested)
        buttons.rejected.connect(self.reject)
        for button in (self.again_button, self.other_button, self.copy_button, self.look_button):
            button.setAutoDefault(False)
        layout = QVBoxLayout(self)
        layout.addLayout(top)
        layout.addWidget(self.verdict)
        layout.addWidget(self.remedy)
        layout.addWidget(self.table, 1)
        layout.addWidget(buttons)
        self.resize(1020, 430)

    def show_report(self, compared: str, report: AgreementReport) -> None:
        """Show how well two readings agree.

        Parameters
        ----------
        compared : str
            What is compared, in words.
        report : AgreementReport
        """
        self._words.setText(compared)
        self.verdict.setText(report.verdict)
        self.remedy.setText(report.remedy)
        self.remedy.setVisible(bool(report.remedy))
        self.table.show_rows(report.rows)
        self.look_button.setEnabled(bool(report.found))

    def _copy(self) -> None:
        QGuiApplication.clipboard().setText(self.table.as_text())

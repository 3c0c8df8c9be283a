"""What to track of a study: settings of the parameter panel, seeds, processes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from PySide6.QtWidgets import QCheckBox, QFormLayout, QWidget

from stereotrack_core.counting import counted
from stereotrack_core.recording.selection import seeds_of
from stereotrack_core.study.run import StudyRequest, selection_of
from stereotrack_core.worker_processes import usable_cores

from ...widgets.forms.form_dialog import FormDialog, line_edit
from ...widgets.forms.numbers import WholeNumberField
from ...widgets.style.building import label

_NOTE = (
    "Runs are kept beside the study file. Those that are there and up to date are not computed "
    "again. Corrections of a project are applied, and no project is changed."
)


class TrackDialog(FormDialog):
    """Asks how to track recordings; `begin` is given the words of the command."""

    def __init__(
        self,
        study: Path,
        recordings: Sequence[str],
        of: int,
        settings: tuple[str, Sequence[str]],
        begin: Callable[[list[str]], object],
        parent: QWidget | None = None,
    ) -> None:
        super().__init__("Track recordings", "&Start", self._start, parent)
        self._study, self._recordings, self._of = study, tuple(recordings), of
        self._preset, self._changes = settings
        self._begin = begin
        self.seeds = line_edit("Seeds", "0", tip="Comma-separated; one run for each seed")
        self.processes = WholeNumberField(minimum=1, maximum=4 * usable_cores())
        self.processes.setValue(usable_cores())
        self.smooth = QCheckBox("S&mooth the runs")
        self.report = QCheckBox("Write a &page about every run")
        self.again = QCheckBox("Track &again what is there already")
        self.goes_on = QCheckBox("&Continue when the window is closed")
        changes = f", {', '.join(self._changes)}" if self._changes else ""
        form = QFormLayout()
        form.addRow("Recordings:", label(counted(len(self._recordings), "recording")))
        form.addRow("Parameter panel:", label(f"{self._preset}{changes}"))
        form.addRow("S&eeds:", self.seeds)
        form.addRow("&Processes:", self.processes)
        for box in (self.smooth, self.report, self.again, self.goes_on):
            form.addRow(box)
        self.lay_out(form, label(_NOTE, "muted"), size=(520, 320))

    def request(self) -> StudyRequest:
        """What the fields ask for. Raises InputError where seeds make no sense."""
        seeds = self.seeds.text().replace(" ", "")
        seeds_of(seeds)
        everything = len(self._recordings) == self._of
        return StudyRequest(
            self._study,
            select=() if everything else (selection_of(self._recordings),),
            preset=self._preset,
            changes=tuple(self._changes),
            seeds=seeds,
            smooth=self.smooth.isChecked(),
            workers=self.processes.value(),
            again=self.again.isChecked(),
        )

    def _start(self) -> None:
        found: list[str] = []
        if self.attempt(lambda: found.extend(self.request().arguments())):
            self._begin([*found, *(["--report"] if self.report.isChecked() else [])])
            self.accept()

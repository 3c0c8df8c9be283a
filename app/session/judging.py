"""Keeps the judgement of every run, computed when it has grown, a few times a second."""

from __future__ import annotations

from PySide6.QtCore import QObject, QTimer, Signal, Slot

from stereotrack_core.annotation.reference import Reference

from .document import DocumentPresenter
from .judgement import Judgement, judged
from .runs import RunEntry, RunList
from .truth import Against, Truth, project_truth, recorded_truth

_INTERVAL_MS = 250


class JudgementPresenter(QObject):
    """Judgements by run.

    Signals
    -------
    judged : ()
        Some judgement is new, or a run is shown in another way.
    truth_changed : ()
        Errors are measured against something else.
    """

    judged = Signal()
    truth_changed = Signal()

    def __init__(self, document: DocumentPresenter, runs: RunList, parent: QObject) -> None:
        super().__init__(parent)
        self._document, self._runs = document, runs
        self._known: dict[RunEntry, tuple[int, Truth | None, Judgement]] = {}
        self._wanted: Against | None = None
        self._recorded: Truth | None = None
        self._project: Truth | None = None
        self._told: Truth | None = None
        self._timer = QTimer(self, singleShot=True, interval=_INTERVAL_MS)
        self._timer.timeout.connect(self.judge)
        runs.grew.connect(self._on_grew)
        runs.changed.connect(self.judge)
        runs.active_changed.connect(self.judge)

    def of(self, entry: RunEntry | None) -> Judgement | None:
        """Judgement of a run, None where it has no frames yet."""
        known = self._known.get(entry) if entry is not None else None
        return known[-1] if known is not None else None

    def all(self) -> dict[RunEntry, Judgement]:
        """Judgements by run."""
        return {entry: known[-1] for entry, known in self._known.items()}

    # ---- what errors are measured against

    @property
    def truth(self) -> Truth | None:
        """The reference that is wanted, where it is there; else the recording's, or the project's.

        None where there is none: runs are judged by their own signs then.
        """
        recording = self._document.recording
        trajectory = recording.reference if recording is not None else None
        if self._recorded is None or self._recorded.trajectory is not trajectory:
            self._recorded = recorded_truth(trajectory)
        there = [self._recorded, self._project]
        if self._wanted == "project":
            there.reverse()
        return next((one for one in there if one is not None), None)

    def has(self, against: Against) -> bool:
        """Whether there is such a reference."""
        recording = self._document.recording
        if against == "project":
            return self._project is not None
        return recording is not None and recording.reference is not None

    def judge_against(self, wanted: Against | None) -> None:
        """Measure errors against the recording's or the project's reference, where it is there."""
        self._wanted = wanted
        self.judge()

    def set_project_reference(self, name: str, reference: Reference | None) -> None:
        """The project uses another reference, or none."""
        self._project = project_truth(name, reference) if reference is not None else None
        self.judge()

    # ---- judging

    def settled(self) -> bool:
        """Whether every run is judged as it is now."""
        return not self._timer.isActive()

    @Slot()
    def judge(self) -> None:
        """Judge what has grown."""
        self._timer.stop()
        truth = self.truth
        entries = self._runs.entries
        self._known = {entry: known for entry, known in self._known.items() if entry in entries}
        for entry in entries:
            count = len(entry.frames)
            known = self._known.get(entry)
            if count and (known is None or known[0] != count or known[1] is not truth):
                self._known[entry] = (count, truth, judged(entry, truth))
        self.judged.emit()
        if truth is not self._told:
            self._told = truth
            self.truth_changed.emit()

    @Slot()
    def _on_grew(self) -> None:
        if not self._timer.isActive():
            self._timer.start()

"""The report on the active run: asked for, made in the background, opened when wanted."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QObject, QUrl
from PySide6.QtGui import QDesktopServices

from stereotrack_core.report.pages import repeat_command, write_page
from stereotrack_core.report.reported import Source, gathered

from ..context import Context
from ..services.actions import Menu
from ..services.tasks.task import Task
from ..session.runs import RunEntry
from ..widgets.forms.form_dialog import ask_to_save
from ..widgets.forms.message import Message

_FILTER = "Page for a browser (*.html)"


class ReportController(QObject):
    """Writes reports."""

    def __init__(self, context: Context) -> None:
        super().__init__(context.session)
        self._context, self._session = context, context.session
        self._task: Task | None = None

    @property
    def working(self) -> bool:
        """Whether a report is being made."""
        return self._task is not None

    def ask_where(self) -> None:
        """Let the person choose where the report on the active run goes, and make it."""
        entry = self._session.runs.active
        if entry is None:
            return
        beside = entry.path.parent if entry.path is not None else Path.home()
        proposed = beside / f"report-{_file_name(entry.name)}.html"
        parent = self._context.docks.dialog_parent

        def make(path: Path) -> None:
            known = path.suffix.lower() in {".html", ".htm"}
            self.make(path if known else path.with_name(f"{path.name}.html"))

        ask_to_save(parent, "Save report", proposed, _FILTER, make)

    def make(self, path: Path) -> None:
        """Make the report on the active run in the background."""
        entry = self._session.runs.active
        source = self._source(entry) if entry is not None else None
        if source is None or self._task is not None:
            return

        def work(task: Task) -> Path:
            reported = gathered(source, on_progress=task.report, cancelled=task.token.cancelled)
            write_page(path, reported)
            return path

        self._task = self._context.tasks.begin("Writing report", work, self._on_made, promised=True)
        self._task.ended.connect(self._on_ended)

    def _source(self, entry: RunEntry) -> Source | None:
        recording, run = self._session.document.recording, entry.run()
        truth = self._session.judging.truth
        if recording is None or run is None:
            return None
        repeat = (
            repeat_command(recording.folder.name, str(entry.path)) if entry.path is not None else ""
        )
        note = entry.facts.note if entry.facts is not None else ""
        return Source(
            name=entry.name,
            run=run,
            recording=recording,
            reference=None if truth is None else truth.trajectory,
            reference_name="" if truth is None else truth.words,
            states=None if truth is None else truth.reference,
            repeat=repeat,
            note=note,
        )

    def _on_made(self, path: Path) -> None:
        def show() -> None:
            QDesktopServices.openUrl(QUrl.fromLocalFile(str(path)))

        self._context.notifier.show(
            Message("note", f"Report saved to {path}", button="Open", do=show)
        )

    def _on_ended(self) -> None:
        self._task = None


def register(context: Context) -> ReportController:
    """Offer reports."""
    reports = ReportController(context)

    def why_not() -> str:
        busy = "A report is already being written." if reports.working else ""
        return context.session.no_run() or busy

    report = Menu("&File", why_not).command(
        "report",
        "Report …",
        "Write a report on the active run as a web page: errors, curves, failures with "
        "images, calibration, parameters, and how to reproduce it.",
        reports.ask_where,
        "Ctrl+Shift+R",
        "export",
    )
    context.actions.add([report])
    return reports


def _file_name(name: str) -> str:
    """A run's name as part of a file's."""
    kept = "".join(letter if letter.isalnum() or letter in "-_." else "-" for letter in name)
    return kept.strip("-.") or "run"

"""The report on the active run: asked for, made in the background, opened when wanted."""

from pathlib import Path

from PySide6.QtCore import QUrl
from PySide6.QtGui import QDesktopServices

from stereotrack_core.report.pages import repeat_command, write_page
from stereotrack_core.report.reported import Source, gathered

from ..context import Context
from ..services.actions import Menu
from ..session.jobs import Job, NewestJob, Task
from ..session.messages import Message
from ..widgets.forms.form_dialog import ask_to_save

_FILTER = "Page for a browser (*.html)"


class ReportController:
    """Writes reports."""

    def __init__(self, context: Context) -> None:
        self._context, self._session = context, context.session
        self.job = NewestJob(context.tasks)

    def why_not(self) -> str:
        busy = "A report is already being written." if self.job.busy else ""
        return self._session.no_run() or busy

    def ask_where(self) -> None:
        entry = self._session.runs.active
        if entry is None:
            return
        beside = entry.path.parent if entry.path is not None else Path.home()
        kept = "".join(one if one.isalnum() or one in "-_." else "-" for one in entry.name)
        proposed = beside / f"report-{kept.strip('-.') or 'run'}.html"

        def make(path: Path) -> None:
            known = path.suffix.lower() in {".html", ".htm"}
            self.make(path if known else path.with_name(f"{path.name}.html"))

        ask_to_save(self._context.docks.dialog_parent, "Save report", proposed, _FILTER, make)

    def make(self, path: Path) -> None:
        source = self._source()
        if source is None or self.job.busy:
            return

        def work(task: Task) -> None:
            reported = gathered(source, on_progress=task.report, cancelled=task.token.cancelled)
            write_page(path, reported)

        def show() -> None:
            QDesktopServices.openUrl(QUrl.fromLocalFile(str(path)))

        def done(_: None) -> None:
            message = Message("note", f"Report saved to {path}", button="Open", do=show)
            self._context.notifier.show(message)

        self.job.run(Job("Writing report", work, done), promised=True)

    def _source(self) -> Source | None:
        """The active run and what it is measured against; None where it cannot be put together."""
        entry, recording = self._session.runs.active, self._session.document.recording
        run = None if entry is None else entry.run()
        if entry is None or recording is None or run is None:
            return None
        truth, file = self._session.judging.truth, entry.path
        return Source(
            name=entry.name, run=run, recording=recording,
            reference=None if truth is None else truth.trajectory,
            reference_name="" if truth is None else truth.words,
            states=None if truth is None else truth.reference,
            repeat="" if file is None else repeat_command(recording.folder.name, str(file)),
        )  # fmt: skip


def register(context: Context) -> ReportController:
    """Offer reports."""
    reports = ReportController(context)
    report = Menu("&File", reports.why_not).command(
        "report", "Report …", "Write a report on the active run as a web page: errors, curves, "
        "failures with images, parameters, and how to reproduce it.", reports.ask_where,
        "Ctrl+Shift+R", "export",
    )  # fmt: skip
    context.actions.add([report])
    return reports

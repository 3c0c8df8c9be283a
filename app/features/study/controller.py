"""Studies in the window: one study is open, its edits are saved at once, its work is one task."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from PySide6.QtWidgets import QAbstractItemView, QFileDialog

from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.study import description
from stereotrack_core.study.run import Outcome, plan_study, run_study
from stereotrack_core.study.status import RowStatus, study_status
from stereotrack_core.study.store import stored_results
from stereotrack_core.study.workers import LocalWorkers

from ...context import Context
from ...services.actions import Menu
from ...session.changes import Part
from ...session.jobs import Job, NewestJob, Task
from ...widgets.forms.form_dialog import ask_to_open, ask_to_save
from .results import ResultsPanel
from .settings_form import SettingsForm, apply_to_panel, panel_settings, study_of_open
from .window import StudyWindow

_FILTER = f"Study (*{description.SUFFIX})"


def register(context: Context) -> StudyController:
    """Offer studies."""
    studies = StudyController(context)
    file, track = Menu("&File").command, Menu("&Track", context.session.no_recording).command
    context.actions.add([
        file("new_study", "New study …", "Make a study file (.study.toml): recordings with their "
             "subjects and conditions, and the settings that all are tracked with.",
             studies.ask_for_new, "Ctrl+Alt+Shift+N", "add", section=True),
        file("open_study", "Open a study …", "Show the recordings of a study file (.study.toml) "
             "in one table: annotation, runs, errors, failures and problems. Track and evaluate "
             "them together.", studies.ask_for_study, "Ctrl+Alt+Shift+O", "table"),
        track("sweep", "Sweep …", "Track the open recording with several parameter values and "
              "seeds in the background, and compare the results: a study of one recording.",
              studies.sweep, "Ctrl+Alt+S", "grid", section=True),
    ])  # fmt: skip
    return studies


class StudyController:
    """Opens a study, keeps its table up to date, and does what a person wants with its rows."""

    def __init__(self, context: Context) -> None:
        self._context, self._session = context, context.session
        self._job, self._reads = NewestJob(context.tasks), False
        self._content = b""
        self.window: StudyWindow | None = None
        context.session.changes.hear(Part.STUDY_WANTED, self.open_study)

    @property
    def working(self) -> bool:
        return self._job.busy

    @property
    def _busy(self) -> bool:
        return self._job.busy and not self._reads

    # ---- which study

    def ask_for_study(self) -> None:
        parent = self._context.docks.dialog_parent
        ask_to_open(parent, "Open a study", self._folder(), _FILTER, self.open_study)

    def ask_for_new(self) -> None:
        """Let the person choose where a new study is kept, and show it; nothing is overwritten."""
        folder, parent = self._folder(), self._context.docks.dialog_parent
        proposed = folder / f"{folder.name or 'walks'}{description.SUFFIX}"
        ask_to_save(parent, "New study", proposed, _FILTER, self.new_study, goes_on=True)

    def new_study(self, path: Path) -> None:
        path = path.with_name(
            path.name.removesuffix(".toml").removesuffix(".study") + description.SUFFIX
        )
        study = description.Study(
            path, settings=panel_settings(self._session, description.StudySettings())
        )
        if path.exists() or self._context.notifier.attempt(lambda: description.write_study(study)):
            self.open_study(path)

    def sweep(self) -> None:
        """Show a study of the open recording alone, which is made if there is none yet."""
        recording = self._session.document.recording
        if recording is None:
            return
        folder = recording.folder.resolve()
        beside = folder.parent if os.access(folder.parent, os.W_OK) else Path.home()
        path = beside / f"{folder.name}-sweep{description.SUFFIX}"
        made = study_of_open(self._context, path)
        if path.exists() or self._context.notifier.attempt(lambda: description.write_study(made)):
            self.open_study(path)
            if self.window is not None:
                self.window.tabs.setCurrentWidget(self.window.form)

    def open_study(self, path: Path) -> None:
        if self._busy:
            words = "A study is at work. Wait, or stop it before another one is opened."
            self._context.notifier.say(words, 6000)
            return
        shown = self._context.notifier.attempt(partial(self._read, path.resolve()))
        if shown and self.window is not None:
            self.window.say("")
            self.window.show()
            self.window.raise_()
            self.refresh()

    def _read(self, path: Path) -> None:
        study = description.read_study(path)
        self._content = _content(study.path)
        if self.window is None:
            self.window = self._made()
        self.window.show_study(study, [RowStatus(row) for row in study.rows])

    def _folder(self) -> Path:
        if self.window is not None:
            return self.window.study.folder
        recording = self._session.document.recording
        return Path.home() if recording is None else recording.folder.resolve().parent

    def _made(self) -> StudyWindow:
        do: dict[str, Callable[[], object]] = {
            "open": self._open_row, "track": lambda: self.track(window.chosen()),
            "refresh": self.refresh, "stop": self.stop, "add": self._ask_for_folders,
            "remove": lambda: self.remove([row.row.recording for row in window.selected()]),
        }  # fmt: skip
        form = SettingsForm(self._take_panel)
        results = ResultsPanel(partial(apply_to_panel, self._context))
        window = StudyWindow(do, form, results, self._context.docks.dialog_parent)
        return window

    # ---- edits

    def edit(self, change: Callable[[description.Study], description.Study]) -> bool:
        """Make an edit and save it; what another program has written is never overwritten."""
        window = self.window
        if window is None:
            return False
        try:
            study = change(window.study)
            if study == window.study:
                return True
            if _content(study.path) != self._content:
                raise InputError(
                    "another program has changed the study file, so nothing was written",
                    where=str(study.path),
                    remedy="Refresh reads it again; then make the edit again.",
                )
            description.write_study(study)
        except InputError as error:
            window.say(str(error), error=True)
            return False
        self._content = _content(study.path)
        known = {row.row.recording: row for row in window.rows}
        rows = [
            replace(known[row.recording], row=row) if row.recording in known else RowStatus(row)
            for row in study.rows
        ]
        window.show_study(study, rows)
        return True

    def remove(self, recordings: Sequence[str]) -> None:
        def without(study: description.Study) -> description.Study:
            left = [row for row in study.rows if row.recording not in recordings]
            return replace(study, rows=tuple(left))

        if self.edit(without) and self.window is not None:
            count = counted(len(recordings), "recording")
            self.window.say(f"{count} removed from the study. No file was deleted.")

    def _ask_for_folders(self) -> None:
        """Let the person choose several folders at once, which no dialog of the system offers."""
        if self.window is None:
            return
        title, start = "Add folders with recordings", str(self.window.study.folder)
        dialog = QFileDialog(self.window, title, start)
        dialog.setFileMode(QFileDialog.FileMode.Directory)
        dialog.setOption(QFileDialog.Option.DontUseNativeDialog)
        for view in dialog.findChildren(QAbstractItemView):
            if view.objectName() in ("listView", "treeView"):
                view.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        dialog.filesSelected.connect(lambda chosen: self.add(tuple(map(Path, chosen))))
        dialog.open()

    def add(self, folders: Sequence[Path]) -> None:
        window = self.window
        if window is None or self._busy:
            return
        study = window.study

        def look(task: Task) -> description.Listed:
            return description.with_recordings(study, folders, cancelled=task.token.cancelled)

        def done(listed: description.Listed) -> None:
            if self.edit(lambda _: listed.study):
                window.say(f"{counted(len(listed.added), 'recording')} added.")
                window.select(listed.added)

        self._begin("looking for recordings", look, done)

    def _take_panel(self) -> None:
        window = self.window
        if window is not None:
            settings = panel_settings(self._session, window.form.settings())
            self.edit(lambda study: replace(study, settings=settings))

    # ---- work

    def refresh(self) -> None:
        window = self.window
        if window is None or self._busy:
            return
        if _content(window.study.path) != self._content:
            try:
                self._read(window.study.path)
            except InputError as error:
                window.say(str(error), error=True)
                return
        study = window.study

        def read(task: Task) -> None:
            study_status(
                study, study.rows, stored_results(study.table), on_row=task.tell,
                on_progress=task.report, cancelled=task.token.cancelled,
            )  # fmt: skip

        self._begin("reading the study", read, reads=True)

    def track(self, recordings: Sequence[str]) -> None:
        window = self.window
        if window is None or self._busy:
            return
        try:
            settings = window.form.settings()
        except InputError as error:
            window.say(str(error), error=True)
            return
        if not self.edit(lambda study: replace(study, settings=settings)):
            return
        study, processes = window.study, window.form.processes.value()
        rows = [row for row in study.rows if row.recording in recordings]

        def work(task: Task) -> tuple[Outcome, int]:
            stopped = task.token.cancelled
            plan = plan_study(study, rows, on_progress=task.report, cancelled=stopped)
            workers = LocalWorkers(processes)
            outcome, results = run_study(
                study, plan.jobs, workers, on_progress=task.report, cancelled=stopped
            )
            known = [results.get(job.identity) for job in plan.jobs]
            failed = sum(one is not None and not one.done for one in known)
            return outcome, failed + len(plan.left_out)

        self._begin("tracking the study", work, self._on_tracked)

    def _on_tracked(self, done: tuple[Outcome, int]) -> None:
        outcome, failed = done
        words = f"{counted(outcome.computed, 'run')} computed, {outcome.reused} there already"
        if failed:
            words += f", {failed} failed; select a recording to see why"
        if outcome.stopped:
            words = f"Stopped. Finished runs are kept; Track goes on. {words}"
        if self.window is not None:
            self.window.say(f"{words}.")
        self._context.notifier.say(f"Study: {words}.", 10_000)

    def _begin(
        self,
        title: str,
        work: Callable[[Task], Any],
        done: Callable[[Any], object] = lambda _: None,
        *,
        reads: bool = False,
    ) -> None:
        """Start the one task of the study; reading is stopped for it."""
        self._reads = reads
        self._job.run(
            Job(
                title,
                work,
                done,
                self._tell,
                ended=self._on_ended,
                told=self._show_rows,
                progressed=partial(self._show_progress, title.capitalize()),
            )
        )
        if self.window is not None and not reads:
            self.window.show_working(title)

    def stop(self) -> None:
        self._job.cancel()

    def _show_rows(self, rows: list[RowStatus]) -> None:
        if self.window is not None:
            for row in rows:
                self.window.show_row(row)

    def _show_progress(self, title: str, share: float, words: str) -> None:
        if self.window is not None and not self._reads:
            self.window.show_progress(f"{title}: {words}", share)

    def _tell(self, error: Exception) -> None:
        if self.window is not None and isinstance(error, InputError):
            self.window.say(str(error), error=True)
        else:
            self._context.notifier.error(error)

    def _on_ended(self) -> None:
        if self.window is not None:
            self.window.show_working("")
            if not self._reads:
                self.refresh()

    def _open_row(self) -> None:
        rows = self.window.selected() if self.window is not None else []
        if self.window is not None and rows:
            row, study = rows[0].row, self.window.study
            self._session.open(study.place(row.project or row.recording))
            self._context.docks.dialog_parent.window().raise_()


def _content(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError:
        return b""

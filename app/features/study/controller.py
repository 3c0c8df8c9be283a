"""Studies in the window: their table, and work on them by processes of their own."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

from PySide6.QtCore import QObject, Qt, QUrl, Slot
from PySide6.QtGui import QDesktopServices

from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.parameters import value_text
from stereotrack_core.study.create import Found
from stereotrack_core.study.file import SUFFIX
from stereotrack_core.study.run import places_of
from stereotrack_core.study.status import RowStatus
from stereotrack_core.study.stored import StoredStudy
from stereotrack_core.study.tasks import (
    ExportResults,
    FindRecordings,
    ReadStatus,
    Remembered,
    Share,
    WritePages,
    remembered,
)
from stereotrack_core.task_process import TaskProcess
from stereotrack_core.tracking.presets import preset

from ...context import Context
from ...services.tasks.task import Task
from ...session.sweeping import SweepNow, SweepPresenter
from ...widgets.forms.form_dialog import ask_to_open, ask_to_save
from ...widgets.forms.message import Message
from .editing import StudyEditing
from .rows import is_unread
from .track_dialog import TrackDialog
from .window import StudyWindow

_SAID_MS = 10_000
_BUSY = "Something is being written or looked for. Wait, or stop it."
_FILTER = f"Study (*{SUFFIX})"
_TABLES = "Table (*.csv);;Parquet (*.parquet)"


class StudyController(QObject):
    """Opens a study, keeps its table up to date, and does what a person wants with its rows."""

    def __init__(self, context: Context) -> None:
        super().__init__(context.session)
        self._context, self._session = context, context.session
        self._process = TaskProcess()
        self._task: Task | None = None
        self._reading = self._read_again = self._reopening = False
        self._tracked = ""
        self.window: StudyWindow | None = None
        self.editing: StudyEditing | None = None
        self.presenter = SweepPresenter(context.settings, self, "study")
        self.presenter.changed.connect(self._on_tracking)
        context.session.opening.study_wanted.connect(self.open_study)
        context.session.closing.connect(self.presenter.leave)
        context.session.closing.connect(self._process.close)

    @property
    def working(self) -> bool:
        """Whether something is being read or written."""
        return self._task is not None

    def ask_for_study(self) -> None:
        """Let the person choose a study file."""
        parent = self._context.docks.dialog_parent
        ask_to_open(parent, "Open a study", self._last_folder(), _FILTER, self.open_study)

    def ask_for_new(self) -> None:
        """Let the person choose where a new study is kept, and show it; nothing is overwritten."""
        start = self._last_folder()
        parent = self._context.docks.dialog_parent
        proposed = start / f"{start.name or 'walks'}{SUFFIX}"
        ask_to_save(parent, "New study", proposed, _FILTER, self.new_study, goes_on=True)

    def _last_folder(self) -> Path:
        """Where studies are, as far as that is known."""
        if self.window is not None:
            return self.window.study.folder
        table, recording = self.presenter.last_table, self._session.document.recording
        if table is not None:
            return table.parent.parent
        return Path.home() if recording is None else recording.folder.resolve().parent

    def new_study(self, path: Path) -> None:
        """Write a study without recordings and show it."""
        stem = path.name.removesuffix(".csv").removesuffix(".study")
        named = path.with_name(f"{stem}{SUFFIX}")
        if self._context.notifier.attempt(lambda: StoredStudy.new(named)):
            self.open_study(named)

    @Slot(object)
    def open_study(self, path: Path) -> None:
        """Show what is remembered of a study at once, and read what has changed."""
        path = path.resolve()
        task = self._context.tasks
        task.begin(f"opening {path.name}", lambda _: remembered(path), self._show)

    @Slot(object)
    def _show(self, found: Remembered) -> None:
        if self.window is None:
            self.window = self._made()
        self._give_up()
        self._put(found)
        self.window.show()
        self.window.raise_()
        self.window.activateWindow()
        self.refresh()

    def _put(self, found: Remembered) -> None:
        if self.window is not None and self.editing is not None:
            self.editing.editor.show(found.stored)
            self.window.show_study(found.study, found.rows)

    def _made(self) -> StudyWindow:
        window = StudyWindow(self._context.docks.dialog_parent)
        window.open_wanted.connect(self._open_row)
        window.track_wanted.connect(self._ask_how_to_track)
        window.pages_wanted.connect(self._write_pages)
        window.export_wanted.connect(self._ask_where_to_export)
        window.refresh_wanted.connect(self.refresh)
        window.stop_wanted.connect(self._stop)
        window.came_back.connect(self._look)
        self.editing = StudyEditing(window, self._context.settings)
        self.editing.add_wanted.connect(self._add)
        self.editing.editor.changed.connect(self._read_what_is_new)
        return window

    # ---- edits, and what others wrote

    @Slot(object)
    def _add(self, paths: tuple[Path, ...]) -> None:
        """Look for the recordings of folders and projects, and add them."""
        if self.window is not None:
            study = self.window.study.path
            todo = FindRecordings(study, tuple(sorted(path.resolve() for path in paths)))
            self._begin("looking for recordings", todo, partial(self._on_found, study))

    def _on_found(self, path: Path, found: Found) -> None:
        if self.editing is not None and self.editing.editor.study.path == path:
            self._say("")
            self.editing.add(found)

    @Slot()
    def _read_what_is_new(self) -> None:
        if self.window is not None and any(map(is_unread, self.window.rows)):
            self.refresh()

    @Slot()
    def _look(self) -> None:
        """Read a study that another program has changed, when a person comes back to it."""
        editing = self.editing
        if editing is not None and self._task is None and not editing.editor.is_current:
            self.refresh()

    def _reopen(self, path: Path) -> None:
        if self._reopening:
            return
        self._reopening = True
        task = Task(f"opening {path.name}", lambda _: remembered(path))
        task.finished.connect(partial(self._take_over, path))
        task.failed.connect(self._on_unreadable)
        task.ended.connect(self._on_reopened)
        self._context.tasks.start(task)

    @Slot()
    def _on_reopened(self) -> None:
        self._reopening = False

    def _take_over(self, path: Path, found: Remembered) -> None:
        """Show a study that another program has changed."""
        editing, window = self.editing, self.window
        if editing is None or window is None or window.study.path != path:
            return
        lost = editing.editor.stack.to_undo() is not None
        self._put(found)
        more = " Edits before that can no longer be undone." if lost else ""
        window.say(f"Another program has changed the study file; it was read again.{more}")
        self.refresh()

    def _on_unreadable(self, error: Exception) -> None:
        if self.window is None or not isinstance(error, InputError):
            self._context.notifier.error(error)
        else:
            self.window.say(str(error), error=True)

    # ---- work in a process

    @Slot()
    def refresh(self) -> None:
        """Read what has changed of the study, evaluate new runs, and show it row by row."""
        window, editing = self.window, self.editing
        if window is None or editing is None:
            return
        path = window.study.path
        if not editing.editor.is_current:
            self._reopen(path)
        elif self._task is None:
            self._begin("reading the study", ReadStatus(path), self._on_read)
            self._reading = True
            self._show_working()
        else:
            self._read_again = True

    @Slot(object)
    def _write_pages(self, recordings: tuple[str, ...]) -> None:
        if self.window is not None:
            todo = WritePages(self.window.study.path, recordings)
            self._begin("writing pages", todo, self._on_pages)

    @Slot(object)
    def _ask_where_to_export(self, recordings: tuple[str, ...]) -> None:
        window = self.window
        if window is None:
            return
        study = window.study

        def export(path: Path) -> None:
            target = path if path.suffix else path.with_suffix(".csv")
            todo = ExportResults(study.path, recordings, target)
            self._begin("exporting results", todo, partial(self._on_exported, target))

        proposed = study.folder / f"{study.stem}-results.csv"
        ask_to_save(window, "Export table", proposed, _TABLES, export)

    def _begin(self, title: str, todo: Any, done: Any) -> None:
        """Have something done by the process; what it tells is shown. Reading is given up for it,
        and begins again when it is done.
        """
        if self._reading:
            self._give_up()
            self._read_again = True
        if self._task is not None:
            return
        process = self._process
        task = Task(title, lambda task: process(todo, task.tell, task.token.cancelled))
        task.told.connect(self._on_told)
        task.finished.connect(done)
        task.failed.connect(self._on_failed)
        task.stopped.connect(self._on_stopped)
        task.ended.connect(self._on_ended)
        self._task = task
        self._context.tasks.start(task)
        self._show_working()

    @Slot(list)
    def _on_told(self, words: list[Any]) -> None:
        if self.window is None or self.sender() is not self._task:
            return
        self.window.take([word for word in words if isinstance(word, RowStatus)])
        shares = [word for word in words if isinstance(word, Share)]
        if shares and self._task is not None:
            title = self._task.title.capitalize()
            self._task.report(shares[-1].share, shares[-1].words)
            self.window.show_work(f"{title}: {shares[-1].words}", shares[-1].share)

    @Slot(object)
    def _on_read(self, _: object) -> None:
        self._say(self._tracked)
        self._tracked = ""

    @Slot(object)
    def _on_pages(self, pages: tuple[Path, ...]) -> None:
        first = pages[0]
        said = f"{counted(len(pages), 'page')} beside the runs, such as {first}"
        self._say(f"{said}.")

        def show() -> None:
            QDesktopServices.openUrl(QUrl.fromLocalFile(str(first)))

        self._context.notifier.show(Message("note", said, button="Open", do=show))

    def _on_exported(self, target: Path, rows: int) -> None:
        self._say(f"{counted(rows, 'value')} written to {target}.")

    @Slot(object)
    def _on_failed(self, error: Exception) -> None:
        if self.window is None or not isinstance(error, InputError):
            self._context.notifier.error(error)
        else:
            self.window.show_work(str(error), error=True)

    @Slot()
    def _on_stopped(self) -> None:
        if self.sender() is self._task:
            self._say("Stopped. What was read is remembered.")

    @Slot()
    def _on_ended(self) -> None:
        if self.sender() is not self._task:
            return
        self._task, self._reading = None, False
        self._show_working()
        if self._read_again:
            self._read_again = False
            self.refresh()

    def _give_up(self) -> None:
        """Leave what is being done for something else, or for another study."""
        if self._task is not None:
            self._task.cancel()
        self._task, self._reading, self._read_again = None, False, False

    @Slot()
    def _stop(self) -> None:
        self._read_again = False
        if self._task is not None:
            self._task.cancel()
        self.presenter.stop()

    # ---- opening and tracking

    @Slot(object)
    def _open_row(self, row: RowStatus) -> None:
        """Open the project of a row, or its recording where there is none."""
        place = row.place.project or row.place.folder
        if place is not None:
            self._session.opening.open(place)
            self._context.docks.dialog_parent.window().raise_()

    @Slot(object)
    def _ask_how_to_track(self, recordings: tuple[str, ...]) -> None:
        window = self.window
        if window is None or not recordings:
            return
        study, track = window.study, self._session.track
        base = preset(track.preset).values()
        changes = [
            f"{name}={value!r}" if isinstance(value, float) else f"{name}={value_text(value)}"
            for name, value in track.settings.values().items()
            if value != base[name]
        ]
        settings = (track.preset, changes)
        dialog = TrackDialog(study.path, recordings, len(study.rows), settings, self.track, window)
        dialog.goes_on.setChecked(self.presenter.goes_on)
        dialog.goes_on.toggled.connect(self._on_goes_on)
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.open()

    @Slot(bool)
    def _on_goes_on(self, wanted: bool) -> None:
        self.presenter.goes_on = wanted

    def track(self, arguments: list[str]) -> None:
        """Track with the words of a command, in processes of their own."""
        if self.window is None or self.presenter.now.going:
            return
        try:
            places = places_of(self.window.study)
        except InputError as error:
            self.window.show_work(str(error), error=True)
            return
        self.presenter.begin(arguments, places.table)
        self._show_working()

    @Slot(object)
    def _on_tracking(self, now: SweepNow) -> None:
        """Show how tracking goes; when it has ended, read the new runs."""
        self._show_working()
        if now.going:
            self._say(f"Tracking: {now.words}", now.share)
            return
        self._context.notifier.say(f"Study: {now.words}", _SAID_MS)
        if self.window is not None:
            self.window.show_work(now.words, 1.0, error=now.phase == "failed")
            if now.phase != "failed":
                self._tracked = now.words
                self.refresh()

    def _say(self, words: str, share: float = 1.0) -> None:
        if self.window is not None:
            self.window.show_work(words or None, share)

    def _show_working(self) -> None:
        if self.window is not None:
            self.window.show_working(reading=self.working, tracking=self.presenter.now.going)
        if self.editing is not None:
            busy = self.working and not self._reading
            self.editing.busy = _BUSY if busy else ""
            self.editing.refresh()

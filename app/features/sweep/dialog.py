"""The dialog of a sweep: fields, what they come to, and how it is going."""

from __future__ import annotations

import json
import os
import subprocess
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

from PySide6.QtCore import QTimer, Signal, Slot
from PySide6.QtWidgets import QCheckBox, QDialogButtonBox, QProgressBar, QWidget

from stereotrack_core.counting import counted, in_words
from stereotrack_core.errors import InputError
from stereotrack_core.experiments.sweep.plan import SweepCount, SweepPlan, count_of
from stereotrack_core.experiments.sweep.points import SweepRequest
from stereotrack_core.experiments.sweep.store import SweepPlaces, stored_results
from stereotrack_core.own_program import BOUND, program_command
from stereotrack_core.recording.folder import open_recordings

from ...services.tasks.task import Task, TaskList
from ...session.sweeping import SweepNow, SweepPresenter
from ...widgets.forms.form_dialog import FormDialog, push_button
from ...widgets.style.building import hbox, label
from .form import SweepForm

_COUNT_AFTER_MS = 350
_LOOK_SECONDS = 0.1
_NOTE = (
    "Results already in the table are not computed again. Recordings are read from their "
    "folders; corrections stored in a project are not applied."
)


class SweepDialog(FormDialog):
    """Asks what to sweep, says what it comes to, begins, follows and stops it.

    Parameters
    ----------
    tasks : TaskList
        Where jobs are counted.
    """

    results_wanted = Signal(object)
    """Path: the person wants to look at a table."""

    def __init__(
        self, presenter: SweepPresenter, tasks: TaskList, parent: QWidget | None = None
    ) -> None:
        super().__init__("Sweep", "&Start", self._begin, parent, close=True, by_return=False)
        self._presenter, self._tasks = presenter, tasks
        self._counting: Task | None = None
        self._count_again = False
        self.form = SweepForm()
        self.count_label, self.error_label = label("", "heading"), label("", "error")
        self.progress = QProgressBar(minimum=0, maximum=1000, textVisible=False)
        self.goes_on = QCheckBox("&Continue when the window is closed")
        self.goes_on.setChecked(presenter.goes_on)
        self.goes_on.toggled.connect(self._on_goes_on)
        tip = "Track some frames of one run to estimate the total time"
        self.measure_button = push_button("&Estimate time", self._measure, tip)
        self.measure_button.hide()
        count, note = hbox((self.count_label, 1), self.measure_button), label(_NOTE, "muted")
        self.stop_button = push_button("&Stop", presenter.stop)
        self.results_button = push_button("&Results …", self._want_results)
        for button in (self.stop_button, self.results_button):
            self.buttons.addButton(button, QDialogButtonBox.ButtonRole.ActionRole)
        parts = (count, self.error_label, self.progress, self.goes_on, note)
        self.lay_out((self.form, 1), *parts, size=(980, 620))
        self._timer = QTimer(self, singleShot=True, interval=_COUNT_AFTER_MS)
        self._timer.timeout.connect(self._count)
        self.form.changed.connect(self._count_soon)
        presenter.changed.connect(self._show_now)
        self._show_now(presenter.now)

    @property
    def settled(self) -> bool:
        """Whether jobs are counted as the fields say."""
        return self._counting is None and not self._timer.isActive()

    # ---- counting

    @Slot()
    def _count_soon(self) -> None:
        """Count when nothing is typed for a moment; what was counted before is greyed."""
        self.count_label.setEnabled(False)
        self._timer.start()

    @Slot()
    def _count(self) -> None:
        """Count the jobs off the window's thread; the newest fields win."""
        if self._counting is not None:
            self._count_again = True
            return
        self._count_again = False
        request = self._request()
        if request is None:
            return

        def count(_task: Task) -> SweepCount | InputError:
            try:
                return counted_jobs(request)
            except InputError as error:
                return error

        self._counting = self._tasks.begin("counting runs of the sweep", count, self._on_counted)
        self._counting.ended.connect(self._on_count_ended)

    def _request(self) -> SweepRequest | None:
        """What the fields ask for; None where something is missing, which is said."""
        try:
            return self.form.request()
        except InputError as error:
            self._on_counted(error)
            return None

    @Slot(object)
    def _on_counted(self, found: SweepCount | InputError) -> None:
        wrong = isinstance(found, InputError)
        self.error_label.setText(str(found) if wrong else "")
        self.error_label.setVisible(wrong)
        self.count_label.setVisible(not wrong)
        unknown = False
        if isinstance(found, SweepCount):
            cluster = self.form.cluster.isChecked()
            self.count_label.setText(count_words(found, cluster=cluster))
            unknown = found.seconds is None and not cluster
        self.measure_button.setVisible(unknown)
        self.accept_button.setEnabled(not wrong and not self._presenter.now.going)

    @Slot()
    def _on_count_ended(self) -> None:
        self._counting = None
        if self._count_again:
            self._count()
        else:
            self.count_label.setEnabled(not self._timer.isActive())

    @Slot()
    def _measure(self) -> None:
        """Track some frames in another process to learn how long the sweep takes."""
        request = self._request()
        if request is None:
            return
        self.measure_button.setEnabled(False)
        task = self._tasks.begin(
            "estimating the time of the sweep",
            lambda task: measured_seconds(request, task.token.cancelled),
            partial(self._on_measured, request),
        )
        task.ended.connect(lambda: self.measure_button.setEnabled(True))

    def _on_measured(self, request: SweepRequest, seconds: float | None) -> None:
        if seconds is not None and request == self._request():
            said = self.count_label.text().partition(". Duration")[0]
            self.count_label.setText(f"{said}. Estimated time: {in_words(seconds)}.")
            self.measure_button.hide()

    # ---- running

    @Slot()
    def _begin(self) -> None:
        request = self._request()
        if request is not None:
            self._presenter.begin(request.arguments(), request.table)

    @Slot(object)
    def _show_now(self, now: SweepNow) -> None:
        self.progress.setVisible(now.going)
        self.progress.setValue(round(1000 * now.share))
        self.say(now.words, error=now.phase == "failed")
        self.stop_button.setEnabled(now.phase == "running")
        self.accept_button.setEnabled(not now.going and not self.error_label.text())
        self.results_button.setEnabled(self._table() is not None)
        if not now.going:
            self._timer.start()

    def _table(self) -> Path | None:
        """The table to look at: the one that is written, else the one that is named."""
        now = self._presenter.now
        table = now.table if now.going else Path(self.form.table.text().strip() or ".")
        return table if table is not None and table.is_file() else None

    @Slot()
    def _want_results(self) -> None:
        table = self._table()
        if table is not None:
            self.results_wanted.emit(table)

    @Slot(bool)
    def _on_goes_on(self, wanted: bool) -> None:
        self._presenter.goes_on = wanted


def counted_jobs(request: SweepRequest) -> SweepCount:
    """What a sweep would compute; takes as long as looking at the recordings does.

    Raises
    ------
    InputError
        Where something cannot be meant.
    """
    request.check()
    jobs = SweepPlan(request, open_recordings(request.recordings)).jobs_to_count()
    return count_of(jobs, stored_results(SweepPlaces(request.table)), request.workers or 1)[0]


def measured_seconds(request: SweepRequest, cancelled: Callable[[], bool]) -> float | None:
    """What a sweep will take, after tracking some frames in another process.

    None where it was cancelled.

    Raises
    ------
    InputError
        Where it cannot be told.
    """
    words = program_command([*request.arguments(), "--dry-run", "--json"])
    with subprocess.Popen(  # noqa: S603 - our own code in our own interpreter
        words,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env={**os.environ, **BOUND, "OPENBLAS_NUM_THREADS": "1"},
        creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
    ) as process:
        while process.poll() is None:
            if cancelled():
                process.kill()
                return None
            time.sleep(_LOOK_SECONDS)
        told = process.stdout.read() if process.stdout is not None else b""
    try:
        return float(json.loads(told)["seconds"])
    except (ValueError, KeyError, TypeError):
        raise InputError(
            "the run time could not be measured", remedy="Start the sweep; it shows the time left."
        ) from None


def count_words(count: SweepCount, *, cluster: bool) -> str:
    """What a sweep comes to: ``24 runs (4 points), 8 of them are in the table already …``."""
    said = f"{counted(count.jobs, 'run')} ({counted(count.points, 'point')})"
    waiting = count.jobs - count.there
    if not waiting:
        return f"{said}; all results are already in the table."
    if count.there:
        said += f"; {count.there} already in the table"
    said += f". To track: {counted(count.frames, 'frame')}"
    if cluster:
        return f"{said}, on the cluster."
    if count.seconds is None:
        return f"{said}. Duration not known yet."
    processes = f"{count.workers} process{'' if count.workers == 1 else 'es'}"
    return f"{said}, in about {in_words(count.seconds)} with {processes}."

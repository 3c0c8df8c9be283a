"""The study that is open: its edits are saved at once, its work is one task."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.parameters import value_text
from stereotrack_core.study import description
from stereotrack_core.study.description import Study, StudySettings
from stereotrack_core.study.run import Outcome, plan_study, run_study
from stereotrack_core.study.status import RowStatus, study_status
from stereotrack_core.study.store import stored_results
from stereotrack_core.study.workers import LocalWorkers
from stereotrack_core.tracking.presets import preset

from .base import Base
from .changes import Part
from .jobs import Job, NewestJob, Task
from .tracking import TrackPresenter

_BUSY = "A study is at work. Wait, or stop it before another one is opened."
_CHANGED = "another program has changed the study file, so nothing was written"


class StudyPresenter:
    """Opens a study, keeps its rows up to date, and does what a person wants with them."""

    def __init__(self, base: Base, track: TrackPresenter) -> None:
        self._base, self._track = base, track
        self._tell = partial(base.changes.tell, Part.STUDY)
        self._job, self._reads = NewestJob(base.tasks), False
        self._content = b""
        self.study: Study | None = None
        self.rows: tuple[RowStatus, ...] = ()
        self.said, self.is_error = "", False
        """Result of the last task in words, and whether that is an error."""
        self.doing, self.share = "", 0.0
        """The task under way besides reading, in words, and the share that is done."""

    @property
    def working(self) -> bool:
        return self._job.busy

    @property
    def busy(self) -> bool:
        """Whether nothing else can be begun; what is being read is no hindrance."""
        return self._job.busy and not self._reads

    def panel_settings(self, settings: StudySettings) -> StudySettings:
        """Settings with the preset and the parameters of the next run."""
        track = self._track
        base = preset(track.preset).values()
        changes = tuple(
            f"{name}={value!r}" if isinstance(value, float) else f"{name}={value_text(value)}"
            for name, value in track.settings.values().items()
            if value != base[name]
        )
        return replace(settings, preset=track.preset, changes=changes)

    # ---- which study

    def open(self, path: Path) -> None:
        """Show a study, unless another one is at work. Raises InputError if it cannot be read."""
        if self.busy:
            self._base.changes.tell(Part.SAID, _BUSY)
            return
        self._read(path.resolve())
        self._say("")
        self.refresh()

    def _read(self, path: Path) -> None:
        study = description.read_study(path)
        self._content = _content(study.path)
        self._put(study, [RowStatus(row) for row in study.rows])

    def _put(self, study: Study, rows: Sequence[RowStatus]) -> None:
        self.study, self.rows = study, tuple(rows)
        self._tell()

    # ---- edits

    def edit(self, change: Callable[[Study], Study]) -> bool:
        """Make an edit and save it; what another program has written is never overwritten."""
        if self.study is None:
            return False
        try:
            study = change(self.study)
            if study == self.study:
                return True
            if _content(study.path) != self._content:
                remedy = "Refresh reads it again; then make the edit again."
                raise InputError(_CHANGED, where=str(study.path), remedy=remedy)
            description.write_study(study)
        except InputError as error:
            self._say(str(error), error=True)
            return False
        self._content = _content(study.path)
        known = {row.row.recording: row for row in self.rows}
        rows = (replace(known.get(row.recording, RowStatus(row)), row=row) for row in study.rows)
        self._put(study, list(rows))
        return True

    def remove(self, recordings: Sequence[str]) -> None:
        def without(study: Study) -> Study:
            left = [row for row in study.rows if row.recording not in recordings]
            return replace(study, rows=tuple(left))

        if self.edit(without):
            count = counted(len(recordings), "recording")
            self._say(f"{count} removed from the study. No file was deleted.")

    def add(
        self, folders: Sequence[Path], select: Callable[[Sequence[str]], object] = lambda _: None
    ) -> None:
        """Look for recordings in folders and below them, add them, and `select` them."""
        study = self.study
        if study is None or self.busy:
            return

        def look(task: Task) -> description.Listed:
            return description.with_recordings(study, folders, task.work)

        def done(listed: description.Listed) -> None:
            if self.edit(lambda _: listed.study):
                self._say(f"{counted(len(listed.added), 'recording')} added.")
                select(listed.added)

        self._begin("looking for recordings", look, done)

    # ---- work

    def refresh(self) -> None:
        """Read the recordings again, and the study where another program has changed it."""
        if self.study is None or self.busy:
            return
        try:
            if _content(self.study.path) != self._content:
                self._read(self.study.path)
        except InputError as error:
            self._say(str(error), error=True)
            return
        study = self.study

        def read(task: Task) -> None:
            results = stored_results(study.table)
            study_status(study, study.rows, results, task.work, on_row=task.tell)

        self._begin("reading the study", read, reads=True)

    def track(self, recordings: Sequence[str], settings: StudySettings, processes: int) -> None:
        edited = not self.busy and self.edit(lambda study: replace(study, settings=settings))
        study = self.study
        if not edited or study is None:
            return
        rows = [row for row in study.rows if row.recording in recordings]

        def work(task: Task) -> tuple[Outcome, int]:
            plan = plan_study(study, rows, task.work)
            outcome, results = run_study(study.table, plan.jobs, LocalWorkers(processes), task.work)
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
        self._say(f"{words}.")
        self._base.changes.tell(Part.SAID, f"Study: {words}.")

    def stop(self) -> None:
        self._job.cancel()

    def _begin(
        self,
        title: str,
        work: Callable[[Task], Any],
        done: Callable[[Any], object] = lambda _: None,
        *,
        reads: bool = False,
    ) -> None:
        """Start the one task of the study; reading is stopped for it."""
        self._reads, self.doing = reads, "" if reads else title
        self.share = 0.0
        self._job.run(
            Job(
                title, work, done, self._on_failed, ended=self._on_ended, told=self._on_rows,
                progressed=partial(self._on_progress, title.capitalize()),
            )
        )  # fmt: skip
        self._tell()

    def _on_rows(self, rows: list[RowStatus]) -> None:
        read = {row.row.recording: row for row in rows}
        self.rows = tuple(read.get(one.row.recording, one) for one in self.rows)
        self._tell()

    def _on_progress(self, title: str, share: float, words: str) -> None:
        if not self._reads:
            self.share = share
            self._say(f"{title}: {words}")

    def _on_failed(self, error: Exception) -> None:
        if isinstance(error, InputError):
            self._say(str(error), error=True)
        else:
            self._base.tasks.failed(error)

    def _on_ended(self) -> None:
        self.doing = ""
        if not self._reads:
            self.refresh()
        self._tell()

    def _say(self, words: str, *, error: bool = False) -> None:
        self.said, self.is_error = words, error
        self._tell()


def _content(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError:
        return b""

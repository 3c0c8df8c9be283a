"""Work on a study for a process of its own: reading, pages, tables; picklable."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from stereotrack_core.errors import InputError
from stereotrack_core.study.cache import StudyCache
from stereotrack_core.study.create import Found, find_recordings
from stereotrack_core.study.file import Study, StudyRow, read_study
from stereotrack_core.study.results import write_result_table
from stereotrack_core.study.run import write_reports
from stereotrack_core.study.status import RowStatus, remembered_status, study_status
from stereotrack_core.study.stored import StoredStudy
from stereotrack_core.worker_processes import Asker


@dataclass(frozen=True)
class Share:
    """How far work is, told by a process."""

    share: float
    words: str


@dataclass(frozen=True)
class Remembered:
    """A study with what was known of its rows when they were read last."""

    stored: StoredStudy
    rows: tuple[RowStatus, ...]

    @property
    def study(self) -> Study:
        """The study."""
        return self.stored.study


def remembered(path: Path) -> Remembered:
    """Read a study file and what is remembered of it; no recording or project is opened.

    Raises InputError where the study cannot be read.
    """
    stored = StoredStudy.read(path)
    return Remembered(stored, remembered_status(stored.study, StudyCache(stored.study.cache)))


@contextmanager
def _cache_of(study: Study, *, forget: bool) -> Iterator[StudyCache]:
    """What is remembered; what becomes known is saved where that is possible."""
    cache = StudyCache(study.cache)
    whole = False
    try:
        yield cache
        whole = True
    finally:
        with suppress(InputError):  # a drive that cannot be written to: it is read again next time
            cache.save(forget=forget and whole)


def _rows(study: Study, recordings: Sequence[str]) -> tuple[StudyRow, ...]:
    return tuple(row for row in study.rows if row.recording in set(recordings))


@dataclass(frozen=True)
class ReadStatus:
    """Reads what has changed of a study, and tells the status of every row."""

    path: Path

    def __call__(self, asker: Asker) -> None:
        """Do it. Raises InputError where the study cannot be read, and Cancelled."""
        study = read_study(self.path)
        with _cache_of(study, forget=True) as cache:
            study_status(
                study,
                cache,
                on_row=asker.tell,
                on_progress=lambda share, words: asker.tell(Share(share, words)),
                cancelled=asker.cancelled,
            )


@dataclass(frozen=True)
class WritePages:
    """Writes a page about the newest run of each of these recordings, of the study's own runs."""

    path: Path
    recordings: tuple[str, ...]

    def __call__(self, asker: Asker) -> tuple[Path, ...]:
        """The pages, one or more. Raises InputError where none can be written, and Cancelled."""
        study = read_study(self.path)
        with _cache_of(study, forget=False) as cache:
            status = study_status(
                study, cache, _rows(study, self.recordings), cancelled=asker.cancelled
            )
        shown = [row.shown for row in status]
        files = [run.place.path for run in shown if run and run.place.kept_in == "study"]
        if not files:
            raise InputError(
                "none of these recordings has a run of the study",
                where=str(self.path),
                remedy="Track them first.",
            )
        write_reports(
            status,
            files,
            on_progress=lambda share, words: asker.tell(Share(share, words)),
            cancelled=asker.cancelled,
        )
        return tuple(file.with_suffix(".html") for file in files)


@dataclass(frozen=True)
class ExportResults:
    """Writes the results of these recordings as one table."""

    path: Path
    recordings: tuple[str, ...]
    target: Path

    def __call__(self, asker: Asker) -> int:
        """The number of its rows. Raises InputError where it cannot be written, and Cancelled."""
        study = read_study(self.path)
        with _cache_of(study, forget=False) as cache:
            status = study_status(
                study,
                cache,
                _rows(study, self.recordings),
                on_progress=lambda share, words: asker.tell(Share(share, words)),
                cancelled=asker.cancelled,
            )
        return write_result_table(self.target, study, status)


@dataclass(frozen=True)
class FindRecordings:
    """Finds the recordings of folders and project files that a person wants to add."""

    path: Path
    added: tuple[Path, ...]

    def __call__(self, asker: Asker) -> Found:
        """What was found. Raises InputError where the study cannot be read, and Cancelled."""
        return find_recordings(
            read_study(self.path),
            self.added,
            on_progress=lambda share, words: asker.tell(Share(share, words)),
            cancelled=asker.cancelled,
        )

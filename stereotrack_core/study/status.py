"""How far a study is: what is known of every recording, its project and its runs."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from stereotrack_core.errors import Cancelled, Finding
from stereotrack_core.study.cache import StudyCache
from stereotrack_core.study.evaluated import RunFacts, RunPlace
from stereotrack_core.study.facts import (
    ProjectFacts,
    RecordingFacts,
    read_project_facts,
    read_recording_facts,
)
from stereotrack_core.study.file import Study, StudyRow
from stereotrack_core.study.places import Finder, Place
from stereotrack_core.version import __version__


@dataclass(frozen=True)
class RunStatus:
    """A run of a recording."""

    place: RunPlace
    facts: RunFacts
    outdated: tuple[str, ...] = ()
    """Why it is not what tracking now would give, in words."""

    @property
    def failures(self) -> int | None:
        """Failures against the reference, else by the run's own signs; None where not known."""
        by = "failures_by_error" if self.facts.reference else "failures_by_signs"
        count = self.facts.value(by, "count")
        return None if count is None else int(count)


@dataclass(frozen=True)
class RowStatus:
    """What is known of a row; None for what was not read, or is not there."""

    row: StudyRow
    place: Place
    recording: RecordingFacts | None = None
    project: ProjectFacts | None = None
    runs: tuple[RunStatus, ...] = ()
    """The project's, oldest first, then the study's own."""
    findings: tuple[Finding, ...] = ()
    """What is missing, has moved or is out of date."""

    @property
    def shown(self) -> RunStatus | None:
        """The run that a table shows: of the study's own, else of all, the newest one."""
        usable = [run for run in self.runs if not run.facts.problem]
        own = [run for run in usable if run.place.kept_in == "study"]
        return (own or usable or [None])[-1]  # type: ignore[list-item]  # None where there is none


def study_status(
    study: Study,
    cache: StudyCache,
    rows: Sequence[StudyRow] | None = None,
    *,
    on_row: Callable[[RowStatus], None] = lambda _: None,
    on_progress: Callable[[float, str], None] = lambda _share, _words: None,
    cancelled: Callable[[], bool] = lambda: False,
) -> tuple[RowStatus, ...]:
    """The status of rows (all of them where not given); files that have not changed are not read.

    What was read is in the cache, which the caller saves. Raises Cancelled.
    """
    wanted = study.rows if rows is None else rows
    reader = _Reader(study, cache)
    found = []
    for i, row in enumerate(wanted):
        if cancelled():
            raise Cancelled
        on_progress(i / len(wanted), row.recording)
        found.append(reader.row(row))
        on_row(found[-1])
    return tuple(found)


def remembered_status(study: Study, cache: StudyCache) -> tuple[RowStatus, ...]:
    """What was known of all rows when they were read last; no file is looked at."""
    found = []
    for row in study.rows:
        folder = study.place(row.recording)
        place = Place(folder, study.place(row.project) if row.project else None)
        recording = cache.known(_name(study, "recording", folder), RecordingFacts.of)
        project = None
        if place.project is not None:
            project = cache.known(_name(study, "project", place.project), ProjectFacts.of)
        runs = []
        for run in _runs_of(study, row, place, project):
            facts = cache.known(_name(study, "run", run.path, run.name), RunFacts.of)
            if facts is not None:
                runs.append(RunStatus(run, facts))
        found.append(RowStatus(row, place, recording, project, tuple(runs)))
    return tuple(found)


class _Reader:
    """Reads what is known of rows, by way of a cache."""

    def __init__(self, study: Study, cache: StudyCache) -> None:
        self._study = study
        self._cache = cache
        self._finder = Finder(study, lambda folder: self._recording(folder).fingerprint)
        self._listed: dict[str, list[str]] = defaultdict(list)
        for row in study.rows:
            if row.fingerprint:
                self._listed[row.fingerprint].append(row.recording)

    def row(self, row: StudyRow) -> RowStatus:
        """All that is known of a row."""
        place = self._finder.place(row)
        recording = None if place.folder is None else self._recording(place.folder)
        project = None if place.project is None else self._project(place.project, place.folder)
        runs = tuple(
            self._run(run, recording, project) for run in _runs_of(self._study, row, place, project)
        )
        alike = [name for name in self._listed.get(row.fingerprint, ()) if name != row.recording]
        findings = (*place.findings, *_findings(row, recording, project, runs, alike))
        return RowStatus(row, place, recording, project, runs, findings)

    def _recording(self, folder: Path) -> RecordingFacts:
        name = _name(self._study, "recording", folder)
        return self._cache.facts(name, lambda: read_recording_facts(folder), RecordingFacts.of)

    def _project(self, path: Path, folder: Path | None) -> ProjectFacts:
        name = _name(self._study, "project", path)
        also = "" if folder is None else self._study.relative(folder)
        return self._cache.facts(
            name, lambda: read_project_facts(path, folder), ProjectFacts.of, also
        )

    def _run(
        self, run: RunPlace, recording: RecordingFacts | None, project: ProjectFacts | None
    ) -> RunStatus:
        contents = {} if project is None else {one.name: one.content for one in project.runs}
        own = contents.get(run.name, "") if run.kept_in == "project" else ""
        truth = "" if project is None or not run.reference else project.reference_content
        also = f"{own} {truth} {'' if run.folder is None else self._study.relative(run.folder)}"
        name = _name(self._study, "run", run.path, run.name)
        facts = self._cache.facts(name, run.read, RunFacts.of, also)
        return RunStatus(run, facts, tuple(_outdated(facts, recording, project)))


def _name(study: Study, what: str, path: Path, inner: str = "") -> str:
    """Under which something is remembered; the same when the study moves with its files."""
    return f"{what} {study.relative(path)} {inner}".strip()


def _runs_of(
    study: Study, row: StudyRow, place: Place, project: ProjectFacts | None
) -> Iterator[RunPlace]:
    """Runs of a row: the project's, oldest first, then the study's own, oldest first."""
    reference = "" if project is None else project.reference
    against = (place.folder, reference, place.project)
    if project is not None and place.project is not None:
        for run in project.runs:
            yield RunPlace(run.name, "project", place.project, *against)
    folder = study.runs_of(row)
    files = [path for path in folder.glob("*.npz") if not path.name.startswith(".")]
    for path in sorted(files, key=lambda path: (path.stat().st_mtime_ns, path.name)):
        yield RunPlace(path.stem, "study", path, *against)


def _outdated(
    run: RunFacts, recording: RecordingFacts | None, project: ProjectFacts | None
) -> Iterator[str]:
    if run.problem:
        return
    if recording is not None and recording.fingerprint:
        calibration = (project.calibration if project is not None else "") or recording.calibration
        if run.fingerprint and run.fingerprint != recording.fingerprint:
            yield "the recording has changed since"
        elif run.calibration and run.calibration != calibration:
            yield "the calibration has changed since"
    if run.version and run.version != __version__:
        yield f"tracked by version {run.version} of this program"


def _findings(
    row: StudyRow,
    recording: RecordingFacts | None,
    project: ProjectFacts | None,
    runs: Sequence[RunStatus],
    alike: Sequence[str],
) -> Iterator[Finding]:
    if alike:
        yield Finding(
            "warning",
            row.recording,
            f"the same recording is also listed as {alike[0]}",
            "Remove one of the two, else the results contain it twice.",
        )
    if recording is not None and row.fingerprint not in ("", recording.fingerprint):
        yield Finding(
            "warning",
            row.recording,
            "the recording has changed since it was listed",
            "Check it. Empty the cell `fingerprint` and list it again to take it as it is.",
        )
    if project is not None and project.problem:
        yield Finding("error", row.project, project.problem, "Open the project to see more.")
    for run in runs:
        where = f"{row.recording}, run {run.place.name}"
        if run.facts.problem:
            yield Finding("error", where, run.facts.problem, "Delete it, or track again.")
        for reason in run.outdated:
            yield Finding("warning", where, reason, "Track again to have it up to date.")

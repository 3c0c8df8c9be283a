"""How far a study is: a row for each recording, in a terminal and in the window."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from stereotrack_core.errors import Finding, InputError
from stereotrack_core.evaluation.failure_segments.reasons import WHY_WORDS
from stereotrack_core.evaluation.summary import Spread
from stereotrack_core.project.project import Project
from stereotrack_core.recording.findings import examine
from stereotrack_core.study.description import Study, StudyRecording
from stereotrack_core.study.job import Job, JobResult, is_kept
from stereotrack_core.study.run import jobs_of, source_of
from stereotrack_core.work import NO_WORK, Work


@dataclass(frozen=True)
class RowStatus:
    """What is known of a recording; None for what was not read, or is not there."""

    row: StudyRecording
    frames: int | None = None
    views: str | None = None
    annotated: float | None = None  # share of the keyframes that are done, percent
    clicks: int | None = None
    jobs: tuple[Job, ...] = ()
    results: tuple[JobResult, ...] = ()  # of those of the jobs that are done
    findings: tuple[Finding, ...] = ()  # errors and warnings

    def mean(self, measure: str) -> float | None:
        """Mean of a measure over the runs that are done; None if it is not known."""
        values = [one.measures.get(measure, math.nan) for one in self.results]
        found = Spread.of(values).mean
        return found if math.isfinite(found) else None

    @property
    def failures(self) -> float | None:
        """Failures by error if there is a reference, else by the run's own signs; mean of runs."""
        by_error = self.mean("failures_by_error:count")
        return self.mean("failures_by_signs:count") if by_error is None else by_error

    @property
    def reasons(self) -> str | None:
        """Why arm searches failed, ``cost 4, search 1.5``; means of the runs."""
        known = {why: self.mean(f"failures_{why}:count") or 0.0 for why in WHY_WORDS}
        told = sorted((why for why in known if known[why]), key=lambda why: -known[why])
        return ", ".join(f"{why} {known[why]:.3g}" for why in told) or None

    @property
    def messages(self) -> list[str]:
        """The findings as sentences."""
        return [f"{one.severity}: {one.where}: {one.what}. {one.remedy}" for one in self.findings]


def status_of(study: Study, row: StudyRecording, results: Mapping[str, JobResult]) -> RowStatus:
    """Open a recording and its project, and find the results of its runs."""
    findings = [one for one in examine(study.place(row.recording)) if one.severity != "note"]
    annotated, clicks = None, None
    try:
        if row.project:
            with Project.open(study.place(row.project), read_only=True) as project:
                progress = project.progress()
            clicks = progress.clicks
            annotated = 100.0 * progress.done / progress.keyframes if progress.keyframes else None
        source = source_of(study, row)
    except InputError as error:
        findings = list(dict.fromkeys((Finding.of(error), *findings)))
        return RowStatus(row, annotated=annotated, clicks=clicks, findings=tuple(findings))
    jobs: tuple[Job, ...] = ()
    try:
        jobs = tuple(jobs_of(study, source, study.settings.all_points(), keep=True))
    except InputError as error:
        findings.append(Finding.of(error))
    known = [results[job.identity] for job in jobs if job.identity in results and is_kept(job)]
    for one in known:
        if not one.done:
            findings.append(Finding("error", row.recording, one.error, "Track again."))
    return RowStatus(
        row,
        source.frames,
        " ".join(view.name for view in source.recording.views),
        annotated,
        clicks,
        jobs,
        tuple(one for one in known if one.done),
        tuple(findings),
    )


def study_status(
    study: Study,
    rows: Sequence[StudyRecording],
    results: Mapping[str, JobResult],
    work: Work = NO_WORK,
    *,
    on_row: Callable[[RowStatus], None] = lambda _: None,
) -> tuple[RowStatus, ...]:
    """The status of recordings, one after the other. Raises Cancelled."""
    found: list[RowStatus] = []
    for i, row in enumerate(rows):
        work.step(i / len(rows), row.recording)
        found.append(status_of(study, row, results))
        on_row(found[-1])
    return tuple(found)


@dataclass(frozen=True)
class Column:
    """A column of the table; its value is None if nothing is known."""

    name: str
    label: str
    value: Callable[[RowStatus], float | str | None]
    help: str
    digits: int = 0

    def text(self, row: RowStatus) -> str:
        """A cell; a dash if nothing is known."""
        value = self.value(row)
        if value is None:
            return "-"
        return value if isinstance(value, str) else f"{value:.{self.digits}f}"


def _mean(measure: str) -> Callable[[RowStatus], float | None]:
    return lambda row: row.mean(measure)


def _runs(row: RowStatus) -> str | None:
    return f"{len(row.results)} of {len(row.jobs)}" if row.jobs else None


def _tracked(row: RowStatus) -> float | None:
    gaps = row.mean("gaps")
    return None if gaps is None else 100.0 - gaps


COLUMNS: tuple[Column, ...] = (
    Column("frames", "frames", lambda row: row.frames, "Frame sets of the recording."),
    Column("views", "views", lambda row: row.views, "Views of the recording."),
    Column("problems", "problems", lambda row: len(row.findings),
           "Errors and warnings about the recording, its project and its runs."),
    Column("annotated", "annotated %", lambda row: row.annotated,
           "Share of the keyframes that are done."),
    Column("clicks", "clicks", lambda row: row.clicks, "Clicked landmarks in the project."),
    Column("runs", "runs", _runs, "Runs that are done, of those that the study asks for. "
           "The following columns are means over them."),
    Column("tracked", "tracked %", _tracked, "Share of frames with a pose."),
    Column("torso_position", "torso mm", _mean("torso_position"),
           "Mean error of the torso's position.", 1),
    Column("upper_arms", "upper arms deg", _mean("upper_arms"),
           "Mean angular error of both upper arms.", 1),
    Column("forearms", "forearms deg", _mean("forearms"),
           "Mean angular error of both forearms.", 1),
    Column("lost", "lost %", _mean("lost"),
           "Share of arm segments that are more than 45 degrees off.", 1),
    Column("failures", "failures", lambda row: row.failures,
           "Failures by error if there is a reference, else by the run's own signs.", 1),
    Column("reasons", "why", lambda row: row.reasons, "Why the arm search failed where failures "
           "begin, from the cost of the reference's arms."),
)  # fmt: skip
"""Columns behind the recording and its factors."""


def row_facts(row: RowStatus) -> dict[str, Any]:
    """A row for JSON."""
    return {
        "recording": row.row.recording,
        "project": row.row.project,
        "factors": dict(row.row.factors),
        **{column.name: column.value(row) for column in COLUMNS},
        "messages": row.messages,
        "files": [job.keep for job in row.jobs if is_kept(job)],
    }

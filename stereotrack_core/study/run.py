"""Track the recordings of a study: jobs of a sweep whose runs are kept, and pages about them."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from stereotrack_core.errors import Cancelled, Finding, InputError
from stereotrack_core.experiments.runner.job import Job, JobResult
from stereotrack_core.experiments.sweep.plan import SweepPlan, count_of
from stereotrack_core.experiments.sweep.points import HowToTrack, SweepRequest
from stereotrack_core.experiments.sweep.store import SweepPlaces
from stereotrack_core.locks import refuse_second
from stereotrack_core.project.project import Project
from stereotrack_core.project.setups import load_reference
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.selection import seeds_of
from stereotrack_core.report.pages import write_page
from stereotrack_core.report.reported import Source, gathered
from stereotrack_core.study.cache import newest
from stereotrack_core.study.evaluated import OWN_REFERENCE
from stereotrack_core.study.facts import corrected, corrections_of
from stereotrack_core.study.file import Study, StudyRow, read_study, selected
from stereotrack_core.study.places import Finder, Place
from stereotrack_core.study.status import RowStatus, RunStatus
from stereotrack_core.tracking.presets import PRESETS, preset

_TABLE = "runs.csv"


@dataclass(frozen=True)
class StudyRequest(HowToTrack):
    """What to track of a study, in the words of a person; see ``stereotrack study run --help``."""

    study: Path
    select: tuple[str, ...] = ()
    """``COLUMN=VALUE`` of the rows; all of them without."""

    def arguments(self) -> list[str]:
        """The command that does it."""
        return ["study", "run", str(self.study), *self.options_besides({"study"})]


def selection_of(recordings: Sequence[str]) -> str:
    """``recording=...`` that selects these recordings."""
    return f"recording={','.join(re.sub(r'[,*[]', '?', name) for name in recordings)}"


@dataclass(frozen=True)
class StudyPlan:
    """What a request comes to."""

    study: Study
    rows: tuple[StudyRow, ...]
    sweep: SweepPlan
    """With the jobs of all rows that can be tracked; each keeps its run."""
    left_out: tuple[Finding, ...]
    """Rows that cannot, and why."""
    findings: tuple[Finding, ...]
    """What else a person should know."""

    def missing(self, known: Mapping[str, JobResult]) -> list[Job]:
        """Jobs whose runs are not there, or are of other settings."""
        return count_of(self.sweep.jobs, known, 1)[1]


def plan_study(
    request: StudyRequest,
    *,
    on_progress: Callable[[float, str], None] = lambda _share, _words: None,
    cancelled: Callable[[], bool] = lambda: False,
) -> StudyPlan:
    """Make the jobs of a study; a recording that cannot be tracked does not stop the others.

    Raises InputError where the study cannot be read, or settings make no sense, and Cancelled.
    """
    study = read_study(request.study)
    rows = selected(study, request.select)
    table = study.runs / _TABLE
    refuse_second(table)
    asked = {one.name: getattr(request, one.name) for one in dataclasses.fields(HowToTrack)}
    base = SweepRequest((), table, **asked)
    base.check()
    preset(request.preset, request.changes)
    seeds_of(request.seeds)
    finder = Finder(study)
    jobs: list[Job] = []
    left_out: list[Finding] = []
    findings: list[Finding] = []
    for i, row in enumerate(rows):
        if cancelled():
            raise Cancelled
        on_progress(i / len(rows), row.recording)
        place = finder.place(row)
        findings += [one for one in place.findings if one.severity != "error"]
        try:
            jobs += _jobs_of(study, row, place, base)
        except InputError as error:
            left_out.append(Finding.of(error))
    sweep = SweepPlan(base, ())
    sweep.jobs = tuple(jobs)
    return StudyPlan(study, rows, sweep, tuple(left_out), tuple(findings))


def places_of(study: Study) -> SweepPlaces:
    """Where the state of a study's work is kept; the folder is made."""
    try:
        study.runs.mkdir(exist_ok=True)
    except OSError as error:
        raise InputError(
            f"the folder for runs cannot be made ({error.strerror})",
            where=str(study.runs),
            remedy="Make it possible to write beside the study file.",
        ) from error
    return SweepPlaces(study.runs / _TABLE)


def _jobs_of(study: Study, row: StudyRow, place: Place, base: SweepRequest) -> list[Job]:
    """Jobs of one recording, as its project corrects it."""
    lost = [one for one in place.findings if one.severity == "error"]
    if lost or place.folder is None:
        raise InputError(lost[0].what, where=row.recording, remedy=lost[0].remedy)
    corrections = corrections_of(place.project)
    recording = corrected(open_recording(place.folder), corrections)
    blind = dataclasses.replace(recording, reference=None)  # runs stay when it is mended
    jobs = SweepPlan(dataclasses.replace(base, recordings=(place.folder,)), (blind,)).jobs
    folder = study.runs_of(row)
    return [
        dataclasses.replace(
            job,
            identity=_identity(job, row),
            recording=row.recording,
            keep=str(folder / f"{_name(job, base)}.npz"),
            corrections=corrections,
        )
        for job in jobs
    ]


def _identity(job: Job, row: StudyRow) -> str:
    """That of a job whose run is kept for a row: copies of a recording have runs of their own."""
    text = f"{job.identity} {row.recording}"
    return hashlib.blake2b(text.encode(), digest_size=12).hexdigest()


def _name(job: Job, base: SweepRequest) -> str:
    """Name of a run: its preset and seed, and a few digits for everything else that was asked."""
    name, settings = job.spec.preset, job.spec.settings
    own = name not in PRESETS or settings.values() != preset(name).values()
    asked = [settings.values() if own else None, base.views, base.frames, base.init, base.smooth]
    words = [Path(name).stem if name.endswith(".toml") else name]
    if asked != [None, None, None, "auto", False]:
        text = json.dumps(asked, sort_keys=True)
        words.append(hashlib.blake2b(text.encode(), digest_size=3).hexdigest())
    return "-".join([*words, f"seed{job.seed}"])


def write_reports(
    rows: Sequence[RowStatus],
    files: Sequence[Path],
    *,
    on_progress: Callable[[float, str], None] = lambda _share, _words: None,
    cancelled: Callable[[], bool] = lambda: False,
) -> tuple[Path, ...]:
    """Write a page about each of these run files beside it; pages that are newer are left alone.

    Raises InputError where one cannot be written, and Cancelled.
    """
    wanted = set(files)
    runs = [(row, run) for row in rows for run in row.runs if run.place.path in wanted]
    written = []
    for i, (row, run) in enumerate(runs):
        page = run.place.path.with_suffix(".html")
        if newest([page]) > newest([run.place.path]) or run.facts.problem:
            continue
        on_progress(i / len(runs), row.row.recording)
        reported = gathered(_source(row, run, page), cancelled=cancelled)
        write_page(page, reported)
        written.append(page)
    return tuple(written)


def _source(row: RowStatus, run: RunStatus, page: Path) -> Source:
    """What the page of a run is made of."""
    folder, project, states = row.place.folder, row.place.project, None
    recording = None
    if folder is not None:
        recording = corrected(open_recording(folder), corrections_of(project))
    truth = None if recording is None else recording.reference
    said = OWN_REFERENCE if truth is not None else ""
    if run.place.reference and project is not None:
        with Project.open(project, read_only=True) as opened:
            states = load_reference(opened.references, run.place.reference)
        truth, said = states.trajectory(), f"the project's reference {run.place.reference}"
    return Source(
        name=f"{row.row.recording} {run.place.name}",
        run=run.place.load(),
        recording=recording,
        reference=truth,
        reference_name=said,
        states=states,
        command=f"stereotrack report {run.place.path} -o {page}",
    )

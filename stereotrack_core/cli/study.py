"""``stereotrack study``: recordings in a study: list them, track them, export results."""

import dataclasses
from argparse import Namespace
from pathlib import Path
from typing import Any

from stereotrack_core.cli import options
from stereotrack_core.cli.output import FAILED, OK, put_facts, put_result, say, stoppable, watched
from stereotrack_core.cli.sources import say_notes
from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.locks import refuse_second
from stereotrack_core.study import description
from stereotrack_core.study.job import Job, JobResult, named
from stereotrack_core.study.run import plan_study, run_study
from stereotrack_core.study.status import COLUMNS, row_facts, study_status
from stereotrack_core.study.store import stored_results, write_result_table
from stereotrack_core.study.workers import ClusterWorkers, LocalWorkers
from stereotrack_core.tables import Table, number

STUDY = options.path("study STUDY.study.toml", "study file")
SELECT = options.several(
    "--select COLUMN=VALUE",
    "only recordings with this value, for example condition=slow; values are separated by "
    "commas, * stands for any letters; if given several times, all must agree",
)
SETTINGS = (
    options.PRESET,
    options.changes("change one parameter"),
    options.several(
        "--grid NAME=a,b,c",
        "values of a parameter, or of views, preset, seed, frames, init or smooth; if given "
        "several times, all combinations are tried",
    ),
    options.option("--seeds 0,1,2", "comma-separated seeds (default: 0)"),
    options.FRAMES,
    options.VIEWS,
    options.option("--init auto|tpose|FILE", "initial pose, as for track (default: auto)"),
    options.flag("--smooth", "smooth the runs"),
)
RUNNING = (
    options.option(
        "--workers N",
        "number of processes on this machine (default: one per core)",
        type=options.at_least(1),
    ),
    options.option(
        "--scheduler ADDRESS",
        "compute on a Dask cluster: tcp://host:port, tls://host:port, or a scheduler file "
        "(.json); all machines must see the recordings under the same path",
    ),
)


def settings_of(
    args: Namespace, base: description.StudySettings | None = None
) -> description.StudySettings:
    """The settings that options ask for, else those of `base`; InputError if they make no sense."""
    base = base or description.StudySettings()
    given: dict[str, Any] = {}
    for field in dataclasses.fields(description.StudySettings):
        value = getattr(args, field.name, None)
        if value:
            given[field.name] = tuple(value) if isinstance(value, list) else value
    settings = dataclasses.replace(base, **given)
    settings.check()
    return settings


def workers_of(args: Namespace) -> ClusterWorkers | LocalWorkers:
    """A cluster, or processes of this machine. Raises InputError for both at once."""
    if args.scheduler and args.workers is not None:
        what = "runs are computed on this machine or on a cluster"
        raise InputError(what, where="--workers, --scheduler", remedy="Use only one of them.")
    return ClusterWorkers(args.scheduler) if args.scheduler else LocalWorkers(args.workers)


@options.command(
    options.path("folders FOLDER", "folders with recordings in or below them", nargs="+"),
    options.output("STUDY.study.toml", "study file to write, or to add to"),
    *SETTINGS,
)
def create(args: Namespace) -> int:
    """List all recordings below folders, with their projects, in a text file that can be
    edited, with the settings of all runs and the values to try. Other keys of a recording
    are factors such as subject or condition. The same command adds new recordings and
    changes settings; everything else stays.
    """
    path: Path = args.output
    description.check_name(path)
    before = description.read_study(path) if path.exists() else description.Study(path)
    before = dataclasses.replace(before, settings=settings_of(args, before.settings))
    with stoppable("Nothing was written.") as stopped:
        listed = description.with_recordings(before, args.folders, cancelled=stopped)
    study = listed.study
    description.write_study(study)
    facts = {
        "recordings": len(study.rows),
        "projects": sum(bool(row.project) for row in study.rows),
        "added": list(listed.added),
        "factors": list(study.factors),
    }
    put_facts(facts, f"Study {study.path}", as_json=args.json, study=study.path)
    return OK


@options.command(STUDY, SELECT)
def status(args: Namespace) -> int:
    """Print a table of all recordings of a study: frames and views, problems, progress of
    the annotation, and runs with their errors and failures.
    """
    study = description.read_study(args.study)
    rows, results = description.selected(study, args.select), stored_results(study.table)
    with watched("Reading", "Nothing was printed.") as (report, stopped):
        status = study_status(study, rows, results, on_progress=report, cancelled=stopped)
    shown = [one for one in COLUMNS if any(one.value(row) is not None for row in status)]
    headings = [one.label if one.name == "views" else f">{one.label}" for one in shown]
    cells = [
        [
            row.row.recording,
            *(row.row.cell(name) for name in study.factors),
            *(column.text(row) for column in shown),
        ]
        for row in status
    ]
    title = f"Study {study.path}: {len(cells)} recordings"
    facts = {"study": study.path, "recordings": [row_facts(row) for row in status]}
    table = Table(title, ("recording", *study.factors, *headings), cells)
    put_result(facts, table, as_json=args.json)
    say_notes(finding for row in status for finding in row.findings)
    return OK


@options.command(STUDY, SELECT, *RUNNING)
def run(args: Namespace) -> int:
    """Track the recordings of a study with all its settings and seeds, keep the runs beside
    the study file, and print their errors. Runs that are there are not computed again, so
    the same command resumes stopped work; if a reference has changed, they are only measured
    again. A recording that cannot be tracked does not stop the others. References are only
    used to measure errors, never by the tracker.
    """
    study = description.read_study(args.study)
    rows = description.selected(study, args.select)
    workers = workers_of(args)
    refuse_second(study.table)
    with watched("Planning", "Nothing was tracked.") as (report, stopped):
        plan = plan_study(study, rows, on_progress=report, cancelled=stopped)
    say_notes(plan.left_out)
    with watched("Tracking", "") as (report, stopped):
        outcome, results = run_study(
            study, plan.jobs, workers, on_progress=report, cancelled=stopped
        )
    known = [(job, results[job.identity]) for job in plan.jobs if job.identity in results]
    failed = [(job, result) for job, result in known if not result.done]
    runs = [_facts_of(job, result) for job, result in known if result.done]
    facts = {
        "study": study.path,
        "jobs": len(plan.jobs),
        "computed": outcome.computed,
        "reused": outcome.reused,
        "failed": len(failed),
        "left_out": [one.where for one in plan.left_out],
        "stopped": outcome.stopped,
        "runs": runs,
    }
    title = (
        f"Study {study.path}: {outcome.computed} computed, {outcome.reused} there already, "
        f"{len(plan.left_out)} left out"
    )
    put_result(facts, _table(title, runs), as_json=args.json)
    for job, result in failed:
        say(f"Failed: {job.recording}, seed {job.seed}: {result.error}")
    if outcome.stopped:
        say("Stopped. Finished runs are kept; run the same command again to continue.")
    return FAILED if outcome.stopped or failed or plan.left_out else OK


_SHOWN = {
    "upper_arms": "upper arms",
    "forearms": "forearms",
    "lost": "lost",
    "failures_by_error:count": "failures",
}


def _facts_of(job: Job, result: JobResult) -> dict[str, Any]:
    return {
        "recording": job.recording,
        "run": Path(job.keep).stem,
        "file": job.keep,
        "frames": result.frames,
        "tracked": int(result.measures.get("frames_tracked:count", 0)),
        **{key.partition(":")[0]: result.measures.get(key) for key in _SHOWN},
    }


def _table(title: str, runs: list[dict[str, Any]]) -> Table:
    units = {key: named(key).unit.replace("1", "") for key in _SHOWN}
    headings = [f">{label} {units[key]}".strip() for key, label in _SHOWN.items()]
    cells = [
        [
            row["recording"],
            row["run"],
            str(row["frames"]),
            str(row["tracked"]),
            *(
                "-" if (value := row[key.partition(":")[0]]) is None else number(value)
                for key in _SHOWN
            ),
        ]
        for row in runs
    ]
    return Table(title, ("recording", "run", ">frames", ">tracked", *headings), cells)


@options.command(STUDY, options.output("TABLE.csv", "table to write", ".csv"), SELECT)
def export(args: Namespace) -> int:
    """Write the results of all runs of a study as one table with a value per row: factors,
    recording, run, measure, statistic, unit, value. It has errors, the tracker's own signs,
    the number of failures, and the range of every joint angle.
    """
    study = description.read_study(args.study)
    rows = description.selected(study, args.select)
    with watched("Reading", "Nothing was written.") as (report, stopped):
        plan = plan_study(study, rows, on_progress=report, cancelled=stopped)
    say_notes(plan.left_out)
    results = stored_results(study.table)
    done = [job for job in plan.jobs if job.identity in results and results[job.identity].done]
    there = {job.recording for job in done}
    without = [row.recording for row in rows if row.recording not in there]
    if without:
        say(f"{counted(len(without), 'recording')} without a run: {', '.join(without)}.")
    values = write_result_table(args.output, study, done, results)
    facts = {"recordings": len(rows), "runs": len(done), "values": values}
    more = {"file": args.output, "without_run": without}
    put_facts(facts, f"Results in {args.output}", as_json=args.json, **more)
    return OK

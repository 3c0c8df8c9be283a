"""``stereotrack study`` and ``sweep``: recordings, settings and seeds, tracked and measured.

A sweep is a study that the command describes and whose runs are not kept.
"""

import dataclasses
import math
from argparse import Namespace
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from stereotrack_core.cli import options
from stereotrack_core.cli.output import FAILED, OK, put_facts, put_result, say, stoppable, watched
from stereotrack_core.cli.sources import say_notes
from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.evaluation.measures import measure_named
from stereotrack_core.locks import refuse_second
from stereotrack_core.parameters import value_text
from stereotrack_core.recording.selection import gives_depth
from stereotrack_core.study import description
from stereotrack_core.study.description import Study, StudyRecording, check_rows
from stereotrack_core.study.job import Job, JobResult, named
from stereotrack_core.study.points import varied_names
from stereotrack_core.study.run import (
    Outcome,
    PointSummary,
    jobs_of,
    plan_study,
    run_study,
    source_of,
    summarised,
)
from stereotrack_core.study.status import COLUMNS, row_facts, study_status
from stereotrack_core.study.store import stored_results, write_result_table
from stereotrack_core.study.workers import ClusterWorkers, LocalWorkers
from stereotrack_core.tables import Table, number
from stereotrack_core.work import Work

STUDY = options.path("study STUDY.study.toml", "study file")
SELECT = options.several(
    "--select COLUMN=VALUE",
    "only recordings with this value, for example condition=slow; values are separated by "
    "commas, * stands for any letters; all that are given must agree",
)
SETTINGS = (
    options.PRESET,
    options.changes("change one parameter"),
    options.several(
        "--grid NAME=a,b,c",
        "values of a parameter, or of views, preset, seed, frames, init or smooth; all "
        "combinations are tried",
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
        raise InputError(what, "--workers, --scheduler", "Use only one of them.")
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
        listed = description.with_recordings(before, args.folders, Work(stopped=stopped))
    study = listed.study
    description.write_study(study)
    facts: dict[str, Any] = {"recordings": len(study.rows)}
    facts["projects"] = sum(bool(row.project) for row in study.rows)
    facts |= {"added": list(listed.added), "factors": list(study.factors)}
    put_facts(facts, f"Study {study.path}", as_json=args.json, study=study.path)
    return OK


@options.command(STUDY, SELECT)
def status(args: Namespace) -> int:
    """Print a table of all recordings of a study: frames and views, problems, progress of
    the annotation, and runs with their errors and failures.
    """
    study = description.read_study(args.study)
    rows, results = description.selected(study, args.select), stored_results(study.table)
    with watched("Reading", "Nothing was printed.") as work:
        status = study_status(study, rows, results, work)
    shown = [one for one in COLUMNS if any(one.value(row) is not None for row in status)]
    headings = [one.label if one.name == "views" else f">{one.label}" for one in shown]
    cells = []
    for row in status:
        factors = (row.row.cell(name) for name in study.factors)
        cells.append([row.row.recording, *factors, *(column.text(row) for column in shown)])
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
    with watched("Planning", "Nothing was tracked.") as work:
        plan = plan_study(study, rows, work)
    say_notes(plan.left_out)
    with watched("Tracking", "") as work:
        outcome, results = run_study(study.table, plan.jobs, workers, work)
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
    done = f"{outcome.computed} computed, {outcome.reused} there already"
    title = f"Study {study.path}: {done}, {len(plan.left_out)} left out"
    put_result(facts, _table(title, runs), as_json=args.json)
    for job, result in failed:
        say(f"Failed: {job.recording}, seed {job.spec.seed}: {result.error}")
    if outcome.stopped:
        say("Stopped. Finished runs are kept; run the same command again to continue.")
    return FAILED if outcome.stopped or failed or plan.left_out else OK


_SHOWN = {name: name.replace("_", " ") for name in ("upper_arms", "forearms", "lost")}
_SHOWN["failures_by_error:count"] = "failures"


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
    cells = []
    for row in runs:
        named_run = [row["recording"], row["run"], str(row["frames"]), str(row["tracked"])]
        values = (row[key.partition(":")[0]] for key in _SHOWN)
        cells.append([*named_run, *("-" if one is None else number(one) for one in values)])
    return Table(title, ("recording", "run", ">frames", ">tracked", *headings), cells)


@options.command(STUDY, options.output("TABLE.csv", "table to write", ".csv"), SELECT)
def export(args: Namespace) -> int:
    """Write the results of all runs of a study as one table with a value per row: factors,
    recording, run, measure, statistic, unit, value. It has errors, the tracker's own signs,
    the number of failures, and the range of every joint angle.
    """
    study = description.read_study(args.study)
    rows = description.selected(study, args.select)
    with watched("Reading", "Nothing was written.") as work:
        plan = plan_study(study, rows, work)
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


@options.command(
    options.path("recordings RECORDING", "recordings to track", nargs="+"),
    options.path(
        "-o --output TABLE.csv",
        "results table to write; results are stored at once in a journal beside it, so that "
        "the same command resumes a stopped sweep",
        required=True,
        dest="table",
    ),
    *SETTINGS,
    *RUNNING,
)
def sweep(args: Namespace) -> int:
    """Track recordings with every combination of values (--grid), each with all seeds, and write
    one row per run to a table. Results already in the table are not computed again, so the same
    command resumes a stopped sweep. References are only used to measure errors, never by the
    tracker.
    """
    options.check_suffix(args.table, ".csv")
    rows = tuple(StudyRecording(str(folder.absolute())) for folder in args.recordings)
    study = Study(args.table, rows, settings_of(args))
    check_rows(study)
    refuse_second(args.table)
    opened = [source_of(study, row) for row in study.rows]
    for source in opened:
        options.check_output(args.table, source.recording.folder)
    recordings = [one.recording for one in opened]
    by = "unexplained_fraction" if all(map(gives_depth, recordings)) else "keypoint_error"
    if all(one.reference is not None for one in recordings):
        by = "forearms"
    points = study.settings.all_points()
    jobs = [job for one in opened for job in jobs_of(study, one, points, keep=False)]
    workers = workers_of(args)
    with watched("Sweeping", "") as work:
        outcome, results = run_study(args.table, jobs, workers, work)
    return _report(args, outcome, results, by)


def _report(args: Namespace, outcome: Outcome, results: Mapping[str, JobResult], by: str) -> int:
    jobs = outcome.jobs
    summaries = summarised(jobs, results, by)
    different = {job.identity for job in jobs}
    failed = sum(one in results and not results[one].done for one in different)
    facts = {
        "table": args.table,
        "jobs": len(different),
        "computed": outcome.computed,
        "reused": outcome.reused,
        "failed": failed,
        "stopped": outcome.stopped,
        "judged_by": by,
        "points": [_point_facts(summary) for summary in summaries],
    }
    told = f"{args.table}: {outcome.computed} computed, {outcome.reused} reused."
    tables: tuple[Table | str, ...] = ()
    if summaries:
        tables = (_point_table(summaries, by), *_stretch_table(summaries), told)
    put_result(facts, *tables, as_json=args.json)
    for job in {job.identity: job for job in jobs}.values():
        if job.identity in results and not results[job.identity].done:
            values = (f"{name}={value_text(value)}" for name, value in job.point.values)
            where = ", ".join((job.recording, *values, f"seed {job.spec.seed}"))
            say(f"Failed: {where}: {results[job.identity].error}")
    if outcome.stopped:
        say("Stopped. Finished results are kept; run the same command again to continue.")
    return FAILED if outcome.stopped or failed else OK


_WITH_REFERENCE = ("torso_position", "upper_arms", "forearms", "lost", "not_tracked")
_WITHOUT = ("gaps", "unexplained_fraction", "residual", "keypoint_error", "limb_sigma", "limb_lost")
_MOST_ROWS = 40


def _point_table(summaries: Sequence[PointSummary], by: str) -> Table:
    """Mean and spread of every point over recordings and seeds, best first."""
    varied = varied_names(summary.point for summary in summaries)

    def is_known(name: str) -> bool:
        return any(math.isfinite(one.values[name].mean) for one in summaries)

    usual = _WITH_REFERENCE if is_known("forearms") else tuple(filter(is_known, _WITHOUT))
    names = dict.fromkeys((by, *usual, "frames_per_second"))
    measures = [measure for name in names if (measure := measure_named(name)) is not None]
    rows = []
    for summary in summaries[:_MOST_ROWS]:
        values = summary.point.by_name
        runs = str(summary.runs) + (f", {summary.failed} failed" if summary.failed else "")
        cells = [summary.values[measure.name].text() for measure in measures]
        rows.append([*(value_text(values.get(name, "")) for name in varied), runs, *cells])
    first = measures[0].short or measures[0].label
    title = f"Mean ± standard deviation over recordings and seeds, best {first} first"
    if len(summaries) > len(rows):
        title += f"; the table has {len(summaries) - len(rows)} more points"
    headings = [f">{one.short or one.label} {one.unit}".strip() for one in measures]
    return Table(title, (*varied, ">runs", *headings), rows)


_OF_STRETCHES = ("upper_arms", "forearms", "lost")


def _stretch_table(summaries: Sequence[PointSummary]) -> tuple[Table, ...]:
    """The same over each named stretch; empty if there is none."""
    varied = varied_names(summary.point for summary in summaries)
    rows = []
    for summary in summaries[:_MOST_ROWS]:
        values = summary.point.by_name
        point = [value_text(values.get(name, "")) for name in varied]
        for stretch in dict.fromkeys(n.rpartition("/")[0] for n in summary.values if "/" in n):
            cells = [summary.values[f"{stretch}/{name}"].text() for name in _OF_STRETCHES]
            rows.append([*point, stretch, *cells])
    headings = (*varied, "stretch", ">upper arms deg", ">forearms deg", ">lost %")
    return (Table("Named stretches", headings, rows),) if rows else ()


def _point_facts(summary: PointSummary) -> dict[str, Any]:
    known = {name: one for name, one in summary.values.items() if math.isfinite(one.mean)}
    return {
        "values": summary.point.by_name,
        "runs": summary.runs,
        "failed": summary.failed,
        "mean": {name: one.mean for name, one in known.items()},
        "standard_deviation": {
            name: one.deviation for name, one in known.items() if math.isfinite(one.deviation)
        },
    }

"""``stereotrack study run``: track recordings of a study, evaluate the runs, write pages."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from stereotrack_core.cli.arguments import (
    FRAMES,
    INIT,
    JSON,
    SETTINGS,
    TLS,
    VIEWS,
    flag,
    option,
)
from stereotrack_core.cli.jobs import executor_of, request_of
from stereotrack_core.cli.output import FAILED, OK, put_json, put_table, say
from stereotrack_core.cli.progress import progress, stoppable, watched
from stereotrack_core.cli.studies.shared import SELECT, STUDY, read_status, say_findings
from stereotrack_core.counting import counted
from stereotrack_core.experiments.runner.job import JobResult
from stereotrack_core.experiments.sweep.run import SweepOutcome, SweepRun
from stereotrack_core.experiments.sweep.store import SweepStore
from stereotrack_core.study.run import StudyPlan, StudyRequest, places_of, plan_study, write_reports
from stereotrack_core.study.status import RowStatus
from stereotrack_core.tables import Table, number

DESCRIPTION = (
    "Track the recordings of a study with one preset, keep the runs beside the study file, and "
    "print their errors. Runs that are there and up to date are not computed again, so the same "
    "command resumes stopped work. A recording that cannot be tracked does not stop the others. "
    "References are only used to measure errors, never by the tracker."
)

OPTIONS = (
    STUDY,
    SELECT,
    *SETTINGS,
    option("--seeds 0,1,2", "comma-separated seeds (default: 0)", default="0"),
    FRAMES,
    VIEWS,
    INIT,
    flag("--smooth", "smooth the runs"),
    flag("--report", "also write a page about every run beside it"),
    option("--workers N", "number of processes on this machine (default: one per core)", type=int),
    option(
        "--scheduler ADDRESS",
        "compute on a Dask cluster: tcp://host:port, tls://host:port, or a scheduler file (.json); "
        "all machines must see the study's folder under the same path",
    ),
    *TLS,
    option(
        "--retries N",
        "number of retries after a job failed by chance (default: 1)",
        type=int,
        default=1,
    ),
    flag("--again", "track again what is there already"),
    flag("--dry-run", "only print what would be tracked"),
    JSON,
)


def run(args: Namespace) -> int:
    """Plan, track what is missing, evaluate, write pages, print."""
    with watched("Planning", "Nothing was tracked.") as (report, stopped):
        plan = plan_study(request_of(args, StudyRequest), on_progress=report, cancelled=stopped)
    say_findings((*plan.findings, *plan.left_out))
    store = SweepStore(places_of(plan.study))
    try:
        if args.dry_run:
            return _tell_plan(plan, store, as_json=args.json)
        with (
            executor_of(plan.sweep.request) as executor,
            progress("Tracking", 100) as show,
            stoppable() as stopped,
        ):
            work = SweepRun(plan.sweep, store, executor, on_percent=show, cancelled=stopped)
            outcome = work.do()
        status = read_status(plan.study, plan.rows)
        pages: Sequence[Path] = ()
        if args.report and not outcome.stopped:
            files = [Path(job.keep) for job in plan.sweep.jobs]
            with watched("Reporting", "Finished pages are kept.") as (report, stopped):
                pages = write_reports(status, files, on_progress=report, cancelled=stopped)
        return _tell(args, plan, outcome, store.results, status, pages)
    finally:
        store.close()


def _tell_plan(plan: StudyPlan, store: SweepStore, *, as_json: bool) -> int:
    """Say what would be tracked."""
    waiting = plan.missing(store.results)
    facts = {
        "jobs": len(plan.sweep.jobs),
        "there": len(plan.sweep.jobs) - len(waiting),
        "to_compute": len(waiting),
        "frames": sum(len(job.frames) for job in waiting),
        "left_out": len(plan.left_out),
    }
    if as_json:
        put_json(facts)
    else:
        rows = [(key.replace("_", " "), str(value)) for key, value in facts.items()]
        put_table(Table(f"Plan for {plan.study.path}", ("what", ">value"), rows))
    return OK


def _tell(
    args: Namespace,
    plan: StudyPlan,
    outcome: SweepOutcome,
    results: dict[str, JobResult],
    status: Sequence[RowStatus],
    pages: Sequence[Path],
) -> int:
    failed = [
        (job, results[job.identity])
        for job in plan.sweep.jobs
        if job.identity in results and not results[job.identity].done
    ]
    rows = list(_rows(plan, status))
    if args.json:
        put_json(
            {
                "study": plan.study.path,
                "jobs": len(plan.sweep.jobs),
                "computed": outcome.computed,
                "reused": outcome.reused,
                "failed": len(failed),
                "left_out": [one.where for one in plan.left_out],
                "stopped": outcome.stopped,
                "runs": rows,
                "pages": list(pages),
            }
        )
    else:
        put_table(_table(plan, outcome, rows))
    for job, result in failed:
        say(f"Failed: {job.recording}, seed {job.seed}: {result.error}")
    if pages:
        say(f"{counted(len(pages), 'page')} written beside the runs in {plan.study.runs}.")
    if outcome.stopped:
        say("Stopped. Finished runs are kept; run the same command again to continue.")
    return FAILED if outcome.stopped or failed or plan.left_out else OK


def _rows(plan: StudyPlan, status: Iterable[RowStatus]) -> Iterable[dict[str, Any]]:
    """The runs of this plan, one by one."""
    wanted = {Path(job.keep) for job in plan.sweep.jobs}
    for row in status:
        for run in row.runs:
            if run.place.path in wanted and not run.facts.problem:
                yield {
                    "recording": row.row.recording,
                    "run": run.place.name,
                    "file": run.place.path,
                    "frames": run.facts.frames,
                    "tracked": run.facts.tracked,
                    "forearms": run.facts.value("forearms", "mean"),
                    "upper_arms": run.facts.value("upper_arms", "mean"),
                    "lost": run.facts.value("lost", "share"),
                    "failures": run.failures,
                }


def _table(plan: StudyPlan, outcome: SweepOutcome, rows: Iterable[dict[str, Any]]) -> Table:
    title = (
        f"Study {plan.study.path}: {outcome.computed} tracked, {outcome.reused} there already, "
        f"{len(plan.left_out)} left out"
    )
    columns = (
        *("recording", "run", ">frames", ">tracked", ">upper arms deg", ">forearms deg"),
        *(">lost %", ">failures"),
    )
    numbers = ("upper_arms", "forearms", "lost")
    cells = [
        [
            row["recording"],
            row["run"],
            str(row["frames"]),
            str(row["tracked"]),
            *("-" if row[name] is None else number(row[name]) for name in numbers),
            "-" if row["failures"] is None else str(row["failures"]),
        ]
        for row in rows
    ]
    return Table(title, columns, cells)

"""``stereotrack study run``: track the recordings of a study and evaluate the runs."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path
from typing import Any

from stereotrack_core.cli.arguments import JSON
from stereotrack_core.cli.output import FAILED, OK, put_result, say
from stereotrack_core.cli.progress import watched
from stereotrack_core.cli.studies.shared import RUNNING, SELECT, STUDY, say_findings, workers_of
from stereotrack_core.locks import refuse_second
from stereotrack_core.study.description import read_study, selected
from stereotrack_core.study.job import Job, JobResult
from stereotrack_core.study.run import missing, plan_study, run_study
from stereotrack_core.study.store import stored_results
from stereotrack_core.study.values import named
from stereotrack_core.tables import Table, number

DESCRIPTION = (
    "Track the recordings of a study with all its settings and seeds, keep the runs beside the "
    "study file, and print their errors. Runs that are there are not computed again, so the same "
    "command resumes stopped work; if a reference has changed, they are only measured again. A "
    "recording that cannot be tracked does not stop the others. References are only used to "
    "measure errors, never by the tracker."
)

OPTIONS = (STUDY, SELECT, *RUNNING, JSON)


def run(args: Namespace) -> int:
    """Plan, track what is missing, print."""
    study = read_study(args.study)
    rows = selected(study, args.select)
    workers = workers_of(args)
    refuse_second(study.table)
    with watched("Planning", "Nothing was tracked.") as (report, stopped):
        plan = plan_study(study, rows, on_progress=report, cancelled=stopped)
    say_findings(plan.left_out)
    if args.dry_run:
        waiting = missing(plan.jobs, stored_results(study.table), again=args.again)
        return tell_plan(f"Plan for {study.path}", plan.jobs, waiting, as_json=args.json)
    with watched("Tracking", "") as (report, stopped):
        outcome, results = run_study(
            study, plan.jobs, workers, again=args.again, on_progress=report, cancelled=stopped
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


def tell_plan(title: str, jobs: tuple[Job, ...], waiting: list[Job], *, as_json: bool) -> int:
    """Print what would be computed."""
    different = len({job.identity for job in jobs})
    facts = {
        "jobs": different,
        "there": different - len(waiting),
        "to_compute": len(waiting),
        "frames": sum(len(job.frames) for job in waiting),
    }
    rows = [(key.replace("_", " "), str(value)) for key, value in facts.items()]
    put_result(facts, Table(title, ("what", ">value"), rows), as_json=as_json)
    return OK


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

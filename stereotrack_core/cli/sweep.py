"""``stereotrack sweep``: many runs over recordings, seeds and values of parameters."""

from __future__ import annotations

import dataclasses
import math
from argparse import Namespace
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from stereotrack_core.cli.arguments import (
    FRAMES,
    INIT,
    JSON,
    KEYPOINT_OPTIONS,
    SETTINGS,
    TLS,
    VIEWS,
    check_output,
    flag,
    option,
)
from stereotrack_core.cli.jobs import executor_of, request_of
from stereotrack_core.cli.output import FAILED, OK, put, put_json, put_result, put_table, say
from stereotrack_core.cli.progress import progress, stoppable
from stereotrack_core.counting import in_words
from stereotrack_core.experiments.measures import SweepMeasure, measure_named
from stereotrack_core.experiments.runner.job import Job, JobResult, do_batch
from stereotrack_core.experiments.sweep.plan import SweepPlan, count_of, expected_seconds
from stereotrack_core.experiments.sweep.points import TRIALS, Point, SweepRequest, varied_names
from stereotrack_core.experiments.sweep.run import PointSummary, SweepOutcome, SweepRun, summarised
from stereotrack_core.experiments.sweep.store import SweepPlaces, SweepStore, stored_results
from stereotrack_core.locks import refuse_second
from stereotrack_core.recording.folder import open_recordings
from stereotrack_core.tables import Table

DESCRIPTION = (
    "Track recordings with every combination of values (--grid), with the points of a list "
    "(--list) or in search of the best values (--search), each with all seeds, and write one "
    "row per run to a table. Results already in the table are not computed again, so the same "
    "command resumes a stopped sweep. References are only used to measure errors, never by "
    "the tracker."
)

OPTIONS = (
    option("recordings RECORDING", "recordings to track", type=Path, nargs="+"),
    option(
        "-o --output TABLE.csv",
        "results table to write; results are stored in it immediately, so that the same "
        "command resumes a stopped sweep",
        type=Path,
        required=True,
        dest="table",
    ),
    option(
        "--grid NAME=a,b,c",
        "values of a parameter, or of views, preset, seed, frames, init or smooth; if given "
        "several times, all combinations are tried",
        action="append",
        default=[],
    ),
    option(
        "--list FILE.csv",
        "file with the points to try: one column per name, one row per point",
        type=Path,
        dest="points",
    ),
    option(
        "--search NAME=LOW:HIGH[:log|int]",
        "search for the best value in a range, or among NAME=a,b,c; repeat it for more",
        action="append",
        default=[],
    ),
    option(
        "--trials N",
        f"number of points that a search tries (default: {TRIALS})",
        type=int,
        default=TRIALS,
    ),
    option("--search-seed N", "random seed of the search (default: 0)", type=int, default=0),
    option(
        "--minimise MEASURE",
        "column that the search minimises (default: forearms where all recordings have a "
        "reference, else unexplained_fraction, or keypoint_error for mono views); measures for "
        "which higher is better are maximised",
    ),
    option("--seeds 0,1,2", "comma-separated seeds (default: 0)", default="0"),
    *SETTINGS,
    FRAMES,
    VIEWS,
    INIT,
    flag("--smooth", "smooth the runs"),
    *KEYPOINT_OPTIONS,
    option("--workers N", "number of processes on this machine (default: one per core)", type=int),
    option(
        "--together N",
        "largest number of jobs that one process runs together to share their clouds "
        "(default: 8, fewer for long recordings); jobs in progress are lost when the program is "
        "killed",
        type=int,
    ),
    option(
        "--scheduler ADDRESS",
        "compute on a Dask cluster: tcp://host:port, tls://host:port, or a scheduler file (.json)",
    ),
    *TLS,
    option(
        "--retries N",
        "number of retries after a job failed by chance (default: 1)",
        type=int,
        default=1,
    ),
    flag("--again", "recompute results that are already in the table"),
    flag("--dry-run", "only print what would be computed, and the expected time"),
    JSON,
)


_LONGEST_PROBE = 10
"""Frames that are tracked for an estimate where nothing has been measured yet."""


def run(args: Namespace) -> int:
    """Plan, compute what is missing, print."""
    request = request_of(args, SweepRequest)
    request.check()
    refuse_second(request.table)
    recordings = open_recordings(request.recordings)
    for recording in recordings:
        check_output(request.table, recording)
    plan = SweepPlan(request, recordings)
    if args.dry_run:
        return _tell_plan(plan, as_json=args.json)
    store = SweepStore(SweepPlaces(request.table))
    try:
        with (
            executor_of(request) as executor,
            progress("Sweeping", 100) as show,
            stoppable() as stopped,
        ):
            work = SweepRun(plan, store, executor, on_percent=show, cancelled=stopped)
            outcome = work.do()
        return _report(store, outcome, plan.by, as_json=args.json)
    finally:
        store.close()


def _tell_plan(plan: SweepPlan, *, as_json: bool) -> int:
    """Say what would be computed, and how long it would take."""
    request = plan.request
    known = {} if request.again else stored_results(SweepPlaces(request.table))
    with executor_of(request) as executor:
        workers = executor.count
    count, waiting = count_of(plan.jobs_to_count(), known, workers)
    seconds, source = count.seconds, "from earlier results"
    if seconds is None:
        seconds = expected_seconds(waiting, *_probe(waiting[0]), workers)
        source = f"rough estimate from the first {_LONGEST_PROBE} frames of one job"
    expected = "unknown" if seconds is None else f"{in_words(seconds)} ({source})"
    facts = {
        "jobs": count.jobs,
        "in_table": count.there,
        "to_compute": len(waiting),
        "frames": count.frames,
        "points": count.points,
        "workers": workers,
        "seconds": seconds,
        "estimated": source,
    }
    rows = [
        ("jobs", str(count.jobs)),
        ("already in the table", str(count.there)),
        ("to compute", str(len(waiting))),
        ("frames to track", str(count.frames)),
        ("in parallel", str(workers)),
        ("expected time", expected),
    ]
    table = Table(f"Plan of the sweep to {request.table}", ("what", ">value"), rows)
    put_result(facts, table, as_json=as_json)
    return OK


def _probe(job: Job) -> tuple[tuple[Job, ...], dict[str, JobResult]]:
    """Track a few frames of a job to learn how long it takes."""
    say(f"Tracking up to {_LONGEST_PROBE} frames to estimate the time of a job.")
    spec = dataclasses.replace(job.spec, frames=job.frames[:_LONGEST_PROBE])
    short = dataclasses.replace(job, spec=spec)
    return (short,), {result.identity: result for result in do_batch((short,))}


def _report(store: SweepStore, outcome: SweepOutcome, by: str, *, as_json: bool) -> int:
    jobs, results = outcome.jobs, store.results
    summaries = summarised(jobs, results, by)
    different = {job.identity for job in jobs}
    failed = sum(one in results and not results[one].done for one in different)
    if as_json:
        put_json(
            {
                "table": store.places.table,
                "jobs": len(different),
                "computed": outcome.computed,
                "reused": outcome.reused,
                "failed": failed,
                "stopped": outcome.stopped,
                "judged_by": by,
                "points": [_point_facts(summary) for summary in summaries],
            }
        )
    elif summaries:
        put_table(_point_table(summaries, by))
        put(f"{store.places.table}: {outcome.computed} computed, {outcome.reused} reused.")
    for line in _failures(jobs, results):
        say(line)
    if outcome.stopped:
        say("Stopped. Finished results are kept; run the same command again to continue.")
    return FAILED if outcome.stopped or failed else OK


_WITH_TRUTH = ("torso_position", "upper_arms", "forearms", "lost", "not_tracked")
_WITHOUT = ("gaps", "unexplained_fraction", "residual", "limb_sigma", "limb_lost")
_CLOUDLESS = ("gaps", "keypoint_error", "limb_sigma")
_MOST_ROWS = 40


def _point_table(summaries: Sequence[PointSummary], by: str) -> Table:
    """Mean and spread of every point over recordings and seeds, best first."""
    varied = varied_names(summary.point for summary in summaries)
    known = any(math.isfinite(one.values["forearms"].mean) for one in summaries)
    clouds = any(math.isfinite(one.values["residual"].mean) for one in summaries)
    without = _WITHOUT if clouds else _CLOUDLESS
    names = dict.fromkeys((by, *(_WITH_TRUTH if known else without), "frames_per_second"))
    measures = [measure for name in names if (measure := measure_named(name)) is not None]
    rows = [_row(summary, varied, measures) for summary in summaries[:_MOST_ROWS]]
    more = len(summaries) - len(rows)
    judged = (measures[0].short or measures[0].label) if measures else by
    title = f"Mean ± standard deviation over recordings and seeds, best {judged} first"
    if more > 0:
        title += f"; the table has {more} more points"
    headings = [f">{one.short or one.label} {one.unit}".strip() for one in measures]
    return Table(title, (*varied, ">runs", *headings), rows)


def _row(
    summary: PointSummary, varied: Sequence[str], measures: Sequence[SweepMeasure]
) -> list[str]:
    values = summary.point.by_name
    runs = str(summary.runs) + (f", {summary.failed} failed" if summary.failed else "")
    cells = [summary.values[measure.name].text() for measure in measures]
    return [*(text_of(values.get(name, "")) for name in varied), runs, *cells]


def text_of(value: object) -> str:
    """A value as a person types it."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:g}" if isinstance(value, float) else str(value)


def _point_facts(summary: PointSummary) -> dict[str, Any]:
    """The same for JSON."""
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


def _failures(jobs: Sequence[Job], results: Mapping[str, JobResult]) -> list[str]:
    """What went wrong, once for each kind of error, with the number of its jobs."""
    found: dict[str, list[Job]] = {}
    for job in {job.identity: job for job in jobs}.values():
        result = results.get(job.identity)
        if result is not None and not result.done:
            found.setdefault(result.error, []).append(job)
    lines = []
    for error, own in found.items():
        first = own[0]
        which = f"{first.recording}, {_named(first.point)}seed {first.seed}"
        more = f" and {len(own) - 1} more" if len(own) > 1 else ""
        lines.append(f"Failed: {which}{more}: {error}")
    return lines


def _named(point: Point) -> str:
    return "".join(f"{name}={text_of(value)}, " for name, value in point.values if name != "seed")

"""``stereotrack sweep``: many runs over recordings, seeds and values of parameters."""

from __future__ import annotations

import dataclasses
import math
from argparse import ArgumentParser, Namespace
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stereotrack_core.cli.arguments import (
    add_frames,
    add_json,
    add_settings,
    add_views,
    check_output,
)
from stereotrack_core.cli.command import FAILED, OK, Command
from stereotrack_core.cli.output import Table, number, put, put_json, put_table, say
from stereotrack_core.cli.progress import progress, stoppable
from stereotrack_core.experiments.sweep.request import TRIALS, SweepRequest

if TYPE_CHECKING:
    from stereotrack_core.experiments.measures import SweepMeasure
    from stereotrack_core.experiments.runner.cluster import ClusterWorkers
    from stereotrack_core.experiments.runner.job import Job, JobResult
    from stereotrack_core.experiments.runner.local import LocalWorkers
    from stereotrack_core.experiments.sweep.plan import SweepPlan
    from stereotrack_core.experiments.sweep.points import Point
    from stereotrack_core.experiments.sweep.run import SweepOutcome
    from stereotrack_core.experiments.sweep.store import SweepStore
    from stereotrack_core.experiments.sweep.summary import PointSummary

_LONGEST_PROBE = 10
"""Frames that are tracked for an estimate where nothing has been measured yet."""


def add_arguments(parser: ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument(
        "recordings", type=Path, nargs="+", metavar="RECORDING", help="recordings to track"
    )
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        required=True,
        dest="table",
        metavar="TABLE.csv",
        help="results table to write; results are stored in it immediately, so that the same "
        "command resumes a stopped sweep",
    )
    _add_points(parser)
    add_settings(parser)
    add_frames(parser)
    add_views(parser)
    parser.add_argument(
        "--init",
        default="auto",
        metavar="auto|tpose|FILE",
        help="initial pose, as for track (default: auto)",
    )
    parser.add_argument("--smooth", action="store_true", help="smooth the runs")
    _add_workers(parser)
    parser.add_argument(
        "--again", action="store_true", help="recompute results that are already in the table"
    )
    parser.add_argument(
        "--dry-run",
        action="store_true",
        help="only print what would be computed, and the expected time",
    )
    add_json(parser)


def _add_points(parser: ArgumentParser) -> None:
    parser.add_argument(
        "--grid",
        action="append",
        default=[],
        metavar="NAME=a,b,c",
        help="values of a parameter, or of views, preset, seed, frames, init or smooth; if given "
        "several times, all combinations are tried",
    )
    parser.add_argument(
        "--list",
        type=Path,
        dest="points",
        metavar="FILE.csv",
        help="file with the points to try: one column per name, one row per point",
    )
    parser.add_argument(
        "--search",
        action="append",
        default=[],
        metavar="NAME=LOW:HIGH[:log|int]",
        help="search for the best value in a range, or among NAME=a,b,c; repeat it for more",
    )
    parser.add_argument(
        "--trials",
        type=int,
        default=TRIALS,
        metavar="N",
        help=f"number of points that a search tries (default: {TRIALS})",
    )
    parser.add_argument(
        "--search-seed",
        type=int,
        default=0,
        metavar="N",
        help="random seed of the search (default: 0)",
    )
    parser.add_argument(
        "--minimise",
        metavar="MEASURE",
        help="column that the search minimises (default: forearms where all recordings have a "
        "reference, else unexplained_fraction); measures for which higher is better are maximised",
    )
    parser.add_argument(
        "--seeds", default="0", metavar="0,1,2", help="comma-separated seeds (default: 0)"
    )


def _add_workers(parser: ArgumentParser) -> None:
    parser.add_argument(
        "--workers",
        type=int,
        metavar="N",
        help="number of processes on this machine (default: one per core)",
    )
    parser.add_argument(
        "--together",
        type=int,
        metavar="N",
        help="largest number of jobs that one process runs together to share their clouds "
        "(default: 8, fewer for long recordings); jobs in progress are lost when the program is "
        "killed",
    )
    parser.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="compute on a Dask cluster: tcp://host:port, or a scheduler file (.json)",
    )
    parser.add_argument(
        "--retries",
        type=int,
        default=1,
        metavar="N",
        help="number of retries after a job failed by chance (default: 1)",
    )


def run(args: Namespace) -> int:
    """Plan, compute what is missing, print."""
    from stereotrack_core.experiments.sweep.plan import SweepPlan
    from stereotrack_core.experiments.sweep.run import SweepRun
    from stereotrack_core.experiments.sweep.store import SweepPlaces, SweepStore
    from stereotrack_core.recording.folder import open_recordings

    request = _request(args)
    request.check()
    recordings = open_recordings(request.recordings)
    for recording in recordings:
        check_output(request.table, recording)
    plan = SweepPlan(request, recordings)
    if args.dry_run:
        return _tell_plan(plan, as_json=args.json)
    store = SweepStore(SweepPlaces(request.table))
    try:
        with (
            _executor(request) as executor,
            progress("Sweeping", 100) as show,
            stoppable() as stopped,
        ):
            work = SweepRun(plan, store, executor, on_percent=show, cancelled=stopped)
            outcome = work.do()
        return _report(store, outcome, plan.by, as_json=args.json)
    finally:
        store.close()


def _request(args: Namespace) -> SweepRequest:
    given: dict[str, Any] = {}
    for field in dataclasses.fields(SweepRequest):
        value = getattr(args, field.name)
        given[field.name] = tuple(value) if isinstance(value, list) else value
    return SweepRequest(**given)


def _executor(request: SweepRequest) -> ClusterWorkers | LocalWorkers:
    if request.scheduler:
        from stereotrack_core.experiments.runner.cluster import ClusterWorkers

        return ClusterWorkers(request.scheduler, retries=request.retries)
    from stereotrack_core.experiments.runner.local import LocalWorkers
    from stereotrack_core.worker_processes import usable_cores

    count = request.workers or usable_cores()
    return LocalWorkers(count, together=request.together, retries=request.retries)


def _tell_plan(plan: SweepPlan, *, as_json: bool) -> int:
    """Say what would be computed, and how long it would take."""
    from stereotrack_core.experiments.durations import in_words
    from stereotrack_core.experiments.sweep.estimate import expected_seconds
    from stereotrack_core.experiments.sweep.plan import count_of
    from stereotrack_core.experiments.sweep.store import SweepPlaces, stored_results

    request = plan.request
    known = {} if request.again else stored_results(SweepPlaces(request.table))
    with _executor(request) as executor:
        workers = executor.count
    count, waiting = count_of(plan.jobs_to_count(), known, workers)
    seconds, source = count.seconds, "from earlier results"
    if seconds is None:
        seconds = expected_seconds(waiting, *_probe(waiting[0]), workers)
        source = f"rough estimate from the first {_LONGEST_PROBE} frames of one job"
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
    if as_json:
        put_json(facts)
        return OK
    rows = [
        ("jobs", str(facts["jobs"])),
        ("already in the table", str(facts["in_table"])),
        ("to compute", str(facts["to_compute"])),
        ("frames to track", str(facts["frames"])),
        ("in parallel", str(workers)),
        ("expected time", "unknown" if seconds is None else f"{in_words(seconds)} ({source})"),
    ]
    put_table(Table(f"Plan of the sweep to {request.table}", ("what", ">value"), rows))
    return OK


def _probe(job: Job) -> tuple[tuple[Job, ...], dict[str, JobResult]]:
    """Track a few frames of a job to learn how long it takes."""
    from stereotrack_core.experiments.runner.work import do_batch

    say(f"Tracking up to {_LONGEST_PROBE} frames to estimate the time of a job.")
    spec = dataclasses.replace(job.spec, frames=job.frames[:_LONGEST_PROBE])
    short = dataclasses.replace(job, spec=spec)
    return (short,), {result.identity: result for result in do_batch((short,))}


def _report(store: SweepStore, outcome: SweepOutcome, by: str, *, as_json: bool) -> int:
    from stereotrack_core.experiments.sweep.summary import summarised

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
                "points": [point_facts(summary) for summary in summaries],
            }
        )
    elif summaries:
        put_table(point_table(summaries, by))
        put(f"{store.places.table}: {outcome.computed} computed, {outcome.reused} reused.")
    for line in failures(jobs, results):
        say(line)
    if outcome.stopped:
        say("Stopped. Finished results are kept; run the same command again to continue.")
    return FAILED if outcome.stopped or failed else OK


_WITH_TRUTH = ("torso_position", "upper_arms", "forearms", "lost", "not_tracked")
_WITHOUT = ("gaps", "unexplained_fraction", "residual", "limb_sigma", "limb_lost")
_MOST_ROWS = 40


def point_table(summaries: Sequence[PointSummary], by: str) -> Table:
    """Mean and spread of every point over recordings and seeds, best first."""
    from stereotrack_core.experiments.measures import measure_named
    from stereotrack_core.experiments.sweep.points import varied_names

    varied = varied_names(summary.point for summary in summaries)
    known = any(math.isfinite(one.mean["forearms"]) for one in summaries)
    names = dict.fromkeys((by, *(_WITH_TRUTH if known else _WITHOUT), "frames_per_second"))
    measures = [measure for name in names if (measure := measure_named(name)) is not None]
    rows = [_row(summary, varied, measures) for summary in summaries[:_MOST_ROWS]]
    more = len(summaries) - len(rows)
    judged = (measures[0].short or measures[0].label) if measures else by
    title = f"Mean ± standard deviation over recordings and seeds, best {judged} first"
    if more > 0:
        title += f"; the table has {more} more points"
    return Table(title, (*varied, ">runs", *(f">{_brief(measure)}" for measure in measures)), rows)


def _row(
    summary: PointSummary, varied: Sequence[str], measures: Sequence[SweepMeasure]
) -> list[str]:
    values = summary.point.by_name
    runs = str(summary.runs) + (f", {summary.failed} failed" if summary.failed else "")
    cells = [_figure(summary, measure) for measure in measures]
    return [*(text_of(values.get(name, "")) for name in varied), runs, *cells]


def _figure(summary: PointSummary, measure: SweepMeasure) -> str:
    mean, spread = summary.mean[measure.name], summary.spread[measure.name]
    return number(mean) + (f" ± {number(spread)}" if math.isfinite(spread) else "")


def _brief(measure: SweepMeasure) -> str:
    return f"{measure.short or measure.label} {measure.unit}".strip()


def text_of(value: object) -> str:
    """A value as a person types it."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:g}" if isinstance(value, float) else str(value)


def point_facts(summary: PointSummary) -> dict[str, Any]:
    """The same for JSON."""
    return {
        "values": summary.point.by_name,
        "runs": summary.runs,
        "failed": summary.failed,
        "mean": _known(summary.mean),
        "standard_deviation": _known(summary.spread),
    }


def _known(values: Mapping[str, float]) -> dict[str, float]:
    from stereotrack_core.experiments.measures import MEASURES

    return {m.name: values[m.name] for m in MEASURES if math.isfinite(values[m.name])}


def failures(jobs: Sequence[Job], results: Mapping[str, JobResult]) -> list[str]:
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


COMMAND = Command(
    name="sweep",
    summary="track with several parameter values, recordings and seeds, and compare the results",
    description=(
        "Track recordings with every combination of values (--grid), with the points of a list "
        "(--list) or in search of the best values (--search), each with all seeds, and write one "
        "row per run to a table. Results already in the table are not computed again, so the same "
        "command resumes a stopped sweep. References are only used to measure errors, never by "
        "the tracker."
    ),
    add_arguments=add_arguments,
    run=run,
)

"""``stereotrack sweep``: many runs over recordings, seeds and values of parameters."""

from __future__ import annotations

import dataclasses
from argparse import ArgumentParser, Namespace
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from stereotrack_core.cli.arguments import (
    add_frames,
    add_json,
    add_settings,
    add_views,
    check_output,
    recordings_of,
    seeds_of,
)
from stereotrack_core.cli.command import FAILED, OK, Command
from stereotrack_core.cli.output import Table, put, put_json, put_table, say
from stereotrack_core.cli.sweep_words import in_words

if TYPE_CHECKING:
    from stereotrack_core.cli.sweep_files import SweepStore
    from stereotrack_core.cli.sweep_run import SweepOutcome
    from stereotrack_core.experiments.sweep.cluster import ClusterWorkers
    from stereotrack_core.experiments.sweep.jobs import Job, Planner
    from stereotrack_core.experiments.sweep.pool import LocalWorkers
    from stereotrack_core.experiments.sweep.results import JobResult
    from stereotrack_core.experiments.sweep.search import Range

_TRIALS = 30
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
        metavar="TABLE.csv",
        help="table to write; results are kept beside it at once, so that the same command goes "
        "on where it was stopped",
    )
    _add_points(parser)
    add_settings(parser)
    add_frames(parser)
    add_views(parser)
    parser.add_argument(
        "--init",
        default="auto",
        metavar="auto|tpose|FILE",
        help="where the first pose comes from, as for track (default: auto)",
    )
    parser.add_argument("--smooth", action="store_true", help="go over runs backwards as well")
    _add_workers(parser)
    parser.add_argument(
        "--again", action="store_true", help="compute also what is in the table already"
    )
    parser.add_argument(
        "--dry-run", action="store_true", help="only say what would be computed, and how long"
    )
    add_json(parser)


def _add_points(parser: ArgumentParser) -> None:
    parser.add_argument(
        "--grid",
        action="append",
        default=[],
        metavar="NAME=a,b,c",
        help="values of a parameter, or of views, preset, seed, frames, init or smooth; given "
        "several times, every combination is tried",
    )
    parser.add_argument(
        "--list", type=Path, metavar="FILE.csv", help="points to try: a column per name, a row each"
    )
    parser.add_argument(
        "--search",
        action="append",
        default=[],
        metavar="NAME=LOW:HIGH[:log|int]",
        help="look for the best value between two, or among NAME=a,b,c; may be given several times",
    )
    parser.add_argument(
        "--trials",
        type=int,
        default=_TRIALS,
        metavar="N",
        help=f"points that a search tries (default: {_TRIALS})",
    )
    parser.add_argument(
        "--search-seed", type=int, default=0, metavar="N", help="seed of the search (default: 0)"
    )
    parser.add_argument(
        "--minimise",
        metavar="MEASURE",
        help="column that says which point is best (default: forearms where all recordings have a "
        "reference, else unexplained_fraction); one of which more is better is made large",
    )
    parser.add_argument(
        "--seeds", default="0", metavar="0,1,2", help="seeds, joined by commas (default: 0)"
    )


def _add_workers(parser: ArgumentParser) -> None:
    parser.add_argument(
        "--workers", type=int, metavar="N", help="processes on this machine (default: its cores)"
    )
    parser.add_argument(
        "--together",
        type=int,
        metavar="N",
        help="jobs that one process does together at most, so that clouds are made once for all "
        "(default: 8, fewer of long recordings); what is in work is lost when the program is "
        "killed",
    )
    parser.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="compute on a Dask cluster instead: tcp://host:port, or a scheduler file (.json)",
    )
    parser.add_argument(
        "--retries",
        type=int,
        default=1,
        metavar="N",
        help="how often a job is tried again that failed by chance (default: 1)",
    )


def run(args: Namespace) -> int:
    """Plan, compute what is missing, print."""
    from stereotrack_core.cli import sweep_plan as plan
    from stereotrack_core.cli.sweep_files import SweepPlaces, SweepStore, stored_results

    plan.check_numbers(args)
    recordings = recordings_of(args.recordings)
    for recording in recordings:
        check_output(args.output, recording)
    by = plan.judged_by(args.minimise, recordings)
    planner = plan.sweep_planner(recordings, args)
    ranges = plan.sweep_ranges(args)
    jobs = () if ranges else planner.jobs(plan.sweep_points(args))
    places = SweepPlaces(args.output)
    if args.dry_run:
        known = {} if args.again else stored_results(places)
        return _tell_plan(jobs or planner.jobs(plan.first_points(ranges, args)), known, args)
    store = SweepStore(places)
    try:
        outcome = _done(store, planner, jobs, ranges, by, args)
        return _report(store, outcome, by, args)
    finally:
        store.close()


def _done(
    store: SweepStore,
    planner: Planner,
    jobs: Sequence[Job],
    ranges: Sequence[Range],
    by: str,
    args: Namespace,
) -> SweepOutcome:
    from stereotrack_core.cli.sweep_plan import search_batch, search_signature
    from stereotrack_core.cli.sweep_run import SweepRun

    with _executor(args) as executor:
        work = SweepRun(store, executor, again=args.again)
        if not ranges:
            return work.grid(jobs)
        each = len(args.recordings) * len(seeds_of(args.seeds))
        signature = search_signature(ranges, by, args.search_seed)
        batch = store.search_batch(signature, search_batch(each, executor.count))
        return work.search(planner, ranges, by, args.trials, args.search_seed, batch)


def _executor(args: Namespace) -> ClusterWorkers | LocalWorkers:
    if args.scheduler:
        from stereotrack_core.experiments.sweep.cluster import ClusterWorkers

        return ClusterWorkers(args.scheduler, retries=args.retries)
    from stereotrack_core.experiments.sweep.pool import LocalWorkers
    from stereotrack_core.worker_processes import usable_cores

    count = args.workers or usable_cores()
    return LocalWorkers(count, together=args.together, retries=args.retries)


def _tell_plan(jobs: Sequence[Job], known: Mapping[str, JobResult], args: Namespace) -> int:
    """Say what would be computed, and how long it would take."""
    from stereotrack_core.cli.sweep_plan import count_of
    from stereotrack_core.experiments.sweep.estimate import expected_seconds
    from stereotrack_core.worker_processes import usable_cores

    if args.scheduler:
        with _executor(args) as executor:
            workers = executor.count
    else:
        workers = args.workers or usable_cores()
    count, waiting = count_of(jobs, known, workers)
    seconds, source = count.seconds, "from what was computed before"
    if seconds is None:
        seconds = expected_seconds(waiting, *_probe(waiting[0]), workers)
        source = f"roughly, from the first {_LONGEST_PROBE} frames of one job"
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
    if args.json:
        put_json(facts)
        return OK
    rows = [
        ("jobs", str(facts["jobs"])),
        ("in the table already", str(facts["in_table"])),
        ("to compute", str(facts["to_compute"])),
        ("frames to track", str(facts["frames"])),
        ("at once", str(workers)),
        ("expected time", "not known" if seconds is None else f"{in_words(seconds)} ({source})"),
    ]
    put_table(Table(f"What a sweep to {args.output} would do", ("what", ">value"), rows))
    return OK


def _probe(job: Job) -> tuple[tuple[Job, ...], dict[str, JobResult]]:
    """Track a few frames of a job to learn how long it takes."""
    from stereotrack_core.experiments.sweep.work import do_batch

    say(f"Tracking up to {_LONGEST_PROBE} frames to learn how long a job takes.")
    short = dataclasses.replace(job, end=min(job.end, job.first + _LONGEST_PROBE))
    return (short,), {result.identity: result for result in do_batch((short,))}


def _report(store: SweepStore, outcome: SweepOutcome, by: str, args: Namespace) -> int:
    from stereotrack_core.cli.sweep_tables import failures, point_facts, point_table
    from stereotrack_core.experiments.sweep.summary import summarised

    jobs, results = outcome.jobs, store.results
    summaries = summarised(jobs, results, by)
    different = {job.identity for job in jobs}
    failed = sum(one in results and not results[one].done for one in different)
    if args.json:
        put_json(
            {
                "table": args.output,
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
        put(f"{args.output}: {outcome.computed} computed, {outcome.reused} reused.")
    for line in failures(jobs, results):
        say(line)
    if outcome.stopped:
        say("Stopped; what is done is kept. The same command goes on where it was.")
    return FAILED if outcome.stopped or failed else OK


COMMAND = Command(
    name="sweep",
    summary="track with many values of parameters, recordings and seeds, and compare them",
    description=(
        "Track recordings with every combination of values (--grid), with the points of a list "
        "(--list) or in search of the best ones (--search), each with all seeds, and write one "
        "row per run to a table. What is in the table already is not computed again: the same "
        "command goes on where it was stopped. References are only read to measure errors, never "
        "by the tracker."
    ),
    add_arguments=add_arguments,
    run=run,
)

"""``stereotrack sweep``: a study that the command describes and whose runs are not kept."""

from __future__ import annotations

import math
from argparse import Namespace
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from stereotrack_core.cli.arguments import (
    JSON,
    KEYPOINT_OPTIONS,
    check_least,
    check_output,
    check_suffix,
    option,
)
from stereotrack_core.cli.output import FAILED, OK, put, put_json, put_table, say
from stereotrack_core.cli.progress import watched
from stereotrack_core.cli.studies.run import tell_plan
from stereotrack_core.cli.studies.shared import RUNNING, SETTINGS, settings_of, workers_of
from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError, did_you_mean
from stereotrack_core.evaluation.measures import MEASURES, Measure, measure_named
from stereotrack_core.locks import refuse_second
from stereotrack_core.parameters import value_text
from stereotrack_core.recording.selection import gives_depth
from stereotrack_core.study.description import Study, StudyRecording, check_rows
from stereotrack_core.study.job import Job, JobResult
from stereotrack_core.study.plan import Source, jobs_of, source_of
from stereotrack_core.study.points import varied_names
from stereotrack_core.study.run import Outcome, PointSummary, StudyRun, missing, summarised
from stereotrack_core.study.search import parsed_range
from stereotrack_core.study.store import Store, stored_results
from stereotrack_core.tables import Table

_TRIALS = 30

DESCRIPTION = (
    "Track recordings with every combination of values (--grid) or in search of the best values "
    "(--search), each with all seeds, and write one row per run to a table. Results already in "
    "the table are not computed again, so the same command resumes a stopped sweep. References "
    "are only used to measure errors, never by the tracker."
)

OPTIONS = (
    option("recordings RECORDING", "recordings to track", type=Path, nargs="+"),
    option(
        "-o --output TABLE.csv",
        "results table to write; results are stored at once in a journal beside it, so that the "
        "same command resumes a stopped sweep",
        type=Path,
        required=True,
        dest="table",
    ),
    *SETTINGS,
    option(
        "--search NAME=LOW:HIGH[:log]",
        "search for the best value in a range, or among NAME=a,b,c; repeat it for more",
        action="append",
        default=[],
    ),
    option(
        "--trials N",
        f"number of points that a search tries (default: {_TRIALS})",
        type=int,
        default=_TRIALS,
    ),
    option(
        "--minimise MEASURE",
        "column that the search minimises (default: forearms where all recordings have a "
        "reference, else unexplained_fraction, or keypoint_error for mono views); measures for "
        "which higher is better are maximised",
    ),
    *KEYPOINT_OPTIONS,
    *RUNNING,
    JSON,
)


def run(args: Namespace) -> int:
    """Plan, compute what is missing, print."""
    study = _study_of(args)
    refuse_second(args.table)
    ranges = [parsed_range(text) for text in args.search]
    sources = [source_of(study, row) for row in study.rows]
    for source in sources:
        check_output(args.table, source.recording)
    by = _judged_by(args.minimise, sources)
    points = study.settings.all_points()
    jobs = tuple(job for one in sources for job in jobs_of(study, one, points, keep=False))
    workers = workers_of(args)
    if args.dry_run:
        if ranges:
            say(f"The search tries {args.trials} points; this is the plan of one of them.")
        waiting = missing(jobs, stored_results(args.table), again=args.again)
        return tell_plan(f"Plan of the sweep to {args.table}", jobs, waiting, as_json=args.json)
    with workers, Store(args.table) as store, watched("Sweeping", "") as (report, stopped):
        work = StudyRun(store, workers, again=args.again, on_progress=report, cancelled=stopped)
        if ranges:
            outcome = work.search(study, sources, ranges, by=by, trials=args.trials)
        else:
            outcome = work.do(jobs)
    return _report(store, outcome, by, as_json=args.json)


def _study_of(args: Namespace) -> Study:
    """The study that the command describes. Raises InputError if it makes no sense."""
    check_suffix(args.table, ".csv")
    check_least(1, trials=args.trials)
    settings = settings_of(args)
    if args.search and settings.grid:
        raise InputError(
            "a sweep uses a grid or a search",
            where="--grid, --search",
            remedy="Use only one of them.",
        )
    if args.keypoints and len(args.keypoints) != len(args.recordings):
        raise InputError(
            f"keypoints are given {len(args.keypoints)} times for "
            f"{counted(len(args.recordings), 'recording')}",
            where="--keypoints",
            remedy="Give them once for each recording, in the order of the recordings.",
        )
    keypoints = args.keypoints or [""] * len(args.recordings)
    rows = tuple(
        StudyRecording(str(folder.absolute()), keypoints=str(file and file.absolute()))
        for folder, file in zip(args.recordings, keypoints, strict=True)
    )
    study = Study(args.table, rows, settings)
    check_rows(study)
    return study


def _judged_by(asked: str | None, sources: Sequence[Source]) -> str:
    """Measure that says which point is best.

    Raises InputError for an unknown one, or one that needs what is not there.
    """
    without = [one.recording for one in sources if one.recording.reference is None]
    if asked is None:
        clouds = all(gives_depth(one.recording) for one in sources)
        of_itself = "unexplained_fraction" if clouds else "keypoint_error"
        return of_itself if without else "forearms"
    measure = measure_named(asked)
    if measure is None:
        names = [one.name for one in MEASURES]
        raise InputError(
            f"unknown measure {asked!r}",
            where="--minimise",
            remedy=f"{did_you_mean(asked, names)}Available: {', '.join(names)}.",
        )
    if asked == "keypoint_error" and None in [one.keypoints for one in sources]:
        raise InputError(
            "the keypoint error needs keypoints",
            where="--minimise",
            remedy="Give them with --keypoints, or choose another measure.",
        )
    if measure.from_reference and without:
        raise InputError(
            f"{asked} needs a reference, which {without[0].name} does not have",
            where="--minimise",
            remedy="Choose unexplained_fraction, or recordings with a reference.csv.",
        )
    return asked


def _report(store: Store, outcome: Outcome, by: str, *, as_json: bool) -> int:
    jobs, results = outcome.jobs, store.results
    summaries = summarised(jobs, results, by)
    different = {job.identity for job in jobs}
    failed = sum(one in results and not results[one].done for one in different)
    if as_json:
        put_json(
            {
                "table": store.table,
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
        put(f"{store.table}: {outcome.computed} computed, {outcome.reused} reused.")
    for line in _failures(jobs, results):
        say(line)
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
    rows = [_row(summary, varied, measures) for summary in summaries[:_MOST_ROWS]]
    title = (
        f"Mean ± standard deviation over recordings and seeds, best "
        f"{measures[0].short or measures[0].label} first"
    )
    if len(summaries) > len(rows):
        title += f"; the table has {len(summaries) - len(rows)} more points"
    headings = [f">{one.short or one.label} {one.unit}".strip() for one in measures]
    return Table(title, (*varied, ">runs", *headings), rows)


def _row(summary: PointSummary, varied: Sequence[str], measures: Sequence[Measure]) -> list[str]:
    values = summary.point.by_name
    runs = str(summary.runs) + (f", {summary.failed} failed" if summary.failed else "")
    cells = [summary.values[measure.name].text() for measure in measures]
    return [*(value_text(values.get(name, "")) for name in varied), runs, *cells]


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


def _failures(jobs: Sequence[Job], results: Mapping[str, JobResult]) -> list[str]:
    """Errors of failed jobs, once for each kind of error, with the number of its jobs."""
    found: dict[str, list[Job]] = {}
    for job in {job.identity: job for job in jobs}.values():
        result = results.get(job.identity)
        if result is not None and not result.done:
            found.setdefault(result.error, []).append(job)
    lines = []
    for error, own in found.items():
        first = own[0]
        values = first.point.without_seed.values
        named = "".join(f"{name}={value_text(value)}, " for name, value in values)
        more = f" and {len(own) - 1} more" if len(own) > 1 else ""
        lines.append(f"Failed: {first.recording}, {named}seed {first.seed}{more}: {error}")
    return lines

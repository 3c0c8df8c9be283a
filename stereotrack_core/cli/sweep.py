"""``stereotrack sweep``: a study that the command describes and whose runs are not kept."""

import math
from argparse import Namespace
from collections.abc import Sequence
from typing import Any

from stereotrack_core.cli import options
from stereotrack_core.cli.output import FAILED, OK, put, put_json, put_table, say, watched
from stereotrack_core.cli.study import RUNNING, SETTINGS, settings_of, workers_of
from stereotrack_core.errors import InputError, did_you_mean
from stereotrack_core.evaluation.measures import MEASURES, measure_named
from stereotrack_core.locks import refuse_second
from stereotrack_core.parameters import value_text
from stereotrack_core.recording.selection import gives_depth
from stereotrack_core.study.description import Study, StudyRecording, check_rows
from stereotrack_core.study.points import parsed_range, varied_names
from stereotrack_core.study.run import (
    Outcome,
    PointSummary,
    Source,
    StudyRun,
    jobs_of,
    source_of,
    summarised,
)
from stereotrack_core.study.store import Store
from stereotrack_core.tables import Table

_TRIALS = 30


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
    options.several(
        "--search NAME=LOW:HIGH[:log]",
        "search for the best value in a range, or among NAME=a,b,c; repeat it for more",
    ),
    options.option(
        "--trials N",
        f"number of points that a search tries (default: {_TRIALS})",
        type=options.at_least(1),
        default=_TRIALS,
    ),
    options.option(
        "--minimise MEASURE",
        "column that the search minimises (default: forearms where all recordings have a "
        "reference, else unexplained_fraction, or keypoint_error for mono views); measures for "
        "which higher is better are maximised",
    ),
    *RUNNING,
)
def run(args: Namespace) -> int:
    """Track recordings with every combination of values (--grid) or in search of the best
    values (--search), each with all seeds, and write one row per run to a table. Results
    already in the table are not computed again, so the same command resumes a stopped sweep.
    References are only used to measure errors, never by the tracker.
    """
    study = _study_of(args)
    refuse_second(args.table)
    ranges = [parsed_range(text) for text in args.search]
    sources = [source_of(study, row) for row in study.rows]
    for source in sources:
        options.check_output(args.table, source.recording.folder)
    by = _judged_by(args.minimise, sources)
    points = study.settings.all_points()
    jobs = tuple(job for one in sources for job in jobs_of(study, one, points, keep=False))
    workers = workers_of(args)
    with workers, Store(args.table) as store, watched("Sweeping", "") as (report, stopped):
        work = StudyRun(store, workers, on_progress=report, cancelled=stopped)
        if ranges:
            outcome = work.search(study, sources, ranges, by=by, trials=args.trials)
        else:
            outcome = work.do(jobs)
    return _report(store, outcome, by, as_json=args.json)


def _study_of(args: Namespace) -> Study:
    options.check_suffix(args.table, ".csv")
    settings = settings_of(args)
    if args.search and settings.grid:
        what = "a sweep uses a grid or a search"
        raise InputError(what, where="--grid, --search", remedy="Use only one of them.")
    rows = tuple(StudyRecording(str(folder.absolute())) for folder in args.recordings)
    study = Study(args.table, rows, settings)
    check_rows(study)
    return study


def _judged_by(asked: str | None, sources: Sequence[Source]) -> str:
    """Measure that says which point is best; InputError for an unknown or impossible one."""
    without = [one.recording for one in sources if one.recording.reference is None]
    if asked is None:
        clouds = all(gives_depth(one.recording) for one in sources)
        of_itself = "unexplained_fraction" if clouds else "keypoint_error"
        return of_itself if without else "forearms"
    measure = measure_named(asked)
    if measure is None:
        names = [one.name for one in MEASURES]
        remedy = f"{did_you_mean(asked, names)}Available: {', '.join(names)}."
        raise InputError(f"unknown measure {asked!r}", where="--minimise", remedy=remedy)
    if measure.from_reference and without:
        what = f"{asked} needs a reference, which {without[0].name} does not have"
        remedy = "Choose unexplained_fraction, or recordings with a reference.csv."
        raise InputError(what, where="--minimise", remedy=remedy)
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
    for job in {job.identity: job for job in jobs}.values():
        if job.identity in results and not results[job.identity].done:
            values = (f"{name}={value_text(value)}" for name, value in job.point.values)
            where = ", ".join((job.recording, *values, f"seed {job.seed}"))
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
    title = (
        f"Mean ± standard deviation over recordings and seeds, best "
        f"{measures[0].short or measures[0].label} first"
    )
    if len(summaries) > len(rows):
        title += f"; the table has {len(summaries) - len(rows)} more points"
    headings = [f">{one.short or one.label} {one.unit}".strip() for one in measures]
    return Table(title, (*varied, ">runs", *headings), rows)


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

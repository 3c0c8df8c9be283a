"""What the arguments of a sweep ask for, checked before anything long begins."""

from __future__ import annotations

import hashlib
import math
from argparse import Namespace
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from stereotrack_core.cli.arguments import frames_within, seeds_of, settings_of, views_of
from stereotrack_core.cli.tracking_job import first_pose
from stereotrack_core.errors import InputError, did_you_mean
from stereotrack_core.experiments.sweep.estimate import expected_seconds
from stereotrack_core.experiments.sweep.jobs import Base, Job, Planner, Reading
from stereotrack_core.experiments.sweep.measures import MEASURES, measure_named
from stereotrack_core.experiments.sweep.points import Point, grid_points, listed_points, parsed_axis
from stereotrack_core.experiments.sweep.results import JobResult
from stereotrack_core.experiments.sweep.search import Range, Search, parsed_range
from stereotrack_core.interop.table_file import read_csv_table
from stereotrack_core.parameters import parsed_settings
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.reader import FrameReader


@dataclass(frozen=True)
class SweepCount:
    """What a sweep would compute.

    Attributes
    ----------
    jobs : int
        Different runs in all.
    points : int
    there : int
        Jobs that are in the table already.
    frames : int
        Frames of the others.
    workers : int
        Jobs that are done at once.
    seconds : float or None
        What the others will take, from what was computed before; None where nothing was.
    """

    jobs: int
    points: int
    there: int
    frames: int
    workers: int
    seconds: float | None


def count_of(
    jobs: Sequence[Job], known: Mapping[str, JobResult], workers: int
) -> tuple[SweepCount, list[Job]]:
    """What a sweep would compute, and the jobs of it."""
    different = {job.identity: job for job in jobs}
    waiting = [job for one, job in different.items() if one not in known or not known[one].done]
    seconds = expected_seconds(waiting, jobs, known, workers) if waiting else 0.0
    count = SweepCount(
        jobs=len(different),
        points=len({job.point for job in jobs}),
        there=len(different) - len(waiting),
        frames=sum(len(job.frames) for job in waiting),
        workers=workers,
        seconds=seconds,
    )
    return count, waiting


def check_numbers(args: Namespace) -> None:
    """Refuse options that do not go together, and numbers that mean nothing.

    Raises
    ------
    InputError
    """
    least = {"workers": 1, "together": 1, "trials": 1, "retries": 0, "search_seed": 0}
    for name, low in least.items():
        value = getattr(args, name)
        if value is not None and value < low:
            option = f"--{name.replace('_', '-')}"
            raise InputError(
                f"{value} is less than {low}", where=option, remedy=f"Give {low} or more."
            )
    if sum(map(bool, (args.grid, args.list, args.search))) > 1:
        raise InputError(
            "a sweep goes over a grid, a list or a search",
            where="--grid, --list, --search",
            remedy="Give only one kind of them.",
        )
    if args.scheduler and args.workers is not None:
        raise InputError(
            "the work is done on this machine or on a cluster",
            where="--workers, --scheduler",
            remedy="Give one of them.",
        )
    if args.output.suffix.lower() != ".csv":
        raise InputError(
            "the table is written as CSV", where=str(args.output), remedy="Let it end in .csv."
        )


def sweep_planner(recordings: Sequence[Recording], args: Namespace) -> Planner:
    """What makes jobs of points."""
    settings_of(args.preset, args.changes)  # refuses what no point could mend
    base = Base(
        preset=args.preset,
        changes=parsed_settings(args.changes),
        seeds=tuple(seeds_of(args.seeds)),
        views=args.views,
        frames=args.frames,
        init=args.init,
        smooth=args.smooth,
    )
    return Planner(recordings, base, Reading(views_of, frames_within, first_pose, _frame_count))


def sweep_points(args: Namespace) -> tuple[Point, ...]:
    """Points of a grid or a list; one that changes nothing where there is neither."""
    if args.list is not None:
        columns, rows = read_csv_table(args.list)
        return listed_points(columns, rows, str(args.list))
    return grid_points([parsed_axis(text) for text in args.grid])


def sweep_ranges(args: Namespace) -> tuple[Range, ...]:
    """Where a search looks; nothing where there is no search."""
    return tuple(parsed_range(text) for text in args.search)


def first_points(ranges: Sequence[Range], args: Namespace) -> tuple[Point, ...]:
    """As many points as a search will try; for counting jobs."""
    return Search(ranges, args.search_seed).ask(args.trials)


def judged_by(asked: str | None, recordings: Sequence[Recording]) -> str:
    """Measure that says which point is best.

    Raises
    ------
    InputError
        For an unknown one, or one that needs a reference that is not there.
    """
    without = [one for one in recordings if one.reference is None]
    if asked is None:
        return "unexplained_fraction" if without else "forearms"
    measure = measure_named(asked)
    if measure is None:
        names = [one.name for one in MEASURES]
        raise InputError(
            f"there is no measure {asked!r}",
            where="--minimise",
            remedy=f"{did_you_mean(asked, names)}Known are: {', '.join(names)}.",
        )
    if measure.from_reference and without:
        raise InputError(
            f"{asked} is measured against a reference, which {without[0].name} does not have",
            where="--minimise",
            remedy="Choose unexplained_fraction, or recordings with a reference.csv.",
        )
    return asked


def search_batch(runs_per_point: int, at_once: int) -> int:
    """Points that a search asks for at once, so that nobody has to wait for work."""
    return max(1, math.ceil(at_once / runs_per_point))


def search_signature(ranges: Sequence[Range], by: str, seed: int) -> str:
    """Hash by which a search is known again."""
    text = repr((tuple(ranges), by, seed))
    return hashlib.blake2b(text.encode(), digest_size=8).hexdigest()


def _frame_count(recording: Recording) -> int:
    with FrameReader(recording, read_ahead=0) as reader:
        return reader.frame_count

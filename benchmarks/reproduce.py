"""Repeat the thesis's evaluation: its tables 4.1 to 4.4 with our numbers below its own.

``python benchmarks/reproduce.py DIR`` makes four recordings like those of the thesis, tracks them
and writes ``tables.md``. Runs that are finished are kept in DIR.
"""

import math
import sys
from argparse import ArgumentParser
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import as_completed
from dataclasses import dataclass, fields, replace
from functools import reduce
from itertools import pairwise, zip_longest
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

import stereotrack_core as stereotrack
from benchmarks.common import ended, say, worker_pool
from benchmarks.thesis import (
    FAST,
    MOTIONS,
    ROWS,
    TABLES,
    ThesisRecording,
    ThesisTable,
    thesis_recordings,
)
from stereotrack_core.atomic import write_file
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.posing import pose_of_landmarks
from stereotrack_core.errors import InputError
from stereotrack_core.evaluation.summary import (
    LimbErrors,
    Spread,
    errors_against,
    summarise,
    truth_of,
)
from stereotrack_core.recording.description import LENGTHS, Recording, Subject
from stereotrack_core.recording.folder import fingerprint, open_recording
from stereotrack_core.tables import markdown_text
from stereotrack_core.tracking.clouds import Clouds
from stereotrack_core.tracking.frame import Run, TrackedFrame, run_of
from stereotrack_core.tracking.prepare import prepare
from stereotrack_core.tracking.run import advances
from stereotrack_core.tracking.run_spec import RunSpec

THESIS = "thesis"
POINTS = (24, 40, 64, 120)  # model points m of table 4.2; 64 is the preset's
WITH_TWO_CAMERAS = ("P1", "P2", "P4")  # as in the thesis, P3 is left out of table 4.3
SLOW = "slow"  # part of a recording: the frames before the first fast motion
LINES = (*ROWS, ("lost", "arm segments lost", "%"))


@dataclass(frozen=True)
class Way:
    """A way of tracking; with a seed and a recording it is a run."""

    preset: str
    points: int | None = None  # model points m, if other than the preset's
    few_views: bool = False  # only the cameras N and S
    averaged: bool = False  # the same averaged proportions for everybody
    # Set to the reference's pose at the first frame of every segment. A protocol of this evaluation
    # alone, which separates new errors from arms that were lost before.
    restarted: bool = False

    def __str__(self) -> str:
        flags: dict[str, object] = {f"m{self.points}": self.points, "NS": self.few_views}
        flags |= {"averaged": self.averaged, "restarted": self.restarted}
        return "-".join([self.preset, *(name for name, chosen in flags.items() if chosen)])

    def spec(self, seed: int) -> RunSpec:
        """Everything but the recording; the thesis's people stood in the T pose at first."""
        changes = [] if self.points is None else [f"model_points={self.points}"]
        settings = stereotrack.preset(self.preset, changes)
        views = ("N", "S") if self.few_views else None
        init = "tpose" if self.preset == THESIS else "auto"
        return RunSpec(settings, self.preset, views=views, seed=seed, init=init)


Job: TypeAlias = tuple[str, Way, int]  # recording, way of tracking, seed
# Errors of a run by part: SLOW, FAST, and every segment by its name.
Parts: TypeAlias = Mapping[str, LimbErrors]


def jobs(names: Sequence[str], presets: Sequence[str], seeds: int) -> list[Job]:
    """All runs, table 4.1 first. ``thesis``, which draws points at random, runs with all seeds."""
    ways = [Way(name) for name in presets]
    if THESIS in presets:
        ways.append(Way(THESIS, restarted=True))
        ways += [Way(THESIS, points=m) for m in POINTS if m != 64]
    ways += [Way(name, averaged=True) for name in presets]
    ways += [Way(name, few_views=True) for name in presets]
    return [
        (name, way, seed)
        for way in ways
        for name in (names if not way.few_views else WITH_TWO_CAMERAS)
        for seed in range(seeds if way.preset == THESIS else 1)
    ]


def made(folder: Path, one: ThesisRecording) -> Recording:
    """Open a recording, which is rendered if it is missing. Raises InputError for another one."""
    if not (folder / "recording.toml").is_file():
        say(f"Rendering {one.name}, {one.frames} frames.")
        simulation = stereotrack.Simulation(
            one.name, frames=one.frames, options=one.options, parts=one.parts
        )
        stereotrack.simulate(folder, simulation)
    recording = open_recording(folder)
    found = [(segment.name, segment.first, segment.end) for segment in recording.segments]
    if found != [(part.name, part.first, part.end) for part in one.parts]:
        raise InputError(
            "this is a different recording from the one that this version would create",
            where=str(folder),
            remedy="Choose another folder, or delete this recording.",
        )
    return recording


def averaged_subject(subjects: Sequence[Subject | None]) -> Subject:
    """Mean of everybody's lengths; a length that nobody has measured stays unknown."""
    values = {name: [getattr(one, name, None) for one in subjects] for name in LENGTHS}
    known = {name: [one for one in own if one is not None] for name, own in values.items()}
    lengths: dict[str, Any] = {name: float(np.mean(own)) for name, own in known.items() if own}
    return Subject(name="averaged", **lengths)


def tracked(recording: Recording, way: Way, seed: int) -> Run:
    """Track a recording whose subject is settled; a tracker never sees the reference.

    Only a restarted run is given the reference's poses, and its file says so.
    """
    spec, blind = way.spec(seed), replace(recording, reference=None)
    starts = _starts(recording) if way.restarted else {}
    run = _restarted(blind, spec, starts) if starts else stereotrack.track(blind, spec)
    return replace(run, meta={**run.meta, "way": str(way), "started_at_reference": [*starts]})


def _starts(recording: Recording) -> dict[int, Pose]:
    """Poses of the reference at frame 0 and at the first frame of every segment."""
    truth = truth_of(recording)
    at = {int(frame): points for frame, points in zip(truth.frame, truth.points, strict=True)}
    begins = sorted({0, *(segment.first for segment in recording.segments)})
    return {frame: pose_of_landmarks(at[frame]) for frame in begins if frame in at}


def _restarted(recording: Recording, spec: RunSpec, starts: Mapping[int, Pose]) -> Run:
    """Track a recording; before each frame of `starts` the tracker is set to a pose."""
    found: list[TrackedFrame] = []
    with Clouds(recording, replace(spec, init=starts[0])) as clouds:
        run = prepare(clouds)
        for first, end in pairwise([*starts, clouds.frames.stop]):
            run = replace(run, state=run.model.first(starts[first]))
            for advance in advances(run, range(first, end)):
                run, found = advance.run, advance.gained.into(found)
        return run_of(found, run.origin())


def _track_and_write(recording: Recording, way: Way, seed: int, path: Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    stereotrack.write_run(path, tracked(recording, way, seed))


def kept_run(path: Path, recording: Recording, way: Way, seed: int) -> Run | None:
    """Read a finished run; None if it is missing, damaged, or would come out otherwise now."""
    try:
        run = stereotrack.read_run(path)
    except InputError:
        return None
    wanted = {"parameters": way.spec(seed).settings.values(), "seed": seed, "way": str(way)}
    wanted["fingerprint"] = fingerprint(recording)
    return run if all(run.meta.get(key) == value for key, value in wanted.items()) else None


def missing_runs_made(
    folder: Path, recordings: Mapping[str, Recording], wanted: Sequence[Job], workers: int
) -> dict[Job, Parts]:
    """Track what is not there yet, in several processes; errors of all runs."""
    average = averaged_subject([recording.subject for recording in recordings.values()])
    paths = {job: folder / "runs" / job[0] / f"{job[1]}-seed{job[2]}.npz" for job in wanted}
    left = [job for job in wanted if kept_run(paths[job], recordings[job[0]], *job[1:]) is None]
    with worker_pool(workers) as pool:
        futures = {}
        for name, way, seed in left:
            own, path = recordings[name], paths[name, way, seed]
            own = replace(own, subject=average) if way.averaged else own
            futures[pool.submit(_track_and_write, own, way, seed, path)] = path
        for count, future in enumerate(as_completed(futures), start=1):
            future.result()
            say(f"{futures[future]}: {count} of {len(left)}")
    return {
        job: parts_of(recordings[job[0]], stereotrack.read_run(path)) for job, path in paths.items()
    }


def parts_of(recording: Recording, run: Run) -> Parts:
    """Errors of a run against the reference, by part."""
    errors, segments = errors_against(run.trajectory(), truth_of(recording)), recording.segments
    end = int(errors.frame[-1]) + 1
    fast = min((s.first for s in segments if s.name.endswith(FAST)), default=end)
    parts = {SLOW: errors.between(0, fast), FAST: errors.between(fast, end)}
    for name in {segment.name for segment in segments}:
        own = (errors.between(one.first, one.end) for one in segments if one.name == name)
        parts[name] = reduce(_together, own)
    return parts


def _together(one: LimbErrors, later: LimbErrors) -> LimbErrors:
    """Errors of some frames and of later ones."""
    pairs = ((getattr(one, f.name), getattr(later, f.name)) for f in fields(one))
    return LimbErrors(*(np.concatenate(pair) for pair in pairs))


@dataclass(frozen=True)
class Column:
    """What one number is taken from: the runs of a way on some recordings, and their part."""

    way: Way
    names: tuple[str, ...]
    part: str = SLOW

    def figure(self, found: Mapping[Job, Parts], measure: str) -> Spread:
        """Pool over frames, then over seeds; nothing until all recordings have a run."""
        values = []
        for seed in sorted({job[2] for job in found if job[1] == self.way}):
            runs = [found.get((name, self.way, seed)) for name in self.names]
            if None in runs:
                return Spread()
            stretches = [run[self.part] for run in runs if run is not None and self.part in run]
            if stretches:
                pooled = summarise(reduce(_together, stretches))
                is_share = measure == "lost"
                mean = 100.0 * pooled.lost if is_share else pooled.measure(measure).statistics.mean
                values.append(mean)
        return Spread.of(values)


def ways_shown(presets: Sequence[str]) -> list[Way]:
    """Ways that the tables 4.1, of fast motions and of single motions compare."""
    both = [Way(THESIS), Way(THESIS, restarted=True)] if THESIS in presets else []
    return [*both, *(Way(name) for name in presets if name != THESIS)]


def tables(found: Mapping[Job, Parts], names: Sequence[str], presets: Sequence[str]) -> str:
    """All tables as Markdown; the thesis's own numbers stand first."""
    each = [*((name,) for name in names), tuple(names)]
    everybody, plain = tuple(names), [Way(name) for name in presets]
    of_points = [Way(THESIS, points=None if m == 64 else m) for m in POINTS]
    both = [(replace(way, few_views=True), way) for way in plain]
    columns = (
        [[Column(way, own) for own in each] for way in ways_shown(presets)],
        [[Column(way, everybody) for way in of_points]] if THESIS in presets else [],
        [[Column(way, WITH_TWO_CAMERAS) for way in pair] for pair in both],
        [[Column(replace(w, averaged=a), everybody) for a in (True, False)] for w in plain],
    )
    texts = [
        f"## Table {one.number}, page {one.page}: {one.title}\n\n"
        + markdown_text(("", "", *(f">{c}" for c in one.columns)), [*_lines(rows, found, one)])
        + f"\n{one.remark}\n"
        for one, rows in zip(TABLES, columns, strict=True)
    ]
    fast = [[Column(way, own, FAST) for own in each] for way in ways_shown(presets)]
    heads = ("", "", *(f">{name}" for name in (*names, "together")))
    texts.append(f"## Fast motions\n\n{markdown_text(heads, [*_lines(fast, found)])}")
    heads = ("motion", "", *(f">{label} [{unit}]" for _, label, unit in LINES[3:]))
    texts.append(f"## Motions\n\n{markdown_text(heads, [*_motions(found, presets)])}")
    return "\n".join(texts)


def _lines(
    columns: Sequence[Sequence[Column]],
    found: Mapping[Job, Parts],
    given: ThesisTable | None = None,
) -> Iterator[tuple[str, ...]]:
    values = () if given is None else given.values
    for (name, label, unit), own in zip_longest(LINES, values):
        digits = 0 if unit == "mm" else 1
        if own is not None:
            yield (f"{label} [{unit}]", "the thesis", *(f"{v:.{digits}f}" for v in own))
        for row in columns:
            figures = [column.figure(found, name) for column in row]
            if any(math.isfinite(one.mean) for one in figures):
                way = replace(row[0].way, points=None, few_views=False, averaged=False)
                texts = (one.text(digits) for one in figures)
                yield (f"{label} [{unit}]", f"preset {way}", *texts)


def _motions(found: Mapping[Job, Parts], presets: Sequence[str]) -> Iterator[tuple[str, ...]]:
    for motion in (*MOTIONS, *(name + FAST for name in MOTIONS)):
        names = tuple(dict.fromkeys(job[0] for job, parts in found.items() if motion in parts))
        for way in ways_shown(presets):
            figures = (Column(way, names, motion).figure(found, line[0]) for line in LINES[3:])
            yield (motion, f"preset {way}", *(figure.text() for figure in figures))


def main(arguments: Sequence[str] | None = None) -> None:
    """Make the recordings, track them, and write the tables."""
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, help="for recordings, runs and results")
    parser.add_argument("--short", action="store_true", help="some dozen frames: a test")
    parser.add_argument("--presets", default="thesis,accurate", help="comma-separated")
    parser.add_argument("--seeds", type=int, default=5, help="runs of preset thesis")
    parser.add_argument("--workers", type=int, default=1, help="processes")
    args = parser.parse_args(arguments)
    presets = args.presets.split(",")
    for name in presets:
        stereotrack.preset(name)
    plans = thesis_recordings(short=args.short)
    recordings = {one.name: made(args.folder / "recordings" / one.name, one) for one in plans}
    wanted = jobs([*recordings], presets, args.seeds)
    found = missing_runs_made(args.folder, recordings, wanted, args.workers)
    text = tables(found, [*recordings], presets)
    write_file(args.folder / "tables.md", text)
    print(text)


if __name__ == "__main__":
    sys.exit(ended(main))

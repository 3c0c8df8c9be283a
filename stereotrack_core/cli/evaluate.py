"""``stereotrack evaluate`` and ``compare``: errors of a run, its angles, failures, other runs."""

import math
from argparse import Namespace
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from stereotrack_core.cli import options, sources
from stereotrack_core.cli.output import OK, put_result, say, watched
from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.evaluation import compare as comparing
from stereotrack_core.evaluation import joint_angles
from stereotrack_core.evaluation.accuracy import (
    accuracy_facts,
    accuracy_of,
    error_facts,
    stated_means,
)
from stereotrack_core.evaluation.failure_segments import segment
from stereotrack_core.evaluation.failure_segments.find import (
    FailureSearch,
    find_failures,
    with_reasons,
)
from stereotrack_core.evaluation.failure_segments.reasons import reasons_words
from stereotrack_core.evaluation.summary import none_of_the_frames
from stereotrack_core.interop.landmark_file import Stated
from stereotrack_core.parameters import parsed_settings
from stereotrack_core.recording.description import Segment
from stereotrack_core.recording.findings import wrong_size
from stereotrack_core.recording.frame_times import values_at
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.recording.selection import asked_frames
from stereotrack_core.report import reported
from stereotrack_core.tables import Table, number
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.run_checks import HEADING, heading_words
from stereotrack_core.tracking.stored import fps_of_run


@dataclass(frozen=True, eq=False)
class Measured:
    """A trajectory to evaluate, and the reference to evaluate it against."""

    path: Path
    trajectory: LandmarkTrajectory
    run: Run | None  # where the file holds a complete one
    truth: sources.Truth | None
    frames: range
    segments: Sequence[Segment]  # those that results are asked for
    stated: Mapping[Path, Stated]  # names and axes of the files


Told = tuple[dict[str, Any], list[Table | str]]  # a result as JSON, and as tables and sentences


@options.command(
    options.path("run_file RUN", "run or reference (.npz), or landmarks (.csv, .trc, .c3d)"),
    options.REFERENCE,
    options.MAX_SIGMA,
    options.EXCLUDE,
    options.flag(
        "--weigh",
        "let errors count by how well the reference is known there, as its uncertainty states",
    ),
    options.OF_RUN,
    *options.STATED,
    options.FPS,
    options.FRAMES,
    options.SEGMENTS,
    options.SCENARIOS,
    options.flag("--angles", "joint angles: ranges, errors"),
    options.flag("--failures", "stretches in which limbs fail, with their probable causes"),
    options.changes("change how failures are detected, for example episode_error=30"),
    options.path(
        "--against RUN",
        "compare with another run or landmarks, frame by frame: how much better one is, and "
        "whether the difference is significant",
    ),
)
def run(args: Namespace) -> int:
    """Print mean, median and 95th percentile of torso position, torso axes, upper arms and
    forearms against the reference, and the share of arm segments more than 45 degrees off.
    Frames missing in the run count 90 degrees and 500 mm. Frames missing in the reference
    are not scored. --max-sigma leaves out what the reference does not know well enough;
    --weigh lets each error count by 1 / (s^2 + sigma^2), s the median error and sigma the
    reference's own. With --angles, --failures or --against these are printed instead, and
    need no reference.
    """
    wanted = args.angles or args.failures or args.against is not None
    if args.changes and not args.failures:
        raise InputError("it changes how failures are detected", "--set", "Add --failures.")
    measured = _measured_of(args, needs_truth=not wanted)
    told: dict[str, Told] = {}
    if not wanted and measured.truth is not None:
        told[""] = _errors_told(args, measured, measured.truth)
    if args.angles:
        told["angles"] = _angles_told(args, measured)
    if args.failures:
        told["failures"] = _failures_told(args, measured)
    if args.against is not None:
        told["against"] = _against_told(args, measured)
    source = None if measured.truth is None else measured.truth.source
    facts: dict[str, Any] = {"run": args.run_file, "reference": source}
    for name, (one, _) in told.items():
        facts |= {name: one} if name else one
    words = _words(source) if wanted else None
    tables = (table for _, own in told.values() for table in own)
    put_result(facts, words, *tables, as_json=args.json)
    return OK


def _words(source: Path | None) -> str:
    return "No reference." if source is None else f"Reference: {source}"


def _measured_of(args: Namespace, *, needs_truth: bool) -> Measured:
    """Read what is asked for; without truth where there is none and it is not needed."""
    path = args.run_file
    stated = sources.stated_for(args, path, args.against, args.reference)
    trajectory, stored = sources.read_measured(path, stated.get(path), args.recording)
    meta = {} if stored is None else dict(stored.meta)
    truth = None
    _say_size(path, trajectory)
    try:
        own, limit = stated.get(args.reference), 0.001 * args.max_sigma
        truth = sources.truth_of(args.reference, meta, trajectory, own, limit, args.exclude)
        _say_size(truth.source, truth.reference)
    except InputError as error:
        if needs_truth or args.reference is not None:
            raise
        say(f"No reference: {error.what}.")
    segments: Sequence[Segment] = ()
    if args.scenarios is not None:
        with sources.open_project(args.scenarios) as project:
            segments = sources.named_scenarios(project)
    elif args.segments:
        folder = Path(str(meta.get("recording_folder") or path.parent))
        recording = sources.recording_in(folder) if truth is None else None
        known = recording.segments if recording is not None else ()
        segments = known if truth is None else truth.segments
        if not segments:
            remedy = "Put a segments.csv beside the recording or the reference, or omit --segments."
            raise InputError("the recording has no segments", folder, remedy)
    args.segments = bool(segments)  # of either
    return Measured(path, trajectory, stored, truth, asked_frames(args.frames), segments, stated)


def _say_size(source: Path, trajectory: LandmarkTrajectory) -> None:
    if (wrong := wrong_size(trajectory)) is not None:
        say(f"{source}: {wrong.what}. {wrong.remedy}")


def _errors_told(args: Namespace, measured: Measured, truth: sources.Truth) -> Told:
    trajectory = measured.trajectory
    found = measured.run or trajectory
    meta = {} if measured.run is None else dict(measured.run.meta)
    known = truth.reference, truth.states, measured.segments, measured.frames
    accuracy = accuracy_of(found, *known, weigh=args.weigh)
    if args.weigh and not accuracy.quality:
        what = "the reference does not state its uncertainty"
        raise InputError(what, truth.source, "Give the .npz of `stereotrack fit`, or omit --weigh.")
    if not len(accuracy.errors.frame):
        raise none_of_the_frames("--frames" if args.frames else "--reference")
    frame = accuracy.errors.frame
    if absent := int((~np.isin(frame, trajectory.frame)).sum()):
        more = "" if args.frames else " Restrict the range with --frames A:B."
        lacking = f"The run lacks {absent} of the {len(frame)} frames of the reference"
        say(f"{lacking}. They count 90 deg and 500 mm.{more}")
    if heading := heading_words(meta.get(HEADING)):
        say(f"{measured.path}: {heading.what}. {heading.remedy}")
    seconds = meta.get("wall_seconds")
    speed = None
    if isinstance(seconds, int | float) and seconds > 0:
        speed = len(trajectory.frame) / float(seconds)
    facts = {"frames_per_second": speed} | accuracy_facts(accuracy)
    weighted = ", weighted by its uncertainty" * args.weigh
    title = f"{measured.path} against {truth.source}{weighted}"
    tables: list[Any] = [reported.error_table(accuracy, title, speed)]
    if accuracy.quality:
        tables.append(f"Means: {'; '.join(stated_means(accuracy))}.")
    if args.segments:
        facts["segments"] = [error_facts(part) for part in accuracy.segments]
        tables.append(reported.segment_table(accuracy.segments))
    return facts, tables


@options.command(
    options.path(
        "run_files RUN",
        "two or more runs (.npz) or landmark files (.csv, .trc, .c3d); the others are compared "
        "with the first",
        nargs="+",
    ),
    options.REFERENCE,
    options.MAX_SIGMA,
    options.EXCLUDE,
    *options.STATED,
    options.FRAMES,
    options.SEGMENTS,
    options.SCENARIOS,
)
def compare(args: Namespace) -> int:
    """Compare runs over the frames they share: all measures of `evaluate` where there is a
    reference, otherwise the distance between the runs. Differences are paired by frame.
    """
    first, *others = args.run_files
    if not others:
        raise InputError("there is one run only", remedy="Give two runs or more.")
    source: Path | None = None
    found = []
    for other in others:
        asked = Namespace(**vars(args), run_file=other, against=first, recording=None)
        measured = _measured_of(asked, needs_truth=False)
        source = None if measured.truth is None else measured.truth.source
        found.append((other, _against_told(asked, measured)))
    facts: dict[str, Any] = {"run": first, "reference": source}
    facts["pairs"] = [{**one, "run": other} for other, (one, _) in found]
    tables = (table for _, (_, own) in found for table in own)
    put_result(facts, _words(source), *tables, as_json=args.json)
    return OK


def _angles_told(args: Namespace, measured: Measured) -> Told:
    """Ranges and perhaps errors of joint angles; InputError without frames or frame rate."""
    angles, fps = sources.angles_in(measured.path, measured.trajectory, measured.run, args.fps)
    angles = angles.between(measured.frames.start, measured.frames.stop)
    if not len(angles.frame):
        what = "there are no frames to process"
        where = "--frames" if args.frames is not None else str(measured.path)
        raise InputError(what, where, "Give a file with frames, or another frame range.")
    stretches = joint_angles.angle_ranges(angles, measured.segments)
    facts: dict[str, Any] = {"frames_per_second": fps, "stretches": [asdict(s) for s in stretches]}
    tables: list[Table | str] = [*map(reported.range_table, stretches)]
    if measured.truth is not None:
        known = joint_angles.angles_of_trajectory(measured.truth.reference)
        if not np.isin(angles.frame, known.frame).any():
            raise none_of_the_frames(str(measured.truth.source))
        facts["errors"] = joint_angles.angle_errors(angles, known)
        headings = (">mean error", ">median", ">rms", ">95 %")
        title = "Errors of the joint angles, degrees"
        tables.append(reported.angle_table(title, headings, facts["errors"], joint_angles.ERRORS))
    return facts, tables


def _failures_told(args: Namespace, measured: Measured) -> Told:
    """Stretches in which limbs fail, with probable causes; InputError if no complete run."""
    rules = segment.FailureRules().replaced(**parsed_settings(args.changes))
    run = measured.run
    if run is None:
        what = "failures are found in complete runs only"
        raise InputError(what, measured.path, "Give a run that was written as .npz.")
    otherwise = "causes are classified from the run alone"
    recording = sources.recording_of_run(args.recording, run, otherwise)
    reference = None if measured.truth is None else measured.truth.reference
    fps = recording.fps if recording is not None else fps_of_run(run)
    search = FailureSearch(run, fps, reference, recording, rules)
    with watched("Detecting failures", "Nothing was written.") as work:
        every = find_failures(search, work)
        try:
            every = with_reasons(search, every, work)
        except InputError as error:
            say(f"It is not known why the arm search failed: {error.what}.")
    if reference is None and not segment.has_signs(run):
        say(
            "Without depth, failures are detected against a reference alone (--reference). Without "
            "one, only frames that are not tracked are listed."
        )
    asked = measured.frames
    listed = [e for e in every if e.first < asked.stop and e.last >= asked.start]
    facts: dict[str, Any] = {"fps": fps, "rules": rules.values(), "list": listed}
    heading = f"{counted(len(listed), 'failure') if listed else 'No failures'} in {measured.path}"
    if not listed:
        return facts, [f"{heading}."]
    why = reasons_words(one.reason for one in listed)
    table = Table(heading, segment.FAILURE_COLUMNS, segment.failure_rows(listed, fps))
    return facts, [table, f"Where they begin: {why}."] if why else [table]


def _against_told(args: Namespace, measured: Measured) -> Told:
    """The run, B, compared with another one, A, over the frames that both have."""
    path = args.against
    other, run = sources.read_measured(path, measured.stated.get(path))
    unexplained = None if run is None else run.unexplained_fraction
    fps, own = measured.trajectory.fps, other
    if fps is not None:
        other = own.at_rate(fps, str(path))
        sources.say_notes(other.notes[len(own.notes) :])
        if unexplained is not None and own.fps and other is not own:
            values = unexplained[:, None, None]
            unexplained = values_at(own.frame, values, own.fps, fps, other.frame)[:, 0, 0]
    prints = {one.meta.get("fingerprint") for one in (run, measured.run) if one is not None}
    if len(prints - {None}) > 1:
        what = "The runs are of different recordings, so their differences are meaningless"
        say(f"{what}: {path}, {measured.path}.")
    mine = None if measured.run is None else measured.run.unexplained_fraction
    both = [comparing.Candidate("A", other, unexplained)]
    both.append(comparing.Candidate("B", measured.trajectory, mine))
    reference = None if measured.truth is None else measured.truth.reference
    whole = comparing.compare(both, reference, measured.frames)
    parts = comparing.compare_segments(both, reference, measured.segments, measured.frames)
    facts = {"run": path, **_comparison_facts(whole)}
    if args.segments:
        told = ((name, {} if part is None else _comparison_facts(part)) for name, part in parts)
        facts["segments"] = [{"name": name, **own} for name, own in told]
    tables: list[Table | str] = [f"A  {path}\nB  {measured.path}"]
    for title, comparison in (("", whole), *parts):
        if comparison is None:
            tables.append(f"{title}: the runs have no frame in common.")
            continue
        tables.append(_comparison_table(comparison, title))
        if not comparison.against_reference:
            tables.append(_apart_table(comparison.pairs[0], title))
    return facts, [*tables, comparing.how_it_is_made(whole)]


def _comparison_table(comparison: comparing.Comparison, title: str) -> Table:
    """Means of both runs, their difference with its interval, and what that comes to."""
    where = f"{title}: " if title else ""
    heading = f"{where}B compared with A, means over {len(comparison.frames)} frames"
    rows = [
        (
            f"{paired.measure.label} [{paired.measure.unit}]",
            number(paired.first_mean, 2),
            number(paired.second_mean, 2),
            f"{paired.difference:+z.2f}" if math.isfinite(paired.difference) else "-",
            f"{paired.low:+z.2f} to {paired.high:+z.2f}" if paired.enough else "-",
            comparing.verdict(paired, "A", "B"),
        )
        for paired in comparison.pairs[0].measures
    ]
    columns = ("measure", ">A", ">B", ">B - A", ">95 % interval", "conclusion")
    return Table(heading, columns, rows)


def _apart_table(pair: comparing.Pair, title: str) -> Table:
    where = f"{title}: " if title else ""
    rows = reported.measure_rows(pair.apart)
    rows.append(("arm segments over 45 deg apart [%]", number(100.0 * pair.apart.lost), "", ""))
    heading = f"{where}B and A, distance from each other"
    return Table(heading, ("measure", ">mean", ">median", ">95 %"), rows)


def _comparison_facts(comparison: comparing.Comparison) -> dict[str, Any]:
    pair = comparison.pairs[0]
    measures = {}
    for paired in pair.measures:
        facts = asdict(paired)
        unit, verdict = facts.pop("measure")["unit"], comparing.verdict(paired, "A", "B")
        facts = {"unit": unit, **facts, "differs": paired.differs, "verdict": verdict}
        measures[paired.measure.name] = facts
    return {
        "frames": len(comparison.frames),
        "first_frame": comparison.frames[0],
        "last_frame": comparison.frames[-1],
        "against_reference": comparison.against_reference,
        "measures": measures,
        "apart": error_facts(pair.apart),
    }

"""Results of ``stereotrack evaluate`` besides the errors: angles, failures, another run."""

import math
from argparse import Namespace
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from stereotrack_core.cli import sources
from stereotrack_core.cli.output import say, watched
from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.evaluation import joint_angles
from stereotrack_core.evaluation.accuracy import error_facts
from stereotrack_core.evaluation.compare import (
    Candidate,
    Comparison,
    Pair,
    compare,
    compare_segments,
    how_it_is_made,
    verdict,
)
from stereotrack_core.evaluation.failure_segments.find import FailureSearch, find_failures
from stereotrack_core.evaluation.failure_segments.segment import FailureSegment, limbs_words
from stereotrack_core.evaluation.failure_segments.stretches import FailureRules, has_signs
from stereotrack_core.evaluation.summary import none_of_the_frames
from stereotrack_core.interop.landmark_file import Stated
from stereotrack_core.parameters import parsed_settings
from stereotrack_core.recording.description import Segment
from stereotrack_core.recording.frame_times import values_at
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.report.run_tables import measure_rows, range_table
from stereotrack_core.tables import Table, number
from stereotrack_core.tracking.frame import Run
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


def angles_told(args: Namespace, measured: Measured) -> Told:
    """Ranges and perhaps errors of joint angles; InputError without frames or frame rate."""
    angles, fps = sources.angles_in(measured.path, measured.trajectory, measured.run, args.fps)
    angles = angles.between(measured.frames.start, measured.frames.stop)
    if not len(angles.frame):
        raise InputError(
            "there are no frames to process",
            where="--frames" if args.frames is not None else str(measured.path),
            remedy="Give a file with frames, or another frame range.",
        )
    stretches = joint_angles.angle_ranges(angles, measured.segments)
    facts: dict[str, Any] = {
        "frames_per_second": fps,
        "stretches": [_range_facts(stretch) for stretch in stretches],
    }
    tables: list[Table | str] = [*map(range_table, stretches)]
    if measured.truth is not None:
        states, reference = measured.truth.states, measured.truth.reference
        known = (
            joint_angles.angles_of_trajectory(reference)
            if states is None
            else joint_angles.angles_of_reference(states)
        )
        if not np.isin(angles.frame, known.frame).any():
            raise none_of_the_frames(str(measured.truth.source))
        facts["errors"] = joint_angles.angle_errors(angles, known)
        tables.append(_angle_error_table(facts["errors"]))
    return facts, tables


def _angle_error_table(errors: Mapping[str, Mapping[str, float]]) -> Table:
    rows = [
        (
            name.replace("_", " "),
            str(one["frames"]),
            *(number(one[key]) for key in joint_angles.ERRORS),
        )
        for name, one in errors.items()
        if one["frames"]
    ]
    headings = ("angle", ">frames", ">mean error", ">median", ">rms", ">95 %")
    return Table("Errors of the joint angles, degrees", headings, rows)


def _range_facts(stretch: joint_angles.StretchRanges) -> dict[str, Any]:
    """Ranges for JSON, degrees."""
    return {
        "name": stretch.name,
        "first": stretch.first,
        "end": stretch.end,
        "angles": {
            name: {"frames": stretch.frames[name], **values}
            for name, values in stretch.degrees.items()
        },
    }


def failures_told(args: Namespace, measured: Measured) -> Told:
    """Stretches in which limbs fail, with probable causes; InputError if no complete run."""
    rules = FailureRules().replaced(**parsed_settings(args.changes))
    run = measured.run
    if run is None:
        what = "failures are found in complete runs only"
        remedy = "Give a run that was written as .npz."
        raise InputError(what, where=str(measured.path), remedy=remedy)
    recording = sources.recording_of_run(
        args.recording, run, "causes are classified from the run alone"
    )
    reference = None if measured.truth is None else measured.truth.reference
    fps = recording.fps if recording is not None else fps_of_run(run)
    search = FailureSearch(run, fps, reference, recording, rules)
    with watched("Detecting failures", "Nothing was written.") as (report, stopped):
        every = find_failures(search, report, stopped)
    if reference is None and not has_signs(run):
        say(
            "Without depth, failures are detected against a reference alone (--reference). Without "
            "one, only frames that are not tracked are listed."
        )
    listed = [
        e for e in every if e.first < measured.frames.stop and e.last >= measured.frames.start
    ]
    facts: dict[str, Any] = {"fps": fps, "rules": rules.values(), "list": listed}
    heading = f"{counted(len(listed), 'failure') if listed else 'No failures'} in {measured.path}"
    if not listed:
        return facts, [f"{heading}."]
    return facts, [_failure_table(heading, listed, fps)]


def _failure_table(heading: str, listed: Sequence[FailureSegment], fps: float) -> Table:
    rows = [
        (
            f"{e.first}-{e.last}",
            f"{e.first / fps:.1f}-{(e.last + 1) / fps:.1f}",
            limbs_words(e.limbs),
            e.found,
            e.peak_words,
            e.verdict.cause,
            f"{100.0 * e.verdict.confidence:.0f} %" if e.verdict.confidence else "-",
            e.verdict.words,
        )
        for e in listed
    ]
    columns = (
        *("frames", "seconds", "limbs", "detected by"),
        *(">peak", "cause", ">sure", "description"),
    )
    return Table(heading, columns, rows)


def against_told(args: Namespace, measured: Measured) -> Told:
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
        say(
            "The runs are of different recordings, so their differences are meaningless: "
            f"{path}, {measured.path}."
        )
    mine = None if measured.run is None else measured.run.unexplained_fraction
    both = [Candidate("A", other, unexplained), Candidate("B", measured.trajectory, mine)]
    reference = None if measured.truth is None else measured.truth.reference
    whole = compare(both, reference, measured.frames)
    parts = compare_segments(both, reference, measured.segments, measured.frames)
    facts = {"run": path, **_comparison_facts(whole)}
    if args.segments:
        facts["segments"] = [
            {"name": name} | ({} if part is None else _comparison_facts(part))
            for name, part in parts
        ]
    tables: list[Table | str] = [f"A  {path}\nB  {measured.path}"]
    for title, comparison in (("", whole), *parts):
        if comparison is None:
            tables.append(f"{title}: the runs have no frame in common.")
            continue
        tables.append(_comparison_table(comparison, title))
        if not comparison.against_reference:
            tables.append(_apart_table(comparison.pairs[0], title))
    return facts, [*tables, how_it_is_made(whole)]


def _comparison_table(comparison: Comparison, title: str) -> Table:
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
            verdict(paired, "A", "B"),
        )
        for paired in comparison.pairs[0].measures
    ]
    columns = ("measure", ">A", ">B", ">B - A", ">95 % interval", "conclusion")
    return Table(heading, columns, rows)


def _apart_table(pair: Pair, title: str) -> Table:
    """Distances between two runs."""
    where = f"{title}: " if title else ""
    rows = measure_rows(pair.apart)
    rows.append(("arm segments over 45 deg apart [%]", number(100.0 * pair.apart.lost), "", ""))
    heading = f"{where}B and A, distance from each other"
    return Table(heading, ("measure", ">mean", ">median", ">95 %"), rows)


def _comparison_facts(comparison: Comparison) -> dict[str, Any]:
    """The same for JSON."""
    pair = comparison.pairs[0]
    measures = {}
    for paired in pair.measures:
        facts = asdict(paired)
        measures[paired.measure.name] = {
            "unit": facts.pop("measure")["unit"],
            **facts,
            "differs": paired.differs,
            "verdict": verdict(paired, "A", "B"),
        }
    return {
        "frames": len(comparison.frames),
        "first_frame": comparison.frames[0],
        "last_frame": comparison.frames[-1],
        "against_reference": comparison.against_reference,
        "measures": measures,
        "apart": error_facts(pair.apart),
    }

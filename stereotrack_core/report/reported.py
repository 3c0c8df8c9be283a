"""What a report is about, everything that it tells, and its tables."""

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np

from stereotrack_core.annotation.reference import Reference
from stereotrack_core.errors import Finding, InputError
from stereotrack_core.evaluation.accuracy import Accuracy, accuracy_of
from stereotrack_core.evaluation.failure_segments.film import strip_of
from stereotrack_core.evaluation.failure_segments.find import FailureSearch, find_failures
from stereotrack_core.evaluation.failure_segments.segment import (
    CAUSE_WORDS,
    FailureSegment,
    limbs_words,
)
from stereotrack_core.evaluation.joint_angles import RANGES, StretchRanges
from stereotrack_core.evaluation.summary import Summary
from stereotrack_core.recording.description import LENGTHS, Recording, Segment
from stereotrack_core.recording.findings import examine
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.tables import Table, number
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.repeating import changed_parameters, what_differs
from stereotrack_core.tracking.run_checks import HEADING, heading_words
from stereotrack_core.tracking.stored import fps_of_run
from stereotrack_core.work import NO_WORK, Work

MOST_STRIPS = 8  # failures that are shown in pictures: the longest ones
_QUALITY = 80


@dataclass(frozen=True, eq=False)
class Source:
    """What a report is made of."""

    name: str  # of the run, as people know it
    run: Run
    recording: Recording | None = None
    """None where it is not there any more; pictures are left out then."""
    reference: LandmarkTrajectory | None = None
    reference_name: str = ""
    states: Reference | None = None  # the reference with its uncertainty, where it states one
    frames: range | None = None  # that are reported; None for all
    repeat: str = ""  # command that tracks again

    @property
    def fps(self) -> float:
        """Frame sets per second; InputError where neither recording nor run states them."""
        if self.recording is not None:
            return self.recording.fps
        return fps_of_run(self.run)


@dataclass(frozen=True)
class ShownFailure:
    """A failure with its strip of pictures as a JPEG, where it has one."""

    failure: FailureSegment
    strip: bytes | None = None


@dataclass(frozen=True, eq=False)
class Reported:
    """Everything that a report tells."""

    source: Source  # its run is cut to the stretch that is reported
    segments: tuple[Segment, ...]  # within the stretch
    findings: tuple[Finding, ...]  # about the recording
    accuracy: Accuracy | None  # None without a reference
    failures: tuple[ShownFailure, ...]
    differs: tuple[str, ...]  # why tracking again may come out otherwise


def gathered(source: Source, work: Work = NO_WORK) -> Reported:
    """Measure, find failures, draw strips; InputError if the run lacks frames, Cancelled."""
    source = dataclasses.replace(source, run=_cut(source.run, source.frames))
    run, recording = source.run, source.recording
    first, end = int(run.frame[0]), int(run.frame[-1]) + 1
    known = () if recording is None else recording.segments
    inside = (s for s in known if s.first < end and s.end > first)
    segments = tuple(Segment(s.name, max(s.first, first), min(s.end, end)) for s in inside)
    work.tell(0.02, "reading the recording")
    findings = () if recording is None else examine(recording.folder, compare=True)
    accuracy, failures = _accuracy(source, segments), _failures(source, work)
    differs = () if recording is None else what_differs(run, recording)
    return Reported(source, segments, findings, accuracy, failures, differs)


def _cut(run: Run, frames: range | None) -> Run:
    first, end = (0, np.inf) if frames is None else (frames.start, frames.stop)
    inside = (run.frame >= first) & (run.frame < end)
    if not inside.any():
        what, remedy = "the run has no frames", "Track the recording first."
        if len(run.frame):
            what = "the run has none of these frames"
            remedy = "Choose frames that the run contains."
        raise InputError(what, "--frames", remedy)
    names = (
        *("frame", "landmarks", "x", "P", "tracked", "unexplained_fraction", "residual"),
        *("innovation", "limb_sigma_deg", "limb_lost", "seconds"),
    )
    return dataclasses.replace(run, **{name: getattr(run, name)[inside] for name in names})


def _accuracy(source: Source, segments: Sequence[Segment]) -> Accuracy | None:
    if source.reference is None:
        return None
    frame = source.run.frame
    stretch = range(int(frame[0]), int(frame[-1]) + 1)
    found = accuracy_of(source.run, source.reference, source.states, segments, stretch)
    return found if len(found.errors.frame) else None


def _failures(source: Source, work: Work) -> tuple[ShownFailure, ...]:
    searched = FailureSearch(source.run, source.fps, source.reference, source.recording)
    found = find_failures(searched, work.part(0.05, 0.6))
    if source.reference is not None:
        found = tuple(failure for failure in found if failure.found == "truth")
    recording = source.recording
    if recording is None:
        return tuple(ShownFailure(failure) for failure in found)
    longest = sorted(found, key=lambda e: e.first - e.last)[:MOST_STRIPS]
    shown = []
    for i, failure in enumerate(found):
        work.step(0.6 + 0.4 * i / len(found), "rendering failures")
        strip = None
        if failure in longest:
            picture = strip_of(searched, recording, failure)
            done, data = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])
            strip = data.tobytes() if done else None
        shown.append(ShownFailure(failure, strip))
    return tuple(shown)


def error_table(
    accuracy: Accuracy, title: str = "", frames_per_second: float | None = None
) -> Table:
    """Mean, median and 95th percentile of every measure, and the share that is lost."""
    summary, doubts, quality = accuracy.summary, accuracy.doubts, accuracy.quality
    rows = measure_rows(summary)
    facts = {"lost (arm segments over 45 deg off) [%]": number(100.0 * summary.lost)}
    if doubts is not None:
        real = f"{doubts.both} of {doubts.called}" if doubts.called else "none flagged"
        facts["failures flagged by the run that are real"] = real
        found = f"{doubts.both} of {doubts.lost}" if doubts.lost else "none fails"
        facts["real failures flagged by the run"] = found
    facts |= {"frames": str(summary.frames), "frames not tracked": str(summary.not_tracked)}
    if frames_per_second is not None:
        facts["frames per second"] = number(frames_per_second)
    headings: tuple[str, ...] = ("measure", ">mean", ">median", ">95 %")
    if quality:
        headings = (*headings, ">reference uncertainty")
        good = [number(quality.get(measure.name, math.nan)) for measure in summary.measures]
        rows = [(*row, cell) for row, cell in zip(rows, good, strict=True)]
    blank = [""] * (len(headings) - 2)
    return Table(title, headings, [*rows, *((what, text, *blank) for what, text in facts.items())])


def measure_rows(summary: Summary) -> list[tuple[str, ...]]:
    """Label, mean, median and 95th percentile of every measure."""
    rows: list[tuple[str, ...]] = []
    for measure in summary.measures:
        figures = measure.statistics
        values = (figures.mean, figures.median, figures.p95)
        rows.append((f"{measure.label} [{measure.unit}]", *(number(value) for value in values)))
    return rows


def segment_table(summaries: Sequence[Summary]) -> Table:
    """Means of every segment, one row each."""
    headings = (
        *("segment", ">frames", ">torso mm", ">long", ">cross", ">upper arms", ">forearms"),
        *(">left upper", ">right upper", ">left fore", ">right fore", ">lost %"),
    )
    rows = []
    for summary in summaries:
        means = (number(measure.statistics.mean) for measure in summary.measures)
        rows.append((summary.name, str(summary.frames), *means, number(100.0 * summary.lost)))
    return Table("Means per segment, degrees unless stated otherwise", headings, rows)


def range_table(stretch: StretchRanges) -> Table:
    """Range and mean of every angle that is known."""
    where = "all frames" if stretch.name == "all" else f"segment {stretch.name}"
    title = f"Joint angles, {where} ({stretch.first} to {stretch.end - 1}), degrees"
    return angle_table(title, (">from", ">to", ">range", ">mean"), stretch.angles, RANGES)


def angle_table(
    title: str, headings: Sequence[str], angles: Mapping[str, Any], keys: Sequence[str]
) -> Table:
    """Values of every angle that is known in any frame."""
    own = {name.replace("_", " "): one for name, one in angles.items() if one["frames"]}
    rows = [(n, str(one["frames"]), *(number(one[k]) for k in keys)) for n, one in own.items()]
    return Table(title, ("angle", ">frames", *headings), rows)


def tables(reported: Reported) -> dict[str, Table | None]:
    """All of them by their name in the template; None for those that there is nothing to tell."""
    run, accuracy = reported.source.run, reported.accuracy
    stored: dict[str, Any] = dict(run.meta.get("parameters") or {})
    return {
        "lengths": _lengths(run),
        "errors": None if accuracy is None else error_table(accuracy),
        "segments": None if accuracy is None else segment_table(accuracy.segments),
        "failures": _failure_table(reported),
        "parameters": _parameters(stored),
        "changed": _changed(stored, str(run.meta.get("preset") or "")),
        "versions": _versions(reported),
    }


def _lengths(run: Run) -> Table:
    stated = run.meta.get("subject") or {}
    known = {name.replace("_", " "): stated[name] for name in LENGTHS if name in stated}
    values = ["average" if value is None else f"{1000.0 * value:.0f}" for value in known.values()]
    columns = ("", *(f">{key.removesuffix(' length')}" for key in known))
    return Table("", columns, [("length [mm]", *values)])


def _failure_table(reported: Reported) -> Table:
    fps = reported.source.fps
    rows = []
    for shown in reported.failures:
        failure = shown.failure
        sure = failure.verdict.confidence
        rows.append(
            (
                f"{failure.first}–{failure.last}",
                f"{failure.first / fps:.1f}–{(failure.last + 1) / fps:.1f} s",
                limbs_words(failure.limbs),
                failure.peak_words,
                CAUSE_WORDS[failure.verdict.cause] + (f" ({100.0 * sure:.0f} %)" if sure else ""),
            )
        )
    return Table("", ("frames", "time", "limbs", ">peak", "probable cause"), rows)


def _parameters(stored: dict[str, Any]) -> Table:
    """All parameters; those that are not the default are set apart."""
    known = {row.name: row for row in Settings.rows()}
    rows, kinds = [], []
    for key, value in stored.items():
        row = known.get(key)
        unit, default = ("", "-") if row is None else (row.unit, str(row.default))
        rows.append((key, str(value), unit, default))
        kinds.append("" if row is None or value == row.default else "given")
    return Table("", ("parameter", ">value", "unit", ">default"), rows, kinds)


def _changed(stored: dict[str, Any], preset: str) -> Table:
    units = {row.name: row.unit for row in Settings.rows()}
    both = changed_parameters(stored, preset).items()
    rows = [(key, str(value), units.get(key, ""), str(usual)) for key, (usual, value) in both]
    return Table("", ("parameter", ">value", "unit", ">preset"), rows)


def _versions(reported: Reported) -> Table:
    meta = reported.source.run.meta
    rows = [(key, str(value)) for key, value in dict(meta.get("versions") or {}).items()]
    rows = rows or [("stereotrack", str(meta.get("version") or "unknown"))]
    rows += [
        ("tracked", str(meta.get("made") or "unknown time")),
        ("seed", str(meta.get("seed", "unknown"))),
        ("initial pose", str(meta.get("init", "unknown"))),
    ]
    if (words := heading_words(meta.get(HEADING))) is not None:
        rows.append(("direction that the person faces", words.brief))
    rows.append(("recording's fingerprint", str(meta.get("fingerprint") or "unknown")))
    return Table("", ("", ""), rows)

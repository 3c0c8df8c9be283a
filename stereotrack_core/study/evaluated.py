"""A run of a study with its errors, signs, failures and ranges of motion, each with its unit."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, TypeAlias

from stereotrack_core.errors import InputError
from stereotrack_core.evaluation.failure_segments.find import FailureSearch, stretches_of
from stereotrack_core.evaluation.joint_angles.motion import motion_of, range_of_motion
from stereotrack_core.evaluation.joint_angles.series import angles_of_run
from stereotrack_core.experiments.measures import MEASURES, measured
from stereotrack_core.interop.run_npz import read_npz
from stereotrack_core.plain_data import Kind, check_kind, plain
from stereotrack_core.project.project import Project
from stereotrack_core.project.runs import load_run
from stereotrack_core.project.setups import load_reference
from stereotrack_core.recording.folder import describe
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.study.cache import Read
from stereotrack_core.study.facts import description_files
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.repeating import changed_parameters
from stereotrack_core.tracking.stored import fps_of_run

KeptIn: TypeAlias = Literal["study", "project"]

OWN_REFERENCE = "the recording's reference"

_KIND: Kind = {
    **dict.fromkeys(("preset", "changes", "fingerprint", "calibration", "version"), str),
    **dict.fromkeys(("reference", "problem"), str),
    **dict.fromkeys(("seed", "frames", "tracked"), int),
    "values": [[str, str, str, float]],
}
_RANGES = ("minimum", "maximum", "range", "mean", "peak_velocity")
_PERCENTILES = {"median": "median", "p95": "95th percentile"}


@dataclass(frozen=True)
class Value:
    """One number about a run."""

    measure: str
    statistic: str
    unit: str
    """``mm``, ``deg``, ``deg/s``, ``%``, ``s``, ``Hz``; ``1`` for a pure number or a count."""
    value: float


@dataclass(frozen=True)
class RunFacts:
    """What is known of a run; `problem` says why it is nothing."""

    preset: str = ""
    changes: str = ""
    """Parameters that differ from the preset: ``iterations=2 data_points=400``."""
    seed: int | None = None
    frames: int = 0
    tracked: int = 0
    """Frames of the run, and those with a pose."""
    fingerprint: str = ""
    calibration: str = ""
    version: str = ""
    """Of the recording, of its cameras and of this program when it was tracked."""
    reference: str = ""
    """What it was measured against; empty: nothing."""
    values: tuple[Value, ...] = ()
    problem: str = ""

    def value(self, measure: str, statistic: str) -> float | None:
        """One of the values; None where it is not known."""
        for one in self.values:
            if (one.measure, one.statistic) == (measure, statistic):
                return one.value
        return None

    @classmethod
    def of(cls, facts: Mapping[str, Any]) -> RunFacts:
        """From plain data. Raises InputError where they are another's."""
        check_kind(facts, _KIND, "run", "Delete the cache of the study.")
        return cls(**{**facts, "values": tuple(Value(*value) for value in facts["values"])})

    def to_dict(self) -> dict[str, Any]:
        """The same as plain data."""
        return {**plain(self), "values": [plain(list(vars(one).values())) for one in self.values]}


@dataclass(frozen=True)
class RunPlace:
    """Where a run is, and what it is measured against."""

    name: str
    kept_in: KeptIn
    path: Path
    """Of the run file or the project."""
    folder: Path | None
    """Of the recording; None where it is missing."""
    reference: str = ""
    """Of the project, which is measured against; empty: the recording's own."""
    project: Path | None = None

    def read(self) -> Read:
        """Read it and measure; what it depends on besides files is not among the sources."""
        sources = [] if self.kept_in == "project" else [self.path]
        if not self.reference and self.folder is not None:
            sources += description_files(self.folder)
        try:
            facts = self._facts()
        except InputError as error:
            facts = RunFacts(problem=str(error))
        return Read(facts.to_dict(), tuple(sources))

    def load(self) -> Run:
        """The run itself. Raises InputError where it cannot be read."""
        if self.kept_in == "study":
            return read_npz(self.path)
        with Project.open(self.path, read_only=True) as project:
            return load_run(project.runs, self.name)

    def _facts(self) -> RunFacts:
        run = self.load()
        recording = None if self.folder is None else describe(self.folder, [])
        truth, name = None, ""
        if self.reference and self.project is not None:
            with Project.open(self.project, read_only=True) as project:
                truth = load_reference(project.references, self.reference).trajectory()
            name = self.reference
        elif recording is not None and recording.reference is not None:
            truth, name = recording.reference, OWN_REFERENCE
        fps = fps_of_run(run) if recording is None else recording.fps
        meta = run.meta
        seed = meta.get("seed")
        return RunFacts(
            preset=str(meta.get("preset", "")),
            changes=_changes(meta),
            seed=None if seed is None else int(seed),
            frames=len(run.frame),
            tracked=int(run.tracked.sum()),
            fingerprint=str(meta.get("fingerprint", "")),
            calibration=str(meta.get("calibration", "")),
            version=str(dict(meta.get("versions") or {}).get("stereotrack", "")),
            reference=name,
            values=tuple(one for one in values_of(run, fps, truth) if math.isfinite(one.value)),
        )


def _changes(meta: Mapping[str, Any]) -> str:
    if not meta.get("parameters"):
        return ""
    try:
        changed = changed_parameters(meta["parameters"], str(meta.get("preset", "")))
    except InputError:  # a preset that is not on this machine
        return ""
    return " ".join(f"{name}={now}" for name, (_, now) in changed.items())


def values_of(run: Run, fps: float, truth: LandmarkTrajectory | None) -> Iterator[Value]:
    """All numbers about a run; NaN where one is not known.

    `fps`: frame sets per second. `truth`: what it is measured against, None where nothing is known.
    """
    yield Value("frames", "count", "1", float(len(run.frame)))
    yield Value("frames_tracked", "count", "1", float(run.tracked.sum()))
    found = measured(run, truth)
    for measure in MEASURES:
        if measure.name not in found:
            continue
        name, _, end = measure.name.rpartition("_")
        statistic = _PERCENTILES.get(end) or ("share" if measure.unit == "%" else "mean")
        whole = name if end in _PERCENTILES else measure.name
        yield Value(whole, statistic, measure.unit or "1", found[measure.name])
    failures = stretches_of(FailureSearch(run, fps, truth))
    by_signs = sum(one.found == "signs" for one in failures)
    if truth is not None:
        yield Value("failures_by_error", "count", "1", float(len(failures) - by_signs))
    yield Value("failures_by_signs", "count", "1", float(by_signs))
    yield from _ranges(run, fps)
    seconds = run.meta.get("wall_seconds")
    if isinstance(seconds, int | float) and seconds > 0:
        yield Value("computing_time", "total", "s", float(seconds))


def _ranges(run: Run, fps: float) -> Iterator[Value]:
    angles = angles_of_run(run)
    whole = range_of_motion(angles, motion_of(angles, fps))[0]
    for one in whole.ranges:
        degrees = one.degrees()
        for statistic in _RANGES:
            unit = "deg/s" if statistic == "peak_velocity" else "deg"
            yield Value(one.angle.name, statistic, unit, degrees[statistic])

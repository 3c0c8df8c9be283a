"""What a sweep comes to, checked before anything long begins."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from statistics import fmean
from typing import Any

import numpy as np

from stereotrack_core.body.pose import Pose
from stereotrack_core.errors import InputError, did_you_mean
from stereotrack_core.experiments.measures import MEASURES, measure_named
from stereotrack_core.experiments.runner.job import Job, JobResult, is_kept
from stereotrack_core.experiments.sweep.points import (
    Point,
    Search,
    SweepRequest,
    grid_points,
    listed_points,
    parsed_axis,
    parsed_range,
)
from stereotrack_core.interop.first_pose import first_pose
from stereotrack_core.parameters import Value, parsed_settings
from stereotrack_core.project.detectors import keypoints_in
from stereotrack_core.reading import TABLE_BYTES, read_bytes
from stereotrack_core.recording.description import Recording, Subject
from stereotrack_core.recording.detections import OWN_FILE
from stereotrack_core.recording.folder import calibration_fingerprint, fingerprint
from stereotrack_core.recording.keypoints import Keypoints
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.recording.selection import (
    frames_within,
    gives_depth,
    seeds_of,
    tracked_views,
    views_of,
)
from stereotrack_core.tables import read_csv_table
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run_spec import FirstPose, RunSpec, measured_keypoints
from stereotrack_core.version import __version__


class SweepPlan:
    """What a request asks for: jobs, or ranges in which points are searched.

    Raises InputError where something cannot be meant.

    Attributes
    ----------
    by : str
        Measure that says which point is best.
    ranges : tuple of Range
        Where a search looks; empty where there is no search.
    jobs : tuple of Job
        Empty for a search, whose points depend on what comes out.
    """

    def __init__(self, request: SweepRequest, recordings: Sequence[Recording]) -> None:
        self.request = request
        given = request.keypoints or (None,) * len(recordings)
        keypoints = [
            None
            if path is None
            else keypoints_in(path, recording, request.layout, request.person).keypoints
            for path, recording in zip(given, recordings, strict=True)
        ]
        self.by = _judged_by(request.minimise, recordings, with_keypoints=None not in keypoints)
        preset(request.preset, request.changes)
        self._changes = parsed_settings(request.changes)
        self.seeds = seeds_of(request.seeds)
        self._sources = tuple(map(_Source, recordings, keypoints))
        self.ranges = tuple(parsed_range(text) for text in request.search)
        self.jobs = () if self.ranges else self.jobs_of(_points(request))

    def jobs_of(self, points: Sequence[Point]) -> tuple[Job, ...]:
        """Jobs of points: recordings times points times seeds, in this order.

        Raises InputError for views, frames or first poses that a recording does not have.
        """
        jobs: list[Job] = []
        for source in self._sources:
            for point in points:
                own = point.special("seed")
                seeds = self.seeds if own is None else [int(own)]
                jobs += [source.job(point, self.request, self._changes, seed) for seed in seeds]
        return tuple(jobs)

    def jobs_to_count(self) -> tuple[Job, ...]:
        """All jobs; of a search as many as it will try."""
        if not self.ranges:
            return self.jobs
        search = Search(self.ranges, self.request.search_seed)
        return self.jobs_of(search.ask(self.request.trials))

    def search_batch(self, at_once: int) -> int:
        """Points that a search asks for at once, so that nobody has to wait for work."""
        return max(1, math.ceil(at_once / (len(self.request.recordings) * len(self.seeds))))

    def search_signature(self) -> str:
        """Hash by which a search is known again."""
        text = repr((self.ranges, self.by, self.request.search_seed))
        return hashlib.blake2b(text.encode(), digest_size=8).hexdigest()


@dataclass(frozen=True)
class SweepCount:
    """What a sweep would compute."""

    jobs: int
    """Different runs in all."""
    points: int
    there: int
    """Jobs that are in the table already."""
    frames: int
    """Frames of the others."""
    workers: int
    """Jobs that are done at once."""
    seconds: float | None
    """What the others will take, from what was computed before; None where nothing was."""


def count_of(
    jobs: Sequence[Job], known: Mapping[str, JobResult], workers: int
) -> tuple[SweepCount, list[Job]]:
    """What a sweep would compute, and the jobs of it."""
    different = {job.identity: job for job in jobs}
    done = {job for job in known if known[job].done and job in different}
    done = {one for one in done if is_kept(different[one])}
    waiting = [job for one, job in different.items() if one not in done]
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


def _points(request: SweepRequest) -> tuple[Point, ...]:
    """Points of a grid or a list; one that changes nothing where there is neither."""
    if request.points is not None:
        columns, rows = read_csv_table(request.points)
        return listed_points(columns, rows, str(request.points))
    return grid_points([parsed_axis(text) for text in request.grid])


def _judged_by(asked: str | None, recordings: Sequence[Recording], *, with_keypoints: bool) -> str:
    """Measure that says which point is best.

    Raises InputError for an unknown one, or one that needs what is not there.
    """
    without = [one for one in recordings if one.reference is None]
    if asked is None:
        clouds = all(gives_depth(one) for one in recordings)
        of_itself = "unexplained_fraction" if clouds else "keypoint_error"
        return of_itself if without else "forearms"
    if asked == "keypoint_error" and not with_keypoints:
        raise InputError(
            "the keypoint error needs keypoints",
            where="--minimise",
            remedy="Give them with --keypoints, or choose another measure.",
        )
    measure = measure_named(asked)
    if measure is None:
        names = [one.name for one in MEASURES]
        raise InputError(
            f"unknown measure {asked!r}",
            where="--minimise",
            remedy=f"{did_you_mean(asked, names)}Available: {', '.join(names)}.",
        )
    if measure.from_reference and without:
        raise InputError(
            f"{asked} needs a reference, which {without[0].name} does not have",
            where="--minimise",
            remedy="Choose unexplained_fraction, or recordings with a reference.csv.",
        )
    return asked


def expected_seconds(
    waiting: Iterable[Job], known: Iterable[Job], results: Mapping[str, JobResult], workers: int
) -> float | None:
    """Wall time that jobs will take on so many workers; None where none has been measured yet.

    A job takes per frame what jobs on the same views of the same recording took, else what all took
    per frame and view.
    """
    same: dict[tuple[str, int], list[float]] = {}
    per_view: list[float] = []
    for job in known:
        result = results.get(job.identity)
        seconds = result.measures.get("seconds") if result is not None and result.done else None
        if seconds is not None and len(job.frames):
            each = seconds / len(job.frames)
            same.setdefault((job.folder, len(job.views)), []).append(each)
            per_view.append(each / len(job.views))
    if not per_view:
        return None
    total = 0.0
    for job in waiting:
        own = same.get((job.folder, len(job.views)))
        each = fmean(own) if own else fmean(per_view) * len(job.views)
        total += each * len(job.frames)
    return total / max(1, workers)


class _Source:
    """A recording from which jobs are made."""

    def __init__(self, recording: Recording, keypoints: Keypoints | None) -> None:
        self._recording, self._keypoints = recording, keypoints
        with FrameReader(recording, read_ahead=0) as reader:
            self._count = reader.frame_count
        self._fingerprint = fingerprint(recording)
        self._facts = _facts_of(recording, self._fingerprint)
        self._truth = _digest(_reference_facts(recording))

    def job(self, point: Point, base: SweepRequest, changes: Mapping[str, Value], seed: int) -> Job:
        name = point.special("preset") or base.preset
        settings = preset(name).replaced(**{**changes, **point.parameters})
        asked = views_of(self._recording, point.special("views") or base.views)
        keypoints = measured_keypoints(self._recording, settings, self._keypoints)
        views = tracked_views(self._recording, asked, keypoints)
        views = tuple(view.name for view in self._recording.views if view.name in views)
        frames = frames_within(point.special("frames") or base.frames, self._count)
        init = first_pose(point.special("init") or base.init, frames.start, self._recording)
        smooth = point.by_name.get("smooth", base.smooth) is True
        clouds = {
            "recording": self._facts,
            "depth": settings.depth.values(),
            "colour": settings.tracking.wants_colour,
            "views": views,
            "frames": [frames.start, frames.stop],
        }
        whole = {
            "clouds": clouds,
            "version": __version__,
            "settings": settings.values(),
            "seed": seed,
            "init": _pose_facts(init),
            "smooth": smooth,
            "reference": self._truth,
        }
        if keypoints is not None:
            whole["keypoints"] = keypoints.fingerprint()
        return Job(
            identity=_digest(whole),
            clouds=_digest(clouds),
            recording=self._recording.name,
            folder=str(self._recording.folder.resolve()),
            fingerprint=self._fingerprint,
            point=point,
            spec=RunSpec(settings, name, frames, views, seed, init, smooth, keypoints=keypoints),
        )


def _facts_of(recording: Recording, own_fingerprint: str) -> dict[str, Any]:
    """What the tracker is told of a recording, without its folder."""
    told, file, subject = None, recording.folder / OWN_FILE, recording.subject
    if file.is_file():
        told = hashlib.blake2b(read_bytes(file, TABLE_BYTES), digest_size=16)
    return {
        "fingerprint": own_fingerprint,
        "calibration": calibration_fingerprint(recording),
        "fps": recording.fps,
        "subject": None if subject is None else _known(subject),
        "detections": told.hexdigest() if told is not None else None,
    }


def _known(subject: Subject) -> dict[str, Any]:
    """Its facts; offsets only where there are any, so that jobs without keep their identity."""
    return {key: value for key, value in vars(subject).items() if key != "offsets" or value}


def _reference_facts(recording: Recording) -> Any:
    """The truth that is measured against: where it is mended, old errors are no longer right."""
    reference = recording.reference
    if reference is None:
        return None
    return [reference.frame.tolist(), np.nan_to_num(reference.points, nan=1e9).tolist()]


def _pose_facts(init: FirstPose) -> Any:
    if not isinstance(init, Pose):
        return init
    return {name: np.asarray(value).tolist() for name, value in sorted(vars(init).items())}


def _digest(facts: Any) -> str:
    text = json.dumps(facts, sort_keys=True, separators=(",", ":"))
    return hashlib.blake2b(text.encode(), digest_size=12).hexdigest()

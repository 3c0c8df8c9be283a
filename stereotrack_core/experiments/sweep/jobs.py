"""Jobs of a sweep, made of points: recordings times points times seeds."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from stereotrack_core.body.pose import Pose
from stereotrack_core.experiments.runner.job import Job
from stereotrack_core.experiments.sweep.points import Point
from stereotrack_core.experiments.sweep.request import SweepRequest
from stereotrack_core.interop.first_pose import first_pose
from stereotrack_core.parameters import Value, parsed_settings
from stereotrack_core.reading import TABLE_BYTES, read_bytes
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.detections import OWN_FILE
from stereotrack_core.recording.fingerprint import calibration_fingerprint, fingerprint
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.recording.selection import frames_within, seeds_of, usable_views, views_of
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run_spec import FirstPose, RunSpec
from stereotrack_core.version import __version__


class Planner:
    """Makes jobs of points: recordings times points times seeds, in this order.

    Parameters
    ----------
    recordings : sequence of Recording
    request : SweepRequest
        What holds where a point says nothing else.

    Raises
    ------
    InputError
        Where the request asks for what no point could mend.
    """

    def __init__(self, recordings: Sequence[Recording], request: SweepRequest) -> None:
        preset(request.preset, request.changes)
        self._request = request
        self._changes = parsed_settings(request.changes)
        self.seeds = seeds_of(request.seeds)
        self._sources = tuple(_Source(recording) for recording in recordings)

    def jobs(self, points: Sequence[Point]) -> tuple[Job, ...]:
        """All jobs of some points.

        Raises
        ------
        InputError
            For views, frames or first poses that a recording does not have.
        """
        jobs: list[Job] = []
        for source in self._sources:
            for point in points:
                own = point.special("seed")
                seeds = self.seeds if own is None else [int(own)]
                jobs += [source.job(point, self._request, self._changes, seed) for seed in seeds]
        return tuple(jobs)


class _Source:
    """A recording from which jobs are made."""

    def __init__(self, recording: Recording) -> None:
        self._recording = recording
        with FrameReader(recording, read_ahead=0) as reader:
            self._count = reader.frame_count
        self._fingerprint = fingerprint(recording)
        self._facts = _facts_of(recording, self._fingerprint)
        self._truth = _digest(_reference_facts(recording))

    def job(self, point: Point, base: SweepRequest, changes: Mapping[str, Value], seed: int) -> Job:
        name = point.special("preset") or base.preset
        settings = preset(name).replaced(**{**changes, **point.parameters})
        asked = views_of(self._recording, point.special("views") or base.views)
        views = usable_views(self._recording, asked)
        views = tuple(view.name for view in self._recording.views if view.name in views)
        frames = frames_within(point.special("frames") or base.frames, self._count)
        init = first_pose(point.special("init") or base.init, frames.start)
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
        return Job(
            identity=_digest(whole),
            clouds=_digest(clouds),
            recording=self._recording.name,
            folder=str(self._recording.folder.resolve()),
            fingerprint=self._fingerprint,
            point=point,
            spec=RunSpec(settings, name, frames, views, seed, init, smooth),
        )


def _facts_of(recording: Recording, own_fingerprint: str) -> dict[str, Any]:
    """What the tracker is told of a recording, without its folder."""
    detections = recording.folder / OWN_FILE
    subject = recording.subject
    return {
        "fingerprint": own_fingerprint,
        "calibration": calibration_fingerprint(recording),
        "fps": recording.fps,
        "subject": None if subject is None else vars(subject),
        "detections": _file_digest(detections) if detections.is_file() else None,
    }


def _file_digest(path: Path) -> str:
    return hashlib.blake2b(read_bytes(path, TABLE_BYTES), digest_size=16).hexdigest()


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

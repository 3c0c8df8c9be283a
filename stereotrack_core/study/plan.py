"""Jobs of a study, checked before anything long begins."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from stereotrack_core.body.pose import Pose
from stereotrack_core.errors import InputError
from stereotrack_core.interop.first_pose import first_pose
from stereotrack_core.parameters import parsed_settings
from stereotrack_core.project.detectors import keypoints_in
from stereotrack_core.project.project import Project
from stereotrack_core.project.setups import load_reference
from stereotrack_core.reading import TABLE_BYTES, read_bytes
from stereotrack_core.recording.description import Recording, Subject
from stereotrack_core.recording.detections import OWN_FILE
from stereotrack_core.recording.folder import calibration_fingerprint, fingerprint, open_recording
from stereotrack_core.recording.keypoints import Keypoints
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.recording.selection import frames_within, seeds_of, tracked_views, views_of
from stereotrack_core.study.description import Study, StudyRecording, StudySettings
from stereotrack_core.study.job import Job
from stereotrack_core.study.points import Point
from stereotrack_core.tracking.presets import PRESETS, preset
from stereotrack_core.tracking.run_spec import FirstPose, RunSpec, measured_keypoints
from stereotrack_core.version import __version__


@dataclass(frozen=True)
class Source:
    """A recording of a study with what its project and a detector say of it."""

    row: StudyRecording
    recording: Recording
    """With the reference that counts."""
    keypoints: Keypoints | None
    frames: int
    truth: LandmarkTrajectory | None = None
    """The reference chosen in the project; None: the recording's own counts."""

    @cached_property
    def facts(self) -> dict[str, Any]:
        """Everything about the recording that the tracker is told, without its folder."""
        return _facts_of(self.recording)

    @cached_property
    def reference(self) -> str:
        """Hash of the reference: results of another one are not valid."""
        reference = self.recording.reference
        if reference is None:
            return _digest(None)
        points = np.nan_to_num(reference.points, nan=1e9)
        return _digest([reference.frame.tolist(), points.tolist()])


def source_of(study: Study, row: StudyRecording) -> Source:
    """Open a recording with its project and keypoints.

    Raises InputError if one of them is missing or cannot be used.
    """
    folder = study.place(row.recording)
    if not folder.is_dir():
        raise InputError(
            "the recording was not found",
            where=row.recording,
            remedy=f"Move it back to {folder}, or write its place into the study file.",
        )
    recording, truth = open_recording(folder), None
    if row.project:
        with Project.open(study.place(row.project), read_only=True) as project:
            chosen = project.chosen(project.references)
            if chosen:
                truth = load_reference(project.references, chosen).trajectory()
    if truth is not None:
        recording = dataclasses.replace(recording, reference=truth)
    keypoints = None
    if row.keypoints:
        settings, path = study.settings, study.place(row.keypoints)
        keypoints = keypoints_in(path, recording, settings.layout, settings.person).keypoints
    with FrameReader(recording, read_ahead=0) as reader:
        count = reader.frame_count
    return Source(row, recording, keypoints, count, truth)


def jobs_of(study: Study, source: Source, points: Sequence[Point], *, keep: bool) -> list[Job]:
    """Jobs of a recording: points times seeds, in this order; `keep`: whether runs are kept.

    Raises InputError for views, frames or first poses that the recording does not have.
    """
    jobs = []
    for point in points:
        own = point.special("seed")
        seeds = seeds_of(study.settings.seeds) if own is None else [int(own)]
        jobs += [_job(study, source, point, seed) for seed in seeds]
    return [_kept(study, source.row, job) for job in jobs] if keep else jobs


def _job(study: Study, source: Source, point: Point, seed: int) -> Job:
    base, recording = study.settings, source.recording
    name = point.special("preset") or base.preset
    settings = preset(name).replaced(**{**parsed_settings(base.changes), **point.parameters})
    asked = views_of(recording, point.special("views") or base.views)
    keypoints = measured_keypoints(recording, settings, source.keypoints)
    tracked = tracked_views(recording, asked, keypoints)
    views = tuple(view.name for view in recording.views if view.name in tracked)
    frames = frames_within(point.special("frames") or base.frames, source.frames)
    init = first_pose(point.special("init") or base.init, frames.start, recording)
    smooth = point.by_name.get("smooth", base.smooth) is True
    clouds = {
        "recording": source.facts,
        "depth": settings.depth.values(),
        "colour": settings.tracking.wants_colour,
        "views": views,
        "frames": [frames.start, frames.stop],
    }
    tracking = {
        "clouds": clouds,
        "version": __version__,
        "settings": settings.values(),
        "seed": seed,
        "init": _pose_facts(init),
        "smooth": smooth,
    }
    if keypoints is not None:
        tracking["keypoints"] = keypoints.fingerprint()
    return Job(
        identity=_digest({**tracking, "reference": source.reference}),
        tracking=_digest(tracking),
        clouds=_digest(clouds),
        recording=recording.name,
        folder=str(recording.folder.resolve()),
        fingerprint=source.facts["fingerprint"],
        point=point,
        spec=RunSpec(settings, name, frames, views, seed, init, smooth, keypoints=keypoints),
        truth=source.truth,
    )


def _kept(study: Study, row: StudyRecording, job: Job) -> Job:
    """The job with a file for its run; copies of a recording have runs of their own."""
    name = _run_name(study.settings, job)
    return dataclasses.replace(
        job,
        identity=_digest([job.identity, row.recording]),
        recording=row.recording,
        keep=str(study.runs_of(row) / f"{name}.npz"),
    )


def _run_name(base: StudySettings, job: Job) -> str:
    """Preset and seed, and a few digits for everything else that was asked for."""
    name, settings = job.spec.preset, job.spec.settings
    own = name not in PRESETS or settings.values() != preset(name).values()
    point = job.point
    asked = [
        settings.values() if own else None,
        *(point.special(key) or getattr(base, key) for key in ("views", "frames", "init")),
        job.spec.smooth,
    ]
    words = [Path(name).stem if name.endswith(".toml") else name]
    if asked != [None, None, None, "auto", False]:
        words.append(_digest(asked)[:6])
    return "-".join([*words, f"seed{job.seed}"])


def _facts_of(recording: Recording) -> dict[str, Any]:
    digest, file, subject = None, recording.folder / OWN_FILE, recording.subject
    if file.is_file():
        digest = hashlib.blake2b(read_bytes(file, TABLE_BYTES), digest_size=16).hexdigest()
    return {
        "fingerprint": fingerprint(recording),
        "calibration": calibration_fingerprint(recording),
        "fps": recording.fps,
        "subject": None if subject is None else _subject_facts(subject),
        "detections": digest,
    }


def _subject_facts(subject: Subject) -> dict[str, Any]:
    """Offsets only if there are any, so that jobs without keep the identity they had."""
    return {key: value for key, value in vars(subject).items() if key != "offsets" or value}


def _pose_facts(init: FirstPose) -> Any:
    if not isinstance(init, Pose):
        return init
    return {name: np.asarray(value).tolist() for name, value in sorted(vars(init).items())}


def _digest(facts: Any) -> str:
    text = json.dumps(facts, sort_keys=True, separators=(",", ":"))
    return hashlib.blake2b(text.encode(), digest_size=12).hexdigest()

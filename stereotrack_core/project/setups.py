"""References, subjects, sets of landmarks, parameters and corrections of a recording in a project.

They are saved by edits, and read back as they were.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field, replace
from math import inf, isfinite
from pathlib import Path
from typing import Any, ClassVar

from stereotrack_core.annotation.landmark_set import NINE, LandmarkSet, landmark_set_of
from stereotrack_core.annotation.reference import Reference
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.interop.reference_npz import reference_bytes, reference_of_bytes
from stereotrack_core.project.database import making_sense
from stereotrack_core.project.edit import Change, Edit, Stamp, State
from stereotrack_core.project.entries import Entries, SaveEntry, facts_as_json
from stereotrack_core.project.schema import (
    CHOICE,
    DESCRIPTION,
    LANDMARK_SET,
    PARAMETER_SET,
    REFERENCE,
    SUBJECT,
)
from stereotrack_core.recording.calibration import read_calibration, write_calibration
from stereotrack_core.recording.description import (
    LENGTHS,
    Recording,
    Stream,
    Subject,
    View,
    subject_in,
)


@dataclass(frozen=True)
class ParameterSet:
    """Parameters by name, JSON-serialisable, as they differ from a preset."""

    preset: str
    values: Mapping[str, Any]


_META_SHOWN = ("program", "version", "preset", "seed", "recording", "fingerprint", "views")


def save_reference(name: str, reference: Reference, *, replacing: bool = False) -> SaveEntry:
    """The edit that puts a reference into the project."""
    shown = {key: reference.meta[key] for key in _META_SHOWN if key in reference.meta}
    facts = facts_as_json({"frames": len(reference.frame), **shown})
    return SaveEntry(REFERENCE.name, name, facts, reference_bytes(reference), replacing)


def load_reference(references: Entries, name: str) -> Reference:
    """A reference of the project, bit by bit as it was saved.

    Raises InputError where there is none of that name; ProjectDamaged where its data are not what
    was stored.
    """
    data = references.data(name)
    with making_sense(references.path):
        return reference_of_bytes(data, name)


def save_subject(subject: Subject, *, origin: str = "entered") -> SaveEntry:
    """The edit that keeps a subject's proportions under the subject's name.

    The origin is ``entered``, ``measured from clicks``, ``found by the tracker`` or
    ``personalised``.
    """
    facts = {**asdict(subject), "origin": origin}
    return SaveEntry(SUBJECT.name, subject.name, facts_as_json(facts), replacing=True)


@dataclass(frozen=True, eq=False)
class UseSubject(Edit):
    """Keep a subject under its name, and let the project use it, as one edit."""

    kind: ClassVar[str] = "use subject"
    subject: Subject
    origin: str

    def words(self) -> str:
        """``use subject P2, personalised``."""
        return f"use subject {self.subject.name}, {self.origin}"

    def changes(self, state: State, stamp: Stamp) -> Iterable[Change]:
        """The subject's row, and the choice."""
        yield from save_subject(self.subject, origin=self.origin).changes(state, stamp)
        yield state.change(CHOICE, (SUBJECT.name,), (self.subject.name,))


def load_subject(subjects: Entries, name: str) -> Subject:
    """A subject of the project; InputError where there is none of that name."""
    facts = subjects.get(name).facts
    with making_sense(subjects.path):
        lengths = {key: _length(facts.get(key)) for key in LENGTHS}
        return Subject(name, **lengths, offsets=_offsets(facts.get("offsets") or {}))


def _offsets(values: Any) -> Mapping[str, tuple[float, float, float]]:
    try:
        return subject_in({"offsets": values}, "subject").offsets
    except InputError as error:
        raise ValueError(error.what) from error


def _length(value: Any) -> float | None:
    if value is not None and not (isinstance(value, int | float) and 0 < value < inf):
        raise ValueError(f"{value!r} is not a length")
    return None if value is None else float(value)


def save_landmark_set(landmarks: LandmarkSet) -> SaveEntry:
    """The edit that keeps a set of landmarks under its name."""
    facts = facts_as_json(landmarks.facts())
    return SaveEntry(LANDMARK_SET.name, landmarks.name, facts, replacing=True)


def load_landmark_set(sets: Entries, name: str | None) -> LandmarkSet:
    """A set of landmarks of the project, the nine without a name.

    InputError where there is none of that name.
    """
    if name is None or (name == NINE.name and name not in sets.names()):
        return NINE
    facts = sets.get(name).facts
    with making_sense(sets.path):
        try:
            return landmark_set_of(facts)
        except InputError as error:  # which says how to write one
            raise ValueError(error.what) from error


def save_parameters(name: str, parameters: ParameterSet) -> SaveEntry:
    """The edit that keeps parameters under a name."""
    facts = facts_as_json({"preset": parameters.preset, "values": dict(parameters.values)})
    return SaveEntry(PARAMETER_SET.name, name, facts, replacing=True)


def load_parameters(sets: Entries, name: str) -> ParameterSet:
    """Parameters of the project; InputError where there are none of that name."""
    facts = sets.get(name).facts
    with making_sense(sets.path):
        return ParameterSet(str(facts["preset"]), dict(facts["values"]))


@dataclass(frozen=True, eq=False)
class Corrections:
    """What is different from the recording's folder, which is not touched.

    Every version says everything that differs, so that versions can be compared and taken back one
    by one. Streams are named ``N/left``.
    """

    reason: str  # how they were found, in words
    time_offsets: Mapping[str, float] = field(default_factory=dict)
    """Seconds by which a stream shows the scene later."""
    first_frames: Mapping[str, int] = field(default_factory=dict)
    """The stream's own frame that is frame 0 of the recording."""
    stream_cameras: Mapping[str, str] = field(default_factory=dict)
    """Name of the camera that a stream really shows (views that were swapped)."""
    cameras: Mapping[str, Camera] = field(default_factory=dict)
    """Cameras by name that are better calibrated."""

    def applied_to(self, recording: Recording) -> Recording:
        """The recording as it is with these corrections.

        InputError where a stream or a camera is not in the recording.
        """
        streams = {f"{view.name}/{key}" for view in recording.views for key in view.streams()}
        for names in (self.time_offsets, self.first_frames, self.stream_cameras):
            _check_known("stream", set(names) - streams, recording)
        cameras = {**recording.cameras, **self.cameras}
        _check_known("camera", set(self.stream_cameras.values()) - set(cameras), recording)
        return replace(
            recording,
            views=tuple(self._view(view) for view in recording.views),
            cameras=cameras,
            guessed=recording.guessed and bool(set(recording.cameras) - set(self.cameras)),
        )

    def _view(self, view: View) -> View:
        changed: dict[str, Any] = {}
        for key in ("image", "left", "depth", "mask"):
            if (stream := getattr(view, key)) is not None:
                own = "right" if key == "image" and view.kind == "stereo" else key
                changed[key] = self._stream(f"{view.name}/{own}", stream)
        return replace(view, **changed)

    def _stream(self, name: str, stream: Stream) -> Stream:
        return replace(
            stream,
            time_offset=self.time_offsets.get(name, stream.time_offset),
            first_frame=self.first_frames.get(name, stream.first_frame),
            camera=self.stream_cameras.get(name, stream.camera),
        )


def save_corrections(name: str, corrections: Corrections) -> SaveEntry:
    """The edit that keeps corrections as a new version of the description."""
    facts = {
        "reason": corrections.reason,
        "time_offsets": dict(corrections.time_offsets),
        "first_frames": dict(corrections.first_frames),
        "stream_cameras": dict(corrections.stream_cameras),
        "calibration": _calibration_text(corrections.cameras),
    }
    return SaveEntry(DESCRIPTION.name, name, facts_as_json(facts))


def load_corrections(descriptions: Entries, name: str) -> Corrections:
    """A version of the description; InputError where there is none of that name."""
    facts = descriptions.get(name).facts
    with making_sense(descriptions.path):
        return Corrections(
            reason=str(facts["reason"]),
            time_offsets={key: _seconds(x) for key, x in dict(facts["time_offsets"]).items()},
            first_frames={key: int(x) for key, x in dict(facts["first_frames"]).items()},
            stream_cameras={key: str(x) for key, x in dict(facts["stream_cameras"]).items()},
            cameras=_cameras(str(facts["calibration"])),
        )


def _seconds(value: Any) -> float:
    if not isfinite(seconds := float(value)):
        raise ValueError("a time offset is not a number")
    return seconds


def _calibration_text(cameras: Mapping[str, Camera]) -> str:
    if not cameras:
        return ""
    with _temporary_file() as path:
        write_calibration(path, cameras)
        return path.read_text(encoding="utf-8")


def _cameras(text: str) -> Mapping[str, Camera]:
    if not text:
        return {}
    with _temporary_file() as path:
        path.write_text(text, encoding="utf-8")
        try:
            return read_calibration(path)
        except InputError as error:  # which names the temporary file
            raise ValueError(error.what) from error


@contextmanager
def _temporary_file() -> Iterator[Path]:
    with tempfile.TemporaryDirectory() as folder:
        yield Path(folder) / "calibration.toml"


def _check_known(what: str, unknown: set[str], recording: Recording) -> None:
    if unknown:
        raise InputError(
            f"the recording has no {what} {min(unknown)!r}",
            where=recording.name,
            remedy="These corrections belong to a different recording.",
        )

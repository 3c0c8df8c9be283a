"""Description of a recording folder: views, cameras, subject and segments."""

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any, Literal, TypeAlias

import tomli_w

from stereotrack_core.atomic import write_file
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory
from stereotrack_core.recording.toml_table import Table, load_toml
from stereotrack_core.tables import csv_text, read_rows, whole_number

ViewKind: TypeAlias = Literal["stereo", "depth", "mono"]

Cameras: TypeAlias = Mapping[str, Camera]
"""Cameras by their name in the calibration."""


@dataclass(frozen=True)
class Stream:
    """One video, or one set of numbered images."""

    camera: str  # name of the camera in the calibration (empty for a mask)
    frames: str  # video file or printf pattern, relative to the folder
    background: str | None = None  # image or video of the empty scene
    first_frame: int = 0  # the stream's own frame that is frame 0 of the recording
    time_offset: float = 0.0  # seconds by which the stream shows the scene later

    def shift(self, fps: float) -> int:
        """Its own frame at frame 0 of a recording of that rate."""
        return self.first_frame + round(self.time_offset * fps)


@dataclass(frozen=True)
class View:
    """A viewpoint: one mono, depth or stereo camera.

    `image` is the reference image: the right image of a stereo camera, the image of a depth
    or mono view. `left` is there for stereo views; `depth`, `depth_unit` (metres per count)
    and perhaps `mask` for depth views.
    """

    name: str
    kind: ViewKind
    image: Stream
    left: Stream | None = None
    depth: Stream | None = None
    depth_unit: float = 0.001
    mask: Stream | None = None
    display_rotation: int = 0

    def streams(self) -> dict[str, Stream]:
        """The view's streams by their key in ``recording.toml``."""
        named = {
            "left": self.left,
            "right" if self.kind == "stereo" else "image": self.image,
            "depth": self.depth,
            "mask": self.mask,
        }
        return {key: stream for key, stream in named.items() if stream is not None}

    def cameras(self) -> tuple[str, ...]:
        """Names of its cameras, each once."""
        return tuple(dict.fromkeys(one.camera for one in self.streams().values() if one.camera))


@dataclass(frozen=True)
class Segment:
    """A named stretch of frames, half-open."""

    name: str
    first: int
    end: int


@dataclass(frozen=True)
class Subject:
    """One person's body: lengths in metres, None if not measured, and where bones lie in it."""

    name: str = ""
    shoulder_width: float | None = None
    hip_width: float | None = None
    torso_length: float | None = None
    upper_arm_length: float | None = None
    forearm_length: float | None = None
    hand_length: float | None = None
    shoulder_to_head: float | None = None
    offsets: Mapping[str, tuple[float, float, float]] = field(default_factory=dict, hash=False)
    """Mapping from landmark to metres along three axes of its part (:mod:`body.offsets`): how far
    it lies from where the tracked surface puts it. Empty where that was not estimated."""


@dataclass(frozen=True, eq=False)
class Recording:
    """A recording folder as described by its files; images are read by ``FrameReader``."""

    folder: Path
    name: str
    fps: float  # frame sets per second
    views: tuple[View, ...]
    cameras: Cameras  # mapping from camera name to Camera
    subject: Subject | None = None
    reference: LandmarkTrajectory | None = None  # truth for ``evaluate``; never tracked with
    segments: tuple[Segment, ...] = field(default=())
    guessed: bool = False
    """Whether the cameras are guessed, so that nothing in space may be concluded from them."""

    def view(self, name: str) -> View:
        """The view of that name; KeyError where there is none."""
        for view in self.views:
            if view.name == name:
                return view
        raise KeyError(name)

    def camera_names(self) -> dict[str, str]:
        """How people call the cameras: the view's name, with ``left`` for the left image."""
        names = {view.left.camera: f"{view.name} left" for view in self.views if view.left}
        return {**names, **{view.image.camera: view.name for view in self.views}}

    def reference_camera(self, view: View) -> Camera:
        """Camera of the view's reference image."""
        return self.cameras[view.image.camera]


LENGTHS = tuple(one.name for one in fields(Subject) if one.name not in ("name", "offsets"))

_FARTHEST = 0.2  # metres; no bone lies farther from where the surface puts it


def read_subject(path: Path) -> Subject:
    """The subject, lengths in metres or None; InputError at the first thing that is wrong."""
    return subject_in(load_toml(path), str(path))


def subject_in(values: Mapping[str, Any], where: str) -> Subject:
    """The subject that a table of names and values describes; as :func:`read_subject`."""
    complaints: list[InputError] = []
    table = Table(values, where, complaints)
    lengths = {key: table.number(key) for key in LENGTHS}
    for key, length in lengths.items():
        if length is not None and length <= 0:
            what = f"a length of {length:g} m is not possible"
            table.complain(key, what, "Give the length in metres.")
    name = table.text("name") or ""
    offsets = _offsets(table.table("offsets", example="left_hip = [0.0, 0.01, 0.0]"))
    if complaints:
        raise complaints[0]
    return Subject(name=name, **lengths, offsets=offsets)


def _offsets(table: Table | None) -> dict[str, tuple[float, float, float]]:
    """Offsets by landmark; the table is told what is wrong with others."""
    found: dict[str, tuple[float, float, float]] = {}
    if table is None:
        return found
    for name in table.values:
        numbers = table.numbers(name, 3)
        if name not in LANDMARKS:
            remedy = f"The landmarks are {', '.join(LANDMARKS)}."
            table.complain(name, f"unknown landmark {name!r}", remedy)
        elif max(map(abs, numbers), default=0.0) > _FARTHEST:
            remedy = f"Give metres, at most {_FARTHEST:g}."
            table.complain(name, f"{list(numbers)} is not a possible offset", remedy)
        elif numbers:
            x, y, z = numbers
            found[name] = (x, y, z)
    return found


def write_subject(path: Path, subject: Subject) -> None:
    """Write a subject so that :func:`read_subject` gives it again."""
    known = {key: value for key, value in asdict(subject).items() if value is not None}
    if known.pop("offsets"):
        known["offsets"] = {name: list(place) for name, place in subject.offsets.items()}
    write_file(path, tomli_w.dumps(known))


COLUMNS = ("segment", "first", "end")


def read_segments(path: Path) -> tuple[Segment, ...]:
    """Segments in the file's order; InputError for an unreadable file, no name or no frames."""
    segments = []
    for line, cells in read_rows(path, COLUMNS):
        first = whole_number(cells["first"], path, line, "first")
        end = whole_number(cells["end"], path, line, "end")
        what, remedy = "", "Write 0 <= first < end. The frame `end` is not part of the segment."
        if not cells["segment"]:
            what, remedy = f"the segment in line {line} has no name", "Give it a name."
        elif not 0 <= first < end:
            what = f"segment {cells['segment']!r} in line {line} goes from {first} to {end}"
        if what:
            raise InputError(what, path, remedy)
        segments.append(Segment(cells["segment"], first, end))
    return tuple(segments)


def write_segments(path: Path, segments: Iterable[Segment]) -> None:
    """Write segments so that :func:`read_segments` gives them again."""
    rows = [(segment.name, segment.first, segment.end) for segment in segments]
    write_file(path, csv_text(COLUMNS, rows))

"""What a recording folder says about itself, as frozen facts, with subject and segments."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any, Literal, TypeAlias

import tomli_w

from stereotrack_core.atomic import write_file
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.recording.toml_table import Table, load_toml
from stereotrack_core.tables import csv_text, read_rows, whole_number

ViewKind: TypeAlias = Literal["stereo", "depth", "mono"]


@dataclass(frozen=True)
class Stream:
    """One video, or one set of numbered images."""

    camera: str  # name of the camera in the calibration (empty for a mask)
    frames: str  # video file or printf pattern, relative to the folder
    background: str | None = None  # image or video of the empty scene
    first_frame: int = 0  # the stream's own frame that is frame 0 of the recording
    time_offset: float = 0.0  # seconds by which the stream shows the scene later


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


@dataclass(frozen=True)
class Segment:
    """A named stretch of frames, half-open."""

    name: str
    first: int
    end: int


@dataclass(frozen=True)
class Subject:
    """Measured lengths in metres between joint centres; None where not measured."""

    name: str = ""
    shoulder_width: float | None = None
    hip_width: float | None = None
    torso_length: float | None = None
    upper_arm_length: float | None = None
    forearm_length: float | None = None
    hand_length: float | None = None
    shoulder_to_head: float | None = None


@dataclass(frozen=True, eq=False)
class Recording:
    """A recording folder as described by its files; images are read by ``FrameReader``."""

    folder: Path
    name: str
    fps: float  # frame sets per second
    views: tuple[View, ...]
    cameras: Mapping[str, Camera]  # mapping from camera name to Camera
    subject: Subject | None = None
    reference: LandmarkTrajectory | None = None
    """Taken as truth by ``evaluate``; the tracker never sees it."""
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


LENGTHS = tuple(field.name for field in fields(Subject) if field.name != "name")


def read_subject(path: Path) -> Subject:
    """The subject; lengths in metres, None where not measured.

    Raises InputError at the first thing that is wrong.
    """
    return subject_in(load_toml(path), str(path))


def subject_in(values: Mapping[str, Any], where: str) -> Subject:
    """The subject that a table of names and values describes; as :func:`read_subject`."""
    complaints: list[InputError] = []
    table = Table(values, where, complaints)
    lengths = {key: table.number(key) for key in LENGTHS}
    for key, length in lengths.items():
        if length is not None and length <= 0:
            table.complain(
                key, f"a length of {length:g} m is not possible", "Give the length in metres."
            )
    name = table.text("name") or ""
    if complaints:
        raise complaints[0]
    return Subject(name=name, **lengths)


def write_subject(path: Path, subject: Subject) -> None:
    """Write a subject so that :func:`read_subject` gives it again."""
    known = {key: value for key, value in asdict(subject).items() if value is not None}
    write_file(path, tomli_w.dumps(known))


COLUMNS = ("segment", "first", "end")


def read_segments(path: Path) -> tuple[Segment, ...]:
    """Segments in the file's order.

    Raises InputError when the file cannot be read or a segment has no name or ends before it
    begins.
    """
    segments = []
    for line, cells in read_rows(path, COLUMNS):
        first = whole_number(cells["first"], path, line, "first")
        end = whole_number(cells["end"], path, line, "end")
        if not cells["segment"]:
            raise InputError(
                f"the segment in line {line} has no name", where=str(path), remedy="Give it a name."
            )
        if not 0 <= first < end:
            raise InputError(
                f"segment {cells['segment']!r} in line {line} goes from {first} to {end}",
                where=str(path),
                remedy="Write 0 <= first < end. The frame `end` is not part of the segment.",
            )
        segments.append(Segment(cells["segment"], first, end))
    return tuple(segments)


def write_segments(path: Path, segments: Iterable[Segment]) -> None:
    """Write segments so that :func:`read_segments` gives them again."""
    rows = [(segment.name, segment.first, segment.end) for segment in segments]
    write_file(path, csv_text(COLUMNS, rows))

"""What an ``.slp`` file of SLEAP holds, as plain data: read by sleap-io in a process of its own."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from stereotrack_core.errors import InputError
from stereotrack_core.interop.hdf5 import read_hdf5
from stereotrack_core.reading import decoding
from stereotrack_core.versions import check_library, extra_library

_MISSING = "SLEAP files need the library sleap-io, which is not installed"
_INSTEAD = "COCO keypoints (.json)"
_WHAT = "this is not a SLEAP labels file"
_REMEDY = "Use an .slp file saved by SLEAP; save a damaged one again."


class SleapPerson(NamedTuple):
    """Points of one person in one picture."""

    names: tuple[str, ...]
    x: list[float]  # pixels, not finite where there is no point
    y: list[float]
    sure: list[float]
    """Scores of what was predicted; of what was labelled 1 where it is visible, else 0."""
    track: str  # name of the person's track; empty if there is none

    def points(self) -> Iterator[tuple[str, float, float, float]]:
        """Name, x, y and `sure` of the points that have a place."""
        for point in zip(*self[:4], strict=True):
            if math.isfinite(point[1]) and math.isfinite(point[2]):
                yield point


@dataclass(frozen=True)
class SleapFrame:
    """A picture and the people in it, labelled or predicted, whichever was asked for."""

    number: int  # frame of its video
    video: str  # path of the video, or of its first picture; ``/`` between folders
    people: Sequence[SleapPerson]
    problem: InputError | None = None  # why they cannot be read
    picture: str = ""  # path of the picture, if the video is a list of pictures


@dataclass(frozen=True)
class SleapFile:
    """All of it that is asked for."""

    nodes: Sequence[str]  # names of the points of all skeletons
    frames: Sequence[SleapFrame]


def read_sleap_file(path: Path, *, predicted: bool = False) -> SleapFile:
    """What people have labelled, or with `predicted` SLEAP has; InputError where unreadable."""
    check_sleap_library(path)
    return read_hdf5(path, partial(_stored, predicted=predicted), _WHAT, _REMEDY)


def check_sleap_library(path: Path) -> None:
    """InputError where the library sleap-io is not installed; another process will load it."""
    check_library("sleap_io", "sleap", missing=_MISSING, where=str(path), instead=_INSTEAD)


def sleap_library(path: Path) -> Any:
    """The library sleap-io; InputError where it is not installed."""
    return extra_library("sleap_io", "sleap", missing=_MISSING, where=str(path), instead=_INSTEAD)


def _stored(path: Path, *, predicted: bool) -> SleapFile:
    sio = sleap_library(path)
    with decoding(path, _WHAT, _REMEDY):
        stored = sio.load_slp(str(path), open_videos=False)
        nodes = [str(node.name) for skeleton in stored.skeletons for node in skeleton.nodes]
        frames = [_frame(labelled, path, predicted) for labelled in stored.labeled_frames]
    return SleapFile(nodes, frames)


def _frame(labelled: Any, path: Path, predicted: bool) -> SleapFrame:
    number = int(labelled.frame_idx)
    video, picture, people = "", "", []
    again = "Predict it again in SLEAP." if predicted else "Label it again in SLEAP."
    try:
        with decoding(f"{path}, frame {number}", "it cannot be read", again):
            found = labelled.predicted_instances if predicted else labelled.user_instances
            people = [_person(one, "score" if predicted else "visible") for one in found]
            video, picture = _files_of(labelled.video, number)
    except InputError as problem:
        return SleapFrame(number, video, (), problem)
    return SleapFrame(number, video, people, picture=picture)


def _person(instance: Any, sure: str) -> SleapPerson:
    points, track = instance.points, instance.track
    places = np.asarray(points["xy"], dtype=np.float64).reshape(len(points), 2)
    names = tuple([str(name) for name in points["name"].tolist()])
    x, y = places.T.tolist()
    scores = np.asarray(points[sure], dtype=np.float64).tolist()
    return SleapPerson(names, x, y, scores, "" if track is None else str(track.name))


def _files_of(video: Any, number: int) -> tuple[str, str]:
    """Path of a video, and that of its picture of this number if it is a list of pictures."""
    video = video.source_video or video  # of pictures that are kept in the file
    file = video.filename
    if not isinstance(file, list):
        return str(file).replace("\\", "/"), ""
    first = str(file[0]).replace("\\", "/")
    return first, str(file[number]).replace("\\", "/") if 0 <= number < len(file) else ""

"""Labels of SLEAP (``.slp``), by the optional library sleap-io.

Pixels are SLEAP's own (the centre of the first one is 0, as here), frames those of the video: a
stream that begins earlier or later than the recording is accounted for. The format cannot tell what
is outside the image from what nobody has labelled, and keeps neither flag nor sigma.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from io import BytesIO
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np

from stereotrack_core.annotation.click import Click, Visibility
from stereotrack_core.annotation.landmark_set import LandmarkSet
from stereotrack_core.atomic import replacing
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.interop.label_source import Labels, LabelSource, pictures_of
from stereotrack_core.interop.sleap_file import (
    SleapFrame,
    SleapPerson,
    check_sleap_library,
    read_sleap_file,
    sleap_library,
)
from stereotrack_core.limited_process import write_apart
from stereotrack_core.recording.description import Recording, Stream
from stereotrack_core.recording.images import is_pattern, numbered_files
from stereotrack_core.recording.landmarks import SKELETON


def write_sleap(
    path: Path,
    clicks: Iterable[Click],
    recording: Recording,
    landmarks: LandmarkSet,
    *,
    pictures: bool = False,
) -> None:
    """Write the clicks of all cameras; each camera is a video.

    With `pictures` the labelled ones are kept in the file, which then needs no video.

    InputError where the file cannot be written, or sleap-io is not installed.
    """
    check_sleap_library(path)
    placed = (click for click in clicks if click.position is not None)
    found = pictures_of(placed, landmarks.names, recording, path)
    write = partial(_save, found, recording, landmarks, "user" if pictures else False)

    def is_whole(written: Path) -> bool:
        import h5py

        # of the file itself it remembers what it could not write
        with h5py.File(BytesIO(written.read_bytes())) as stored:
            return len(stored["frames"][()]) == len(found)

    with replacing(path, is_whole) as temporary:
        write_apart(write, temporary)


def _save(
    pictures: Sequence[tuple[Camera, int, Mapping[str, Click]]],
    recording: Recording,
    landmarks: LandmarkSet,
    embed: str | bool,
    path: Path,
) -> None:
    """Write them in this process, which HDF5 may end later where it could not."""
    sio = sleap_library(path)
    names = landmarks.names
    bones = [(a, b) for a, b in SKELETON if {a, b} <= set(names)]
    skeleton = sio.Skeleton(nodes=list(names), edges=bones, name=landmarks.name)
    streams = _streams(recording)
    videos: dict[str, Any] = {}
    frames = []
    for camera, frame, found in pictures:
        stream = streams[camera.name]
        if camera.name not in videos:
            videos[camera.name] = _video(sio, recording, stream)
        points = np.full((len(names), 2), np.nan)
        seen = np.zeros(len(names), dtype=np.bool_)
        for name, click in found.items():
            points[names.index(name)] = click.position
            seen[names.index(name)] = click.visibility == Visibility.SEEN
        instance = sio.Instance.from_numpy(points, skeleton=skeleton)
        instance.points["visible"] = seen
        own = frame + _shift(stream, recording)
        frames.append(
            sio.LabeledFrame(video=videos[camera.name], frame_idx=own, instances=[instance])
        )
    labels = sio.Labels(labeled_frames=frames, videos=list(videos.values()), skeletons=[skeleton])
    for video in videos.values() if embed else ():
        video.open_backend = True
    try:
        sio.save_slp(labels, str(path), embed=embed, verbose=False)
    except RuntimeError as error:  # what h5py raises where a drive is full
        raise OSError(str(error)) from error


def read_sleap(source: LabelSource) -> Labels:
    """Read what people have labelled; predictions are left out.

    InputError where the file cannot be read, sleap-io is not installed, or no landmark is
    known.
    """
    path = source.path
    stored = read_sleap_file(path)

    def read(labelled: SleapFrame, known: Mapping[str, str]) -> list[Click]:
        if labelled.problem is not None:
            raise labelled.problem
        people = labelled.people
        if not people:
            return []
        where = f"{path}, frame {labelled.number}"
        if len(people) > 1:
            raise InputError(
                f"{len(people)} people are labelled",
                where=where,
                remedy="Keep only the instances of one person.",
            )
        return _clicks(people[0], place_of_labelled(labelled, source, where), known)

    return source.labels(stored.nodes, stored.frames, read)


def _streams(recording: Recording) -> dict[str, Stream]:
    """The stream of every camera that shows pictures."""
    shown = [view.image for view in recording.views]
    shown += [view.left for view in recording.views if view.left is not None]
    return {stream.camera: stream for stream in shown}


def _video(sio: Any, recording: Recording, stream: Stream) -> Any:
    """The video, or all of its pictures; their pattern where they are not there."""
    files: Mapping[int, Path] = {}
    if is_pattern(stream.frames) and (recording.folder / stream.frames).parent.is_dir():
        files = numbered_files(recording.folder, stream.frames)
    if not files:
        return sio.Video(filename=str(recording.folder / stream.frames), open_backend=False)
    return sio.Video.from_filename([str(files[number]) for number in sorted(files)])


def _shift(stream: Stream, recording: Recording) -> int:
    """The stream's own frame that is frame 0 of the recording."""
    return stream.first_frame + round(stream.time_offset * recording.fps)


def place_of_labelled(labelled: SleapFrame, source: LabelSource, where: str) -> tuple[int, str]:
    """Frame and camera of a labelled frame; InputError where they cannot be told."""
    streams = _streams(source.recording)
    file = labelled.video
    own = {PurePosixPath(stream.frames).name: name for name, stream in streams.items()}
    base = PurePosixPath(file).name
    whole = [name for name, one in streams.items() if file.endswith(one.frames)]
    if source.camera is None and len(whole) == 1:
        name = whole[0]
    elif source.camera is None and len(own) == len(streams) and base in own:
        name = own[base]
    else:
        name = source.camera_of(file, where)
    frame = labelled.number - _shift(streams[name], source.recording)
    if frame < 0:
        raise InputError(
            f"it is {-frame} frames before the start of the recording",
            where=where,
            remedy="Delete it.",
        )
    return frame, name


def _clicks(person: SleapPerson, place: tuple[int, str], known: Mapping[str, str]) -> list[Click]:
    clicks = []
    for name, x, y, visible in person.points():
        if name in known:
            seen = Visibility.SEEN if visible else Visibility.GUESSED
            clicks.append(Click(*place, known[name], (x, y), seen, origin="imported"))
    return clicks

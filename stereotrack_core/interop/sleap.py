"""Labels of SLEAP (``.slp``), by the optional library sleap-io in a process of its own.

Pixels are SLEAP's own (the centre of the first one is 0, as here), frames those of the video: a
stream that begins earlier or later than the recording is accounted for. Of numbered pictures SLEAP
counts the files, so that a missing number moves all frames behind it. The format cannot tell what
is outside the image from what nobody has labelled, and keeps neither flag nor sigma.

Predictions are also read from an analysis (.h5) of one video, which holds arrays: ``tracks``
(track, x y, node, frame), ``point_scores`` (track, node, frame), names of tracks and nodes.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from io import BytesIO
from pathlib import Path, PurePosixPath
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from stereotrack_core.annotation.click import Click, Visibility
from stereotrack_core.annotation.landmark_set import LandmarkSet
from stereotrack_core.arrays import FloatArray
from stereotrack_core.atomic import replacing
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.interop import label_source
from stereotrack_core.interop.keypoints.source import FileRow, KeypointSource, Who
from stereotrack_core.limited_process import read_apart
from stereotrack_core.reading import check_file, decoding
from stereotrack_core.recording.description import Recording, Stream
from stereotrack_core.recording.images import is_pattern, numbered_files
from stereotrack_core.recording.landmarks import SKELETON
from stereotrack_core.versions import check_library, extra_library

_MISSING = "SLEAP files need the library sleap-io, which is not installed"
_INSTEAD = "COCO keypoints (.json)"
_OTHERWISE = "export them as csv or coco"
_WHAT = "this is not a SLEAP labels file"
_REMEDY = "Use an .slp file saved by SLEAP; save a damaged one again."


class SleapPerson(NamedTuple):
    """Points of one person in one picture."""

    track: str  # name of the person's track; empty if there is none
    points: list[tuple[str, float, float, float]]
    """Name, x and y in pixels of the points that have a place, and how sure they are: the score of
    what was predicted; of what was labelled 1 where it is visible, else 0."""


@dataclass(frozen=True)
class SleapFrame:
    """A picture and the people in it, labelled or predicted, whichever was asked for."""

    number: int  # frame of its video
    video: str  # path of the video, or of its first picture; ``/`` between folders
    people: Sequence[SleapPerson]
    problem: InputError | None = None  # why they cannot be read
    picture: str = ""  # path of the picture, if the video is a list of pictures


def write_sleap(
    path: Path, clicks: Iterable[Click], recording: Recording, landmarks: LandmarkSet
) -> None:
    """Write clicks, each camera as a video; InputError without sleap-io, or a clicked picture."""
    check_sleap_library(path)
    placed = (click for click in clicks if click.position is not None)
    found = label_source.pictures_of(placed, landmarks.names, recording, path)
    streams = _streams(recording)
    files = {name: _pictures(recording, streams[name]) for name in {one[0].name for one in found}}
    for camera, frame, _ in found:
        if _index_of(files[camera.name], frame + streams[camera.name].shift(recording.fps)) is None:
            missing = f"the picture of frame {frame} in {camera.name} is missing"
            what = f"{missing}, so SLEAP cannot hold its clicks"
            raise InputError(what, path, f"Delete the clicks of this frame, or {_OTHERWISE}.")
    write = partial(_save, found, recording, landmarks, files)

    def is_whole(written: Path) -> bool:
        import h5py

        # of the file itself it remembers what it could not write
        with h5py.File(BytesIO(written.read_bytes())) as stored:
            return len(stored["frames"][()]) == len(found)

    with replacing(path, is_whole) as temporary:
        read_apart(write, temporary, f"Free space on the drive, or {_OTHERWISE}.")


def _save(
    pictures: Sequence[tuple[Camera, int, Mapping[str, Click]]],
    recording: Recording,
    landmarks: LandmarkSet,
    files: Mapping[str, Mapping[int, Path]],
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
            own_files = [str(path) for _, path in sorted(files[camera.name].items())]
            videos[camera.name] = (
                sio.Video.from_filename(own_files)
                if own_files
                else sio.Video(str(recording.folder / stream.frames), open_backend=False)
            )
        points = np.full((len(names), 2), np.nan)
        seen = np.zeros(len(names), dtype=np.bool_)
        for name, click in found.items():
            points[names.index(name)] = click.position
            seen[names.index(name)] = click.visibility == Visibility.SEEN
        instance = sio.Instance.from_numpy(points, skeleton=skeleton)
        instance.points["visible"] = seen
        own = _index_of(files[camera.name], frame + stream.shift(recording.fps))
        frames.append(
            sio.LabeledFrame(video=videos[camera.name], frame_idx=own, instances=[instance])
        )
    labels = sio.Labels(labeled_frames=frames, videos=list(videos.values()), skeletons=[skeleton])
    try:
        sio.save_slp(labels, str(path), embed=False, verbose=False)
    except RuntimeError as error:  # what h5py raises where a drive is full
        raise OSError(str(error)) from error


def read_sleap(source: label_source.LabelSource) -> label_source.Labels:
    """Read what people have labelled, not predictions; InputError if unreadable or unknown."""
    path = source.path
    nodes, frames = read_sleap_file(path)
    place_of_labelled = places_of_labelled(frames, source)

    def read(labelled: SleapFrame, known: Mapping[str, str]) -> list[Click]:
        if labelled.problem is not None:
            raise labelled.problem
        people = labelled.people
        if not people:
            return []
        where = f"{path}, frame {labelled.number}"
        if len(people) > 1:
            what = f"{len(people)} people are labelled"
            raise InputError(what, where, "Keep only the instances of one person.")
        place = place_of_labelled(labelled, where)
        if place is None:
            return []
        clicks = []
        for name, x, y, visible in people[0].points:
            if name in known:
                seen = Visibility.SEEN if visible else Visibility.GUESSED
                clicks.append(Click(*place, known[name], (x, y), seen, origin="imported"))
        return clicks

    return source.labels(nodes, frames, read)


def _streams(recording: Recording) -> dict[str, Stream]:
    """The stream of every camera that shows pictures."""
    shown = [view.image for view in recording.views]
    shown += [view.left for view in recording.views if view.left is not None]
    return {stream.camera: stream for stream in shown}


def _pictures(recording: Recording, stream: Stream) -> Mapping[int, Path]:
    """Numbered pictures of a stream; empty for a video, or if they are not there."""
    if not is_pattern(stream.frames) or not (recording.folder / stream.frames).parent.is_dir():
        return {}
    return numbered_files(recording.folder, stream.frames)


def _index_of(files: Mapping[int, Path], frame: int) -> int | None:
    """Place among the files of a stream's frame; None if its picture is missing among them."""
    if not files:
        return frame
    number = min(files) + frame
    inside = min(files) <= number <= max(files)
    return None if inside and number not in files else frame - _missing(files, number)


def _missing(files: Mapping[int, Path], before: int) -> int:
    """How many pictures are missing between the first one and a number."""
    there = sum(number < before for number in files)
    return min(before, max(files) + 1) - min(files) - there


def places_of_labelled(
    frames: Iterable[SleapFrame], source: label_source.LabelSource
) -> Callable[[SleapFrame, str], tuple[int, str] | None]:
    """Gives frame and camera of a labelled frame; None for one of another camera than stated."""
    recording = source.recording
    streams = _streams(recording)
    files = {name: _pictures(recording, stream) for name, stream in streams.items()}
    videos = list(dict.fromkeys(labelled.video for labelled in frames))
    named = ((video, _camera_of_video(video, streams)) for video in videos)
    cameras = {video: name for video, name in named if name}
    places = label_source.PicturePlaces(source, videos, cameras)

    def place(labelled: SleapFrame, where: str) -> tuple[int, str] | None:
        name = places.camera(labelled.video, where)
        if name is None:
            return None
        own = files[name]
        if labelled.picture:  # one of several files, by its number
            frame = label_source.frame_of(labelled.picture, where=where) - min(own, default=0)
        else:  # of a video, or behind the last picture
            frame = labelled.number + (_missing(own, max(own) + 1) if own else 0)
        frame -= streams[name].shift(recording.fps)
        if frame < 0:
            what = f"it is {-frame} frames before the start of the recording"
            raise InputError(what, where, "Delete it.")
        return frame, name

    return place


def _camera_of_video(video: str, streams: Mapping[str, Stream]) -> str | None:
    """The camera whose stream a video is, by its path or else by its name."""
    parts = PurePosixPath(video).parts
    paths = {name: PurePosixPath(stream.frames).parts for name, stream in streams.items()}
    whole = [name for name, own in paths.items() if parts[-len(own) :] == own]
    if len(whole) == 1:
        return whole[0]
    own = {path[-1]: name for name, path in paths.items()}
    return own.get(parts[-1]) if parts and len(own) == len(paths) else None


def read_sleap_file(path: Path, *, predicted: bool = False) -> tuple[list[str], list[SleapFrame]]:
    """Names of points, and pictures that people, or SLEAP (`predicted`), labelled; InputError."""
    check_sleap_library(path)
    check_file(path)
    return read_apart(partial(_stored, predicted=predicted), path, _REMEDY)


def check_sleap_library(path: Path) -> None:
    """InputError where the library sleap-io is not installed; another process will load it."""
    check_library("sleap_io", "sleap", missing=_MISSING, where=str(path), instead=_INSTEAD)


def sleap_library(path: Path) -> Any:
    """The library sleap-io; InputError where it is not installed."""
    return extra_library("sleap_io", "sleap", missing=_MISSING, where=str(path), instead=_INSTEAD)


def _stored(path: Path, *, predicted: bool) -> tuple[list[str], list[SleapFrame]]:
    sio = sleap_library(path)
    with decoding(path, _WHAT, _REMEDY):
        stored = sio.load_slp(str(path), open_videos=False)
        nodes = [str(node.name) for skeleton in stored.skeletons for node in skeleton.nodes]
        frames = [_frame(labelled, path, predicted) for labelled in stored.labeled_frames]
    return nodes, frames


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
    places = np.asarray(points["xy"], dtype=np.float64).reshape(len(points), 2).tolist()
    scores = np.asarray(points[sure], dtype=np.float64).tolist()
    rows = zip(points["name"].tolist(), places, scores, strict=True)
    known = (row for row in rows if all(map(math.isfinite, row[1])))
    found = [(str(name), x, y, score) for name, (x, y), score in known]
    return SleapPerson("" if track is None else str(track.name), found)


def _files_of(video: Any, number: int) -> tuple[str, str]:
    """Path of a video, and that of its picture of this number if it is a list of pictures."""
    video = video.source_video or video  # of pictures that are kept in the file
    file = video.filename
    if not isinstance(file, list):
        return str(file).replace("\\", "/"), ""
    first = str(file[0]).replace("\\", "/")
    return first, str(file[number]).replace("\\", "/") if 0 <= number < len(file) else ""


_NO_ANALYSIS = "this is not an analysis of SLEAP"
_EXPORT_AGAIN = "Export it again with SLEAP's File, Export Analysis HDF5."


def read_predictions(source: KeypointSource) -> Iterator[FileRow]:
    """Rows of what SLEAP has predicted, not of labels; InputError where it cannot be read."""
    path = source.path
    frames = [one for one in read_sleap_file(path, predicted=True)[1] if one.people]
    place_of = places_of_labelled(frames, source)
    for labelled in frames:
        if labelled.problem is not None:
            raise labelled.problem
        place = place_of(labelled, f"{path}, frame {labelled.number}")
        if place is None:
            continue
        for number, person in enumerate(labelled.people):
            who = Who(number, person.track)
            for point, x, y, score in person.points:
                yield *place, point, x, y, score, source.name, who


Analysis: TypeAlias = tuple[list[str], list[str], FloatArray, FloatArray]
"""Names of nodes and tracks, places (track, node, frame, 2) and scores (track, node, frame)."""


def stored_analysis(stored: Any, path: Path) -> Analysis:
    """What an open file holds; InputError where its parts do not fit together."""
    with decoding(path, _NO_ANALYSIS, _EXPORT_AGAIN):
        nodes, tracks = (
            [name.decode() if isinstance(name, bytes) else str(name) for name in stored[one][()]]
            for one in ("node_names", "track_names")
        )
        data = stored["tracks"]
        if data.ndim != 4 or data.shape[1:3] != (2, len(nodes)):
            raise ValueError("its parts do not fit together")
        places = np.moveaxis(data[()].astype(np.float64), 1, 3)
        scores = np.ones(places.shape[:3])
        if "point_scores" in stored and stored["point_scores"].shape == scores.shape:
            scores = stored["point_scores"][()].astype(np.float64)
        tracks = tracks if len(tracks) == len(places) else [""] * len(places)
        return nodes, tracks, places, scores


def rows_of_analysis(found: Analysis, source: KeypointSource) -> Iterator[FileRow]:
    """Rows of an analysis, whose camera is stated or told by the file's name."""
    nodes, tracks, places, scores = found
    camera = source.camera_of(source.path.name, str(source.path))
    for track, node, frame in np.argwhere(np.isfinite(places).all(axis=3)).tolist():
        x, y = places[track, node, frame].tolist()
        sure, who = float(scores[track, node, frame]), Who(track, tracks[track])
        yield frame, camera, nodes[node], x, y, sure, source.name, who

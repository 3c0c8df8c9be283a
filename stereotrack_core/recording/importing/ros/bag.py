"""Images in ROS bags (ROS 1 ``.bag``; ROS 2 sqlite3 and MCAP), by the optional library rosbags.

The instant of an image is the stamp of its header; where the driver left it empty, the time at
which it was recorded. Depth is 16 bits in millimetres, or 32-bit floats in metres (REP 118).
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.reading import open_file
from stereotrack_core.recording.images import DamagedFrame, Keep, PictureKind
from stereotrack_core.recording.importing.image_groups import entries_of
from stereotrack_core.recording.importing.ros.cameras import (
    INFO,
    TRANSFORMS,
    Info,
    cameras_of,
    focal_of,
    info_of,
    links_of,
)
from stereotrack_core.recording.importing.ros.images import (
    METRIC_UNIT,
    is_depth,
    picture_in,
)
from stereotrack_core.versions import extra_library

_SUFFIXES = frozenset({".bag", ".mcap", ".db3"})
_BEGINNING = b"#ROSBAG V"
_IMAGE = "sensor_msgs/msg/Image"
_COMPRESSED = "sensor_msgs/msg/CompressedImage"
_LAST_PARTS = frozenset(
    {"image", "image_raw", "image_rect", "image_rect_raw", "image_color", "image_rect_color"}
    | {"image_mono", "compressed", "compressedDepth", "raw"}
)
_DAMAGE = (
    *(ArithmeticError, AssertionError, AttributeError, LookupError, MemoryError, OSError),
    *(RuntimeError, TypeError, ValueError, struct.error, DamagedFrame),
)
_OF_VIEWER = re.compile(r"/device_\d+/sensor_\d+/(\w+)/image/data")
"""Topics of the bags that RealSense's viewer writes: Depth_0, Color_0, Infrared_1."""

_FEWEST = 2  # images of a topic that are a stream

Size: TypeAlias = tuple[int, int]


@dataclass(frozen=True)
class Topic:
    """The images of one topic."""

    name: str
    short: str
    """What the source is called: the topic without the parts that all have."""
    depth: bool
    width: int
    height: int
    times: tuple[float, ...]
    """Seconds since 1970 of each image, ascending."""
    places: tuple[int, ...]
    """Nanoseconds at which each was recorded, by which it is found."""
    unit: float | None
    """Metres per count, where it is depth that states it."""
    bits: int = 8
    """Bits of a stored value."""
    camera: Camera | None = None
    focal: float | None = None
    """Focal length in pixels, even of a camera whose place is not known."""


@dataclass(frozen=True)
class Bag:
    """What a bag holds that a recording can be made of."""

    topics: tuple[Topic, ...]
    notes: tuple[str, ...] = ()
    """What has to be known about its cameras, in clauses."""


@dataclass
class _Seen:
    """What was found of one topic while a bag is read."""

    frame: str = ""
    stamps: list[tuple[int, int]] = field(default_factory=list)  # of header and record, ns
    first: tuple[bool, Size, float | None, int] | None = None


def bags_in(paths: Sequence[Path]) -> tuple[Path, ...]:
    """The bags among paths, and in folders among them: files, or the folders of ROS 2."""
    bags: list[Path] = []
    for path in paths:
        inside = entries_of(path) if path.is_dir() and not _is_bag(path) else [path]
        bags += [one for one in inside if _is_bag(one)]
    return tuple(bags)


def is_bag_file(path: Path) -> bool:
    """Whether a name is that of a file of a bag."""
    return path.suffix.lower() in _SUFFIXES


def _is_bag(path: Path) -> bool:
    if path.is_file():
        return is_bag_file(path)
    stored = path.is_dir() and (path / "metadata.yaml").is_file()
    return stored and any(is_bag_file(one) for one in path.iterdir())


def read_topics(path: Path) -> Bag:
    """The streams of images in a bag, with their cameras; reads the bag once.

    Of a topic that is there raw and compressed, the raw images are taken.

    Raises InputError where it cannot be read, holds no images, or rosbags is not installed.
    """
    with opened(path) as reader:
        images = {
            one.topic: one for one in reader.connections if one.msgtype in (_IMAGE, _COMPRESSED)
        }
        for name in [one for one in images if _raw_of(one) in images]:
            del images[name]
        seen = {name: _Seen() for name in images}
        infos: dict[str, Info] = {}
        links: list[Any] = []
        wanted = [
            one
            for one in reader.connections
            if one.topic in images or one.msgtype == INFO or one.topic == TRANSFORMS
        ]
        for connection, at, raw in reader.messages(connections=wanted) if wanted else ():
            if connection.topic in seen:
                _note(seen[connection.topic], reader, connection, at, raw)
            elif connection.topic == TRANSFORMS:
                links += links_of(reader.deserialize(raw, connection.msgtype))
            elif connection.topic not in infos:
                infos[connection.topic] = info_of(reader.deserialize(raw, connection.msgtype))
        everything = sorted(f"{one.topic} ({one.msgtype})" for one in reader.connections)
    topics = [
        _topic(name, one)
        for name, one in seen.items()
        if len(one.stamps) >= _FEWEST and one.first is not None
    ]
    if not topics:
        raise InputError(
            f"the bag contains no images; its topics are {', '.join(everything) or 'none'}",
            where=str(path),
            remedy="Record sensor_msgs/Image or sensor_msgs/CompressedImage.",
        )
    frames = {name: one.frame for name, one in seen.items()}
    cameras, notes = cameras_of({one.name: frames[one.name] for one in topics}, infos, links)
    focals = {one.name: focal_of(one.name, infos) for one in topics}
    stated = (replace(one, camera=cameras.get(one.name), focal=focals[one.name]) for one in topics)
    return Bag(tuple(stated), notes)


def _note(seen: _Seen, reader: Any, connection: Any, at: int, raw: bytes) -> None:
    """Keep the stamp of an image; of the first, what it is."""
    if seen.first is None:
        message = reader.deserialize(raw, connection.msgtype)
        depth = is_depth(message)
        if getattr(message, "encoding", "") == "mono16":  # brightness, but some drivers send depth
            depth = "depth" in connection.topic.lower()
        picture = picture_in(message, "depth" if depth else "stored", METRIC_UNIT)
        seen.frame = str(message.header.frame_id).lstrip("/")
        unit = None
        if depth and "32FC1" in (getattr(message, "encoding", ""), *_format_of(message)):
            unit = METRIC_UNIT
        elif depth and getattr(message, "encoding", "16UC1") == "16UC1":
            unit = 0.001 if "depth" in connection.topic.lower() else None
        size = (picture.shape[1], picture.shape[0])
        seen.first = (depth, size, unit, 8 * picture.dtype.itemsize)
    seen.stamps.append((_stamp_of(raw, two=reader.is2) or at, at))


def _format_of(message: Any) -> list[str]:
    return str(getattr(message, "format", "")).replace(";", " ").split()


def _stamp_of(raw: bytes, *, two: bool) -> int:
    """Nanoseconds of a message's header, without reading the rest of it."""
    if two:
        order = "<" if raw[1] & 1 else ">"
        seconds, nanoseconds = struct.unpack_from(f"{order}iI", raw, 4)
    else:
        seconds, nanoseconds = struct.unpack_from("<II", raw, 4)
    return int(seconds) * 10**9 + int(nanoseconds)


def _topic(name: str, seen: _Seen) -> Topic:
    places: dict[int, int] = {}
    for stamp, at in seen.stamps:
        places.setdefault(at, stamp)
    ordered = sorted((stamp, at) for at, stamp in places.items())
    assert seen.first is not None  # noqa: S101 - it has images
    depth, (width, height), unit, bits = seen.first
    return Topic(
        name, _short(name), depth, width, height,
        tuple(stamp / 1e9 for stamp, _ in ordered), tuple(at for _, at in ordered), unit, bits,
    )  # fmt: skip


def _raw_of(topic: str) -> str:
    """The topic of the raw images that those of a topic were compressed from."""
    stem, _, last = topic.rpartition("/")
    return stem if last in ("compressed", "compressedDepth") else ""


def _short(topic: str) -> str:
    parts = [part for part in topic.split("/") if part]
    viewer = _OF_VIEWER.fullmatch(topic)
    if viewer is not None:
        return viewer[1].lower().replace("infrared_", "infra").removesuffix("_0")
    kept = list(parts)
    while len(kept) > 1 and kept[-1] in _LAST_PARTS:
        kept.pop()
    return "_".join(kept).replace("aligned_depth_to_color", "depth")


@contextmanager
def opened(path: Path) -> Iterator[Any]:
    """A bag opened by rosbags.

    Raises InputError where it is damaged, or rosbags is not installed.
    """
    with ExitStack() as kept, bag_errors(path):
        yield kept.enter_context(_reader(path))


def _reader(path: Path) -> Any:
    parts = [
        extra_library(
            f"rosbags.{part}", "ros", missing="ROS bags need rosbags, which is not installed",
            where=str(path), instead="videos or images that were extracted from it",
        )
        for part in ("highlevel", "typesys")
    ]  # fmt: skip
    highlevel, typesys = parts
    if path.suffix.lower() == ".bag" and path.is_file():
        with open_file(path) as file:  # rosbags looks for the end of the first line
            if file.read(len(_BEGINNING)) != _BEGINNING:
                raise ValueError("it does not begin as one")
    usual = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    return highlevel.AnyReader([path], default_typestore=usual)


@contextmanager
def bag_errors(path: Path) -> Iterator[None]:
    """Raise InputError for whatever is wrong with a bag."""
    try:
        yield
    except InputError:
        raise
    except _DAMAGE as error:
        raise _damaged(path, error) from None
    except Exception as error:
        if not type(error).__module__.startswith(("rosbags", "apsw", "sqlite3", "lz4")):
            raise
        raise _damaged(path, error) from None


def _damaged(path: Path, error: Exception) -> InputError:
    return InputError(
        f"the bag cannot be read ({str(error) or type(error).__name__})",
        where=str(path),
        remedy="Copy it again, or repair it with `rosbag reindex` or `ros2 bag reindex`. A bag of "
        "ROS 2 is a folder with a metadata.yaml.",
    )


class BagImages:
    """Images of one topic by number, in the order of their stamps."""

    def __init__(
        self,
        path: Path,
        topic: str,
        places: Sequence[int],
        kind: PictureKind,
        unit: float | None,
    ) -> None:
        self._path, self._topic, self._places = path, topic, places
        self._kind: PictureKind = kind
        self._unit = unit
        self._stack = ExitStack()
        self._reader = self._stack.enter_context(opened(path))
        self._connections = [one for one in self._reader.connections if one.topic == topic]
        self._messages: Iterator[Any] = iter(())
        self._at: int | None = None

    def count(self) -> int:
        """Number of images."""
        return len(self._places)

    def read(self, k: int, keep: Keep) -> NDArray[Any]:  # noqa: ARG002 - nothing is on the way
        """Picture of image k; DamagedFrame where it cannot be decoded."""
        if not 0 <= k < len(self._places):
            raise DamagedFrame(f"the topic has no image {k}")
        place = self._places[k]
        try:
            with bag_errors(self._path):
                return self._read(place)
        except InputError as problem:
            raise DamagedFrame(problem.what) from None

    def _read(self, place: int) -> NDArray[Any]:
        if self._at is None or not self._at < place < self._at + 10**9:
            self._messages = self._reader.messages(connections=self._connections, start=place)
        for connection, at, raw in self._messages:
            self._at = at
            if at == place:
                message = self._reader.deserialize(raw, connection.msgtype)
                return np.ascontiguousarray(
                    picture_in(message, self._kind, self._unit or METRIC_UNIT)
                )
            if at > place:
                break
        self._at = None
        raise DamagedFrame(f"the image of {self._topic} is no longer there")

    def close(self) -> None:
        """Close the bag."""
        self._stack.close()

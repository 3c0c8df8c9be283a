"""Images in ROS bags (ROS 1 ``.bag``; ROS 2 sqlite3 and MCAP), by the optional library rosbags.

The instant of an image is the stamp of its header; where the driver left it empty, the time at
which it was recorded. Depth is 16 bits in millimetres, or 32-bit floats in metres (REP 118).
"""

import re
import struct
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from stereotrack_core.errors import InputError
from stereotrack_core.reading import open_file
from stereotrack_core.recording.images import DamagedFrame, Keep, PictureKind, decoded
from stereotrack_core.recording.importing.image_groups import entries_of
from stereotrack_core.recording.importing.source import METRIC_UNIT, Source
from stereotrack_core.recording.importing.video_sources import rate_of
from stereotrack_core.recording.writing import counts_of
from stereotrack_core.versions import extra_library

_SUFFIXES = frozenset({".bag", ".mcap", ".db3"})
_IMAGES = ("sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage")
_INFO = "sensor_msgs/msg/CameraInfo"
_LAST_PARTS = re.compile(r"image(_raw|_rect|_color|_mono)*|compressed(Depth)?|raw|data")
_VIEWER = re.compile(r"/device_\d+/sensor_\d+/(\w+)/image/data")  # RealSense's: Color_0, Infrared_1
_DAMAGE = (
    *(ArithmeticError, AssertionError, AttributeError, LookupError, MemoryError, OSError),
    *(RuntimeError, TypeError, ValueError, struct.error, DamagedFrame),
)
_FEWEST = 2  # images of a topic that are a stream
_COUNTS = ("16UC1", "mono16")
_ENCODINGS: dict[str, tuple[int, int | None]] = {
    "mono8": (1, None), "8UC1": (1, None), "bgr8": (3, None), "8UC3": (3, None),
    "rgb8": (3, cv2.COLOR_RGB2BGR), "rgba8": (4, cv2.COLOR_RGBA2BGR),
    "bgra8": (4, cv2.COLOR_BGRA2BGR), "8UC4": (4, cv2.COLOR_BGRA2BGR),
    "bayer_rggb8": (1, cv2.COLOR_BayerRGGB2BGR), "bayer_bggr8": (1, cv2.COLOR_BayerBGGR2BGR),
    "bayer_gbrg8": (1, cv2.COLOR_BayerGBRG2BGR), "bayer_grbg8": (1, cv2.COLOR_BayerGRBG2BGR),
    "yuv422": (2, cv2.COLOR_YUV2BGR_UYVY), "uyvy": (2, cv2.COLOR_YUV2BGR_UYVY),
    "yuv422_yuy2": (2, cv2.COLOR_YUV2BGR_YUY2), "yuyv": (2, cv2.COLOR_YUV2BGR_YUY2),
}  # fmt: skip
"""Bytes of a pixel, and OpenCV's conversion to BGR."""
_HEADER = struct.Struct("<iff")  # of compressedDepth: format, and the quantisation of floats


def bags_in(paths: Sequence[Path]) -> tuple[Path, ...]:
    """The bags among paths, and in folders among them: files, or the folders of ROS 2."""
    inside = (entries_of(one) if one.is_dir() and not _is_bag(one) else [one] for one in paths)
    return tuple(one for several in inside for one in several if _is_bag(one))


def is_bag_file(path: Path) -> bool:
    """Whether a name is that of a file of a bag."""
    return path.suffix.lower() in _SUFFIXES


def _is_bag(path: Path) -> bool:
    if path.is_dir():
        return (path / "metadata.yaml").is_file() and any(map(is_bag_file, path.iterdir()))
    return path.is_file() and is_bag_file(path)


def read_topics(path: Path) -> list[Source]:
    """The streams of images in a bag, which is read once; raw images go before compressed ones.

    Raises InputError where it cannot be read, holds no images, or rosbags is not installed.
    """
    stamps: dict[str, dict[int, int]] = {}
    first: dict[str, dict[str, Any]] = {}
    focals: dict[str, float] = {}
    with _opened(path) as reader:
        topics = [one.topic for one in reader.connections if one.msgtype in _IMAGES]
        wanted = [
            one
            for one in reader.connections
            if one.msgtype == _INFO
            or (one.topic in topics and one.topic.rpartition("/")[0] not in topics)
        ]
        for connection, at, raw in reader.messages(connections=wanted) if wanted else ():
            topic = connection.topic
            if connection.msgtype != _INFO:
                stamps.setdefault(topic, {}).setdefault(at, _stamp_of(raw, two=reader.is2) or at)
            if topic not in first and topic not in focals:
                message = reader.deserialize(raw, connection.msgtype)
                if connection.msgtype == _INFO:
                    matrix = message.K if hasattr(message, "K") else message.k
                    focals[topic] = float(matrix[0])
                else:
                    first[topic] = _facts_of(message, topic)
        everything = sorted(f"{one.topic} ({one.msgtype})" for one in reader.connections)
    found = []
    for topic, own in stamps.items():
        if len(own) >= _FEWEST:
            ordered = sorted((stamp, at) for at, stamp in own.items())
            times = tuple(stamp / 1e9 for stamp, _ in ordered)
            rate, uneven, pause = rate_of(np.array(times))
            found.append(Source(
                name=_short(topic), path=path, topic=topic, frames=len(times), fps=rate,
                start=times[0], times=times, uneven=uneven, pause=pause, **first[topic],
                places=tuple(at for _, at in ordered), focal=_focal_of(topic, focals),
            ))  # fmt: skip
    if not found:
        what = f"the bag contains no images; its topics are {', '.join(everything) or 'none'}"
        remedy = "Record sensor_msgs/Image or sensor_msgs/CompressedImage."
        raise InputError(what, where=str(path), remedy=remedy)
    return found


def _facts_of(message: Any, topic: str) -> dict[str, Any]:
    """Properties of all images of a topic, by the first one."""
    words = getattr(message, "encoding", None) or str(message.format).replace(";", " ")
    named = "depth" in topic.lower()
    depth = is_depth(message) and (words != "mono16" or named)  # some drivers send depth so
    picture = picture_in(message, "depth" if depth else "stored", METRIC_UNIT)
    unit = METRIC_UNIT if "32FC1" in words else 0.001 if named else None
    return {
        "kind": "depth" if depth else "images", "width": picture.shape[1],
        "height": picture.shape[0], "bits": 8 * picture.dtype.itemsize,
        "unit": unit if depth and words != "mono16" else None,
    }  # fmt: skip


def _stamp_of(raw: bytes, *, two: bool) -> int:
    """Nanoseconds of a message's header, without reading the rest of it."""
    kind = "<II" if not two else "<iI" if raw[1] & 1 else ">iI"
    seconds, nanoseconds = struct.unpack_from(kind, raw, 4)
    return int(seconds) * 10**9 + int(nanoseconds)


def _focal_of(topic: str, focals: dict[str, float]) -> float | None:
    """Focal length in pixels by the camera_info beside a topic; None where none is stated."""
    parts = topic.split("/")
    places = (parts[:-1], parts[:-2], [*parts[:-2], "info"])
    return next(filter(None, (focals.get("/".join([*one, "camera_info"])) for one in places)), None)


def _short(topic: str) -> str:
    """Name of the source: the topic without the parts that all have."""
    if viewer := _VIEWER.fullmatch(topic):
        return viewer[1].lower().replace("infrared_", "infra").removesuffix("_0")
    parts = [part for part in topic.split("/") if part]
    while len(parts) > 1 and _LAST_PARTS.fullmatch(parts[-1]):
        parts.pop()
    return "_".join(parts).replace("aligned_depth_to_color", "depth")


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    """A bag opened by rosbags; InputError where it is damaged, or rosbags is not installed."""
    missing, instead = "ROS bags need rosbags, which is not installed", "videos or images from it"
    highlevel, typesys = (
        extra_library(f"rosbags.{part}", "ros", missing=missing, where=str(path), instead=instead)
        for part in ("highlevel", "typesys")
    )
    with ExitStack() as kept:
        with _said(path):
            if path.suffix.lower() == ".bag" and path.is_file():
                with open_file(path) as file:  # rosbags looks for the end of the first line
                    if file.read(9) != b"#ROSBAG V":
                        raise ValueError("it does not begin as one")
            usual = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
            reader = kept.enter_context(highlevel.AnyReader([path], default_typestore=usual))
        with _said(path):
            yield reader


@contextmanager
def _said(path: Path) -> Iterator[None]:
    """Raise InputError for whatever is wrong with a bag."""
    try:
        yield
    except InputError:
        raise
    except Exception as error:
        libraries = ("rosbags", "apsw", "sqlite3", "lz4")
        if not isinstance(error, _DAMAGE) and not type(error).__module__.startswith(libraries):
            raise
        what = f"the bag cannot be read ({str(error) or type(error).__name__})"
        repair = "Copy it again, or repair it with `rosbag reindex` or `ros2 bag reindex`."
        remedy = f"{repair} A bag of ROS 2 is a folder with a metadata.yaml."
        raise InputError(what, where=str(path), remedy=remedy) from None


class BagImages:
    """Images of one topic by number, in the order of their stamps."""

    def __init__(self, source: Source, kind: PictureKind) -> None:
        self._source, self._kind = source, kind
        self._stack = ExitStack()
        self._reader = self._stack.enter_context(_opened(source.path))
        self._own = [one for one in self._reader.connections if one.topic == source.topic]
        self._messages: Iterator[Any] = iter(())
        self._at: int | None = None

    def count(self) -> int:
        """Number of images."""
        return len(self._source.places)

    def read(self, k: int, keep: Keep) -> NDArray[Any]:  # noqa: ARG002 - nothing is on the way
        """Picture of image k; DamagedFrame where it cannot be decoded."""
        if not 0 <= k < self.count():
            raise DamagedFrame(f"the topic has no image {k}")
        try:
            with _said(self._source.path):
                return self._read(self._source.places[k])
        except InputError as problem:
            raise DamagedFrame(problem.what) from None

    def _read(self, place: int) -> NDArray[Any]:
        if self._at is None or not self._at < place < self._at + 10**9:
            self._messages = self._reader.messages(connections=self._own, start=place)
        for connection, at, raw in self._messages:
            self._at = at
            if at == place:
                message = self._reader.deserialize(raw, connection.msgtype)
                picture = picture_in(message, self._kind, self._source.unit or METRIC_UNIT)
                return np.ascontiguousarray(picture)
        self._at = None
        raise DamagedFrame(f"the image of {self._source.topic} is no longer there")

    def close(self) -> None:
        """Close the bag."""
        self._stack.close()


def is_depth(message: Any) -> bool:
    """Whether an image holds 16-bit counts or metres."""
    words = str(getattr(message, "encoding", None) or message.format)
    return any(word in words for word in ("compressedDepth", "32FC1", *_COUNTS))


def picture_in(message: Any, kind: PictureKind, unit: float) -> NDArray[Any]:
    """Pixels of a message: grey (H, W), BGR (H, W, 3) uint8, counts (H, W) uint16, or as stored.
    Metres become counts of `unit`. Raises DamagedFrame where they cannot be decoded.
    """
    try:
        raw = _raw(message) if hasattr(message, "encoding") else _compressed(message)
    except (cv2.error, ValueError, struct.error) as error:
        raise DamagedFrame(f"the image cannot be decoded ({error})") from None
    if raw.dtype == np.float32:
        raw = counts_of(raw, unit)
    if kind == "depth" and (raw.dtype != np.uint16 or raw.ndim != 2):
        raise DamagedFrame("the image holds no depth; 16 bits or floats are needed")
    if kind in ("depth", "stored"):
        return raw
    if raw.dtype == np.uint16:  # whose white is not known here
        raw = (raw >> 8).astype(np.uint8)
    if kind == "grey" and raw.ndim == 3:
        return np.asarray(cv2.cvtColor(raw, cv2.COLOR_BGR2GRAY))
    return raw


def _raw(message: Any) -> NDArray[Any]:
    encoding, height, width = str(message.encoding), int(message.height), int(message.width)
    order, base = ">" if message.is_bigendian else "<", re.sub("16$", "8", encoding)
    if encoding in (*_COUNTS, "32FC1"):
        size, code, kind = 1, None, np.dtype(f"{order}f4" if encoding == "32FC1" else f"{order}u2")
    elif base in _ENCODINGS:
        size, code = _ENCODINGS[base]
        kind = np.dtype("u1" if base == encoding else f"{order}u2")
    else:
        known = "mono8, mono16, rgb8, bgr8, bayer, yuv422, 16UC1 or 32FC1"
        raise DamagedFrame(f"images of encoding {encoding!r} cannot be read; use {known}")
    data, step = np.asarray(message.data, dtype=np.uint8), int(message.step)
    wanted = width * size * kind.itemsize  # bytes of a row, without what fills it up
    if height < 1 or step < wanted or data.size < height * step:
        raise DamagedFrame("the image has fewer bytes than its size needs")
    rows = np.ascontiguousarray(data[: height * step].reshape(height, step)[:, :wanted]).view(kind)
    pixels = rows.astype(kind.newbyteorder("="))
    pixels = pixels if size == 1 else pixels.reshape(height, width, size)
    return pixels if code is None else np.asarray(cv2.cvtColor(pixels, code))


def _compressed(message: Any) -> NDArray[Any]:
    data, words = np.asarray(message.data, dtype=np.uint8).tobytes(), str(message.format)
    packed = "compressedDepth" in words
    if packed and len(data) <= _HEADER.size:
        raise DamagedFrame("the compressed depth map is cut off")
    flags = cv2.IMREAD_ANYCOLOR | cv2.IMREAD_ANYDEPTH
    flags = cv2.IMREAD_UNCHANGED if is_depth(message) else flags
    picture = decoded(data[_HEADER.size * packed :], flags | cv2.IMREAD_IGNORE_ORIENTATION)
    if picture is None:
        raise DamagedFrame("the compressed image is damaged")
    if not packed or "32FC1" not in words:
        return picture
    _, a, b = _HEADER.unpack_from(data)  # inverse depth: metres = a / (count - b)
    inverse = picture.astype(np.float32) - np.float32(b)
    return np.where(picture > 0, np.float32(a) / np.where(picture > 0, inverse, 1), 0).astype("f4")

"""The files behind a stream: where they are, how large their pictures are, and opening them."""

from contextlib import closing
from pathlib import Path, PureWindowsPath
from typing import TypeAlias

import av
import numpy as np

from stereotrack_core.arrays import ImageArray
from stereotrack_core.errors import InputError
from stereotrack_core.reading import check_file, readable, reason
from stereotrack_core.recording import images
from stereotrack_core.recording.description import Stream, View
from stereotrack_core.recording.video import VideoStream, open_container, video_stream

IMAGE_SUFFIXES = frozenset(
    {".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".pgm", ".ppm", ".webp"}
)
"""Endings of the files that hold one picture."""

VIDEO_SUFFIXES = frozenset(
    {".mp4", ".mov", ".avi", ".mkv", ".m4v", ".webm", ".mts", ".m2ts", ".ts", ".mpg", ".mpeg"}
    | {".wmv", ".3gp", ".flv", ".asf", ".mxf", ".ogv", ".y4m", ".ivf"}
    | {".h264", ".264", ".avc", ".h265", ".265", ".hevc", ".mjpeg", ".mjpg", ".m2v", ".obu"}
)
"""Endings of videos, the last ones of streams without a container."""


def is_image(path: Path) -> bool:
    """Whether a name is that of an image."""
    return path.suffix.lower() in IMAGE_SUFFIXES


def is_video(path: Path) -> bool:
    """Whether a name is that of a video."""
    return path.suffix.lower() in VIDEO_SUFFIXES


_WIDEST_GAP = 10_000  # image numbers that may be missing altogether, besides every second one


StreamSource: TypeAlias = images.NumberedImages | VideoStream
"""Pictures by their number in the stream's own counting; used by one thread at a time."""


def inside(folder: Path, relative: str, where: str) -> Path:
    """Path of a file or pattern in the recording; InputError where it leaves it or is not there."""
    path = Path(relative)
    leaves = path.is_absolute() or PureWindowsPath(relative).drive != "" or "\0" in relative
    try:
        root = folder.resolve()
        full = root if leaves else (root / path).resolve()
        shown = full.parent if images.is_pattern(relative) else full
        there = shown.exists()
    except (OSError, RuntimeError) as error:  # no permission; links that lead in a circle
        what = f"the path {relative!r} cannot be followed ({reason(error) or 'links in a circle'})"
        remedy = "Make it readable, or replace the link with the file."
        raise InputError(what, where, remedy) from None
    if leaves or not full.is_relative_to(root):
        remedy = "Use a path relative to the folder, and keep the files in it."
        raise InputError(f"the path {relative!r} leaves the recording folder", where, remedy)
    if not there:
        what = f"{'folder' if images.is_pattern(relative) else 'file'} {shown.name!r} not found"
        raise InputError(what, where, "Add it or correct the path.")
    if not images.is_pattern(relative):
        check_file(full, where)
    return folder / path


def picture_size(folder: Path, frames: str, where: str) -> tuple[int, int]:
    """Width and height of a stream's first picture; InputError where there is none."""
    path = inside(folder, frames, where)
    if images.is_pattern(frames):
        files = _files(folder, frames, where)
        return image_size(files[min(files)], where)
    if is_image(path):
        return image_size(path, where)
    try:
        with open_container(path) as container:
            context = video_stream(container).codec_context
            width, height = int(context.width), int(context.height)
        if width < 1 or height < 1:
            raise IndexError
    except (av.FFmpegError, OSError, IndexError) as error:
        raise no_video(error, where, repr(frames)) from None
    return width, height


def image_size(path: Path, where: str) -> tuple[int, int]:
    """Width and height of an image file; InputError where it is none."""
    try:
        height, width = images.read_image(path, "colour").shape[:2]
    except images.DamagedFrame as problem:
        raise InputError(str(problem), where, "Replace the file with a readable image.") from None
    return width, height


def open_stream(folder: Path, frames: str, kind: images.PictureKind, where: str) -> StreamSource:
    """Open a video or numbered images; InputError where that cannot be done."""
    path = inside(folder, frames, where)
    if images.is_pattern(frames):
        return images.NumberedImages(_files(folder, frames, where), frames, kind)
    try:
        return VideoStream(path, kind)
    except (av.FFmpegError, OSError, IndexError) as error:
        raise no_video(error, where, repr(frames)) from None


def _files(folder: Path, frames: str, where: str) -> dict[int, Path]:
    try:
        files = images.numbered_files(folder, frames)
    except ValueError:
        what = f"the file name of the pattern {frames!r} must contain exactly one number"
        raise InputError(what, where, "Write it like N/%06d.png.") from None
    except OSError as error:
        what = f"the folder cannot be read ({reason(error)})"
        raise InputError(what, where, "Correct the path.") from None
    if not files:
        what = f"no file matches the pattern {frames!r}"
        raise InputError(what, where, "Add the images or correct the pattern.")
    if max(files) - min(files) > _WIDEST_GAP + 2 * len(files):
        numbers = f"{min(files)} to {max(files)}, but there are only {len(files)}"
        remedy = "Number them without large gaps, or remove files that do not belong to them."
        raise InputError(f"the images of {frames!r} are numbered from {numbers}", where, remedy)
    return files


def no_video(error: Exception, where: str, name: str = "it") -> InputError:
    """The error for a file that is no video."""
    empty = isinstance(error, IndexError | StopIteration)
    cause = "it contains no image" if empty else reason(error)
    remedy = "Copy it again from the source, or convert it to a common format such as MP4."
    what = f"{name} cannot be opened as a video ({cause})"
    return InputError(what, where, readable(error, remedy))


_FRAMES_OF_A_VIDEO = 15  # frames, spread over a video, whose median is the background


def background_picture(
    folder: Path, view: View, kind: images.PictureKind
) -> tuple[ImageArray | None, ImageArray] | None:
    """The empty scene as (left or None, image); None if not stated, InputError if unreadable."""
    if view.image.background is None or (view.left and view.left.background is None):
        return None
    key = "right" if view.kind == "stereo" else "image"
    image = _picture(folder, view, view.image, key, kind)
    left = None if view.left is None else _picture(folder, view, view.left, "left", kind)
    return left, image


def _picture(
    folder: Path, view: View, stream: Stream, key: str, kind: images.PictureKind
) -> ImageArray:
    where = f"{folder / 'recording.toml'}, view {view.name}, {key}.background"
    file = stream.background or ""
    path = inside(folder, file, where)
    try:
        if not images.is_pattern(file) and is_image(path):
            return images.read_image(path, kind)
        with closing(open_stream(folder, file, kind, where)) as source:
            numbers = images.spread(source.count(), _FRAMES_OF_A_VIDEO)
            pictures = [source.read(n, lambda _n, _picture: None) for n in numbers]
    except images.DamagedFrame as problem:
        raise InputError(str(problem), where, "Replace the file or remove the key.") from None
    if not pictures:
        raise InputError("it contains no image", where, "Remove the key.")
    return np.asarray(np.median(pictures, axis=0).round().astype(np.uint8))

"""Open a recording folder: everything it says about itself, checked, and how it is known again."""

import dataclasses
import hashlib
import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np

from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera, is_padded
from stereotrack_core.reading import SETTINGS_BYTES, open_file, read_bytes
from stereotrack_core.recording import description
from stereotrack_core.recording.calibration import parse_calibration
from stereotrack_core.recording.description import Cameras
from stereotrack_core.recording.images import is_pattern, numbered_files
from stereotrack_core.recording.landmarks import LandmarkTrajectory, read_landmarks
from stereotrack_core.recording.stream_files import inside, picture_size
from stereotrack_core.recording.toml_table import Table, load_toml

_STREAM_KEYS: dict[str, tuple[str, ...]] = {
    "stereo": ("right", "left"),
    "depth": ("image", "depth"),
    "mono": ("image",),
}
"""Streams that a view of each kind must have, the reference image first."""

_EXAMPLE = 'camera = "...", frames = "..."'

_LARGEST_UNIT_M = 1.0


def parse_view(table: Table) -> description.View | None:
    """The view, or None where something essential is missing (with complaints)."""
    name = table.text("name", required=True)
    kind = table.text("kind", required=True)
    if kind is not None and kind not in _STREAM_KEYS:
        table.complain("kind", f"unknown kind {kind!r}", 'Use "stereo", "depth" or "mono".')
        return None
    if name is None or kind is None:
        return None
    streams = [_stream(table, key) for key in _STREAM_KEYS[kind]]
    mask = _stream(table, "mask", required=False) if kind == "depth" else None
    image = streams[0]
    second = streams[1] if len(streams) > 1 else None
    if image is None or (len(streams) > 1 and second is None):
        return None
    own: dict[str, Any] = {"left": second} if kind == "stereo" else {}
    if kind == "depth":
        own = {"depth": second, "depth_unit": _depth_unit(table), "mask": mask}
    turn = table.whole_number("display_rotation", 0)
    if turn not in (0, 90, 180, 270):
        what, remedy = f"{turn} degrees is not possible", "Use 0, 90, 180 or 270 (clockwise)."
        table.complain("display_rotation", what, remedy)
        turn = 0
    named = cast(description.ViewKind, kind)
    return description.View(name, named, image, display_rotation=turn, **own)


def _stream(view: Table, key: str, *, required: bool = True) -> description.Stream | None:
    table = view.table(key, required=required, example=_EXAMPLE)
    if table is None:
        return None
    camera = table.text("camera", required=key != "mask")
    frames = table.text("frames", required=True)
    first_frame = table.whole_number("first_frame", 0)
    if first_frame < 0:
        what = f"{first_frame} is before the start of the stream"
        table.complain("first_frame", what, "Use 0 or more.")
    time_offset = table.number("time_offset", 0.0)
    if frames is None or (camera is None and key != "mask"):
        return None
    background = table.text("background")
    first_frame = max(first_frame, 0)
    return description.Stream(camera or "", frames, background, first_frame, time_offset or 0.0)


def _depth_unit(view: Table) -> float:
    table = view.table("depth")
    unit = None if table is None else table.number("unit", 0.001)
    if unit is None or 0 < unit <= _LARGEST_UNIT_M:
        return unit or 0.001
    view.complain("depth.unit", f"{unit:g} metres per count is not possible", "Write e.g. 0.001.")
    return 0.001


FORMAT = 1
MOST_VIEWS = 100
DESCRIPTION = "recording.toml"

T = TypeVar("T")


def open_recording(folder: Path) -> description.Recording:
    """Read the description of a recording folder; no picture is decoded.

    Raises InputError at the first thing that is wrong; :func:`findings.examine` tells all of them.

    Examples
    --------
    >>> recording = open_recording(Path("recording"))
    >>> [view.name for view in recording.views]
    ['N', 'O', 'S', 'W']
    """
    complaints: list[InputError] = []
    recording = describe(folder, complaints)
    if complaints:
        raise complaints[0]
    assert recording is not None  # noqa: S101 - without a complaint it was read
    return recording


def describe(
    folder: Path, complaints: list[InputError], content: Mapping[str, Any] | None = None
) -> description.Recording | None:
    """The usable part of a recording; complaints are appended, `content` replaces the TOML's."""
    folder = Path(folder)
    if not folder.is_dir():
        what, remedy = "there is no such folder", "Correct the path."
        if folder.is_file():
            what, remedy = "this is a file", "Give the folder that contains recording.toml."
        complaints.append(InputError(what, folder, remedy))
        return None
    path = folder / DESCRIPTION
    try:
        values = load_toml(path) if content is None else content
    except InputError as error:
        complaints.append(error)
        return None
    table = Table(values, str(path), complaints)
    _check_format(table)
    name = table.text("name") or folder.resolve().name
    fps = table.number("fps")
    if "fps" not in table.values:
        table.complain("fps", "the key is missing", "Add fps = frame sets per second.")
    elif fps is not None and fps <= 0:
        table.complain("fps", f"{fps:g} frame sets per second is invalid", "Write fps > 0.")
    rate = fps if fps is not None and fps > 0 else 1.0

    def reference(path: Path) -> LandmarkTrajectory:
        """The reference at the recording's frames, also if its times have another rate."""
        return dataclasses.replace(read_landmarks(path).at_rate(rate, path.name), fps=None)

    cameras, unusable, guessed = _cameras(folder, table)
    views = _views(table)
    for view in views:
        _check_streams(folder, table, view, cameras, unusable)
    return description.Recording(
        folder=folder,
        name=name,
        fps=rate,
        views=views,
        cameras=cameras,
        subject=_optional(folder, table, "subject", description.read_subject),
        reference=_optional(folder, table, "reference", reference),
        segments=_optional(folder, table, "segments", description.read_segments) or (),
        guessed=guessed,
    )


def named_file(folder: Path, key: str) -> Path:
    """The file of cameras, subject, reference or segments that a recording's description names."""
    name = load_toml(folder / DESCRIPTION).get(key)
    if not isinstance(name, str):
        raise InputError(f"it names no {key}", folder / DESCRIPTION, "Add the file's name.")
    return inside(folder, name, f"{folder / DESCRIPTION}, {key}")


def _check_format(table: Table) -> None:
    version = table.values.get("format")
    if version is None:
        table.complain("format", "the key is missing", f"Add format = {FORMAT}.")
    elif version != FORMAT or isinstance(version, bool):
        remedy = f"This version reads format = {FORMAT}. Use a newer version for later formats."
        table.complain("format", f"unknown format {version!r}", remedy)


def _cameras(folder: Path, table: Table) -> tuple[Cameras, frozenset[str] | None, bool]:
    """The usable cameras, names of the others (None: unknown), whether they are guessed."""
    path = _optional(folder, table, "calibration", lambda path: path)
    if path is None:
        return {}, None, False
    cameras, stated, guessed = parse_calibration(path, table.complaints)
    return cameras, None if stated is None else stated - set(cameras), guessed


def _optional(folder: Path, table: Table, key: str, read: Callable[[Path], T]) -> T | None:
    relative = table.text(key, required=key == "calibration")
    if relative is None:
        return None
    try:
        return read(inside(folder, relative, f"{table.where}, {key}"))
    except InputError as error:
        table.complaints.append(error)
        return None


def _views(table: Table) -> tuple[description.View, ...]:
    entries: Any = table.values.get("views")
    if not isinstance(entries, list) or not entries:
        table.complain("views", "there are no views", "Add at least one section [[views]].")
        return ()
    if len(entries) > MOST_VIEWS:
        table.complain("views", f"there are {len(entries)} views", f"Use at most {MOST_VIEWS}.")
        return ()
    views: list[description.View] = []
    for i, entry in enumerate(entries):
        if not isinstance(entry, Mapping):
            table.complain(f"views[{i}]", "this is not a section", "Write it as [[views]].")
            continue
        place = f"view {entry['name']}" if entry.get("name") else f"views[{i}]"
        view = parse_view(Table(entry, f"{table.where}, {place}", table.complaints))
        if view is not None and view.name in (other.name for other in views):
            what = f"there are two views named {view.name!r}"
            table.complain("views", what, "Rename one of them.")
        elif view is not None:
            views.append(view)
    return tuple(views)


def _check_streams(
    folder: Path,
    table: Table,
    view: description.View,
    cameras: Cameras,
    unusable: frozenset[str] | None,
) -> None:
    """Files are there, cameras are known, and the sizes agree."""
    for key, stream in view.streams().items():
        where = f"{table.where}, view {view.name}, {key}"
        told = unusable is None or stream.camera in unusable
        if stream.camera and stream.camera not in cameras and not told:
            known = ", ".join(cameras) or "none"
            what = f"the camera {stream.camera!r} is not in the calibration"
            remedy = f"Its cameras are: {known}."
            table.complaints.append(InputError(what, f"{where}.camera", remedy))
        camera = cameras.get(stream.camera or view.image.camera)
        for file_key, file in (("frames", stream.frames), ("background", stream.background)):
            if file is None:
                continue
            try:
                size = picture_size(folder, file, f"{where}.{file_key}")
            except InputError as error:
                table.complaints.append(error)
                continue
            if camera is not None and size != (camera.width, camera.height):
                table.complaints.append(_wrong_size(f"{where}.{file_key}", file, size, camera))


def _wrong_size(where: str, file: str, size: tuple[int, int], camera: Camera) -> InputError:
    images = f"the images of {file!r} have {size[0]} x {size[1]} pixels"
    own = f"the calibration of {camera.name!r} is for {camera.width} x {camera.height}"
    remedy = "Use a calibration made with images of this size, or the original images."
    if is_padded((camera.width, camera.height), size):
        wanted = f"write size = [{size[0]}, {size[1]}] into it"
        remedy = f"The calibration is of padded images: {wanted}."
    return InputError(f"{images}, but {own}", where, remedy)


_FIRST_BYTES = 65536


def fingerprint(recording: description.Recording) -> str:
    """Hash (32 hexadecimal digits) of the description, and of sizes and beginnings of the streams.

    It does not depend on where the folder is, nor on reference, subject or segments, which may
    be mended without making it another recording. Files that have vanished count as empty.
    """
    digest = hashlib.blake2b(digest_size=16)
    folder = recording.folder
    calibration = load_toml(folder / DESCRIPTION).get("calibration", "")
    for path in (folder / DESCRIPTION, folder / str(calibration)):
        with suppress(InputError):
            digest.update(read_bytes(path, SETTINGS_BYTES))
    for view in recording.views:
        for key, stream in view.streams().items():
            digest.update(f"{view.name}/{key}".encode())
            for file in identifying_files(folder, stream.frames):
                try:
                    with open_file(file) as opened:
                        size = os.fstat(opened.fileno()).st_size
                        digest.update(f"{file.name} {size} ".encode() + opened.read(_FIRST_BYTES))
                except (InputError, OSError):
                    digest.update(b"missing")
    return digest.hexdigest()


def calibration_fingerprint(recording: description.Recording) -> str:
    """Hash (32 hexadecimal digits) of all cameras, and of which stream shows which, and when.

    It is made of the numbers themselves, with whatever corrects the recording's files, and tells
    a rig that was calibrated anew from the one that a run was tracked with.
    """
    digest = hashlib.blake2b(digest_size=16)
    for name, camera in sorted(recording.cameras.items()):
        placed = camera.camera_from_world
        digest.update(f"{name} {camera.width} {camera.height} {camera.fisheye} ".encode())
        for numbers in (camera.matrix, camera.distortions, placed.rotation, placed.translation):
            digest.update(np.ascontiguousarray(numbers, dtype="<f8").tobytes())
    for view in recording.views:
        for key, stream in view.streams().items():
            shift = f"{stream.first_frame} {stream.time_offset!r}"
            digest.update(f"{view.name}/{key} {stream.camera} {shift} ".encode())
    return digest.hexdigest()


def identifying_files(folder: Path, frames: str) -> Iterator[Path]:
    """The video, or the first and the last image (whose names tell how many there are)."""
    if not is_pattern(frames):
        yield folder / frames
        return
    try:
        files = numbered_files(folder, frames)
    except (ValueError, OSError):
        return
    numbers = sorted(files)
    for number in dict.fromkeys([*numbers[:1], *numbers[-1:]]):
        yield files[number]

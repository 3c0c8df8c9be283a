"""Tell whether a recording is the one that a run or a project was made from."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import numpy as np

from stereotrack_core.errors import InputError
from stereotrack_core.reading import SETTINGS_BYTES, open_file, read_bytes
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.folder import DESCRIPTION
from stereotrack_core.recording.images import is_pattern, numbered_files
from stereotrack_core.recording.toml_table import load_toml

_FIRST_BYTES = 65536


def fingerprint(recording: Recording) -> str:
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
            for file in _files(folder, stream.frames):
                digest.update(_beginning(file))
    return digest.hexdigest()


def calibration_fingerprint(recording: Recording) -> str:
    """Hash (32 hexadecimal digits) of all cameras, and of which stream shows which, and when.

    It is made of the numbers themselves, with whatever corrects the recording's files, and tells
    a rig that was calibrated anew from the one that a run was tracked with.
    """
    digest = hashlib.blake2b(digest_size=16)
    for name, camera in sorted(recording.cameras.items()):
        transform = camera.camera_from_world
        digest.update(f"{name} {camera.width} {camera.height} {camera.fisheye} ".encode())
        for numbers in (
            *(camera.matrix, camera.distortions, transform.rotation, transform.translation),
        ):
            digest.update(np.ascontiguousarray(numbers, dtype="<f8").tobytes())
    for view in recording.views:
        for key, stream in view.streams().items():
            shift = f"{stream.first_frame} {stream.time_offset!r}"
            digest.update(f"{view.name}/{key} {stream.camera} {shift} ".encode())
    return digest.hexdigest()


def _files(folder: Path, frames: str) -> Iterator[Path]:
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


def _beginning(path: Path) -> bytes:
    try:
        with open_file(path) as file:
            size = os.fstat(file.fileno()).st_size
            return f"{path.name} {size} ".encode() + file.read(_FIRST_BYTES)
    except (InputError, OSError):
        return b"missing"

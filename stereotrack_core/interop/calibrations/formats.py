"""Every format of a calibration that is read or written, found out by what is in the file."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import cast

from stereotrack_core.atomic import write_file
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.interop.calibrations import devices, opencv_storage
from stereotrack_core.interop.calibrations.documents import Document, read_document
from stereotrack_core.interop.calibrations.foreign import ForeignCalibration, check_cameras
from stereotrack_core.interop.calibrations.matlab import read_matlab
from stereotrack_core.interop.calibrations.toml_layouts import Layout, read_toml, toml_text

WRITTEN = ("aniposelib", "pose2sim", "opencv")  # formats that are written


def read_foreign(paths: Sequence[Path]) -> ForeignCalibration:
    """Read files that belong together, in their own convention; InputError where they do not."""
    documents = [read_document(path) for path in paths]
    others = [_read(one) for one in documents]
    storages = [one for one, read in zip(documents, others, strict=True) if read is None]
    found = [one for one in others if one is not None]
    if storages:
        found.append(opencv_storage.read_storage(storages))
    whole = found[0] if len(found) == 1 else _together(found)
    check_cameras(whole.cameras, whole.where)
    return whole


_READERS: Sequence[Callable[[Document], ForeignCalibration | None]] = (
    *(read_toml, devices.read_qualisys, devices.read_zed),
    *(read_matlab, devices.read_camera_info),  # of tables alone
)


def _read(document: Document) -> ForeignCalibration | None:
    """The calibration of one file; None for one of OpenCV, of which several may belong together."""
    table = document.kind not in ("toml", "xml", "ini")
    for read in _READERS if table else _READERS[:3]:
        if (found := read(document)) is not None:
            return found
    if table or (document.kind == "xml" and document.content.tag == "opencv_storage"):
        return None
    what = "this is XML, but neither OpenCV's nor Qualisys'"
    if document.kind == "ini":
        what = "these are settings, but not the calibration of a ZED camera"
    raise InputError(what, where=document.where, remedy="Check that it is a calibration file.")


def _together(found: Sequence[ForeignCalibration]) -> ForeignCalibration:
    """Files with a camera each, of one format."""
    first = found[0]
    where = ", ".join(one.where for one in found)
    if any(one.format != first.format or one.unit != first.unit for one in found):
        what = f"the files are of different formats ({', '.join(one.format for one in found)})"
        raise InputError(what, where=where, remedy="Import them one at a time.")
    cameras = tuple(camera for one in found for camera in one.cameras)
    notes = tuple(note for one in found for note in one.notes)
    return replace(first, where=where, cameras=cameras, notes=notes)


def write_foreign(path: Path, cameras: Sequence[Camera], form: str, unit: str = "m") -> None:
    """Write cameras in a format of :data:`WRITTEN`; InputError where it has no place for a name."""
    if form == "opencv":
        suffix = ".xml" if path.suffix.lower() == ".xml" else ".yml"  # those that OpenCV knows
        write_file(path, opencv_storage.storage_text(cameras, unit, suffix))
    else:
        write_file(path, toml_text(cameras, cast("Layout", form), unit))

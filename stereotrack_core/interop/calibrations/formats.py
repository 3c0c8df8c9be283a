"""Every format of a calibration that is read or written, found out by what is in the file.

Here those in TOML: aniposelib and FreeMoCap, Pose2Sim, caliscope. All of them map the world to the
camera, with OpenCV's axes and distortion. They differ in where the sections are, what names a
camera, whether rotations are vectors, and in the unit of length: that of the board in aniposelib,
millimetres in FreeMoCap, metres in Pose2Sim and caliscope; none states it.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import tomli_w

from stereotrack_core.atomic import write_file
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.interop.calibrations import devices, foreign, opencv_storage
from stereotrack_core.interop.calibrations.documents import Document, read_document
from stereotrack_core.interop.calibrations.foreign import ForeignCalibration, check_cameras
from stereotrack_core.recording.calibration import section_of

_OF_FREEMOCAP = ("charuco_square_size", "path_to_recorded_videos", "charuco_board_object")
_UNITS = {"Pose2Sim": "m", "caliscope": "m", "FreeMoCap": "mm"}
_OF_CALISCOPE = ("port", "cam_id", "rotation_count", "grid_count")


def read_toml(document: Document) -> ForeignCalibration | None:
    """Read any of the layouts, None of other files; InputError for what is wrong, and where."""
    if document.kind != "toml":
        return None
    content, where = document.content, document.where
    nested, metadata = content.get("cameras"), content.get("metadata")
    tables = {key: one for key, one in content.items() if isinstance(one, Mapping)}
    # configurations have other tables beside those of cameras
    own = {k: one for k, one in tables.items() if k != "metadata" and {"size", "matrix"} & {*one}}
    sections = nested if isinstance(nested, Mapping) else own
    metadata = metadata if isinstance(metadata, Mapping) else {}
    cameras, notes = [], []
    for key, values in sections.items():
        place = f"{where}, [{key}]"
        table = foreign.table_of(values, place)
        if table.get("ignore") is True or "matrix" not in table:
            notes.append(f"{_name(table, key)} is left out: it is not calibrated")
            continue
        cameras.append(foreign.camera_of(_name(table, key), table, place))
    layout = _layout(sections, metadata, nested=isinstance(nested, Mapping))
    unit = foreign.unit_named(metadata.get("units"))
    square = metadata.get("charuco_square_size")
    square = None if square is None else foreign.number_of(square, f"{where}, [metadata]")
    return ForeignCalibration(
        layout, where, tuple(cameras), unit or _UNITS.get(layout), stated=unit is not None,
        square=square, notes=tuple(notes), documented=True,
    )  # fmt: skip


def _layout(sections: Mapping[str, Any], metadata: Mapping[str, Any], *, nested: bool) -> str:
    first: Mapping[str, Any] = next(iter(sections.values()), {})
    if nested or any(key in first for key in _OF_CALISCOPE):
        return "caliscope"
    if any(key in metadata for key in _OF_FREEMOCAP):
        return "FreeMoCap"
    by_name = all(one.get("name") == key for key, one in sections.items())
    numbered = all(key.removeprefix("cam_").isdecimal() for key in sections)
    return "Pose2Sim" if by_name and not numbered else "aniposelib"


def _name(table: Mapping[str, Any], key: str) -> str:
    """The camera's name; its section's where it has none, ``cam_0`` for a bare number."""
    return foreign.text_of(table.get("name")) or (f"cam_{key}" if key.isdecimal() else key)


def toml_text(cameras: Iterable[Camera], layout: str, unit: str) -> str:
    """The cameras in a layout, in a unit of length; InputError where a name has no place in it."""
    sections: dict[str, dict[str, Any]] = {}
    for i, camera in enumerate(cameras):
        key = camera.name if layout == "pose2sim" else f"cam_{i}"
        if key == "metadata":
            what = "Pose2Sim cannot have a camera named 'metadata'"
            where = f"camera {camera.name}"
            raise InputError(what, where, "Rename the camera in calibration.toml.")
        sections[key] = section_of(camera, foreign.METRES_PER_UNIT[unit])
        if layout == "pose2sim":
            size = [float(camera.width), float(camera.height)]
            sections[key] |= {"size": size, "fisheye": camera.fisheye}
    stated = {"adjusted": False, "error": 0.0} if layout == "pose2sim" else {}
    return tomli_w.dumps({**sections, "metadata": {**stated, "units": unit}})


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


_READERS = (
    read_toml, devices.read_qualisys, devices.read_zed, devices.read_matlab,
    devices.read_camera_info,
)  # fmt: skip


def _read(document: Document) -> ForeignCalibration | None:
    """The calibration of one file; None for one of OpenCV, of which several may belong together."""
    for read in _READERS:
        if (found := read(document)) is not None:
            return found
    is_xml = document.kind == "xml"
    if not (is_xml or document.kind == "ini") or (
        is_xml and document.content.tag == "opencv_storage"
    ):
        return None
    what = "this is XML, but neither OpenCV's nor Qualisys'"
    if document.kind == "ini":
        what = "these are settings, but not the calibration of a ZED camera"
    raise InputError(what, document.where, "Check that it is a calibration file.")


def _together(found: Sequence[ForeignCalibration]) -> ForeignCalibration:
    """Files with a camera each, of one format."""
    first = found[0]
    where = ", ".join(one.where for one in found)
    if any(one.format != first.format or one.unit != first.unit for one in found):
        what = f"the files are of different formats ({', '.join(one.format for one in found)})"
        raise InputError(what, where, "Import them one at a time.")
    cameras = tuple(camera for one in found for camera in one.cameras)
    notes = tuple(note for one in found for note in one.notes)
    return replace(first, where=where, cameras=cameras, notes=notes)


def write_foreign(path: Path, cameras: Sequence[Camera], form: str, unit: str = "m") -> None:
    """Write cameras in a format of :data:`WRITTEN`; InputError where it has no place for a name."""
    if form == "opencv":
        suffix = ".xml" if path.suffix.lower() == ".xml" else ".yml"  # those that OpenCV knows
        write_file(path, opencv_storage.storage_text(cameras, unit, suffix))
    else:
        write_file(path, toml_text(cameras, form, unit))

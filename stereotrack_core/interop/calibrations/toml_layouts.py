"""Calibrations as TOML: aniposelib and FreeMoCap, Pose2Sim, caliscope.

All of them map the world to the camera, with OpenCV's axes and distortion. They differ in where the
sections are, what names a camera, whether rotations are vectors, and in the unit of length: that of
the board in aniposelib, millimetres in FreeMoCap, metres in Pose2Sim and caliscope; none states it.
"""

from collections.abc import Iterable, Mapping
from typing import Any, Literal

import tomli_w

from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.interop.calibrations import foreign
from stereotrack_core.interop.calibrations.documents import Document
from stereotrack_core.interop.calibrations.foreign import ForeignCalibration
from stereotrack_core.recording.calibration import section_of

Layout = Literal["aniposelib", "pose2sim"]

_OF_FREEMOCAP = ("charuco_square_size", "path_to_recorded_videos", "charuco_board_object")
_UNITS = {"Pose2Sim": "m", "caliscope": "m", "FreeMoCap": "mm"}
_OF_CALISCOPE = ("port", "cam_id", "rotation_count", "grid_count")


def read_toml(document: Document) -> ForeignCalibration | None:
    """Read any of the layouts, None of other files; InputError for what is wrong, and where."""
    if document.kind != "toml":
        return None
    content, where = document.content, document.where
    nested = content.get("cameras")
    sections = nested if isinstance(nested, Mapping) else _sections(content)
    metadata = content.get("metadata")
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


def _sections(content: Mapping[str, Any]) -> Mapping[str, Any]:
    """The tables that may be cameras; configurations have others beside them."""
    tables = {key: one for key, one in content.items() if isinstance(one, Mapping)}
    tables.pop("metadata", None)
    return {key: one for key, one in tables.items() if "size" in one or "matrix" in one}


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


def toml_text(cameras: Iterable[Camera], layout: Layout, unit: str) -> str:
    """The cameras in a layout, in a unit of length; InputError where a name has no place in it."""
    sections: dict[str, dict[str, Any]] = {}
    for i, camera in enumerate(cameras):
        key = camera.name if layout == "pose2sim" else f"cam_{i}"
        if key == "metadata":
            what = "Pose2Sim cannot have a camera named 'metadata'"
            where = f"camera {camera.name}"
            raise InputError(what, where=where, remedy="Rename the camera in calibration.toml.")
        sections[key] = section_of(camera, foreign.METRES_PER_UNIT[unit])
        if layout == "pose2sim":
            size = [float(camera.width), float(camera.height)]
            sections[key] |= {"size": size, "fisheye": camera.fisheye}
    stated = {"adjusted": False, "error": 0.0} if layout == "pose2sim" else {}
    return tomli_w.dumps({**sections, "metadata": {**stated, "units": unit}})

"""Read and write ``calibration.toml``: the cameras and their places in the world."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from stereotrack_core.arrays import FloatArray
from stereotrack_core.atomic import write_file
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.rotation import rotation_from_vector, vector_from_rotation
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.recording.description import Cameras
from stereotrack_core.recording.toml_table import LARGEST, Table, load_toml

_DISTORTION_COUNTS = (4, 5, 8, 12, 14)
_METRES_PER_UNIT = {"m": 1.0, "mm": 0.001}
_IMPORT = "If another tool made it, run `stereotrack calibrate import`."


def read_calibration(path: Path) -> dict[str, Camera]:
    """Cameras by name, lengths in metres; InputError at the first thing that is wrong."""
    complaints: list[InputError] = []
    cameras, *_ = parse_calibration(path, complaints)
    if complaints:
        raise complaints[0]
    return cameras


def parse_calibration(
    path: Path, complaints: list[InputError]
) -> tuple[dict[str, Camera], frozenset[str] | None, bool]:
    """The cameras that can be used; everything wrong is appended to `complaints`.

    Also the names of all cameras in the file, usable or not (None where it cannot be read), and
    whether it says of itself that it was guessed.
    """
    try:
        content = load_toml(path)
    except InputError as error:
        if path.suffix.lower() != ".toml" and path.is_file():
            error = InputError(error.what, error.where, _IMPORT)
        complaints.append(error)
        return {}, None, False
    metadata = _metadata(content)
    metres = _metres_per_unit(metadata, path, complaints)
    cameras: dict[str, Camera] = {}
    sections = {key: values for key, values in content.items() if isinstance(values, Mapping)}
    for section, values in sections.items():
        if section == "metadata":
            continue
        table = Table(values, f"{path}, [{section}]", complaints)
        camera = _camera(table, metres)
        if camera is None:
            continue
        if camera.name in cameras:
            what = f"there are two cameras named {camera.name!r}"
            table.complain("name", what, "Rename one of them.")
        cameras.setdefault(camera.name, camera)
    if not cameras and not complaints:
        keys = "name, size, matrix, distortions, rotation, translation"
        remedy = f"Add a section with {keys}. {_IMPORT}"
        complaints.append(InputError("it contains no camera", path, remedy))
    names = frozenset(str(one["name"]) for one in sections.values() if "name" in one)
    return cameras, names, metadata.get("guess") is True


def _metadata(content: Mapping[str, Any]) -> Mapping[str, Any]:
    metadata = content.get("metadata")
    return metadata if isinstance(metadata, Mapping) else {}


def _metres_per_unit(
    metadata: Mapping[str, Any], path: Path, complaints: list[InputError]
) -> float:
    units = metadata.get("units")
    if isinstance(units, str) and units in _METRES_PER_UNIT:
        return _METRES_PER_UNIT[units]
    unstated = "the unit of the translations is not stated"
    what = unstated if units is None else f"unknown unit {units!r}"
    remedy = 'Add a section [metadata] with units = "m" or units = "mm". ' + _IMPORT
    complaints.append(InputError(what, f"{path}, [metadata] units", remedy))
    return 1.0


_NUMBERS: Mapping[str, tuple[tuple[int, ...] | None, str]] = {
    "size": ((2,), "[width, height] in pixels"),
    "matrix": ((3, 3), "three rows of three numbers in pixels"),
    "distortions": (None, "4, 5, 8, 12 or 14 coefficients in OpenCV's order, 4 of a fisheye lens"),
    "rotation": ((3,), "a rotation vector of three numbers in radians"),
    "translation": ((3,), "three numbers"),
}
"""Shape of a camera's numbers (None: any row of them), and what they are."""

_SIGMA = "place_sigma"  # optional key; standard deviation (3-D) of a camera's place


def _camera(table: Table, metres: float) -> Camera | None:
    before = len(table.complaints)
    name = table.text("name", required=True)
    fisheye = table.values.get("fisheye", False)
    if not isinstance(fisheye, bool):
        table.complain("fisheye", f"{fisheye!r} is not true or false", "Write fisheye = true.")
    read = {key: _numbers(table, key, *wanted) for key, wanted in _NUMBERS.items()}
    found = {key: numbers for key, numbers in read.items() if numbers is not None}
    sigma = table.number(_SIGMA, 0.0) or 0.0
    for key, what, remedy in _mistakes(found, fisheye is True):
        table.complain(key, what, remedy)
    if len(table.complaints) > before or name is None:
        return None
    rotation = rotation_from_vector(found["rotation"])
    placed = RigidTransform(rotation, found["translation"] * metres)
    width, height = found["size"].astype(int).tolist()
    lens = found["matrix"], found["distortions"], fisheye
    return Camera(name, width, height, *lens, placed, sigma * metres)


def _mistakes(found: Mapping[str, FloatArray], fisheye: bool) -> Iterator[tuple[str, str, str]]:
    """Keys of numbers that no camera has, what is wrong about them, and what would be right."""
    size, matrix, coefficients = (found.get(key) for key in ("size", "matrix", "distortions"))
    if size is not None and ((size < 1).any() or (size != np.round(size)).any()):
        yield "size", f"{size.tolist()} is not an image size", "Write [width, height]."
    if matrix is not None and not (np.allclose(matrix[2], (0, 0, 1)) and matrix[1, 0] == 0):
        what = "the last row is not 0, 0, 1 or there is a number below fx"
        if np.allclose(matrix[:, 2], (0, 0, 1)) and matrix[0, 1] == 0:
            what = "the matrix is transposed: the principal point is in its last row"
        yield "matrix", what, "Write [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]."
    elif matrix is not None and (matrix[0, 0] < 1 or matrix[1, 1] < 1):
        lengths = f"the focal lengths {matrix[0, 0]:g} and {matrix[1, 1]:g} px"
        what = f"{lengths} are invalid: the matrix is singular or mirrors the image"
        yield "matrix", what, "Give positive ones in pixels, or calibrate this camera again."
    if coefficients is not None and coefficients.size not in (
        (4,) if fisheye else _DISTORTION_COUNTS
    ):
        remedy = f"Write {_NUMBERS['distortions'][1]}. Use zeros if there is no distortion."
        yield "distortions", f"it has {coefficients.size} coefficients", remedy


def _numbers(
    table: Table, key: str, shape: tuple[int, ...] | None, expected: str
) -> FloatArray | None:
    value = table.values.get(key)
    if value is None:
        table.complain(key, "the key is missing", f"Add {key} = {expected}.")
        return None
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        array = np.empty(0)
    if (shape is not None and array.shape != shape) or array.ndim != len(shape or (0,)):
        table.complain(key, f"this is not {expected}", f"Write {key} = {expected}.")
        return None
    if (np.abs(array) <= LARGEST).all():
        return array
    wrong = "too large" if np.isfinite(array).all() else "not finite"
    table.complain(key, f"it contains a value that is {wrong}", "Calibrate this camera again.")
    return None


def write_calibration(path: Path, cameras: Cameras, *, guessed: bool = False) -> None:
    """Write cameras, lengths in metres; `guessed`: whether to state that nobody measured them."""
    sections = (section_of(camera, 1.0) for camera in cameras.values())
    content: dict[str, Any] = {f"cam_{i}": one for i, one in enumerate(sections)}
    content["metadata"] = {"units": "m"} | ({"guess": True} if guessed else {})
    write_file(path, tomli_w.dumps(content))


def section_of(camera: Camera, metres: float) -> dict[str, Any]:
    """A camera as a section of the file; `metres` are those of the file's unit."""
    placed = camera.camera_from_world
    section: dict[str, Any] = {
        "name": camera.name,
        "size": [camera.width, camera.height],
        "matrix": camera.matrix.tolist(),
        "distortions": camera.distortions.tolist(),
        "rotation": vector_from_rotation(placed.rotation).tolist(),
        "translation": (placed.translation / metres).tolist(),
    }
    if camera.place_sigma:
        section[_SIGMA] = camera.place_sigma / metres
    return section | ({"fisheye": True} if camera.fisheye else {})


def edited_calibration(path: Path, cameras: Cameras) -> str:
    """The text of a calibration with these cameras changed; InputError where it cannot be read."""
    content = load_toml(path)
    complaints: list[InputError] = []
    metres = _metres_per_unit(_metadata(content), path, complaints)
    if complaints:
        raise complaints[0]
    for section in content.values():
        camera = cameras.get(section.get("name", "")) if isinstance(section, dict) else None
        if camera is not None:
            section.pop("fisheye", None)
            section.pop(_SIGMA, None)
            section.update(section_of(camera, metres))
    return tomli_w.dumps(content)

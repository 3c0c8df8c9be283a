"""Calibrations in OpenCV's FileStorage: YAML, XML or JSON, single cameras, stereo pairs and rigs.

The names of the matrices are whatever the program that wrote them chose. Understood are those of
OpenCV's samples (``camera_matrix``; ``M1, D1, M2, D2`` with ``R, T``), with left and right in place
of 1 and 2, of EasyMocap (``names`` with ``K_<name>, dist_<name>, Rot_<name>, T_<name>``), and of
JARVIS (one file a camera, all matrices transposed). Several files are read as one.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any
from xml.etree.ElementTree import Element

import cv2
import numpy as np

from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.rotation import vector_from_rotation
from stereotrack_core.interop.calibrations import foreign
from stereotrack_core.interop.calibrations.documents import Document
from stereotrack_core.interop.calibrations.foreign import ForeignCalibration, ForeignCamera

_MATRIX = ("cameramatrix", "k", "m", "intrinsicmatrix", "intrinsics", "mtx")
_DISTORTIONS = (
    *("distortioncoefficients", "distcoeffs", "distcoeff", "distortions", "distortion", "dist"),
    "d",
)
_ROTATION = ("r", "rotationmatrix", "rotation", "rot", "rcext", "rvec")
_TRANSLATION = ("t", "translationvector", "translation", "tcext", "tvec")
_FISHEYE = ("fisheye", "equidistant", "kannalabrandt")
_NO_DISTORTION = [0.0] * 4
_SIDES = (("1", "2"), ("left", "right"), ("l", "r"))
_NODE_NAME = re.compile(r"[A-Za-z0-9_-]+")

Values = Mapping[str, Any]  # values by their name in lower case, without what joins its words


def read_storage(documents: Sequence[Document]) -> ForeignCalibration:
    """Read files that belong together; raises InputError for what is wrong, with its place."""
    contents: list[Mapping[str, Any]] = [
        {child.tag: _node(child) for child in one.content} if one.kind == "xml" else one.content
        for one in documents
    ]
    where = ", ".join(one.where for one in documents)
    own = [_known(content) for content in contents]
    merged = {key: value for content in contents for key, value in content.items()}
    if len(own) > 1 and all(_first(values, _MATRIX) is not None for values in own):
        pairs = zip(documents, own, strict=True)
        cameras = [_single(values, one.path.stem, one.where) for one, values in pairs]
    else:
        cameras = list(_cameras(merged, documents[0].path.stem, where))
    values = _known(merged)
    unit = foreign.unit_named(values.get("unit", values.get("units")))
    square = values.get("squaresize")
    square = None if square is None else foreign.number_of(square, f"{where}, square_size")
    stated = unit is not None
    return ForeignCalibration("OpenCV", where, tuple(cameras), unit, stated=stated, square=square)


def _node(element: Element) -> Any:
    """A node of XML as YAML would give it; deeper than three tables nothing is kept."""
    children = list(element)
    if not children:
        found = re.findall(r'"([^"]*)"|(\S+)', element.text or "")
        words = [quoted or bare for quoted, bare in found]
        return words[0] if len(words) == 1 else words
    if all(child.tag == "_" for child in children):
        return [" ".join(child.itertext()).split() for child in children]
    texts = {child.tag: "".join(child.itertext()) for child in children}
    if "data" in texts:
        return {**texts, "data": texts["data"].split()}
    return {child.tag: "".join(child.itertext()).split() for child in children}


def _known(content: Mapping[str, Any]) -> Values:
    return {re.sub(r"[^a-z0-9]", "", key.lower()): value for key, value in content.items()}


def _first(values: Values, names: Sequence[str]) -> Any:
    """The numbers under the first of the names that is there."""
    for name in names:
        if values.get(name) is not None:
            return foreign.data_of(values[name])
    return None


def _cameras(content: Mapping[str, Any], stem: str, where: str) -> Iterator[ForeignCamera]:
    values = _known(content)
    names = content.get("names")
    if isinstance(names, list | str) and any(key.startswith("K_") for key in content):
        for name in [names] if isinstance(names, str) else names:
            yield _of_rig(content, foreign.text_of(name), where)
        return
    for left, right in _SIDES:
        for order in ("{name}{side}", "{side}{name}"):
            pair = [[order.format(name=n, side=side) for n in _MATRIX] for side in (left, right)]
            if all(_first(values, one) is not None for one in pair):
                yield from _stereo(values, order, (left, right), where)
                return
    if _first(values, _MATRIX) is not None:
        yield _single(values, stem, where)
        return
    for key, value in content.items():
        inner = _known(value) if isinstance(value, Mapping) else {}
        if _first(inner, _MATRIX) is not None:
            yield _single(inner, key, f"{where}, {key}")


def _single(values: Values, name: str, where: str) -> ForeignCamera:
    """One camera; placed where the file has one rotation and translation."""
    given = _first(values, _MATRIX)
    own = {
        **_shared(values),
        "matrix": given,
        "distortions": _first(values, _DISTORTIONS) or _NO_DISTORTION,
        "rotation": _first(values, _ROTATION),
        "translation": _first(values, _TRANSLATION),
    }
    name = foreign.text_of(values.get("cameraname")) or foreign.text_of(values.get("name")) or name
    camera = foreign.camera_of(name, own, where)
    if camera.rotation is None or foreign.array_of(given, (3, 3), where, "a matrix")[2, 0] == 0:
        return camera
    # who writes one of them transposed writes all of them transposed
    return replace(camera, rotation=camera.rotation.T)


def _stereo(
    values: Values, order: str, sides: tuple[str, str], where: str
) -> Iterator[ForeignCamera]:
    """A pair as stereoCalibrate gives it: x_2 = R x_1 + T; camera 1 is the world."""
    rotation, translation = _first(values, _ROTATION), _first(values, _TRANSLATION)
    if rotation is None or translation is None:
        remedy = "Give the file with R and T as well: intrinsics.yml extrinsics.yml."
        raise foreign.refusal(where, "there are two cameras, but no R and T between them", remedy)
    places = ((np.eye(3), np.zeros(3)), (rotation, translation))
    for side, name, placed in zip(sides, ("left", "right"), places, strict=True):
        matrix, coefficients = (
            _first(values, [order.format(name=one, side=side) for one in names])
            for names in (_MATRIX, _DISTORTIONS)
        )
        own = {"matrix": matrix, "distortions": coefficients or _NO_DISTORTION}
        own |= {**_shared(values), "rotation": placed[0], "translation": placed[1]}
        yield foreign.camera_of(name, own, f"{where}, camera {side}")


def _of_rig(content: Mapping[str, Any], name: str, where: str) -> ForeignCamera:
    mine = [key for key in content if key.endswith(f"_{name}")]
    own = _known({key.removesuffix(f"_{name}"): content[key] for key in mine})
    place = f"{where}, camera {name}"
    if not name or _first(own, ("k",)) is None:
        raise foreign.refusal(
            place, "there is no K for a camera in names", "Give the file with K as well."
        )
    return replace(_single(own, name, place), name=name)


def _shared(values: Values) -> dict[str, Any]:
    """Lens model and image size, where the file has it."""
    names = ("distortionmodel", "cameramodel", "model")
    models = (foreign.text_of(values.get(key)).lower().replace("_", "") for key in names)
    fisheye = foreign.text_of(values.get("fisheyemodel")) == "1"
    fisheye = fisheye or any(one in _FISHEYE for one in models)
    fisheye = fisheye or values.get("fisheye") in (True, 1, "1")
    names_of = ((f"image{side}", side, f"img{side}", side[0]) for side in ("width", "height"))
    width, height = (_first(values, own) for own in names_of)
    both = _first(values, ("imagesize", "size", "resolution"))
    return {"fisheye": fisheye, "size": both if None in (width, height) else [width, height]}


def storage_text(cameras: Sequence[Camera], unit: str, suffix: str) -> str:
    """Cameras as OpenCV writes ``.yml`` or ``.xml``, with EasyMocap's names; else InputError."""
    unfit = next((one.name for one in cameras if not _NODE_NAME.fullmatch(one.name)), None)
    if unfit is not None:
        what = "OpenCV's files allow letters, digits, - and _ in names only"
        raise InputError(what, f"camera {unfit!r}", "Rename the camera in calibration.toml.")
    storage = cv2.FileStorage(
        f"calibration{suffix}", cv2.FILE_STORAGE_WRITE | cv2.FILE_STORAGE_MEMORY
    )
    metres = foreign.METRES_PER_UNIT[unit]
    storage.write("unit", unit)
    storage.startWriteStruct("names", cv2.FILE_NODE_SEQ)
    for camera in cameras:
        storage.write("", camera.name)
    storage.endWriteStruct()
    for camera in cameras:
        placed, name = camera.camera_from_world, camera.name
        storage.write(f"W_{name}", camera.width)
        storage.write(f"H_{name}", camera.height)
        storage.write(f"K_{name}", camera.matrix)
        storage.write(f"dist_{name}", camera.distortions.reshape(1, -1))
        if camera.fisheye:
            storage.write(f"fisheye_{name}", 1)
        storage.write(f"R_{name}", vector_from_rotation(placed.rotation).reshape(3, 1))
        storage.write(f"Rot_{name}", np.ascontiguousarray(placed.rotation))
        storage.write(f"T_{name}", (placed.translation / metres).reshape(3, 1))
    if len(cameras) == 2:
        for number, camera in enumerate(cameras, start=1):
            storage.write(f"M{number}", camera.matrix)
            storage.write(f"D{number}", camera.distortions.reshape(1, -1))
        second_from_first = cameras[1].camera_from_world @ cameras[0].world_from_camera
        storage.write("R", np.ascontiguousarray(second_from_first.rotation))
        storage.write("T", (second_from_first.translation / metres).reshape(3, 1))
    text: str = storage.releaseAndGetString()
    return text

"""From a calibration in its own convention to cameras in metres: what is open is decided or asked.

The convention and the unit that a format documents are kept; that cameras stand in an unusual way
is only a note. What no format documents is told by how cameras stand; where that cannot decide, the
person is asked.

Ways to read a calibration, and whether the cameras then stand as cameras of a rig do.

Written down wrongly are mostly: the rotation transposed, the transform inverted, the place of the
camera instead of the translation, and the unit of length.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from pathlib import Path
from typing import TypeAlias

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import PADDED, Camera, is_padded
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.interop.calibrations.foreign import METRES_PER_UNIT, ForeignCalibration
from stereotrack_core.interop.calibrations.formats import read_foreign
from stereotrack_core.recording.calibration import read_calibration
from stereotrack_core.recording.camera_checks import at_one_place, common_centre, world_camera
from stereotrack_core.recording.description import Cameras, Recording
from stereotrack_core.recording.importing.choices import Choices, cameras_of, size_of

CONVENTIONS: Mapping[str, Callable[[FloatArray, FloatArray], RigidTransform]] = {
    "world-to-camera": RigidTransform,
    "transposed": lambda rotation, translation: RigidTransform(rotation.T, translation),
    "camera-to-world": lambda rotation, translation: RigidTransform(
        rotation, translation
    ).inverse(),
    "centre": lambda rotation, place: RigidTransform(rotation, -rotation @ place),
}
"""camera_from_world of what a file says, by the name of the convention."""

MEANINGS: Mapping[str, str] = {
    "world-to-camera": "x_camera = R x_world + t",
    "transposed": "x_camera = R^T x_world + t",
    "camera-to-world": "x_world = R x_camera + t",
    "centre": "x_camera = R (x_world - t)",
}

_PARALLEL = np.cos(np.radians(20.0))
_FACING = np.cos(np.radians(30.0))  # from the axis to what the cameras look at, at most
_NEAR = 0.2  # of the rig's width, within which two cameras count as one place
_SIDE_BY_SIDE = 0.5

_POSSIBLE_M = {
    "square of the board": (0.004, 0.12),
    "distance of the cameras": (0.4, 15.0),
    "base line": (0.015, 0.7),
}
"""Lengths of a rig that people know the size of: smallest and largest, in metres."""

Pairs: TypeAlias = Sequence[tuple[str, str]]  # names of the left and right cameras of stereo views


def viewpoints(cameras: Cameras) -> dict[str, Camera]:
    """One camera of each place: of two beside each other that look the same way, the first."""
    spans = [_apart(a, b) for a, b in combinations(cameras.values(), 2)]
    width = max(spans, default=0.0)
    kept: dict[str, Camera] = {}
    for name, camera in cameras.items():
        near = (other for other in kept.values() if _apart(camera, other) < _NEAR * width)
        if not any(_same_way(camera, other) for other in near):
            kept[name] = camera
    return kept


def _apart(a: Camera, b: Camera) -> float:
    return float(np.linalg.norm(a.position_world - b.position_world))


def _same_way(a: Camera, b: Camera) -> bool:
    axes = a.camera_from_world.rotation[2], b.camera_from_world.rotation[2]
    return bool(axes[0] @ axes[1] > _PARALLEL)


def in_order(cameras: Cameras, pairs: Pairs) -> bool | None:
    """Whether the cameras look at one place, and left ones stand left; None if it is open."""
    for left, right in pairs:
        offset = cameras[right].camera_from_world.apply(cameras[left].position_world)
        if not -offset[0] > _SIDE_BY_SIDE * float(np.linalg.norm(offset)):
            return False
    apart = viewpoints(cameras)
    if len(apart) < 2 or (len(apart) == 2 and _same_way(*apart.values())):
        return True if pairs else None
    if at_one_place(apart):
        return False
    centre = common_centre(apart)
    ways = [camera.camera_from_world.apply(centre) for camera in apart.values()]
    if not all(way[2] > _FACING * np.linalg.norm(way) for way in ways):
        return False
    # two cameras alone look at one place in other conventions as well
    return True if len(apart) > 2 or pairs else None


def lengths_of(cameras: Cameras, pairs: Pairs, square: float | None) -> dict[str, float]:
    """Lengths of a rig, in its own unit, that people know the size of."""
    lengths: dict[str, float] = {}
    if square is not None:
        lengths["square of the board"] = square
    apart = viewpoints(cameras)
    if len(apart) >= 2 and not (len(apart) == 2 and _same_way(*apart.values())):
        centre = common_centre(apart)
        away = [float(np.linalg.norm(one.position_world - centre)) for one in apart.values()]
        lengths["distance of the cameras"] = float(np.median(away))
    elif len(apart) == 2:
        lengths["base line"] = _apart(*apart.values())
    base = [_apart(cameras[left], cameras[right]) for left, right in pairs]
    if base:
        lengths["base line"] = float(np.median(base))
    return {name: length for name, length in lengths.items() if np.isfinite(length)}


DOCUMENTED = "world-to-camera"
"""The convention that every reader gives its cameras in, as its format documents them."""


@dataclass(frozen=True, eq=False)
class Decided:
    """Cameras in metres, the `reasons` for how the file was read, and `notes` about the cameras."""

    cameras: Cameras
    convention: str
    unit: str
    reasons: tuple[str, ...]
    notes: tuple[str, ...]


class Undecided(InputError):
    """Neither the file nor its cameras tell how to read a calibration."""


Size: TypeAlias = tuple[int, int]


def completed(
    foreign: ForeignCalibration,
    recording: Recording | None = None,
    *,
    names: Sequence[str] = (),
    size: Size | None = None,
) -> ForeignCalibration:
    """The calibration with a name and an image size for every camera.

    `names` and `size` are given by the person, in the order of the file; else sizes are the file's
    or the recording's. InputError where one is missing or contradicts the recording.
    """
    known = {} if recording is None else recording.cameras
    sizes = {(camera.width, camera.height) for camera in known.values()}
    foreign = foreign.of_size(size or (sizes.pop() if len(sizes) == 1 else None))
    chosen = _names(foreign, recording, names)
    notes, cameras = [], []
    for one, name in zip(foreign.cameras, chosen, strict=True):
        shown = (known[name].width, known[name].height) if name in known else None
        own = one.size or shown or size
        if own is None:
            what = f"the file does not state the image size of {name}"
            remedy = "Give the recording with --recording, or the size with --size WIDTHxHEIGHT."
            raise InputError(what, foreign.where, remedy)
        if shown is not None and is_padded(own, shown):
            notes.append(PADDED.format(name, *own, *shown))
            own = shown
        if shown is not None and own != shown:
            what = (
                f"the calibration of {name} is for images of {own[0]} x {own[1]} pixels, those of "
                f"the recording have {shown[0]} x {shown[1]}"
            )
            remedy = "Use a calibration made with images of this size, or the original images."
            raise InputError(what, foreign.where, remedy)
        cameras.append(replace(one, name=name, size=own))
    if lacking := [name for name in known if name not in chosen]:
        notes.append(f"the file lacks {', '.join(lacking)} of the recording")
    return replace(foreign, cameras=tuple(cameras), notes=(*foreign.notes, *notes))


def _names(
    foreign: ForeignCalibration, recording: Recording | None, given: Sequence[str]
) -> list[str]:
    own = [one.name or f"cam_{i}" for i, one in enumerate(foreign.cameras)]
    if given:
        if len(given) != len(own) or len(set(given)) < len(given):
            what = f"the file has {len(own)} cameras: {', '.join(own)}"
            remedy = "Give a different name for each, in this order, separated by commas."
            raise InputError(what, "--names", remedy)
        return list(given)
    if recording is None or set(own) & set(recording.cameras):
        return own
    pairs = [(view.left.camera, view.image.camera) for view in recording.views if view.left]
    if own == ["left", "right"] and len(pairs) == 1:
        return list(pairs[0])
    theirs, ours = ", ".join(own), ", ".join(recording.cameras)
    what = f"its cameras are named {theirs}, but those of the recording {ours}"
    remedy = "Give the recording's names in the order of the file: --names A,B,..."
    raise InputError(what, foreign.where, remedy)


def cameras_read(foreign: ForeignCalibration, convention: str) -> dict[str, Camera]:
    """Cameras of a completed calibration by a convention, in the file's unit of length."""
    placed = CONVENTIONS[convention]
    cameras = {}
    for one in foreign.cameras:
        assert one.size is not None  # noqa: S101 - it was completed
        there = RigidTransform.identity()
        if one.rotation is not None and one.translation is not None:
            there = placed(one.rotation, one.translation)
        cameras[one.name] = Camera(
            one.name, *one.size, one.matrix, one.distortions, one.fisheye, there
        )
    return cameras


def decide(
    foreign: ForeignCalibration,
    pairs: Pairs = (),
    *,
    convention: str | None = None,
    unit: str | None = None,
) -> Decided:
    """Decide what is open about a calibration and not chosen by the person; else Undecided."""
    if not foreign.placed:
        note = "the file does not say where the cameras are: each is at the origin of the world"
        cameras = cameras_read(foreign, DOCUMENTED)
        return Decided(cameras, DOCUMENTED, unit or "m", (), (*foreign.notes, note))
    chosen, why, doubts = _convention(foreign, pairs, convention)
    in_file = cameras_read(foreign, chosen)
    scale, because, odd = _unit(foreign, in_file, pairs, unit)
    cameras = {name: camera.scaled(METRES_PER_UNIT[scale]) for name, camera in in_file.items()}
    notes = [*foreign.notes, *doubts, *odd]
    if (own := world_camera(cameras.values())) is not None:
        notes.append(
            f"the world is the frame of camera {own.name}: z is its viewing direction, not up. "
            "Tracking takes the axis that points up in its images; `stereotrack calibrate align` "
            "makes a world whose z does"
        )
    return Decided(cameras, chosen, scale, (why, because), tuple(notes))


def _convention(
    foreign: ForeignCalibration, pairs: Pairs, given: str | None
) -> tuple[str, str, tuple[str, ...]]:
    """The convention, why it was chosen, and what is doubtful about it."""
    if given is not None:
        return given, f"convention {given}: given with --convention", ()
    fitting = [n for n in CONVENTIONS if in_order(cameras_read(foreign, n), pairs) is not False]
    if DOCUMENTED in fitting or foreign.documented:
        reason = f"convention {DOCUMENTED}: as {foreign.format} documents it"
        others = " or ".join(f"--convention {name}" for name in fitting)
        unusual = (
            "read as documented, the cameras do not stand as usual: they look at no common place, "
            "or left and right are exchanged"
            + (f". With {others} they would; check them in the workbench" if others else "")
        )
        return DOCUMENTED, reason, () if DOCUMENTED in fitting else (unusual,)
    what = "the cameras look at no common place, however rotations and translations are read"
    if fitting:
        against = f"the convention that {foreign.format} documents"
        what = f"the places of the cameras contradict {against}; these fit: {' or '.join(fitting)}"
    remedy = "Choose one with --convention, and check the cameras in the workbench."
    raise Undecided(what, foreign.where, remedy)


def _unit(
    foreign: ForeignCalibration, cameras: Cameras, pairs: Pairs, given: str | None
) -> tuple[str, str, tuple[str, ...]]:
    """The unit of length, why it was chosen, and what is doubtful about it."""
    if given is not None:
        return given, f"unit {given}: given with --units", ()
    lengths = lengths_of(cameras, pairs, foreign.square)
    limits = [(length, *_POSSIBLE_M[name]) for name, length in lengths.items()]
    units = METRES_PER_UNIT.items() if limits else ()
    possible = [unit for unit, m in units if all(low <= x * m <= high for x, low, high in limits)]
    stated = foreign.unit
    if stated is not None and (stated in possible or not lengths or foreign.documented):
        source = "stated by the file" if foreign.stated else f"what {foreign.format} writes"
        doubts: tuple[str, ...] = ()
        if lengths and stated not in possible:
            unusual = f"the lengths are unusual in {stated} ({_lengths(lengths, stated)})"
            doubts = (f"{unusual}: if they are wrong, give the unit with --units",)
        return stated, f"unit {stated}: {source}", doubts
    if len(possible) == 1 and not foreign.stated:
        text = _lengths(lengths, possible[0])
        usual = "" if stated is None else f"; {foreign.format} usually writes {stated}"
        return possible[0], f"unit {possible[0]}: the only possible one ({text}){usual}", ()
    lines = ", ".join(f"{unit}: {_lengths(lengths, unit)}" for unit in METRES_PER_UNIT)
    what = f"the unit of length is not stated, and the data do not tell it ({lines})"
    if stated is not None:
        what = f"the lengths are not possible in {stated}, the unit of {foreign.format} ({lines})"
    remedy = f"Give it with --units {'|'.join(possible or METRES_PER_UNIT)}."
    raise Undecided(what, foreign.where, remedy)


def _lengths(lengths: Mapping[str, float], unit: str) -> str:
    texts = []
    for name, length in lengths.items():
        metres = length * METRES_PER_UNIT[unit]
        size = f"{metres:,.0f} m" if metres >= 100 else f"{metres:.2f} m"
        texts.append(f"{name} {size if metres >= 0.01 else f'{1000 * metres:.2g} mm'}")
    return ", ".join(texts) or "-"


def with_calibration(
    choices: Choices, paths: Sequence[Path], *, unit: str | None, convention: str | None
) -> tuple[Choices, Decided | None]:
    """Choices with the cameras of files, matched by their names, and how they were read.

    A ``calibration.toml`` needs no decision. Names that are equal but for upper case, the cameras
    of a single pair, and a single camera are matched; others are left to the person, who may say
    `unit` and `convention`. InputError where a file cannot be read, ``Undecided`` where these are
    open.
    """
    if len(paths) == 1 and not (unit or convention) and _is_own(paths[0]):
        known = read_calibration(paths[0])
        choices = replace(choices, calibration=paths[0], given=None)
        return _matched(choices, list(known)), None
    sizes = {size_of(use) for use in choices.used()}
    size = sizes.pop() if len(sizes) == 1 else None
    foreign = completed(read_foreign(paths), size=size)
    theirs = [one.name for one in foreign.cameras]
    matched = _matched(choices, theirs)
    names = {name: matched.cameras.get(name, name) for name in matched.camera_names()}
    views = dict.fromkeys(use.view for use in matched.used())
    both = [(names.get(f"{view}_left", ""), names.get(f"{view}_right", "")) for view in views]
    pairs = [pair for pair in both if set(pair) <= set(theirs)]
    decided = decide(foreign, pairs, convention=convention, unit=unit)
    return replace(matched, calibration=paths[0], given=decided.cameras), decided


def _is_own(path: Path) -> bool:
    """Whether a file can be used as it is."""
    if path.suffix.lower() != ".toml":
        return False
    try:
        read_calibration(path)
    except InputError:
        try:
            read_foreign([path])
        except InputError:
            return True  # what is wrong is said as for a calibration.toml
        return False
    return True


def _matched(choices: Choices, theirs: Sequence[str]) -> Choices:
    ours = choices.camera_names()
    lower = {name.casefold(): name for name in theirs}
    found = {name: lower[name.casefold()] for name in ours if name.casefold() in lower}
    pairs = [cameras_of(use)[0].rpartition("_")[0] for use in choices.used()
             if use.role == "left" or use.role.startswith("side")]  # fmt: skip
    if not found and len(pairs) == 1 and {"left", "right"} <= set(lower):
        found = {f"{pairs[0]}_{side}": lower[side] for side in ("left", "right")}
    if not found and len(ours) == len(theirs) == 1:
        found = {ours[0]: theirs[0]}
    known = {name: camera for name, camera in choices.cameras.items() if camera in theirs}
    return replace(choices, cameras={**found, **known})

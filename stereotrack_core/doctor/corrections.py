"""What corrections of a recording change: the new text of one of its files, and what to say of it.

Whatever else the file says stays: keys and landmarks that the program does not know as well.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeAlias

import tomli_w

from stereotrack_core.doctor.slips import (
    centre_exchanged,
    inverted,
    resized,
    transposed,
    undistorted,
)
from stereotrack_core.errors import Correction, CorrectionKind, InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.recording.calibration import edited_calibration
from stereotrack_core.recording.description import LENGTHS, Recording
from stereotrack_core.recording.folder import DESCRIPTION, named_file
from stereotrack_core.recording.toml_table import load_toml
from stereotrack_core.tables import csv_text, read_cells

Edit: TypeAlias = Callable[[Recording, Path, Correction], str]
"""Gives the new text of a file of a recording."""


@dataclass(frozen=True)
class Change:
    """A kind of correction.

    `file` is the key of the description by which it names the file, empty for itself; `words`
    a sentence in the imperative with ``{names}`` and ``{amount}``.
    """

    file: str
    words: str
    edit: Edit


def words_of(correction: Correction) -> str:
    """What a correction changes, as a sentence."""
    amount = f"{correction.amount:+z.0f}" if "{frames}" in _CHANGES[correction.kind].words else ""
    return _CHANGES[correction.kind].words.format(
        names=_listed(correction.names), amount=f"{correction.amount:.4g}", frames=amount
    )


def _listed(names: tuple[str, ...]) -> str:
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)


def key_of(correction: Correction) -> str:
    """By which key the description names the file that a correction changes; empty: itself."""
    return _CHANGES[correction.kind].file


def file_of(folder: Path, correction: Correction) -> Path:
    """The file that a correction changes; raises InputError where there is none."""
    key = key_of(correction)
    return named_file(folder, key) if key else folder / DESCRIPTION


def corrected_text(recording: Recording, path: Path, correction: Correction) -> str:
    """The text of the file at `path` with a correction.

    Raises InputError where it cannot be read, or the correction is not possible in it.
    """
    return _CHANGES[correction.kind].edit(recording, path, correction)


# ---- cameras


def _of_cameras(change: Callable[[Camera, float], Camera]) -> Edit:
    def edit(recording: Recording, path: Path, correction: Correction) -> str:
        changed = {
            name: change(recording.cameras[name], correction.amount) for name in correction.names
        }
        return edited_calibration(path, changed)

    return edit


def _nearer(camera: Camera, factor: float) -> Camera:
    old = camera.camera_from_world
    moved = RigidTransform(old.rotation, factor * old.translation)
    return replace(camera, camera_from_world=moved)


def _base_line(recording: Recording, path: Path, correction: Correction) -> str:
    """The left camera of a view farther from the other one by a factor."""
    view = recording.view(correction.names[0])
    if view.left is None:
        raise InputError(
            "it has no base line", where=f"view {view.name}", remedy="Check the recording again."
        )
    left, right = recording.cameras[view.left.camera], recording.cameras[view.image.camera]
    apart = left.position_world - right.position_world
    rotation = left.camera_from_world.rotation
    place = right.position_world + correction.amount * apart
    moved = replace(left, camera_from_world=RigidTransform(rotation, -rotation @ place))
    return edited_calibration(path, {left.name: moved})


# ---- the description


def _of_views(change: Callable[[list[dict[str, Any]], float], None]) -> Edit:
    """`change` is given the views that the correction names, and its amount."""

    def edit(_: Recording, path: Path, correction: Correction) -> str:
        content = load_toml(path)
        views = {view["name"]: view for view in content["views"]}
        change([views[name] for name in correction.names], correction.amount)
        return tomli_w.dumps(content)

    return edit


_KEYS = ("left", "right", "image", "depth", "mask")


def _exchange_files(one: dict[str, Any], other: dict[str, Any]) -> None:
    """Exchange everything that two streams say but their cameras."""
    cameras = one.pop("camera", None), other.pop("camera", None)
    kept = dict(one)
    for stream, content, camera in ((one, dict(other), cameras[0]), (other, kept, cameras[1])):
        stream.clear()
        stream.update(content if camera is None else {"camera": camera, **content})


def _exchange_pair(named: list[dict[str, Any]], _: float) -> None:
    [view] = named
    _exchange_files(view["left"], view["right"])


def _exchange_sides(named: list[dict[str, Any]], _: float) -> None:
    [view] = named
    view["left"], view["right"] = view["right"], view["left"]


def _exchange_views(named: list[dict[str, Any]], _: float) -> None:
    one, other = named
    if [key in one for key in _KEYS] != [key in other for key in _KEYS]:
        raise InputError(
            f"the views {one['name']} and {other['name']} have other streams",
            where=DESCRIPTION,
            remedy="Exchange the files by hand.",
        )
    for key in _KEYS:
        if key in one:
            _exchange_files(one[key], other[key])


def _shift(*keys: str) -> Edit:
    """Let streams of the named views begin later by some frames, or all others earlier."""

    def edit(recording: Recording, path: Path, correction: Correction) -> str:
        content, count = load_toml(path), round(correction.amount)
        begins: dict[tuple[str, str], int] = {
            (view["name"], key): int(view[key].get("first_frame", 0))
            for view in content["views"]
            for key in _KEYS
            if key in view
        }
        late = [place for place in begins if place[0] in correction.names and place[1] in keys]
        lacking = max([0, *(-begins[place] - count for place in late)])
        if lacking and (recording.reference is not None or recording.segments):
            raise InputError(
                "the other streams would have to begin later, and reference and segments count "
                "frames from their beginning",
                where=str(path),
                remedy="Change first_frame, and the frames of reference and segments.",
            )
        for view in content["views"]:
            for key in _KEYS:
                stream = view["name"], key
                moved = lacking + count * (stream in late)
                if moved and key in view:
                    view[key]["first_frame"] = begins[stream] + moved
        return tomli_w.dumps(content)

    return edit


def _scale_depth(named: list[dict[str, Any]], factor: float) -> None:
    [view] = named
    view["depth"]["unit"] = float(f"{factor * float(view['depth'].get('unit', 0.001)):.6g}")


def _set_fps(_: Recording, path: Path, correction: Correction) -> str:
    return tomli_w.dumps({**load_toml(path), "fps": correction.amount})


# ---- reference and subject


def _of_rows(change: Callable[[dict[str, str], Correction], Mapping[str, str]]) -> Edit:
    """`change` is given the cells of a row by column, and gives those that are others."""

    def edit(_: Recording, path: Path, correction: Correction) -> str:
        header, *lines = read_cells(path)
        cells = [dict(zip(header, line, strict=False)) for line in lines if any(line)]
        rows = [{**row, **change(row, correction)} for row in cells]
        kept = [row for row in rows if not row["frame"].startswith("-")]
        return csv_text(header, [[row.get(column, "") for column in header] for row in kept])

    return edit


def _turned(cells: dict[str, str], correction: Correction) -> Mapping[str, str]:
    return {
        axis: _negative(cells[taken[1:]]) if taken.startswith("-") else cells[taken]
        for axis, taken in zip("xyz", correction.names, strict=True)
    }


def _negative(number: str) -> str:
    return number.removeprefix("-") if number.startswith("-") or not number else f"-{number}"


def _later(cells: dict[str, str], correction: Correction) -> Mapping[str, str]:
    return {"frame": str(int(cells["frame"]) + round(correction.amount))}


def _other_side(cells: dict[str, str], _: Correction) -> Mapping[str, str]:
    side, sign, rest = cells["landmark"].partition("_")
    other = {"left": "right", "right": "left"}.get(side)
    return {"landmark": f"{other}{sign}{rest}"} if other else {}


def _scaled(cells: dict[str, str], correction: Correction) -> Mapping[str, str]:
    known = {axis: cells[axis] for axis in "xyz" if cells[axis]}
    return {axis: f"{correction.amount * float(number):.6f}" for axis, number in known.items()}


def _scale_lengths(_: Recording, path: Path, correction: Correction) -> str:
    content = load_toml(path)
    scaled = {key: round(correction.amount * content[key], 4) for key in LENGTHS if key in content}
    return tomli_w.dumps({**content, **scaled})


_CHANGES: Mapping[CorrectionKind, Change] = {
    "transpose": Change(
        "calibration", "Transpose the rotation of {names}.", _of_cameras(lambda c, _: transposed(c))
    ),
    "invert": Change(
        "calibration",
        "Invert rotation and translation of {names}.",
        _of_cameras(lambda c, _: inverted(c)),
    ),
    "exchange_centre": Change(
        "calibration",
        "Exchange c_x and c_y in the matrix of {names}.",
        _of_cameras(lambda c, _: centre_exchanged(c)),
    ),
    "undistort": Change(
        "calibration",
        "Set the distortions of {names} to zero.",
        _of_cameras(lambda c, _: undistorted(c)),
    ),
    "resize": Change(
        "calibration",
        "Multiply the first two rows of the matrix of {names} by {amount}.",
        _of_cameras(resized),
    ),
    "scale_translation": Change(
        "calibration", "Multiply the translation of {names} by {amount}.", _of_cameras(_nearer)
    ),
    "scale_base_line": Change(
        "calibration",
        "Multiply the base line of view {names} by {amount}: its left camera is moved.",
        _base_line,
    ),
    "exchange_pair": Change(
        "", "Exchange the files of left and right in view {names}.", _of_views(_exchange_pair)
    ),
    "exchange_sides": Change(
        "", "Exchange left and right, with their cameras, in view {names}.",
        _of_views(_exchange_sides),
    ),
    "exchange_views": Change(
        "", "Exchange the files of the views {names}.", _of_views(_exchange_views)
    ),
    "shift_frames": Change(
        "", "Change first_frame of the streams of view {names} by {frames} (or that of all "
        "others, where there are not so many frames before it).", _shift(*_KEYS),
    ),
    "shift_left": Change(
        "", "Change first_frame of the left image of view {names} by {frames} (or that of "
        "all others, where there are not so many frames before it).", _shift("left"),
    ),
    "scale_depth": Change(
        "", "Multiply the unit of the depth of view {names} by {amount}.", _of_views(_scale_depth)
    ),
    "set_fps": Change("", "Write fps = {amount}.", _set_fps),
    "turn_axes": Change("reference", "Write {names} for x, y and z.", _of_rows(_turned)),
    "shift_reference": Change(
        "reference", "Change all frame numbers by {frames}.", _of_rows(_later)
    ),
    "exchange_names": Change(
        "reference", "Exchange left and right in the names of landmarks.", _of_rows(_other_side)
    ),
    "scale_points": Change("reference", "Multiply all positions by {amount}.", _of_rows(_scaled)),
    "scale_lengths": Change("subject", "Multiply all lengths by {amount}.", _scale_lengths),
}  # fmt: skip

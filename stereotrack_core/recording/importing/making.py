"""Write the recording folder that was chosen; sources are read only, nothing is overwritten."""

from collections.abc import Sequence
from contextlib import closing, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from stereotrack_core.atomic import filling
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import PADDED, Camera, is_padded
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.recording.calibration import read_calibration
from stereotrack_core.recording.description import Recording, Stream, View
from stereotrack_core.recording.folder import DESCRIPTION, open_recording
from stereotrack_core.recording.importing.choices import Choices, cameras_of, problems_of, size_of
from stereotrack_core.recording.importing.files import (
    StreamFiles,
    bring,
    check_background,
    files_of,
)
from stereotrack_core.recording.importing.readers import with_one_white
from stereotrack_core.recording.writing import write_recording_description
from stereotrack_core.work import NO_WORK, Work

_CALIBRATION = "calibration.toml"
_FOCAL_SHARE = 0.9  # focal length over the longer side; a horizontal field of view of 58 degrees


def make_recording(choices: Choices, folder: Path, work: Work = NO_WORK) -> Recording:
    """Make a recording folder.

    Sources that lie in `folder` are named where they lie; others are copied into it. Images that
    hold two views, are mirrored, or whose names the format cannot express, are written again.
    Without a calibration, the cameras are a guess and marked as such. Raises InputError where the
    choices do not fit together (:func:`problems_of`) or the calibration not to the images, or
    `folder` holds other things; Cancelled on request. Then the folder is as it was.
    """
    folder, choices = Path(folder), with_one_white(choices)
    for problem in problems_of(choices):
        raise problem
    check_place(choices, folder)
    for use in choices.used():
        check_background(use)
    files = files_of(choices.used(), folder)
    cameras = cameras_for(choices)
    kept = _keeps_calibration(choices, folder) and not calibration_notes(choices)
    new = [one for one in files if one.how != "stay"]
    with filling(folder) as workplace:
        for number, one in enumerate(new):
            with closing(bring(one, workplace, choices.fps or 1.0)) as steps:
                for share in steps:
                    work.step((number + share) / len(new), f"writing {one.frames}")
        recording = Recording(
            workplace, choices.name, choices.fps or 1.0, _views(choices, files), cameras,
            guessed=choices.guessed(),
        )  # fmt: skip
        write_recording_description(recording, with_calibration=not kept)
        if len(new) == len(files) and not kept:
            open_recording(workplace)  # what is wrong is said before it is there
    return open_recording(folder)


def _keeps_calibration(choices: Choices, folder: Path) -> bool:
    given, own = choices.calibration, folder / _CALIBRATION
    if choices.given is not None:
        return False
    return given is not None and own.exists() and given.resolve() == own.resolve()


def cameras_for(choices: Choices, notes: list[str] | None = None) -> dict[str, Camera]:
    """The cameras of the calibration, or guessed ones; `notes` are told what is changed.

    A calibration of the upright images of a video that is stored lying is turned back, and one of
    padded images is cut.

    Raises InputError where a camera is missing in the calibration, or its images have another size.
    """
    sizes = {name: size_of(use) for use in choices.used() for name in cameras_of(use)}
    turns = {name: use.source.turned for use in choices.used() for name in cameras_of(use)}
    if choices.calibration is None:
        return {name: _guessed(name, *size) for name, size in sizes.items()}
    known = dict(choices.given or read_calibration(choices.calibration))
    notes = [] if notes is None else notes
    for name, size in sizes.items():
        wanted = choices.cameras.get(name, name)
        camera = known.get(wanted)
        if camera is None:
            what = f"the camera {wanted!r} is not in the calibration"
            remedy = f"Its cameras are: {', '.join(known)}. Say which of them {name} is."
            raise InputError(what, choices.calibration, remedy)
        turned = turns[name]
        if size == (camera.height, camera.width) and turned % 180:
            known[wanted] = camera = as_stored(camera, turned)
            what = f"the calibration of {name} is of upright images"
            notes.append(f"{what}; it is turned to those stored")
        if is_padded((camera.width, camera.height), size):
            notes.append(PADDED.format(name, camera.width, camera.height, *size))
            known[wanted] = camera = replace(camera, width=size[0], height=size[1])
        if size != (camera.width, camera.height):
            images = f"the images of {name} have {size[0]} x {size[1]} pixels"
            own = f"the calibration of {wanted!r} is for {camera.width} x {camera.height}"
            remedy = "Use a calibration made with images of this size."
            raise InputError(f"{images}, but {own}", choices.calibration, remedy)
    return known


def calibration_notes(choices: Choices) -> tuple[str, ...]:
    """Clauses about cameras whose calibration is of turned or padded images, and is changed."""
    notes: list[str] = []
    with suppress(InputError):  # told where the recording is made
        cameras_for(choices, notes)
    return tuple(notes)


def _guessed(name: str, width: int, height: int) -> Camera:
    """A pinhole camera without distortion, 3 m south of the origin, level, facing north."""
    focal = _FOCAL_SHARE * max(width, height)
    matrix = np.array([[focal, 0, (width - 1) / 2], [0, focal, (height - 1) / 2], [0, 0, 1]])
    rotation = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    place = np.array([0.0, -3.0, 1.2])
    placed = RigidTransform(rotation, -rotation @ place)
    return Camera(name, width, height, matrix, np.zeros(5), False, placed)


def check_place(choices: Choices, folder: Path) -> None:
    """Refuse a folder in which the recording cannot be made; InputError says why."""
    files = files_of(choices.used(), folder)
    if folder.is_file():
        raise InputError("this is a file", folder, "Give the name of a folder.")
    if (folder / DESCRIPTION).exists():
        what = "this is a recording already"
        raise InputError(what, folder, "Open it, or choose another folder.")
    root = folder.resolve()
    own = any(one.use.source.path.resolve().is_relative_to(root) for one in files)
    if folder.is_dir() and any(folder.iterdir()) and not own:
        remedy = "Choose a new folder, or the one that holds the videos."
        raise InputError("the folder is not empty", folder, remedy)
    new = [one.frames.split("/")[0] for one in files if one.how != "stay"]
    if not _keeps_calibration(choices, folder) or calibration_notes(choices):
        new.append(_CALIBRATION)
    for name in new:
        if (folder / name).exists():
            use_it = "Use it as the calibration, or choose" if name == _CALIBRATION else "Choose"
            what = f"there is already a {name}, and nothing is overwritten"
            raise InputError(what, folder, f"{use_it} another folder.")


def _views(choices: Choices, files: Sequence[StreamFiles]) -> tuple[View, ...]:
    used, fps = choices.used(), choices.fps or 1.0
    earliest = min(use.lead for use in used)
    views = []
    for name in dict.fromkeys(use.view for use in used):
        streams: dict[str, Stream] = {}
        own = [file for file in files if file.use.view == name]
        empty = {one.part: one.frames for one in own if one.empty}
        for one in (file for file in own if not file.empty):
            start = one.use.lead - earliest
            first = round(start)
            camera = choices.cameras.get(one.camera, one.camera)
            streams[one.part] = Stream(
                camera, one.frames, empty.get(one.part), first, round((start - first) / fps, 6)
            )
        kind: Any = "stereo" if "right" in streams else "depth" if "depth" in streams else "mono"
        turned = next(use.source.turned for use in used if use.view == name)
        units = [use.source.unit for use in used if use.view == name and use.role == "depth"]
        unit = next((one for one in units if one is not None), choices.depth_unit)
        view = View(
            name, kind, streams["right" if kind == "stereo" else "image"], streams.get("left"),
            streams.get("depth"), unit, streams.get("mask"), display_rotation=turned,
        )  # fmt: skip
        views.append(view)
    return tuple(views)


_MOST_COEFFICIENTS = 8  # with thin prisms and a tilted sensor, the model has axes of its own

_STORED_FROM_UPRIGHT = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
"""Axes of images that are shown turned by 90 degrees clockwise: x is upright y, y is -x."""


def as_stored(camera: Camera, turned: int) -> Camera:
    """The camera of images as stored, from that of the images turned by degrees clockwise.

    Videos of telephones are stored lying. A video player, and OpenCV as well, turns them before
    anybody sees them, so that most tools calibrate the turned images.

    Raises InputError where its distortion model or a skew cannot be turned.
    """
    if camera.distortions.size > _MOST_COEFFICIENTS or camera.matrix[0, 1]:
        raise InputError(
            f"the calibration of {camera.name} is of turned images, and its distortion model "
            "cannot be turned back",
            remedy="Calibrate with the images as stored, or with at most 8 coefficients.",
        )
    quarter = RigidTransform(_STORED_FROM_UPRIGHT, np.zeros(3))
    for _quarter in range(turned // 90):  # pixel (u, v) is shown at (height - 1 - v, u)
        height = camera.width  # of the image before the turn
        (fx, _, cx), (_, fy, cy), _ = camera.matrix
        distortions = camera.distortions.copy()
        if not camera.fisheye and distortions.size >= 4:
            p1, p2 = distortions[2:4]
            distortions[2:4] = -p2, p1
        camera = replace(
            camera, width=camera.height, height=height,
            matrix=np.array([[fy, 0.0, cy], [0.0, fx, height - 1 - cx], [0.0, 0.0, 1.0]]),
            distortions=distortions, camera_from_world=quarter @ camera.camera_from_world,
        )  # fmt: skip
    return camera

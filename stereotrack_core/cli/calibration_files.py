"""``stereotrack calibrate import`` and ``export``: calibrations of other tools."""

import re
from argparse import Namespace
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from stereotrack_core.cli import options
from stereotrack_core.cli.output import OK, put_facts, put_result, say
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.interop.calibrations import deciding
from stereotrack_core.interop.calibrations.foreign import METRES_PER_UNIT, ForeignCalibration
from stereotrack_core.interop.calibrations.formats import WRITTEN, read_foreign, write_foreign
from stereotrack_core.recording.calibration import read_calibration, write_calibration
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.folder import describe
from stereotrack_core.recording.stream_files import picture_size
from stereotrack_core.tables import Table


@options.command(
    options.path(
        "files FILE",
        "calibration of another tool; several files that belong together, such as "
        "intrinsics.yml extrinsics.yml, or one for each camera",
        nargs="+",
    ),
    options.path("-o --output FILE", "calibration to write (.toml)", required=True),
    options.option(
        "--units UNIT",
        "unit of the file's lengths: m, cm, mm or in (default: stated in the file, usual for "
        "the format, or decided from the lengths of the rig)",
        choices=tuple(METRES_PER_UNIT),
    ),
    options.option(
        "--convention NAME",
        "how rotation R and translation t of the file map: "
        + "; ".join(
            f"{name}: {deciding.MEANINGS[name]}".replace("%", "%%") for name in deciding.CONVENTIONS
        ),
        choices=tuple(deciding.CONVENTIONS),
    ),
    options.path("--recording DIR", "recording of these cameras: their names and image sizes"),
    options.option("--names A,B", "camera names, in the order of the file"),
    options.option("--size WIDTHxHEIGHT", "image size, for files that do not state it"),
)
def read(args: Namespace) -> int:
    """Read a calibration of another tool: aniposelib, FreeMoCap, Pose2Sim or caliscope TOML,
    OpenCV YAML or XML, ROS camera_info, Qualisys .qca.txt, MATLAB JSON or MAT, ZED .conf.
    """
    options.check_suffix(args.output, ".toml")
    size = _size(args.size)
    recording = None if args.recording is None else _recording_without_calibration(args.recording)
    # a calibration that a recording lacks may be put there; what it has is never replaced
    options.check_output(args.output, args.recording if args.output.exists() else None)
    names = [] if args.names is None else [name.strip() for name in args.names.split(",")]
    foreign = deciding.completed(read_foreign(args.files), recording, names=names, size=size)
    pairs = () if recording is None else _pairs(recording, foreign)
    decided = deciding.decide(foreign, pairs, convention=args.convention, unit=args.units)
    write_calibration(args.output, decided.cameras)
    for note in decided.notes:
        say(f"Note: {note}.")
    put_result(_facts(foreign, decided, args.output), *_tables(foreign, decided), as_json=args.json)
    return OK


def _size(given: str | None) -> tuple[int, int] | None:
    if given is None:
        return None
    found = re.fullmatch(r"(\d{1,5})x(\d{1,5})", given.strip())
    if found is None or "0" in found.groups():
        raise InputError(
            f"{given!r} is not an image size", where="--size", remedy="Write e.g. 1280x720."
        )
    return int(found[1]), int(found[2])


def _recording_without_calibration(folder: Path) -> Recording:
    """A recording without a valid calibration: cameras have names and sizes; else InputError."""
    complaints: list[InputError] = []
    recording = describe(folder, complaints)
    if recording is None or not recording.views:
        raise complaints[0]
    cameras: dict[str, Camera] = {}
    for view in recording.views:
        for key, stream in view.streams().items():
            name = stream.camera or view.image.camera
            where = f"{folder / 'recording.toml'}, view {view.name}, {key}.frames"
            width, height = picture_size(recording.folder, stream.frames, where)
            cameras[name] = Camera(
                name, width, height, np.eye(3), np.zeros(5), False, RigidTransform.identity()
            )
    return replace(recording, cameras=cameras)


def _pairs(recording: Recording, foreign: ForeignCalibration) -> tuple[tuple[str, str], ...]:
    """Left and right cameras of the stereo views that the file has both of."""
    names = {one.name for one in foreign.cameras}
    pairs = [(view.left.camera, view.image.camera) for view in recording.views if view.left]
    return tuple(pair for pair in pairs if names.issuperset(pair))


def _facts(foreign: ForeignCalibration, decided: deciding.Decided, output: Path) -> dict[str, Any]:
    return {
        "file": output,
        "format": foreign.format,
        "convention": decided.convention,
        "units": decided.unit,
        "reasons": decided.reasons,
        "notes": decided.notes,
        "cameras": [
            {
                "name": camera.name,
                "size": [camera.width, camera.height],
                "focal_px": camera.focal,
                "fisheye": camera.fisheye,
                "position_m": camera.position_world,
            }
            for camera in decided.cameras.values()
        ],
    }


def _tables(foreign: ForeignCalibration, decided: deciding.Decided) -> tuple[Table, ...]:
    reasons = [(reason,) for reason in decided.reasons]
    chosen = Table(f"Calibration of {foreign.format}", ("how it was read",), reasons)
    rows = [
        (
            camera.name,
            f"{camera.width} x {camera.height}",
            f"{camera.focal:.0f} px",
            " ".join(f"{value:.3f}" for value in camera.position_world),
        )
        for camera in decided.cameras.values()
    ]
    cameras = Table("Cameras", ("camera", ">size", ">focal", ">place (m)"), rows)
    return (chosen, cameras) if reasons else (cameras,)


_OPENCV = (".yml", ".yaml", ".xml")


@options.command(
    options.path("calibration CALIBRATION", "calibration.toml to read"),
    options.output("FILE", "file to write: .toml, or .yml, .yaml or .xml for OpenCV"),
    options.option(
        "--format NAME",
        f"{', '.join(WRITTEN)} (default: opencv for .yml, .yaml and .xml; aniposelib for .toml)",
        choices=WRITTEN,
    ),
    options.option(
        "--units UNIT",
        "unit of lengths: m, cm, mm or in (default: m; FreeMoCap needs mm)",
        choices=tuple(METRES_PER_UNIT),
        default="m",
    ),
)
def write(args: Namespace) -> int:
    """Write a calibration for another tool. What this program reads again is the same; tools
    that know fewer distortion coefficients or no names may lose some of it.
    """
    opencv = args.output.suffix.lower() in _OPENCV
    form = args.format or ("opencv" if opencv else "aniposelib")
    options.check_suffix(args.output, *(_OPENCV if form == "opencv" else (".toml",)))
    if args.output.resolve() == args.calibration.resolve():
        what = "this is the calibration that is read"
        raise InputError(what, where=str(args.output), remedy="Choose another name.")
    cameras = read_calibration(args.calibration)
    write_foreign(args.output, list(cameras.values()), form, args.units)
    facts = {"format": form, "units": args.units, "cameras": list(cameras)}
    title = f"{args.calibration} to {args.output}"
    put_facts(facts, title, as_json=args.json, file=args.output)
    return OK

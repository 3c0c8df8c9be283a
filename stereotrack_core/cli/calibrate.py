"""``stereotrack calibrate``: with a board one lens, a pair or all cameras; files of other tools."""

import re
from argparse import Namespace
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from stereotrack_core.calibrate import pictures, report
from stereotrack_core.calibrate.board import Board, charuco, chessboard
from stereotrack_core.calibrate.intrinsics import calibrate_intrinsics, check_model
from stereotrack_core.calibrate.lens import LENS_MODELS
from stereotrack_core.calibrate.work import Search, search, sources_in
from stereotrack_core.calibrate.world import World, calibrate_world, pair_of
from stereotrack_core.cli import options
from stereotrack_core.cli.output import OK, put_facts, put_result, say, stoppable, watched
from stereotrack_core.errors import Finding, InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.interop.calibrations import deciding
from stereotrack_core.interop.calibrations.foreign import METRES_PER_UNIT, ForeignCalibration
from stereotrack_core.interop.calibrations.formats import WRITTEN, read_foreign, write_foreign
from stereotrack_core.recording.calibration import read_calibration, write_calibration
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.folder import describe
from stereotrack_core.recording.stream_files import picture_size
from stereotrack_core.tables import Table, number

BOARD = (
    options.option("--board COLSxROWS", "chessboard: number of inner corners, for example 9x6"),
    options.option(
        "--charuco COLSxROWS:DICTIONARY:MARKER",
        "ChArUco board: number of squares, dictionary, side of a marker in metres, for example "
        "5x7:4X4_50:0.018",
    ),
    options.option("--square METRES", "side of a square of the board", type=float),
)
EVERY = options.option(
    "--every N", "use only every Nth picture (default: 1)", type=options.at_least(1), default=1
)
MODEL = options.option(
    f"--model auto|{'|'.join(LENS_MODELS)}",
    "lens model (default: auto, the simplest that no other clearly improves on)",
    default="auto",
)
LENSES = options.path(
    "--lenses FILE.toml",
    "calibration whose lenses are kept, by the names of the cameras; others are calibrated",
)
_NOT_ALIGNED = Finding(
    "note",
    "world",
    "the world is that of the first camera, taken as level and looking south",
    "Turn it with `stereotrack calibrate align`.",
)
NOTHING = "No calibration was written."


def board_of(args: Namespace) -> Board:
    """The board that was named; InputError where none or two were, or its size is not given."""
    if args.square is None:
        remedy = "Give it in metres, and the board with --board or --charuco."
        raise InputError("the side of a square is not given", "--square", remedy)
    if (args.board is None) == (args.charuco is None):
        remedy = "Use either --board 9x6 (inner corners) or --charuco 5x7:4X4_50:0.018."
        raise InputError("name one board", "--board", remedy)
    if args.board is not None:
        return chessboard(args.board, args.square)
    return charuco(args.charuco, args.square)


def found_board(args: Namespace, sources: Sequence[pictures.Pictures], count: int) -> Search:
    """The board looked for in the first `count` pictures of all cameras, with a progress bar."""
    named = board_of(args)
    try:
        with watched("Searching", NOTHING) as work:
            return search(sources, named, range(0, count, args.every), work)
    finally:
        for source in sources:
            source.close()


def put_calibration(
    facts: dict[str, Any],
    tables: Sequence[Table | None],
    left_out: Sequence[pictures.LeftOut],
    findings: Sequence[Finding],
    *,
    as_json: bool,
) -> None:
    """Write the result of a calibration to standard output."""
    told = (*tables, report.left_out_table(left_out), report.finding_table(findings))
    put_result({**facts, "remarks": [vars(one) for one in findings]}, *told, as_json=as_json)


def put_world(
    args: Namespace, sources: Sequence[pictures.Pictures], *, as_pair: bool = False
) -> int:
    """Search for the board, calibrate the cameras together, write and print the result."""
    given = {} if args.lenses is None else read_calibration(args.lenses)
    found = found_board(args, sources, pictures.check_same_length(sources))
    found.check_not_mirrored()
    if as_pair:
        _check_pairs(found)
    with stoppable(NOTHING, at_once=True):
        world = calibrate_world(found.sightings, found.board, model=args.model, given=given)
    facts, tables = _pair_told(world) if as_pair else ({}, [])
    write_calibration(args.output, {camera.name: camera for camera in world.cameras})
    put_calibration(
        {"calibration": args.output, **facts, **report.world_facts(world)},
        [*report.world_tables(world), *tables],
        [out for one in world.sightings for out in one.left_out],
        [*found.findings, *world.findings, _NOT_ALIGNED],
        as_json=args.json,
    )
    return OK


@options.command(
    options.option(
        "--images GLOB",
        "pictures of the board: a pattern in quotes, a folder, or one video",
        required=True,
    ),
    *BOARD,
    options.output("FILE.toml", "calibration to write", ".toml"),
    options.option("--camera NAME", "name of the camera (default: camera)", default="camera"),
    MODEL,
    EVERY,
)
def calibrate_lens(args: Namespace) -> int:
    """Calibrate the lens of one camera from pictures of a board in 15 to 30 positions. The
    camera is placed at the origin; `stereotrack calibrate world` places several cameras in
    one world.
    """
    check_model(args.model)
    board_of(args)
    source = pictures.pictures_of_glob(args.images, args.camera, "--images")
    found = found_board(args, [source], source.count())
    with stoppable(NOTHING, at_once=True):
        lens = calibrate_intrinsics(found.sightings[0], found.board, model=args.model)
    write_calibration(args.output, {lens.camera.name: lens.camera})
    facts = {"calibration": args.output, "board": found.board, **report.lens_facts(lens)}
    tables = [report.lens_table([lens]), report.candidate_table(lens)]
    findings = [*found.findings, *lens.findings]
    put_calibration(facts, tables, lens.sightings.left_out, findings, as_json=args.json)
    return OK


@options.command(
    options.option(
        "--left GLOB",
        "pictures of the left camera: a pattern in quotes, a folder, or one video",
        required=True,
    ),
    options.option("--right GLOB", "those of the right camera, in the same order", required=True),
    *BOARD,
    options.output("FILE.toml", "calibration to write", ".toml"),
    options.option(
        "--view NAME",
        "name of the view; its cameras are NAME_left and NAME_right (default: N)",
        default="N",
    ),
    LENSES,
    MODEL,
    EVERY,
)
def calibrate_pair(args: Namespace) -> int:
    """Calibrate a stereo camera from pairs of pictures of a board. The world is that of the
    left camera, taken as level and looking south; `stereotrack calibrate align` turns it.
    """
    check_model(args.model)
    board_of(args)
    sides = (("left", args.left), ("right", args.right))
    sources = [pictures.pictures_of_glob(one, f"{args.view}_{s}", f"--{s}") for s, one in sides]
    return put_world(args, sources, as_pair=True)


def _check_pairs(found: Search) -> None:
    if not set(found.sightings[0].frames) & set(found.sightings[1].frames):
        what = "no pair of pictures shows the board in both images"
        order = "check that the pictures of both are in the same order"
        remedy = f"Film again with the board where both cameras see it whole, and {order}."
        raise InputError(what, "--left and --right", remedy)


def _pair_told(world: World) -> tuple[dict[str, Any], list[Table]]:
    (left, right), (of_left, of_right) = world.cameras, world.sightings
    pair = pair_of(left, right, of_left, of_right)
    rows = [
        ("base line", f"{1000 * pair.baseline_m:.2f} mm"),
        ("angle between the axes", f"{pair.convergence_deg:.2f}°"),
        ("difference of rows, rectified", f"{number(pair.row_error_px, 3)} px"),
    ]
    return {"pair": pair}, [Table("Stereo camera", ("what", ">value"), rows)]


@options.command(
    options.path(
        "folder FOLDER",
        "a recording, or a folder with one video or folder of images per camera, named as the "
        "camera; frame k of all is the same instant",
    ),
    *BOARD,
    options.output("FILE.toml", "calibration to write", ".toml"),
    LENSES,
    MODEL,
    EVERY,
)
def calibrate_rig(args: Namespace) -> int:
    """Calibrate all cameras of a folder and place them in one world. The board is carried
    through the space so that every camera sees it together with another one. The world is
    that of the first camera, taken as level and looking south; `stereotrack calibrate align`
    turns it.
    """
    check_model(args.model)
    board_of(args)
    return put_world(args, [one.open() for one in sources_in(args.folder)])


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
def import_calibration(args: Namespace) -> int:
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
        raise InputError(f"{given!r} is not an image size", "--size", "Write e.g. 1280x720.")
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
    rows = []
    for camera in decided.cameras.values():
        size, focal = f"{camera.width} x {camera.height}", f"{camera.focal:.0f} px"
        place = " ".join(f"{value:.3f}" for value in camera.position_world)
        rows.append((camera.name, size, focal, place))
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
def export_calibration(args: Namespace) -> int:
    """Write a calibration for another tool. What this program reads again is the same; tools
    that know fewer distortion coefficients or no names may lose some of it.
    """
    opencv = args.output.suffix.lower() in _OPENCV
    form = args.format or ("opencv" if opencv else "aniposelib")
    options.check_suffix(args.output, *(_OPENCV if form == "opencv" else (".toml",)))
    if args.output.resolve() == args.calibration.resolve():
        what = "this is the calibration that is read"
        raise InputError(what, args.output, "Choose another name.")
    cameras = read_calibration(args.calibration)
    write_foreign(args.output, list(cameras.values()), form, args.units)
    facts = {"format": form, "units": args.units, "cameras": list(cameras)}
    title = f"{args.calibration} to {args.output}"
    put_facts(facts, title, as_json=args.json, file=args.output)
    return OK

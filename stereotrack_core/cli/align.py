"""``stereotrack calibrate align``: z up, y north and the origin on the floor."""

from argparse import Namespace
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.calibrate import align
from stereotrack_core.calibrate.pictures import check_same_length
from stereotrack_core.calibrate.work import sources_in
from stereotrack_core.calibrate.world_checks import seen_board
from stereotrack_core.cli import options
from stereotrack_core.cli.calibrate import BOARD, board_of, found_board
from stereotrack_core.cli.output import OK, put_result, say
from stereotrack_core.cli.sources import recording_in, say_notes, stated_for
from stereotrack_core.depth.floor import alignment_to_floor
from stereotrack_core.errors import InputError, did_you_mean
from stereotrack_core.interop.landmark_file import Stated
from stereotrack_core.interop.run_file import read_trajectory
from stereotrack_core.recording.calibration import read_calibration, write_calibration
from stereotrack_core.recording.description import Cameras
from stereotrack_core.recording.selection import frames_within
from stereotrack_core.tables import Table, finite_number, number, read_rows
from stereotrack_core.tracking.presets import preset

_SOURCES = ("floor", "board_on_floor", "points", "person")
_WRONG_SCALE = 0.02


@options.command(
    options.path("calibration CALIBRATION", "calibration to turn"),
    options.output("FILE.toml", "calibration to write", ".toml"),
    options.path(
        "--floor RECORDING",
        "recording whose stereo or depth views see the floor; the largest plane below the "
        "cameras is taken",
    ),
    options.option("--frame N", "frame for --floor (default: 0)", type=int, default=0),
    options.path(
        "--board-on-floor FOLDER",
        "one folder of images or video per camera, named as the camera, in which the board "
        "lies on the floor; its upper side points north, its middle is the origin",
    ),
    *BOARD,
    options.path(
        "--points CSV",
        f"clicks point,camera,x,y of three points of the floor: {', '.join(align.POINTS)} (any "
        "third), each in two cameras or more",
    ),
    options.path(
        "--person FILE",
        "landmarks or run in the calibration's world, of a person who stands facing north",
    ),
    *options.STATED,
    options.FRAMES,
    options.option(
        "--north CAMERA", "camera that stands in the north, for --floor (default: the first)"
    ),
)
def run(args: Namespace) -> int:
    """Turn a calibration so that z is up, y is north and the origin is on the floor. Choose
    one of --floor, --board-on-floor, --points and --person.
    """
    chosen = [name for name in _SOURCES if getattr(args, name) is not None]
    if len(chosen) != 1:
        what = "choose one way to align" if chosen else "nothing says where up is"
        remedy = "Use one of --floor, --board-on-floor, --points and --person."
        raise InputError(what, "stereotrack calibrate align", remedy)
    cameras = read_calibration(args.calibration)
    facts: dict[str, Any] = {}
    if chosen[0] == "floor":
        if args.north and args.north not in cameras:
            remedy = f"{did_you_mean(args.north, cameras)}The cameras are {', '.join(cameras)}."
            raise InputError(f"there is no camera {args.north!r}", "--north", remedy)
        depth, where = preset("accurate", []).depth, str(args.calibration)
        found = alignment_to_floor(args.floor, cameras, depth, args.frame, args.north or "", where)
    elif chosen[0] == "board_on_floor":
        found, facts = _of_board(args, cameras)
    elif chosen[0] == "points":
        found = _of_points(args.points, cameras)
    else:
        found = _of_person(args)
    turned = align.aligned(cameras, found.new_from_old)
    write_calibration(args.output, turned)
    _put(args, found, facts, turned)
    return OK


def _of_board(args: Namespace, cameras: Cameras) -> tuple[align.Alignment, dict[str, Any]]:
    board_of(args)
    sources = [one.open() for one in sources_in(args.board_on_floor) if one.camera in cameras]
    args.every = 1
    found = found_board(args, sources, check_same_length(sources))
    found.check_not_mirrored()
    seen = seen_board(cameras, found.sightings, found.board)
    if np.isfinite(seen.scale.ratio) and abs(seen.scale.ratio - 1) > _WRONG_SCALE:
        off = f"{100 * (seen.scale.ratio - 1):+z.1f} % longer than given"
        say(f"Squares measured with this calibration are {off}: its lengths or --square are wrong.")
    facts = {"rms_px": seen.rms_px, "scale": seen.scale, "seen_by": seen.cameras}
    return align.from_board(seen.world_from_board, found.board.corners), facts


def _of_points(path: Path, cameras: Cameras) -> align.Alignment:
    clicks: dict[str, dict[str, FloatArray]] = {}
    for line, cells in read_rows(path, ("point", "camera", "x", "y")):
        where = f"{path}, line {line}"
        for column, known in (("point", align.POINTS), ("camera", tuple(cameras))):
            if cells[column] not in known:
                what = f"unknown {column} {cells[column]!r}"
                raise InputError(what, where, f"Use one of {', '.join(known)}.")
        pixel = [finite_number(cells[axis], path, line, axis) for axis in "xy"]
        clicks.setdefault(cells["point"], {})[cells["camera"]] = np.array(pixel)
    return align.from_clicks(cameras, clicks)


def _of_person(args: Namespace) -> align.Alignment:
    stated = stated_for(args, args.person).get(args.person, Stated())
    trajectory = read_trajectory(args.person, replace(stated, tilted=True))
    if (recording := recording_in(args.calibration.parent)) is not None:
        trajectory = trajectory.at_rate(recording.fps, str(args.person))
    say_notes(trajectory.notes)
    frames = frames_within(args.frames, int(trajectory.frame.max(initial=-1)) + 1)
    chosen = np.isin(trajectory.frame, np.arange(frames.start, frames.stop))
    return align.from_person(trajectory.points[chosen])


def _put(args: Namespace, found: align.Alignment, facts: dict[str, Any], cameras: Cameras) -> None:
    places = {name: camera.position_world for name, camera in cameras.items()}
    rows = [
        ("up from", found.source),
        ("points or frames used", str(found.points)),
        ("their spread along z", f"{number(1000 * found.spread_m)} mm"),
        ("z turned by", f"{found.tilt_deg:.1f}°"),
    ]
    texts = {name: " ".join(f"{one:.3f}" for one in place) for name, place in places.items()}
    rows += [(f"place of {name}", f"{text} m") for name, text in texts.items()]
    table = Table(f"Calibration written to {args.output}", ("what", ">value"), rows)
    told = {"calibration": args.output, **vars(found), "tilt_deg": found.tilt_deg, **facts}
    told |= {"new_from_old": found.new_from_old.matrix(), "positions_m": places}
    put_result(told, table, as_json=args.json)

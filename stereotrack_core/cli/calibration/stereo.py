"""``stereotrack calibrate stereo``: a pair of cameras side by side."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path

from stereotrack_core.calibrate.pictures import check_same_length, pictures_of_glob
from stereotrack_core.calibrate.report import world_facts, world_tables
from stereotrack_core.calibrate.stereo import Pair, pair_of
from stereotrack_core.calibrate.world import calibrate_world
from stereotrack_core.cli.arguments import JSON, option
from stereotrack_core.cli.calibration.boards import (
    BOARD,
    EVERY,
    LENSES,
    MODEL,
    NOT_ALIGNED,
    NOTHING,
    calibrating,
    found_board,
    given_lenses,
    put_calibration,
)
from stereotrack_core.cli.output import OK
from stereotrack_core.cli.progress import stoppable
from stereotrack_core.errors import InputError
from stereotrack_core.recording.calibration import write_calibration
from stereotrack_core.tables import Table, number

DESCRIPTION = (
    "Calibrate a stereo camera from pairs of pictures of a board. The world is that of the left "
    "camera, taken as level and looking south; `stereotrack calibrate align` turns it."
)

OPTIONS = (
    option(
        "--left GLOB",
        "pictures of the left camera: a pattern in quotes, a folder, or one video",
        required=True,
    ),
    option("--right GLOB", "those of the right camera, in the same order", required=True),
    *BOARD,
    option("-o --output FILE.toml", "calibration to write", type=Path, required=True),
    option(
        "--view NAME",
        "name of the view; its cameras are NAME_left and NAME_right (default: N)",
        default="N",
    ),
    LENSES,
    MODEL,
    EVERY,
    JSON,
)


def run(args: Namespace) -> int:
    """Search for the board, calibrate, write."""
    with calibrating(args):
        _calibrate(args)
    return OK


def _calibrate(args: Namespace) -> None:
    given = given_lenses(args.lenses)
    sources = [
        pictures_of_glob(pattern, f"{args.view}_{side}", f"--{side}")
        for side, pattern in (("left", args.left), ("right", args.right))
    ]
    found = found_board(args, sources, check_same_length(sources))
    found.check_not_mirrored()
    if not set(found.sightings[0].frames) & set(found.sightings[1].frames):
        raise InputError(
            "no pair of pictures shows the board in both images",
            where="--left and --right",
            remedy="Film again with the board where both cameras see it whole, and check that the "
            "pictures of both are in the same order.",
        )
    with stoppable(NOTHING) as stop:
        world = calibrate_world(
            found.sightings, found.board, model=args.model, given=given, stop=stop
        )
    (left, right), (of_left, of_right) = world.cameras, world.sightings
    pair = pair_of(left, right, of_left, of_right)
    write_calibration(args.output, {camera.name: camera for camera in world.cameras})
    put_calibration(
        {"calibration": args.output, "pair": pair, **world_facts(world)},
        [*world_tables(world), _table(pair)],
        [out for one in world.sightings for out in one.left_out],
        [*found.findings, *world.findings, NOT_ALIGNED],
        as_json=args.json,
    )


def _table(pair: Pair) -> Table:
    rows = [
        ("base line", f"{1000 * pair.baseline_m:.2f} mm"),
        ("angle between the axes", f"{pair.convergence_deg:.2f}°"),
        ("difference of rows, rectified", f"{number(pair.row_error_px, 3)} px"),
    ]
    return Table("Stereo camera", ("what", ">value"), rows)

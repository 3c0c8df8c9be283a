"""``stereotrack calibrate world``: all cameras in one frame."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path

from stereotrack_core.calibrate.pictures import check_same_length, pictures_of_folder
from stereotrack_core.calibrate.report import world_facts, world_tables
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
from stereotrack_core.recording.calibration import write_calibration

DESCRIPTION = (
    "Calibrate all cameras of a folder and place them in one world. The board is carried through "
    "the space so that every camera sees it together with another one. The world is that of the "
    "first camera, taken as level and looking south; `stereotrack calibrate align` turns it."
)

OPTIONS = (
    option(
        "folder FOLDER",
        "a recording, or a folder with one video or folder of images per camera, named as the "
        "camera; frame k of all is the same instant",
        type=Path,
    ),
    *BOARD,
    option("-o --output FILE.toml", "calibration to write", type=Path, required=True),
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
    sources = pictures_of_folder(args.folder)
    found = found_board(args, sources, check_same_length(sources))
    found.check_not_mirrored()
    with stoppable(NOTHING) as stop:
        world = calibrate_world(
            found.sightings, found.board, model=args.model, given=given, stop=stop
        )
    write_calibration(args.output, {camera.name: camera for camera in world.cameras})
    put_calibration(
        {"calibration": args.output, **world_facts(world)},
        world_tables(world),
        [out for one in world.sightings for out in one.left_out],
        [*found.findings, *world.findings, NOT_ALIGNED],
        as_json=args.json,
    )

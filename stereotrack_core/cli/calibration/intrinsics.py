"""``stereotrack calibrate intrinsics``: the lens of one camera."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path

from stereotrack_core.calibrate.intrinsics import calibrate_intrinsics
from stereotrack_core.calibrate.pictures import pictures_of_glob
from stereotrack_core.calibrate.report import candidate_table, lens_facts, lens_table
from stereotrack_core.cli.arguments import JSON, option
from stereotrack_core.cli.calibration.boards import (
    BOARD,
    EVERY,
    MODEL,
    NOTHING,
    calibrating,
    found_board,
    put_calibration,
)
from stereotrack_core.cli.output import OK
from stereotrack_core.cli.progress import stoppable
from stereotrack_core.recording.calibration import write_calibration

DESCRIPTION = (
    "Calibrate the lens of one camera from pictures of a board in 15 to 30 positions. The camera "
    "is placed at the origin; `stereotrack calibrate world` places several cameras in one world."
)

OPTIONS = (
    option(
        "--images GLOB",
        "pictures of the board: a pattern in quotes, a folder, or one video",
        required=True,
    ),
    *BOARD,
    option("-o --output FILE.toml", "calibration to write", type=Path, required=True),
    option("--camera NAME", "name of the camera (default: camera)", default="camera"),
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
    source = pictures_of_glob(args.images, args.camera, "--images")
    found = found_board(args, [source], source.count())
    with stoppable(NOTHING) as stop:
        lens = calibrate_intrinsics(found.sightings[0], found.board, model=args.model, stop=stop)
    write_calibration(args.output, {lens.camera.name: lens.camera})
    facts = {"calibration": args.output, "board": found.board, **lens_facts(lens)}
    put_calibration(
        facts,
        [lens_table([lens]), candidate_table(lens)],
        lens.sightings.left_out,
        [*found.findings, *lens.findings],
        as_json=args.json,
    )

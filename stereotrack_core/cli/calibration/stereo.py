"""``stereotrack calibrate stereo``: a pair of cameras side by side."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path
from typing import Any

from stereotrack_core.calibrate.pictures import pictures_of_glob
from stereotrack_core.calibrate.search import Search
from stereotrack_core.calibrate.stereo import pair_of
from stereotrack_core.calibrate.world import World
from stereotrack_core.cli.arguments import JSON, option
from stereotrack_core.cli.calibration.boards import (
    BOARD,
    EVERY,
    LENSES,
    MODEL,
    calibrating,
    put_world,
)
from stereotrack_core.cli.output import OK
from stereotrack_core.errors import InputError
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
        sources = [
            pictures_of_glob(pattern, f"{args.view}_{side}", f"--{side}")
            for side, pattern in (("left", args.left), ("right", args.right))
        ]
        put_world(args, sources, _check_pairs, _pair_told)
    return OK


def _check_pairs(found: Search) -> None:
    if not set(found.sightings[0].frames) & set(found.sightings[1].frames):
        raise InputError(
            "no pair of pictures shows the board in both images",
            where="--left and --right",
            remedy="Film again with the board where both cameras see it whole, and check that the "
            "pictures of both are in the same order.",
        )


def _pair_told(world: World) -> tuple[dict[str, Any], list[Table]]:
    """Facts of a stereo pair besides its cameras."""
    (left, right), (of_left, of_right) = world.cameras, world.sightings
    pair = pair_of(left, right, of_left, of_right)
    rows = [
        ("base line", f"{1000 * pair.baseline_m:.2f} mm"),
        ("angle between the axes", f"{pair.convergence_deg:.2f}°"),
        ("difference of rows, rectified", f"{number(pair.row_error_px, 3)} px"),
    ]
    return {"pair": pair}, [Table("Stereo camera", ("what", ">value"), rows)]

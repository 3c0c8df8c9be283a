"""``stereotrack calibrate world``: all cameras in one frame."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path

from stereotrack_core.calibrate.pictures import pictures_of_folder
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
        put_world(args, pictures_of_folder(args.folder))
    return OK

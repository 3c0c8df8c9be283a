"""``stereotrack open``: declared here for the help; the window's own package does it."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path

from stereotrack_core.cli.command import Command
from stereotrack_core.errors import InputError


def add_arguments(parser: ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("path", type=Path, metavar="PATH", help="recording folder or project file")
    parser.add_argument(
        "--workspace",
        metavar="NAME",
        help="annotate, track, review, tune or calibrate (default: as it was left)",
    )
    parser.add_argument(
        "--frame",
        type=int,
        default=0,
        metavar="N",
        help="frame to start at, from 0 (default: as it was left)",
    )
    parser.add_argument(
        "--screenshot",
        type=Path,
        metavar="PNG",
        help="save the window as a picture and leave; works without a screen",
    )


def run(args: Namespace) -> int:
    """Say that the window is elsewhere."""
    raise InputError(
        f"{args.path} opens in the workbench, which is not started from here",
        remedy="Start it with the program `stereotrack`.",
    )


COMMAND = Command(
    name="open",
    summary="the workbench on a recording folder or project file",
    description="Open the workbench on a recording folder or a project file.",
    add_arguments=add_arguments,
    run=run,
)

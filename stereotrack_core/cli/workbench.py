"""``stereotrack open``: the window on a recording folder or a project file."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path

from stereotrack_core.cli.command import FAILED, OK, Command
from stereotrack_core.cli.output import say
from stereotrack_core.errors import InputError
from stereotrack_core.window import Opening, Window


def add_arguments(parser: ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("path", type=Path, metavar="PATH", help="recording folder or project file")
    parser.add_argument(
        "--workspace",
        metavar="NAME",
        help="annotate, track, review, tune or calibrate (default: the last one used)",
    )
    parser.add_argument(
        "--frame",
        type=int,
        default=0,
        metavar="N",
        help="frame to start at, counted from 0 (default: the last one shown)",
    )
    parser.add_argument(
        "--screenshot",
        type=Path,
        metavar="PNG",
        help="save a screenshot of the window and exit; works without a display",
    )


def run(args: Namespace) -> int:
    """Show the window."""
    opening = Opening(args.path, args.frame, args.workspace, picture=args.screenshot)
    return show_window(args.window, opening)


def show_window(window: Window | None, opening: Opening) -> int:
    """Show the window; return the exit status.

    Raises
    ------
    InputError
        Where the program was started without one.
    """
    if window is None:
        raise InputError(
            "the workbench cannot be started here",
            remedy="Start it with the program `stereotrack`.",
        )
    return OK if window.show(opening, say) else FAILED


COMMAND = Command(
    name="open",
    summary="open the workbench on a recording folder or project file",
    description="Open the workbench on a recording folder or a project file.",
    add_arguments=add_arguments,
    run=run,
)

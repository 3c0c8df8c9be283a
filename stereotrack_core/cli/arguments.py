"""Arguments that several commands share, and what they mean for a recording."""

from __future__ import annotations

import os
import tempfile
from argparse import ArgumentParser
from pathlib import Path
from typing import TYPE_CHECKING

from stereotrack_core.errors import InputError

if TYPE_CHECKING:
    from stereotrack_core.recording.description import Recording


def add_recording(parser: ArgumentParser) -> None:
    """Add the folder to work on."""
    parser.add_argument(
        "recording", type=Path, metavar="RECORDING", help="folder that contains recording.toml"
    )


def add_json(parser: ArgumentParser) -> None:
    """Add the choice between a table and JSON."""
    parser.add_argument("--json", action="store_true", help="print the result as JSON")


def add_settings(parser: ArgumentParser) -> None:
    """Add the preset and changes to it."""
    parser.add_argument(
        "--preset",
        default="accurate",
        metavar="accurate|thesis|fast|FILE.toml",
        help="preset that the parameters come from (default: accurate), or a file with your own "
        "preset as saved by the workbench",
    )
    add_changes(parser, "change one parameter")


def add_changes(parser: ArgumentParser, what: str) -> None:
    """Add changes of parameters; `what` begins the help."""
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        dest="changes",
        help=f"{what}; may be given several times",
    )


def add_frames(parser: ArgumentParser) -> None:
    """Add the stretch of frames."""
    parser.add_argument(
        "--frames",
        metavar="A:B",
        help="only frames A up to but not including B; either may be omitted",
    )


def add_segments(parser: ArgumentParser) -> None:
    """Add the choice of named stretches."""
    parser.add_argument(
        "--segments",
        action="store_true",
        help="also print the results for each segment of segments.csv",
    )


def add_views(parser: ArgumentParser) -> None:
    """Add the choice of views."""
    parser.add_argument(
        "--views",
        metavar="NS or cam_0+cam_2",
        help="use only these views; join names with +; single-letter names may be written together",
    )


def check_seed(seed: int | None) -> None:
    """Refuse a seed that no random numbers begin with.

    Raises
    ------
    InputError
        For a negative one.
    """
    if seed is not None and seed < 0:
        raise InputError("a seed must not be negative", where="--seed", remedy="Give 0 or more.")


def check_output(path: Path, recording: Recording | None = None) -> Path:
    """Refuse at once what could not be written after long work.

    Raises
    ------
    InputError
        Where the folder does not exist, or is the recording's own, which is never written to.
    """
    if not path.parent.is_dir():
        raise InputError(
            "there is no such folder",
            where=str(path.parent),
            remedy="Create it, or choose another folder.",
        )
    if path.is_dir():
        raise InputError(
            "this is a folder", where=str(path), remedy="Give the name of a file in it."
        )
    place = Path(os.path.realpath(path))  # which knows links that lead in a circle
    if recording is not None and place.is_relative_to(recording.folder.resolve()):
        raise InputError(
            "this is inside the recording folder, which is never written to",
            where=str(path),
            remedy="Choose a place outside the recording folder.",
        )
    try:
        tempfile.TemporaryFile(dir=path.parent).close()
    except OSError as error:
        raise InputError(
            f"cannot write to this folder ({error.strerror})",
            where=str(path.parent),
            remedy="Choose a folder that you may write to.",
        ) from None
    return path

"""Arguments that several commands share, and what they mean for a recording."""

from __future__ import annotations

import dataclasses
import os
import tempfile
from argparse import ArgumentParser
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from stereotrack_core.errors import InputError

if TYPE_CHECKING:
    from stereotrack_core.recording.description import Recording
    from stereotrack_core.tracking.settings import Settings


def add_recording(parser: ArgumentParser) -> None:
    """Add the folder to work on."""
    parser.add_argument(
        "recording", type=Path, metavar="RECORDING", help="folder that holds recording.toml"
    )


def recordings_of(folders: Sequence[Path]) -> list[Recording]:
    """Recordings of several folders, with names that tell them apart.

    Raises
    ------
    InputError
        For a folder that is no recording, or is given twice.
    """
    from stereotrack_core.recording.folder import open_recording

    recordings = [open_recording(folder) for folder in folders]
    if len({recording.folder.resolve() for recording in recordings}) < len(recordings):
        raise InputError(
            "a recording is given twice", where="RECORDING", remedy="Give each one once."
        )
    names = [recording.name for recording in recordings]
    return [
        recording
        if names.count(recording.name) == 1
        else dataclasses.replace(recording, name=str(recording.folder))
        for recording in recordings
    ]


def add_json(parser: ArgumentParser) -> None:
    """Add the choice between a table and JSON."""
    parser.add_argument("--json", action="store_true", help="print the result as JSON")


def add_settings(parser: ArgumentParser) -> None:
    """Add the preset and changes to it."""
    parser.add_argument(
        "--preset",
        default="accurate",
        metavar="accurate|thesis|fast|FILE.toml",
        help="where all parameters come from (default: accurate); a file holds a preset of your "
        "own, as the workbench saves it",
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


def settings_of(preset_name: str, changes: list[str]) -> Settings:
    """Settings of ``--preset`` with the changes of ``--set``."""
    from stereotrack_core.parameters import parsed_settings
    from stereotrack_core.tracking.presets import preset

    return preset(preset_name).replaced(**parsed_settings(changes))


def add_frames(parser: ArgumentParser) -> None:
    """Add the stretch of frames."""
    parser.add_argument(
        "--frames",
        metavar="A:B",
        help="only the frames from A up to, not including, B; either may be left out",
    )


def add_segments(parser: ArgumentParser) -> None:
    """Add the choice of named stretches."""
    parser.add_argument(
        "--segments", action="store_true", help="also for each stretch of segments.csv"
    )


def frame_bounds(text: str, option: str = "--frames") -> tuple[int | None, int | None]:
    """First frame and end of ``A:B`` as given to an option; None where left out.

    Raises
    ------
    InputError
        Where the text cannot be read, or the end does not come after the first frame.
    """
    first, sign, end = text.partition(":")
    try:
        if not sign:
            raise ValueError
        bounds = (int(first) if first.strip() else None, int(end) if end.strip() else None)
    except ValueError:
        raise InputError(
            f"{text!r} cannot be read", where=option, remedy="Write A:B, for example 10:60."
        ) from None
    start = bounds[0] or 0
    if start < 0 or (bounds[1] is not None and bounds[1] <= start):
        raise InputError(
            f"{text!r} holds no frame",
            where=option,
            remedy="Count from 0, and let the end come after the first frame.",
        )
    return bounds


def frames_within(text: str | None, count: int) -> range:
    """Frames that ``--frames`` names out of a recording's `count`.

    Raises
    ------
    InputError
        For frames that the recording does not have.
    """
    if not count:
        raise InputError("the recording has no frames", remedy="See `stereotrack info`.")
    if text is None:
        return range(count)
    first, end = frame_bounds(text)
    chosen = range(first or 0, count if end is None else end)
    if chosen.stop > count or chosen.start >= count:
        raise InputError(
            f"{text!r} goes beyond the end",
            where="--frames",
            remedy=f"The recording has the frames 0:{count}.",
        )
    return chosen


def add_views(parser: ArgumentParser) -> None:
    """Add the choice of views."""
    parser.add_argument(
        "--views",
        metavar="NS or cam_0+cam_2",
        help="only these views; names are joined by +, names of one letter may be run together",
    )


def views_of(recording: Recording, text: str | None) -> tuple[str, ...] | None:
    """View names that ``--views`` asks for; None for all.

    Raises
    ------
    InputError
        For a view that the recording does not have.
    """
    if text is None:
        return None
    known = [view.name for view in recording.views]
    if text in known:
        return (text,)
    joined = "+" in text or not all(letter in known for letter in text)
    names = [name.strip() for name in text.split("+")] if joined else list(text)
    unknown = [name for name in names if name not in known]
    if unknown or not names:
        raise InputError(
            f"there is no view {(unknown or [text])[0]!r}",
            where="--views",
            remedy=f"The recording has: {', '.join(known)}.",
        )
    return tuple(dict.fromkeys(names))


def check_seed(seed: int | None) -> None:
    """Refuse a seed that no random numbers begin with.

    Raises
    ------
    InputError
        For a negative one.
    """
    if seed is not None and seed < 0:
        raise InputError("a seed is not negative", where="--seed", remedy="Give 0 or more.")


def seeds_of(text: str) -> list[int]:
    """Seeds that ``--seeds`` names.

    Raises
    ------
    InputError
        For anything but different whole numbers from 0.
    """
    try:
        seeds = [int(part) for part in text.split(",")]
    except ValueError:
        seeds = []
    if not seeds or min(seeds) < 0 or len(set(seeds)) < len(seeds):
        raise InputError(
            f"{text!r} is no list of seeds",
            where="--seeds",
            remedy="Give different whole numbers from 0, for example 0,1,2.",
        )
    return seeds


def check_output(path: Path, recording: Recording | None = None) -> Path:
    """Refuse at once what could not be written after long work.

    Raises
    ------
    InputError
        Where the folder does not exist, or is the recording's own, which is never written to.
    """
    if not path.parent.is_dir():
        raise InputError(
            "there is no such folder", where=str(path.parent), remedy="Make it, or name another."
        )
    if path.is_dir():
        raise InputError("this is a folder", where=str(path), remedy="Name a file in it.")
    place = Path(os.path.realpath(path))  # which knows links that lead in a circle
    if recording is not None and place.is_relative_to(recording.folder.resolve()):
        raise InputError(
            "this is inside the recording, which is never written to",
            where=str(path),
            remedy="Choose a place outside the recording's folder.",
        )
    try:
        tempfile.TemporaryFile(dir=path.parent).close()
    except OSError as error:
        raise InputError(
            f"nothing can be written to this folder ({error.strerror})",
            where=str(path.parent),
            remedy="Choose a folder that you may write to.",
        ) from None
    return path

"""``stereotrack import recording``: a recording folder from videos and images."""

from __future__ import annotations

import math
from argparse import Namespace
from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from stereotrack_core.cli.arguments import JSON, flag, option
from stereotrack_core.cli.output import OK, put_result, say
from stereotrack_core.cli.progress import watched
from stereotrack_core.errors import InputError, did_you_mean
from stereotrack_core.recording.importing.choices import (
    ROLES,
    Choices,
    Use,
    doubts_about,
    guessed_unit,
    problems_of,
    propose,
    view_for,
)
from stereotrack_core.recording.importing.making import make_recording
from stereotrack_core.recording.importing.sources import look_at
from stereotrack_core.recording.importing.synchronise import METHODS, Lead, synchronised
from stereotrack_core.tables import Table

DESCRIPTION = (
    "Make a recording folder from videos, side-by-side stereo videos, folders of images or folders "
    "of depth maps. What they show is proposed from their names and sizes: left and right, cam0 "
    "and cam1, an image twice as wide as usual. Files that lie in the new folder already stay "
    "where they are; others are copied. Nothing is overwritten."
)

OPTIONS = (
    option(
        "sources VIDEOS|FOLDER", "videos, images, or a folder that holds them", type=Path, nargs="+"
    ),
    option(
        "-o --output DIR",
        "the new recording folder, or the folder of the videos itself (default: that folder)",
        type=Path,
    ),
    option("--title NAME", "name of the recording (default: that of the folder)"),
    option("--fps N", "frames per second, if the files do not state them or state them wrongly",
           type=float),
    option("--calibration FILE", "calibration.toml of the cameras; without one they are guessed",
           type=Path),
    option("--camera OURS=THEIRS", "name of a camera in the calibration, where it differs; may be "
           "given several times", action="append", default=[], dest="cameras"),
    option("--as SOURCE=ROLE[:VIEW]", "what a source shows, and of which view; may be given "
           "several times. Roles: " + ", ".join(ROLES), action="append", default=[], dest="roles"),
    option("--mirrored SOURCE", "turn back the mirror images of a source, such as a Kinect v1's; "
           "may be given several times", action="append", default=[]),
    option("--unit METRES", "metres per count of depth maps (default: by the depth of the scene)",
           type=float, dest="unit"),
    option("--synchronise METHOD", "find the frames of the same instant: start (times stated by "
           "the files or a timestamps.csv), flash, clap, or motion (default: frame 0 of all)",
           choices=tuple(METHODS), dest="method"),
    option("--first SOURCE=FRAME", "own frame of a source at the common instant, with fractions if "
           "need be; may be given several times", action="append", default=[], dest="firsts"),
    flag("--dry-run", "only print what would be made"),
    JSON,
)  # fmt: skip


def run(args: Namespace) -> int:
    """Look, decide, make."""
    found = look_at(args.sources)
    for problem in found.problems:
        say(f"not used: {problem}")
    folder = args.output or found.folder
    if folder is None:
        raise InputError(
            "the sources lie in several folders",
            remedy="Say where the recording is to be made, with -o DIR.",
        )
    choices = replace(propose(found), name=args.title or folder.resolve().name)
    choices = _decided(choices, args)
    for problem in problems_of(choices):
        raise problem
    choices, leads = _in_time(choices, args)
    for doubt in doubts_about(choices):
        say(f"note: {doubt}")
    if not args.dry_run:
        with watched("Making the recording", "No recording was created.") as (show, stopped):
            make_recording(choices, folder, on_progress=show, cancelled=stopped)
    what = "Would be made" if args.dry_run else "Recording written to"
    facts = {**_facts(choices, folder), "synchronised": [asdict(lead) for lead in leads]}
    put_result(facts, _table(choices, f"{what} {folder}"), as_json=args.json)
    return OK


def _decided(choices: Choices, args: Namespace) -> Choices:
    """The proposal with everything that the options say."""
    roles = dict(_pair(text, "--as") for text in args.roles)
    uses = tuple(_used(use, roles, args.mirrored) for use in choices.uses)
    names = [use.source.name for use in uses]
    for option_name, asked in (("--as", roles), ("--mirrored", args.mirrored)):
        _check_known(asked, names, option_name)
    choices = replace(choices, uses=uses, fps=args.fps or choices.fps)
    if args.calibration is not None:
        choices = replace(choices, calibration=args.calibration)
    if args.cameras:
        cameras = dict(_pair(text, "--camera") for text in args.cameras)
        _check_known(cameras, choices.camera_names(), "--camera")
        choices = replace(choices, cameras=cameras)
    return replace(choices, depth_unit=_unit(choices, args.unit))


def _in_time(choices: Choices, args: Namespace) -> tuple[Choices, tuple[Lead, ...]]:
    """The choices with the frames of the same instant, and how these were found."""
    leads: tuple[Lead, ...] = ()
    if args.method is not None:
        with watched("Synchronising", "No recording was created.") as (show, stopped):
            choices, leads = synchronised(choices, args.method, on_progress=show, cancelled=stopped)
        for lead in leads:
            say(f"synchronised by {args.method}: {lead.says(choices.fps or 1.0)}")
    firsts = dict(_pair(text, "--first") for text in args.firsts)
    _check_known(firsts, [use.source.name for use in choices.uses], "--first")
    given = {name: _frame(text) for name, text in firsts.items()}
    uses = tuple(replace(use, lead=given.get(use.source.name, use.lead)) for use in choices.uses)
    return replace(choices, uses=uses), leads


def _frame(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(f"{text!r} is no frame", where="--first", remedy="Give a number.")
    return value


def _unit(choices: Choices, given: float | None) -> float:
    depths = [use.source for use in choices.used() if use.source.kind == "depth"]
    if given is not None or not depths:
        return given if given is not None else choices.depth_unit
    unit = guessed_unit(depths[0])
    say(
        f"note: depth is taken to be {unit:g} metres per count, by the depth of the scene. Give "
        "--unit if that is wrong."
    )
    return unit


def _used(use: Use, roles: dict[str, str], mirrored: Sequence[str]) -> Use:
    use = replace(use, mirrored=use.source.name in mirrored)
    text = roles.get(use.source.name)
    if text is None:
        return use
    word, _, view = text.partition(":")
    for role in ROLES:
        if role == word.strip().lower():
            return replace(use, role=role, view=view.strip() or view_for(use, role))
    raise InputError(f"unknown role {word!r}", where="--as", remedy=f"Roles: {', '.join(ROLES)}.")


def _pair(text: str, where: str) -> tuple[str, str]:
    first, sign, second = text.partition("=")
    if not sign or not first.strip() or not second.strip():
        raise InputError(
            f"{text!r} cannot be read", where=where, remedy="Write two names joined by =."
        )
    return first.strip(), second.strip()


def _check_known(asked: Any, known: Sequence[str], where: str) -> None:
    for name in asked:
        if name not in known:
            raise InputError(
                f"there is no {name!r}",
                where=where,
                remedy=f"{did_you_mean(name, known)}There are: {', '.join(known)}.",
            )


def _facts(choices: Choices, folder: Path) -> dict[str, Any]:
    return {
        "recording": folder,
        "name": choices.name,
        "fps": choices.fps,
        "calibration": choices.calibration,
        "guessed": choices.calibration is None,
        "depth_unit": choices.depth_unit,
        "sources": [
            {
                "source": use.source.name,
                "path": use.source.path,
                "role": use.role,
                "view": use.view,
                "mirrored": use.mirrored,
                "lead": use.lead,
                "size": list(use.source.size),
                "frames": use.source.frames,
                "fps": use.source.fps,
            }
            for use in choices.uses
        ],
    }


def _table(choices: Choices, title: str) -> Table:
    rows = [
        (
            use.source.name,
            use.source.says(),
            ROLES[use.role] + (", turned back" if use.mirrored else ""),
            use.view if use.role != "unused" else "",
        )
        for use in choices.uses
    ]
    return Table(title, ("source", "what", "used as", "view"), rows)

"""``stereotrack import recording``: a recording folder from videos and images."""

import math
from argparse import Namespace
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from stereotrack_core.cli import options
from stereotrack_core.cli.output import OK, put_result, say, watched
from stereotrack_core.errors import InputError, did_you_mean
from stereotrack_core.interop.calibrations.deciding import CONVENTIONS, with_calibration
from stereotrack_core.interop.calibrations.foreign import METRES_PER_UNIT
from stereotrack_core.interop.label_source import stated_names
from stereotrack_core.recording.importing import making, synchronise
from stereotrack_core.recording.importing.choices import (
    ROLES,
    Choices,
    Use,
    doubts_about,
    problems_of,
)
from stereotrack_core.recording.importing.proposing import Views, possible_units, propose, viewed
from stereotrack_core.recording.importing.readers import with_one_white
from stereotrack_core.recording.importing.sources import look_at
from stereotrack_core.tables import Table


@options.command(
    options.path("sources VIDEOS|FOLDER", "videos, images, or a folder that holds them", nargs="+"),
    options.path(
        "-o --output DIR",
        "the new recording folder, or the folder of the videos itself (default: that folder)",
    ),
    options.option("--title NAME", "name of the recording (default: that of the folder)"),
    options.several(
        "--fps [SOURCE=]N",
        "frames per second, if the files do not state them or state them wrongly: of the "
        "recording, or of a source",
    ),
    options.several(
        "--calibration FILE",
        "calibration of the cameras: a calibration.toml, or of another tool as in `stereotrack "
        "calibrate import`; several files that belong together, each with --calibration "
        "(default: they are guessed)",
        type=Path,
    ),
    options.option(
        "--units UNIT",
        "unit of the lengths in a calibration of another tool that does not state it: m, cm, "
        "mm or in",
        choices=tuple(METRES_PER_UNIT),
    ),
    options.option(
        "--convention NAME",
        "how a calibration of another tool maps, where it is open: " + ", ".join(CONVENTIONS),
        choices=tuple(CONVENTIONS),
    ),
    options.several(
        "--camera OURS=THEIRS",
        "name of a camera in the calibration, where it differs",
        dest="cameras",
    ),
    options.several(
        "--view NAME=SOURCE[,SOURCE]",
        "sources of a view: one camera, left,right of a stereo camera, or image,depth; sources "
        "that are named nowhere are not used then",
        dest="views",
    ),
    options.several(
        "--mirrored SOURCE", "turn back the mirror images of a source, such as a Kinect v1's"
    ),
    options.option(
        "--unit METRES",
        "metres per count of depth maps (default: by the depth of the scene)",
        type=float,
        dest="unit",
    ),
    options.option(
        "--synchronise METHOD",
        "find the frames of the same instant: start (times stated by the files or a "
        "timestamps.csv), flash, clap, or motion (default: frame 0 of all)",
        choices=tuple(synchronise.METHODS),
        dest="method",
    ),
    options.several(
        "--first SOURCE=FRAME",
        "own frame of a source at the common instant, with fractions if need be",
        dest="firsts",
    ),
    options.flag("--dry-run", "only print what would be made"),
)
def run(args: Namespace) -> int:
    """Make a recording folder from videos, side-by-side stereo videos, folders of images or
    folders of depth maps. What they show is proposed from their names and sizes: left and
    right, cam0 and cam1, an image twice as wide as usual. Files that lie in the new folder
    already stay where they are; others are copied. Nothing is overwritten.
    """
    found = look_at(args.sources)
    for problem in found.problems:
        say(f"not used: {problem}")
    for note in found.notes:
        say(f"note: {note}.")
    folder = args.output or found.folder
    if folder is None:
        what = "the sources lie in several folders"
        raise InputError(what, remedy="Say where the recording is to be made, with -o DIR.")
    choices = replace(propose(found), name=args.title or folder.resolve().name)
    choices = synchronise.at_one_rate(_decided(choices, args))
    for problem in problems_of(choices):
        raise problem
    choices, leads = _in_time(choices, args)
    choices = with_one_white(choices)
    for doubt in doubts_about(choices):
        say(f"note: {doubt}")
    making.cameras_for(choices)
    for note in making.calibration_notes(choices):
        say(f"note: {note}.")
    making.check_place(choices, folder)
    if not args.dry_run:
        with watched("Making the recording", "No recording was created.") as work:
            making.make_recording(choices, folder, work)
    what = "Would be made" if args.dry_run else "Recording written to"
    facts = {**_facts(choices, folder), "synchronised": [asdict(lead) for lead in leads]}
    put_result(facts, _table(choices, f"{what} {folder}"), as_json=args.json)
    return OK


def _decided(choices: Choices, args: Namespace) -> Choices:
    """The proposal with everything that the options say."""
    names = [use.source.name for use in choices.uses]
    if args.views:
        choices = replace(choices, uses=viewed(choices.uses, _views(args.views, names)))
    _check_known(args.mirrored, names, "--mirrored")
    rates = _rates(args.fps, names)
    uses = tuple(
        replace(
            use,
            mirrored=use.source.name in args.mirrored,
            source=replace(use.source, fps=rates.get(use.source.name, use.source.fps)),
        )
        for use in choices.uses
    )
    stated = choices.fps or next((rate for name, rate in rates.items() if name), None)
    choices = replace(choices, uses=uses, fps=rates.get("", stated))
    return _calibrated(replace(choices, depth_unit=_unit(choices, args.unit)), args)


def _rates(texts: Sequence[str], known: Sequence[str]) -> Mapping[str, float]:
    """Frames per second by the name of the source, those of the recording by an empty name."""
    rates = {}
    for text in texts:
        source, _, number = text.rpartition("=")
        source = source.strip()
        if source:
            _check_known([source], known, "--fps")
        rates[source] = _number(number, "--fps", "rate")
        if not rates[source] > 0:
            what = f"{number} frames per second is not possible"
            raise InputError(what, "--fps", "Use more than 0.")
    return rates


def _views(texts: Sequence[str], known: Sequence[str]) -> Views:
    """The names of the sources of each view that is asked for."""
    views: dict[str, tuple[str, ...]] = {}
    for name, text in _pairs(texts, "--view").items():
        views[name] = tuple(one.strip() for one in text.split(","))
        _check_known(views[name], known, "--view")
        if len(views[name]) > 2:
            what = f"the view {name} has {len(views[name])} sources"
            raise InputError(what, "--view", "Give one, left,right, or image,depth.")
    return views


def _calibrated(choices: Choices, args: Namespace) -> Choices:
    """The choices with the cameras of the calibration that is given or lies there."""
    if args.cameras:
        cameras = _pairs(args.cameras, "--camera")
        _check_known(cameras, choices.camera_names(), "--camera")
        choices = replace(choices, cameras=cameras)
    paths = args.calibration or ([] if choices.calibration is None else [choices.calibration])
    if not paths:
        return choices
    choices, decided = with_calibration(choices, paths, unit=args.units, convention=args.convention)
    for line in () if decided is None else (*decided.reasons, *decided.notes):
        say(f"note: {line}.")
    return choices


def _in_time(choices: Choices, args: Namespace) -> tuple[Choices, tuple[synchronise.Lead, ...]]:
    """The choices with the frames of the same instant, and how these were found."""
    leads: tuple[synchronise.Lead, ...] = ()
    if args.method is not None:
        with watched("Synchronising", "No recording was created.") as work:
            choices, leads = synchronise.synchronised(choices, args.method, work)
        for lead in leads:
            say(f"synchronised by {args.method}: {lead.says(choices.fps or 1.0)}")
    firsts = _pairs(args.firsts, "--first")
    _check_known(firsts, [use.source.name for use in choices.uses], "--first")
    given = {name: _number(text, "--first", "frame") for name, text in firsts.items()}
    uses = tuple(replace(use, lead=given.get(use.source.name, use.lead)) for use in choices.uses)
    return replace(choices, uses=uses), leads


def _number(text: str, where: str, what: str) -> float:
    with suppress(ValueError):
        if math.isfinite(value := float(text)):
            return value
    raise InputError(f"{text!r} is no {what}", where, "Give a number.")


def _unit(choices: Choices, given: float | None) -> float:
    used = (use.source for use in choices.used() if use.role == "depth")
    depths = [source for source in used if source.unit is None]
    if given is not None or not depths:
        return choices.depth_unit if given is None else given
    units = possible_units(depths[0])
    listed = ", or ".join(f"{unit:g} ({metres:.1f} m away)" for unit, metres in units)
    say(
        f"note: depth is taken to be {units[0][0]:g} metres per count. By the middle of the scene "
        f"it may be {listed}. Give --unit if it is another."
    )
    return units[0][0]


def _pairs(texts: Sequence[str], where: str) -> Mapping[str, str]:
    return stated_names(texts, where, "two names joined by =")


def _check_known(asked: Any, known: Sequence[str], where: str) -> None:
    for name in asked:
        if name not in known:
            remedy = f"{did_you_mean(name, known)}There are: {', '.join(known)}."
            raise InputError(f"there is no {name!r}", where, remedy)


def _facts(choices: Choices, folder: Path) -> dict[str, Any]:
    return {
        "recording": folder,
        "name": choices.name,
        "fps": choices.fps,
        "calibration": choices.calibration,
        "guessed": choices.guessed(),
        "depth_unit": choices.depth_unit,
        "sources": [
            {
                "source": use.source.name,
                "role": use.role,
                "view": use.view,
                "lead": use.lead,
                "size": list(use.source.size),
                "frames": use.source.frames,
                "fps": use.source.fps,
            }
            for use in choices.uses
        ],
    }


def _shows(use: Use) -> str:
    more = (
        (", turned back" if use.mirrored else "")
        + (f", shown turned by {use.source.turned} degrees" if use.source.turned else "")
        + (f", background {use.background.name}" if use.background and use.role != "unused" else "")
    )
    return ROLES[use.role] + more


def _table(choices: Choices, title: str) -> Table:
    rows = [
        (use.source.name, use.source.says(), _shows(use), use.view if use.role != "unused" else "")
        for use in choices.uses
    ]
    return Table(title, ("source", "what", "used as", "view"), rows)

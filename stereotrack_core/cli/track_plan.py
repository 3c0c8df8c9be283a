"""What ``stereotrack track`` shall do: from the command line, or as a run says with ``--like``."""

from __future__ import annotations

import dataclasses
from argparse import Namespace
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from stereotrack_core.cli.output import say
from stereotrack_core.errors import InputError
from stereotrack_core.recording.selection import frames_within, views_of

if TYPE_CHECKING:
    from stereotrack_core.cli.unfinished import UnfinishedOutput
    from stereotrack_core.recording.description import Recording
    from stereotrack_core.recording.detections import Detections
    from stereotrack_core.tracking.parameters import Settings
    from stereotrack_core.tracking.pipeline import FirstPose
    from stereotrack_core.tracking.repeating import Recipe
    from stereotrack_core.tracking.run import Run
    from stereotrack_core.tracking.unfinished import UnfinishedRun

PRESET, SEED, INIT = "accurate", 0, "auto"
"""What is taken where nothing is said."""


@dataclass(frozen=True, eq=False)
class Plan:
    """Everything that tracking needs to know.

    Attributes
    ----------
    count : int
        Frames to track out of `frames`; fewer where a run that was stopped is repeated.
    like : Run or None
        The run that is repeated.
    exact : bool
        Whether nothing on the command line asks for something else than the run says.
    """

    recording: Recording
    settings: Settings
    preset: str
    frames: range
    count: int
    views: tuple[str, ...]
    seed: int
    init: FirstPose
    smooth: bool
    detections: Detections | None
    colour: bool | None = None
    like: Run | None = None
    exact: bool = False
    begun: UnfinishedRun | None = None


def plan_of(args: Namespace, recording: Recording, output: UnfinishedOutput) -> Plan:
    """Read the command line, with ``--like`` the run, and with ``--resume`` what there is of it.

    Raises
    ------
    InputError
        Where they cannot be followed, or a run would be lost.
    """
    if args.resume:
        return _plan_resumed(args, recording, output)
    output.refuse_to_lose()
    return _plan(args, recording) if args.like is None else _plan_like(args, recording)


def _plan(args: Namespace, recording: Recording) -> Plan:
    from stereotrack_core.interop.first_pose import first_pose
    from stereotrack_core.recording.depth_views import usable_views
    from stereotrack_core.tracking.presets import preset

    preset_name = args.preset or PRESET
    settings = preset(preset_name, args.changes)
    views = usable_views(recording, views_of(recording, args.views))
    frames = frames_within(args.frames, _count(recording, views))
    return Plan(
        recording=recording,
        settings=settings,
        preset=preset_name,
        frames=frames,
        count=len(frames),
        views=views,
        seed=args.seed or SEED,
        init=first_pose(args.init or INIT, frames.start),
        smooth=bool(args.smooth),
        detections=_detections(args.detections, recording),
    )


def _plan_like(args: Namespace, recording: Recording) -> Plan:
    """As the run says, with whatever the command line says otherwise."""
    from stereotrack_core.interop.first_pose import first_pose
    from stereotrack_core.interop.run_file import read_run
    from stereotrack_core.recording.depth_views import usable_views
    from stereotrack_core.tracking.repeating import recipe_of, what_differs

    run = read_run(args.like)
    recipe = recipe_of(run)
    said = _said(args)
    for sentence in (*what_differs(run, recording), *recipe.notes):
        say(f"{args.like}: {sentence}")
    if said:
        say(f"Given on the command line, not taken from the run: {', '.join(said)}.")
    views = usable_views(recording, views_of(recording, args.views) or recipe.views)
    frames = _frames_like(args, recipe, _count(recording, views))
    init = recipe.init if args.init is None else first_pose(args.init, frames.start)
    if init is None:
        raise InputError(
            "the run began with a pose that it does not state",
            where=str(args.like),
            remedy="Say where the first pose comes from with --init.",
        )
    preset_name, settings = _settings(args, recipe)
    return Plan(
        recording=dataclasses.replace(recording, subject=recipe.subject),
        settings=settings,
        preset=preset_name,
        frames=frames,
        count=recipe.count if args.frames is None else len(frames),
        views=views,
        seed=recipe.seed if args.seed is None else args.seed,
        init=init,
        smooth=recipe.smooth if args.smooth is None else args.smooth,
        detections=_detections_like(args, recipe, recording),
        colour=recipe.colour,
        like=run,
        exact=not said,
    )


def _plan_resumed(args: Namespace, recording: Recording, output: UnfinishedOutput) -> Plan:
    """As the unfinished run was begun; nothing may be otherwise."""
    from stereotrack_core.interop.run_npz import check_run
    from stereotrack_core.recording.depth_views import usable_views
    from stereotrack_core.tracking.repeating import other_files, other_versions, recipe_of

    begun, wish = output.begun()
    run = begun.run()
    check_run(output.part, run)
    recipe = recipe_of(run)
    views = usable_views(recording, recipe.views)
    detections, heard_else = recipe.detections_in(recording)
    foreign = [*other_files(run, recording), *recipe.notes, *([heard_else] if heard_else else [])]
    if foreign or recipe.init is None:
        raise InputError(
            "the unfinished run does not go on here" + (f": {foreign[0]}" if foreign else ""),
            where=str(output.part),
            remedy="Restore what it was begun with, or track anew to another output; what is in "
            "it can be evaluated and exported.",
        )
    _refuse_otherwise(args, recipe, recording)
    for sentence in other_versions(run.meta):
        say(f"{output.part}: {sentence}")
    say(f"Going on after {len(begun.frames)} of {len(begun.asked)} frames.")
    return Plan(
        recording=dataclasses.replace(recording, subject=recipe.subject),
        settings=recipe.settings,
        preset=recipe.preset,
        frames=begun.asked,
        count=wish.count or len(begun.asked),
        views=views,
        seed=recipe.seed,
        init=recipe.init,
        smooth=wish.smooth if args.smooth is None else args.smooth,
        detections=detections,
        colour=recipe.colour,
        begun=begun,
    )


def _refuse_otherwise(args: Namespace, recipe: Recipe, recording: Recording) -> None:
    """Refuse options that ask for something else than the unfinished run was begun with."""
    count = _count(recording, recipe.views)
    same = {
        "--preset": args.preset is None or args.preset == recipe.preset,
        "--set": _settings(args, recipe)[1] == recipe.settings,
        "--frames": args.frames is None or frames_within(args.frames, count) == recipe.frames,
        "--views": args.views is None or views_of(recording, args.views) == recipe.views,
        "--seed": args.seed in (None, recipe.seed),
        "--init": args.init in (None, recipe.init),
        "--detections": args.detections is None,
        "--like": args.like is None,
    }
    for option, agrees in same.items():
        if not agrees:
            raise InputError(
                "the unfinished run was begun otherwise",
                where=option,
                remedy="Leave the option out to go on as it was begun, or name another output to "
                "begin anew.",
            )


def _frames_like(args: Namespace, recipe: Recipe, count: int) -> range:
    frames = recipe.frames if args.frames is None else frames_within(args.frames, count)
    if frames.stop > count:
        raise InputError(
            f"the run has the frames {frames.start}:{frames.stop}, the recording only 0:{count}",
            where=str(args.like),
            remedy="Give the run's own recording, or a stretch with --frames A:B.",
        )
    return frames


def _said(args: Namespace) -> list[str]:
    """Options that were given, in their own words."""
    options = {
        "--preset": args.preset,
        "--set": " ".join(args.changes) or None,
        "--frames": args.frames,
        "--views": args.views,
        "--seed": args.seed,
        "--init": args.init,
        "--detections": args.detections,
    }
    said = [f"{name} {value}" for name, value in options.items() if value is not None]
    if args.smooth is not None:
        said.append("--smooth" if args.smooth else "--no-smooth")
    return said


def _settings(args: Namespace, recipe: Recipe) -> tuple[str, Settings]:
    """A preset replaces all of the run's parameters, ``--set`` single ones."""
    from stereotrack_core.parameters import parsed_settings
    from stereotrack_core.tracking.presets import preset

    if args.preset is not None:
        return args.preset, preset(args.preset, args.changes)
    return recipe.preset, recipe.settings.replaced(**parsed_settings(args.changes))


def _detections_like(args: Namespace, recipe: Recipe, recording: Recording) -> Detections | None:
    if args.detections is not None or (recipe.detections is None and recipe.colour is None):
        return _detections(args.detections, recording)  # older runs do not say what they used
    found, otherwise = recipe.detections_in(recording)
    if otherwise:
        say(otherwise)
    return found


def _detections(path: Path | None, recording: Recording) -> Detections | None:
    """What ``--detections`` names, or the recording's own file; None where there is none."""
    from stereotrack_core.recording.detection_csv import own_detections, read_detections

    return own_detections(recording) if path is None else read_detections(path, recording)


def _count(recording: Recording, views: tuple[str, ...]) -> int:
    from stereotrack_core.recording.reader import FrameReader

    with FrameReader(recording, views=views, read_ahead=0) as reader:
        return reader.frame_count

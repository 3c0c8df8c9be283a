"""``stereotrack proportions``: the lengths of a person's body, from the recording itself."""

from __future__ import annotations

from argparse import Namespace
from dataclasses import asdict, replace
from pathlib import Path

from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.cli.arguments import (
    FRAMES,
    INIT,
    JSON,
    RECORDING,
    SEED,
    SETTINGS,
    STATED,
    VIEWS,
    check_least,
    check_output,
    check_suffix,
    option,
)
from stereotrack_core.cli.output import OK, put_json, put_table, say
from stereotrack_core.cli.progress import progress, stoppable
from stereotrack_core.cli.sources import initial_pose
from stereotrack_core.errors import Cancelled, InputError
from stereotrack_core.recording.description import Recording, write_subject
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.recording.selection import frames_within, views_of
from stereotrack_core.tables import Table
from stereotrack_core.tracking.lengths_fit import (
    ESTIMATING_LENGTHS,
    LENGTH_FRAMES,
    EstimatedLengths,
    tracked_lengths,
)
from stereotrack_core.tracking.pipeline import Pipeline
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run_spec import RunSpec

DESCRIPTION = (
    "Track the first 600 frames, and fit the segment lengths to the most informative ones: "
    "frames with few unexplained points and bent elbows. `track --set proportions=sequence` "
    "does the same before tracking. The recording's reference and subject file are not used."
)

OPTIONS = (
    RECORDING,
    option("-o --output TOML", "write the lengths as a subject file (.toml)", type=Path),
    *SETTINGS,
    FRAMES,
    VIEWS,
    SEED,
    INIT,
    *STATED,
    JSON,
)


def run(args: Namespace) -> int:
    """Estimate, print, and write a subject file where that is asked for."""
    if args.output is not None:
        check_suffix(args.output, ".toml")
    check_least(0, seed=args.seed)

    recording = open_recording(args.recording)
    if args.output is not None:
        check_output(args.output, recording)
    found = _estimated(args, recording)
    if not found.frames:
        raise InputError(
            "too few frames are tracked well enough to estimate the body's lengths",
            where=str(recording.folder),
            remedy="Use more frames, preferably with elbows that bend and straighten.",
        )
    if args.output is not None:
        write_subject(args.output, found.subject())
    _put(args, recording, found)
    return OK


def _estimated(args: Namespace, recording: Recording) -> EstimatedLengths:
    settings = preset(args.preset, args.changes)
    views = views_of(recording, args.views)
    with FrameReader(recording, views=views, colour=False) as reader:
        frames = frames_within(args.frames, reader.frame_count)
    unaided = replace(recording, reference=None)  # truth is never seen
    init = initial_pose(args, frames.start, recording)
    wanted = min(LENGTH_FRAMES, len(frames))
    with (
        Pipeline(unaided, RunSpec(settings, views=views, seed=args.seed, init=init)) as pipeline,
        progress("Tracking", wanted) as show,
        stoppable("Nothing was written.") as stopped,
    ):

        def note(stage: str, done: int, _count: int) -> None:
            if stage == ESTIMATING_LENGTHS:
                show(done + 1)
            if stopped():
                raise Cancelled

        pipeline.on_preparing = note
        pipeline.learn(frames)
        return tracked_lengths(pipeline, frames)


def _put(args: Namespace, recording: Recording, found: EstimatedLengths) -> None:
    lengths, average = asdict(found.proportions), asdict(AVERAGE)
    own = recording.subject
    if args.json:
        put_json({"lengths_m": lengths, "sigma_m": dict(found.sigma), "frames": found.frames})
        return
    rows = [
        (
            name.replace("_", " "),
            f"{1000.0 * length:.0f}",
            f"{1000.0 * found.sigma[name]:.0f}",
            _millimetres(None if own is None else getattr(own, name)),
            _millimetres(average[name]),
        )
        for name, length in lengths.items()
    ]
    columns = ("length", ">mm", ">+- mm", ">subject file mm", ">average mm")
    put_table(Table(f"{recording.name}, from {found.frames} well-tracked frames", columns, rows))
    if args.output is not None:
        say(f"Written to {args.output}. Name it as subject in recording.toml to use it.")


def _millimetres(length: float | None) -> str:
    return "-" if length is None else f"{1000.0 * length:.0f}"

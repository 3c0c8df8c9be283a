"""``stereotrack track``: follow the person through a recording."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from stereotrack_core.cli.arguments import (
    add_frames,
    add_json,
    add_recording,
    add_settings,
    add_views,
    check_output,
    frames_within,
    settings_of,
    views_of,
)
from stereotrack_core.cli.command import FAILED, OK, Command
from stereotrack_core.cli.output import put_json, put_table, say
from stereotrack_core.errors import InputError

if TYPE_CHECKING:
    from stereotrack_core.recording.description import Recording
    from stereotrack_core.recording.detections import Detections


def add_arguments(parser: ArgumentParser) -> None:
    """Declare the arguments."""
    add_recording(parser)
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        required=True,
        metavar="RUN",
        help="file to write: .npz (a complete run), .csv, .trc, .c3d or .bvh (its landmarks)",
    )
    add_settings(parser)
    add_frames(parser)
    add_views(parser)
    parser.add_argument(
        "--seed", type=int, default=0, metavar="N", help="seed of all that is random (default: 0)"
    )
    parser.add_argument(
        "--init",
        default="auto",
        metavar="auto|tpose|FILE",
        help="where the first pose comes from: found without help (auto, default), the T pose "
        "facing north (tpose), or a run or landmarks file that knows the first frame",
    )
    parser.add_argument(
        "--detections",
        type=Path,
        metavar="CSV",
        help="head and hands that a detector has seen, as measurements (default: the recording's "
        "own detections.csv, where it has one)",
    )
    parser.add_argument(
        "--smooth",
        action="store_true",
        help="go over the run backwards as well: steadier poses, short gaps bridged",
    )
    add_json(parser)


def run(args: Namespace) -> int:
    """Track and write the run."""
    if args.seed < 0:
        raise InputError("a seed is not negative", where="--seed", remedy="Give 0 or more.")
    from stereotrack_core.interop.run_file import run_suffix

    run_suffix(args.output)
    settings = settings_of(args.preset, args.changes)

    from stereotrack_core.cli.tracking_job import first_pose, track_recording
    from stereotrack_core.interop.run_file import write_run
    from stereotrack_core.recording.folder import open_recording
    from stereotrack_core.recording.reader import FrameReader
    from stereotrack_core.tracking.pipeline import usable_views

    recording = open_recording(args.recording)
    check_output(args.output, recording)
    views = usable_views(recording, views_of(recording, args.views))
    with FrameReader(recording, views=views, read_ahead=0) as reader:
        frames = frames_within(args.frames, reader.frame_count)
    _say_findings(args.recording)
    detections = _detections(args.detections, recording)
    job = track_recording(
        recording,
        settings,
        frames,
        preset=args.preset,
        views=views,
        seed=args.seed,
        init=first_pose(args.init, frames.start),
        smooth=args.smooth,
        detections=detections,
    )
    if not len(job.run.frame):
        say("Stopped before the first frame; nothing was written.")
        return FAILED
    write_run(args.output, job.run)
    if args.json:
        put_json({"run": args.output, **job.facts()})
    else:
        put_table(job.table(f"{recording.name} in {args.output}"))
    if job.stopped:
        say(
            f"Stopped after {len(job.run.frame)} of {job.wanted} frames; they are in {args.output}."
        )
        return FAILED
    return OK


def _detections(path: Path | None, recording: Recording) -> Detections | None:
    """What ``--detections`` names, or the recording's own file; None where there is none."""
    from stereotrack_core.recording.detection_csv import read_detections

    own = recording.folder / "detections.csv"
    if path is None and not own.is_file():
        return None
    return read_detections(own if path is None else path, recording)


def _say_findings(folder: Path) -> None:
    """Tell before long work what looks wrong about the recording; it is tracked nevertheless."""
    from stereotrack_core.recording.findings import examine

    for finding in examine(folder):
        if finding.severity != "note":
            say(f"{finding.severity}: {finding.where}: {finding.what}. {finding.remedy}")


COMMAND = Command(
    name="track",
    summary="follow the person through a recording and write the run",
    description=(
        "Follow the person through a recording. Ctrl-C keeps the frames that are done. The "
        "recording's reference is never read by this command."
    ),
    add_arguments=add_arguments,
    run=run,
)

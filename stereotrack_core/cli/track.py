"""``stereotrack track``: follow the person through a recording."""

from __future__ import annotations

from argparse import ArgumentParser, BooleanOptionalAction, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from stereotrack_core.cli.arguments import (
    add_frames,
    add_json,
    add_recording,
    add_settings,
    add_views,
    check_output,
    check_seed,
)
from stereotrack_core.cli.command import FAILED, OK, Command
from stereotrack_core.cli.output import counted, put_json, put_table, say
from stereotrack_core.cli.track_plan import PRESET, TrackPlan, plan_of

if TYPE_CHECKING:
    from stereotrack_core.experiments.tracked_run import TrackedRun


def add_arguments(parser: ArgumentParser) -> None:
    """Declare the arguments."""
    add_recording(parser)
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        required=True,
        metavar="RUN",
        help="output file: .npz (a complete run), .csv, .trc, .c3d or .bvh (landmarks only)",
    )
    _add_earlier_runs(parser)
    add_settings(parser)
    parser.set_defaults(preset=None)  # what is given is told from what is not
    add_frames(parser)
    add_views(parser)
    parser.add_argument("--seed", type=int, metavar="N", help="random seed (default: 0)")
    parser.add_argument(
        "--init",
        metavar="auto|tpose|FILE",
        help="initial pose: found automatically (auto, default), the T pose facing north (tpose), "
        "or a run or landmarks file that contains the first frame",
    )
    parser.add_argument(
        "--detections",
        type=Path,
        metavar="CSV",
        help="keypoints of head and hands from a detector, used as measurements (default: the "
        "recording's detections.csv, if it has one)",
    )
    parser.add_argument(
        "--smooth",
        action=BooleanOptionalAction,
        help="smooth the run: steadier poses, short gaps bridged",
    )
    add_json(parser)


def _add_earlier_runs(parser: ArgumentParser) -> None:
    parser.add_argument(
        "--like",
        type=Path,
        metavar="RUN.npz",
        help="reproduce a run with its parameters, seed, views, frames, initial pose and "
        "smoothing; other options given here take precedence and are reported",
    )
    parser.add_argument(
        "--resume",
        action="store_true",
        help="resume the stopped run of this output with its settings",
    )


def run(args: Namespace) -> int:
    """Track and write the run."""
    check_seed(args.seed)
    from stereotrack_core.interop.run_file import run_suffix

    run_suffix(args.output)
    if args.like is None and not args.resume:
        from stereotrack_core.tracking.presets import preset

        preset(args.preset or PRESET, args.changes)  # a wrong word is told before long work

    from stereotrack_core.cli.track_output import UnfinishedOutput
    from stereotrack_core.recording.folder import open_recording

    recording = open_recording(args.recording)
    check_output(args.output, recording)
    output = UnfinishedOutput(args.recording, args.output)
    plan = plan_of(args, recording, output)
    _say_findings(args.recording)
    with output.telling():
        job = output.track(plan.recording, plan.spec, plan.count, plan.begun)
        if not len(job.run.frame):
            say("Stopped before the first frame. Nothing was written.")
            return FAILED
        place = output.write(job)
    return _tell(args, plan, job, place)


def _tell(args: Namespace, plan: TrackPlan, job: TrackedRun, place: Path | None) -> int:
    """Say what came out, and for a run that was repeated whether it is the same."""
    from stereotrack_core.cli.track_output import say_signs, track_table
    from stereotrack_core.tracking.repeating import sameness

    same = sameness(plan.like, job.run) if plan.like is not None and plan.exact else None
    if args.json:
        repeated = {} if same is None else {"equal": same.equal, "repeated": same}
        put_json({"run": place, **job.to_dict(), **repeated})
    else:
        put_table(track_table(job, plan.recording.name + ("" if place is None else f" in {place}")))
    if job.changed:
        say(
            f"{counted(len(job.changed), 'frame')} tracked earlier came out differently now, so "
            "the run differs from one without interruption; the new results were kept."
        )
    say_signs(job)
    if job.stopped or job.nothing:
        return FAILED
    if same is not None:
        say(same.words)
    return OK


def _say_findings(folder: Path) -> None:
    """Tell before long work what looks wrong about the recording; it is tracked nevertheless."""
    from stereotrack_core.recording.findings import examine

    for finding in examine(folder):
        if finding.severity != "note":
            say(f"{finding.severity}: {finding.where}: {finding.what}. {finding.remedy}")


COMMAND = Command(
    name="track",
    summary="track the person through a recording and write the run",
    description=(
        "Track the person through a recording. Every frame is stored immediately in RUN.part; RUN "
        "itself is replaced only when the run is complete. After any interruption, --resume "
        "continues. The recording's reference is never read by this command. With --like a run is "
        "reproduced, and differences in recording, calibration and versions are reported."
    ),
    add_arguments=add_arguments,
    run=run,
)

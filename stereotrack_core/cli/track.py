"""``stereotrack track``: follow the person through a recording."""

from __future__ import annotations

from argparse import BooleanOptionalAction, Namespace
from dataclasses import replace
from pathlib import Path

from stereotrack_core.cli.arguments import (
    FRAMES,
    JSON,
    PRESET,
    RECORDING,
    VIEWS,
    changes,
    check_least,
    check_output,
    flag,
    option,
)
from stereotrack_core.cli.output import FAILED, OK, put_json, put_table, say
from stereotrack_core.cli.sources import say_notes
from stereotrack_core.cli.track_output import UnfinishedOutput, say_signs, track_table
from stereotrack_core.cli.track_plan import USUAL_PRESET, TrackPlan, plan_of
from stereotrack_core.counting import counted
from stereotrack_core.experiments.tracked_run import TrackedRun
from stereotrack_core.interop.run_file import run_suffix
from stereotrack_core.recording.findings import examine
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.repeating import sameness

DESCRIPTION = (
    "Track the person through a recording. Every frame is stored immediately in RUN.part; RUN "
    "itself is replaced only when the run is complete. After any interruption, --resume "
    "continues. The recording's reference is never read by this command. With --like a run is "
    "reproduced, and differences in recording, calibration and versions are reported."
)

OPTIONS = (
    RECORDING,
    option(
        "-o --output RUN",
        "output file: .npz (a complete run), .csv, .trc, .c3d or .bvh (landmarks only)",
        type=Path,
        required=True,
    ),
    option(
        "--like RUN.npz",
        "reproduce a run with its parameters, seed, views, frames, initial pose and "
        "smoothing; other options given here take precedence and are reported",
        type=Path,
    ),
    flag("--resume", "resume the stopped run of this output with its settings"),
    replace(PRESET, keywords={**PRESET.keywords, "default": None}),  # given, or not given
    changes("change one parameter"),
    FRAMES,
    VIEWS,
    option("--seed N", "random seed (default: 0)", type=int),
    option(
        "--init auto|tpose|FILE",
        "initial pose: found automatically (auto, default), the T pose facing north (tpose), "
        "or a run or landmarks file that contains the first frame",
    ),
    option(
        "--detections CSV",
        "keypoints of head and hands from a detector, used as measurements (default: the "
        "recording's detections.csv, if it has one)",
        type=Path,
    ),
    option(
        "--smooth",
        "smooth the run: steadier poses, short gaps bridged",
        action=BooleanOptionalAction,
    ),
    JSON,
)


def run(args: Namespace) -> int:
    """Track and write the run."""
    check_least(0, seed=args.seed)

    run_suffix(args.output)
    if args.like is None and not args.resume:
        preset(args.preset or USUAL_PRESET, args.changes)  # a wrong word is told before long work

    recording = open_recording(args.recording)
    check_output(args.output, recording)
    output = UnfinishedOutput(args.recording, args.output)
    plan = plan_of(args, recording, output)
    # what looks wrong is told before long work; the recording is tracked nevertheless
    say_notes(finding for finding in examine(args.recording) if finding.severity != "note")
    with output.telling():
        job = output.track(plan.recording, plan.spec, plan.count, plan.begun)
        if not len(job.run.frame):
            say("Stopped before the first frame. Nothing was written.")
            return FAILED
        place = output.write(job)
    return _tell(args, plan, job, place)


def _tell(args: Namespace, plan: TrackPlan, job: TrackedRun, place: Path | None) -> int:
    """Say what came out, and for a run that was repeated whether it is the same."""
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

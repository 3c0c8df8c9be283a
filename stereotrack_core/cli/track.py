"""``stereotrack track``: follow the person through a recording; keep the run beside its output."""

import math
from argparse import Namespace
from pathlib import Path

from stereotrack_core.cli import options
from stereotrack_core.cli.output import FAILED, OK, put_json, put_table, say
from stereotrack_core.cli.sources import say_notes
from stereotrack_core.cli.track_plan import USUAL_PRESET, UnfinishedOutput, plan_of
from stereotrack_core.counting import counted
from stereotrack_core.doctor import diagnose
from stereotrack_core.experiments.tracked_run import TrackedRun, TrackPlan
from stereotrack_core.interop.run_file import run_suffix
from stereotrack_core.recording.findings import examine_described
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.tables import Table, number
from stereotrack_core.tracking.frame import LOOKED_AGAIN, Run
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run_checks import CHECK, HEADING, heading_words


def _lengths(run: Run) -> str:
    """Where the body's lengths come from."""
    if run.meta["parameters"].get("proportions") == "average":
        return "average"
    subject = run.meta.get("subject")
    if subject is None:
        return "average (no subject file); see --set proportions=sequence"
    return str(subject.get("name") or "the recording's subject file")


def track_table(job: TrackedRun, title: str) -> Table:
    """What the result says to a person."""
    facts = job.to_dict()
    found = sorted(job.run.meta.get("from_recording", {}).items())
    told = ", ".join(f"{name}={value}" for name, value in found)
    rows = [
        ("preset", str(facts["preset"])),
        ("frames", f"{facts['frames']} of {job.wanted}"),
        ("tracked", str(facts["tracked"])),
        ("unexplained fraction of the cloud", number(facts["mean_unexplained_fraction"], 3)),
        ("residual", f"{number(facts['mean_residual_mm'])} mm"),
        ("segment lengths", _lengths(job.run)),
        *([("taken from the recording", told)] if found else []),
        ("frames per second", number(facts["frames_per_second"] or math.nan)),
    ]
    if heading := heading_words(job.run.meta.get(HEADING)):
        rows.append(("direction that the person faces", heading.brief))
    if detector := job.run.meta["detector"]:
        rows.append(("pose detector", detector))
    if again := facts[LOOKED_AGAIN]:
        stretches = ", ".join(f"{first}:{last + 1}" for first, last in again)
        rows.append(("changed by a second look", stretches))
    if facts["repaired"]:
        rows.append(("frames repaired before clicks", str(len(facts["repaired"]))))
    if facts["smoothed"]:
        rows.append(("frames bridged by smoothing", str(len(facts["bridged"]))))
    rows += [(f"not tracked {gap.first}:{gap.end}", gap.reason) for gap in job.gaps]
    rows += [(f"view {b.view} not used {b.first}:{b.end}", b.reason) for b in job.blind]
    return Table(title, ("what", ">value"), rows)


def say_signs(job: TrackedRun) -> None:
    """Say why nobody was tracked, or that nothing fits, and what to do about it."""
    if heading := heading_words(job.run.meta.get(HEADING)):
        say(f"{'warning' if heading.undecided else 'note'}: {heading.what}. {heading.remedy}")
    for warning in job.run.meta["warnings"]:
        say(f"warning: {warning}. {CHECK}")
    if job.nothing and len(job.run.frame):
        say(f"No person was tracked in any of the {counted(len(job.run.frame), 'frame')}.")
        for cause in job.untracked.causes:
            say(cause.sentence())


@options.command(
    options.RECORDING,
    options.output(
        "RUN", "output file: .npz (a complete run), .csv, .trc, .c3d or .bvh (landmarks only)"
    ),
    options.path(
        "--like RUN.npz",
        "reproduce a run with its parameters, seed, views, frames, initial pose and smoothing; "
        "other options given here take precedence",
    ),
    options.flag("--resume", "resume the stopped run of this output with its settings"),
    options.PRESET,
    options.changes("change one parameter"),
    options.FRAMES,
    options.VIEWS,
    options.option("--seed N", "random seed (default: 0)", type=options.at_least(0)),
    options.option(
        "--init auto|tpose|FILE",
        "initial pose: found automatically (auto, default), the T pose facing north (tpose), "
        "or a run or landmarks file that contains the first frame",
    ),
    *options.STATED,
    options.option(
        "--heading DIRECTION",
        "direction that the person faces in the first frame, if the program cannot tell it: "
        "north, east, south, west (world axes y, x, -y, -x), or degrees from north over east",
    ),
    options.path(
        "--keypoints PROJECT|FILE",
        "keypoints of a 2-D detector, used as measurements: those of a project (.stereotrack), "
        "or a detector's file or folder; mono views are tracked by them alone",
    ),
    options.LAYOUT,
    options.PERSON,
    options.option(
        "--detector",
        "use the installed pose detector where no other keypoints are given (default: auto, "
        "where it is installed)",
        choices=("auto", "off"),
    ),
    options.path(
        "--clicks PROJECT|CSV",
        "clicked landmarks, used as measurements: a project, or a clicks file. Around a "
        "clicked frame in which the tracker was wrong, it is repaired forwards and backwards",
    ),
    options.flag("--smooth", "smooth the run: steadier poses, short gaps bridged"),
    options.flag("--despite-errors", "track a recording even if its checks find errors"),
)
def run(args: Namespace) -> int:
    """Track the person through a recording. Every frame is stored immediately in RUN.part;
    RUN itself is replaced only when the run is complete. After any interruption, --resume
    continues. The recording's reference is never read by this command. With --like a run is
    reproduced, and differences in recording, calibration and versions are reported.
    """
    if args.detector is not None:
        args.changes.append(f"detector={args.detector}")
    run_suffix(args.output)
    if args.like is None and not args.resume:
        preset(args.preset or USUAL_PRESET, args.changes)  # a wrong word is told before long work

    recording = open_recording(args.recording)
    output = UnfinishedOutput(args.recording, args.output)
    plan = plan_of(args, recording, output)
    _check(args, plan)
    with output.telling():
        job = output.track(plan)
        if not len(job.run.frame):
            say("Stopped before the first frame. Nothing was written.")
            return FAILED
        place = output.write(job)
    return _tell(args, plan, job, place)


def _check(args: Namespace, plan: TrackPlan) -> None:
    """Tell what looks wrong, and refuse what is plainly wrong unless told not to or resumed."""
    views = plan.spec.views
    found = (
        examine_described(plan.recording)
        if args.resume
        else diagnose.checks_before_tracking(plan.recording, views, plan.spec.settings.depth)
    )
    say_notes(finding for finding in found if finding.severity != "note")
    if not (args.resume or args.despite_errors):
        diagnose.refuse_plainly_wrong(
            diagnose.hindrances(found, plan.recording, views),
            str(args.recording),
            "Correct it (stereotrack info --deep says more), leave the view out with --views, or "
            "track nevertheless with --despite-errors.",
        )


def _tell(args: Namespace, plan: TrackPlan, job: TrackedRun, place: Path | None) -> int:
    if args.json:
        put_json({"run": place, **job.to_dict()})
    else:
        put_table(track_table(job, plan.recording.name + ("" if place is None else f" in {place}")))
    if job.changed:
        say(
            f"{counted(len(job.changed), 'frame')} tracked earlier came out differently now, so "
            "the run differs from one without interruption; the new results were kept."
        )
    say_signs(job)
    return FAILED if job.stopped or job.nothing else OK

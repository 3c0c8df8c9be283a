"""``stereotrack episodes``: the stretches in which a run fails, and why."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stereotrack_core.cli.arguments import add_changes, add_json, check_output
from stereotrack_core.cli.command import FAILED, OK, Command
from stereotrack_core.cli.output import Table, counted, put, put_json, put_table, say
from stereotrack_core.cli.progress import progress, stoppable
from stereotrack_core.cli.sources import say_if_unfinished
from stereotrack_core.errors import Cancelled, InputError

if TYPE_CHECKING:
    from stereotrack_core.evaluation.episodes.episode import Episode
    from stereotrack_core.evaluation.episodes.find import Subject
    from stereotrack_core.evaluation.episodes.matching import Agreement
    from stereotrack_core.recording.description import Recording
    from stereotrack_core.recording.landmarks import LandmarkTrajectory


def add_arguments(parser: ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("run_file", type=Path, metavar="RUN", help="a complete run (.npz)")
    parser.add_argument(
        "--recording",
        type=Path,
        metavar="DIR",
        help="the run's recording; by default the one named in the run",
    )
    parser.add_argument(
        "--no-pictures",
        action="store_true",
        help="classify causes from the run alone, without computing the recording's clouds",
    )
    parser.add_argument(
        "--reference",
        type=Path,
        metavar="FILE",
        help="reference landmarks (.csv, .trc, .c3d, .npz); by default the recording's reference",
    )
    parser.add_argument(
        "--found",
        choices=("truth", "signs"),
        help="only failures detected with the reference (truth), or without it (signs)",
    )
    parser.add_argument(
        "--limb", metavar="LIMB", help="only failures of this limb, for example left_forearm"
    )
    parser.add_argument(
        "--cause", metavar="CAUSE", help="only failures with this cause, for example crossing"
    )
    add_changes(parser, "change a detection parameter, for example episode_error=30")
    parser.add_argument(
        "--strips", type=Path, metavar="DIR", help="folder for an image strip of each failure"
    )
    parser.add_argument("--video", type=Path, metavar="MP4", help="video of all failures")
    parser.add_argument(
        "--view", metavar="VIEW", help="view shown in the strips (default: the best one)"
    )
    add_json(parser)


def run(args: Namespace) -> int:
    """Find, print, and write what is asked for."""
    from stereotrack_core.evaluation.episodes.find import find_episodes

    _check(args)
    subject = _subject(args)
    with progress("Detecting failures", 100) as show, stoppable() as stopped:
        try:
            every = find_episodes(subject, lambda share, _: show(round(100 * share)), stopped)
        except Cancelled:
            say("Stopped. Nothing was written.")
            return FAILED
    chosen = _chosen(every, args)
    agreed = _agreed(every) if subject.reference is not None else None
    if args.json:
        put_json(_facts(args, subject, chosen, agreed))
    elif chosen:
        put_table(_table(args, subject, chosen, agreed))
    else:
        put(f"{_heading(args, 0, agreed)}.")
    try:
        return _export(args, subject, chosen)
    except Cancelled:
        say("Stopped. The output is incomplete.")
        return FAILED


def _check(args: Namespace) -> None:
    """Refuse at once what could only fail after the work."""
    from stereotrack_core.body.limbs import LIMBS
    from stereotrack_core.evaluation.episodes.episode import CAUSE_WORDS

    for option, value, known in (
        ("--limb", args.limb, LIMBS),
        ("--cause", args.cause, tuple(CAUSE_WORDS)),
    ):
        if value is not None and value not in known:
            raise InputError(
                f"unknown value {value!r}", where=option, remedy=f"Use one of {', '.join(known)}."
            )
    if args.strips is not None and args.strips.exists() and not args.strips.is_dir():
        raise InputError(
            "this is a file", where=str(args.strips), remedy="Give the name of a folder."
        )
    if args.strips is not None:
        there = next(one for one in (args.strips, *args.strips.absolute().parents) if one.exists())
        check_output(there / "strip.png")
    if args.video is not None:
        if args.video.suffix.lower() != ".mp4":
            raise InputError(
                "the name of a video must end in .mp4",
                where=str(args.video),
                remedy=f"Use the name {args.video.with_suffix('.mp4').name}.",
            )
        check_output(args.video)


def _subject(args: Namespace) -> Subject:
    from stereotrack_core.cli.sources import recording_of_run
    from stereotrack_core.evaluation.episodes.find import Subject
    from stereotrack_core.evaluation.episodes.stretches import EpisodeRules
    from stereotrack_core.interop.run_file import read_run, read_trajectory
    from stereotrack_core.parameters import parsed_settings
    from stereotrack_core.tracking.stored import fps_of_run

    rules = EpisodeRules().replaced(**parsed_settings(args.changes))
    stored = read_run(args.run_file)
    say_if_unfinished(args.run_file, stored)
    recording = recording_of_run(args.recording, stored, "causes are classified from the run alone")
    reference: LandmarkTrajectory | None = None
    if args.reference is not None:
        reference = read_trajectory(args.reference)
    elif recording is not None:
        reference = recording.reference
    if (args.strips is not None or args.video is not None) and recording is None:
        raise InputError(
            "images require the run's recording", where="--strips, --video",
            remedy="Give its folder with --recording.",
        )  # fmt: skip
    views = [view.name for view in recording.views] if recording is not None else []
    if recording is not None and args.view not in (None, *views):
        raise InputError(
            f"there is no view {args.view!r}",
            where="--view",
            remedy=f"The recording has: {', '.join(views)}.",
        )
    fps = recording.fps if recording is not None else fps_of_run(stored)
    return Subject(stored, fps, reference, recording, rules, pictures=not args.no_pictures)


def _chosen(every: Sequence[Episode], args: Namespace) -> list[Episode]:
    return [
        e
        for e in every
        if (args.limb is None or args.limb in e.limbs)
        and (args.cause is None or e.verdict.cause == args.cause)
        and (args.found is None or e.found == args.found)
    ]


def _agreed(every: Sequence[Episode]) -> Agreement:
    from stereotrack_core.evaluation.episodes.matching import agreement

    return agreement(
        [e for e in every if e.found == "truth"], [e for e in every if e.found == "signs"]
    )


def _facts(
    args: Namespace, subject: Subject, chosen: Sequence[Episode], agreed: Agreement | None
) -> dict[str, Any]:
    facts: dict[str, Any] = {
        "run": args.run_file,
        "fps": subject.fps,
        "rules": subject.rules.values(),
        "episodes": chosen,
    }
    if agreed is not None:
        facts["without_truth"] = {
            "precision": agreed.precision, "recall": agreed.recall, "true": agreed.true,
            "found": agreed.found, "called": agreed.called, "right": agreed.right,
        }  # fmt: skip
    return facts


def _table(
    args: Namespace, subject: Subject, chosen: Sequence[Episode], agreed: Agreement | None
) -> Table:
    from stereotrack_core.evaluation.episodes.episode import limbs_words

    rows = [
        (
            f"{e.first}-{e.last}",
            f"{e.first / subject.fps:.1f}-{(e.last + 1) / subject.fps:.1f}",
            limbs_words(e.limbs),
            e.found,
            e.peak_words,
            e.verdict.cause,
            f"{100.0 * e.verdict.confidence:.0f} %" if e.verdict.confidence else "-",
            e.verdict.words,
        )
        for e in chosen
    ]
    columns = (
        "frames",
        "seconds",
        "limbs",
        "detected by",
        ">peak",
        "cause",
        ">sure",
        "description",
    )
    return Table(_heading(args, len(chosen), agreed), columns, rows)


def _heading(args: Namespace, count: int, agreed: Agreement | None) -> str:
    """How many episodes there are, and how many of the run's are found without truth."""
    heading = f"{counted(count, 'failure') if count else 'No failures'} in {args.run_file}"
    if agreed is None or not (agreed.true or agreed.called):
        return heading
    return (
        f"{heading}; detection without the reference finds {agreed.found} of {agreed.true} true "
        f"failures, and {agreed.right} of its {agreed.called} detections are true"
    )


def _export(args: Namespace, subject: Subject, chosen: Sequence[Episode]) -> int:
    recording = subject.recording
    if recording is None:
        return OK
    if not chosen and (args.strips is not None or args.video is not None):
        say("No failures, so nothing was written.")
        return OK
    if args.strips is not None:
        _write_strips(args, subject, recording, chosen)
    if args.video is not None:
        _write_video(args.video, subject, recording, chosen)
    return OK


def _write_strips(
    args: Namespace, subject: Subject, recording: Recording, chosen: Sequence[Episode]
) -> None:
    from stereotrack_core.evaluation.episodes.export import write_strips

    with progress("Rendering image strips", 100) as show, stoppable() as stopped:
        count = write_strips(
            args.strips, subject, recording, chosen, view=args.view,
            report=lambda share, _: show(round(100 * share)), cancelled=stopped,
        )  # fmt: skip
    say(f"{counted(count, 'strip')} written to {args.strips}.")


def _write_video(
    path: Path, subject: Subject, recording: Recording, chosen: Sequence[Episode]
) -> None:
    from stereotrack_core.evaluation.episodes.export import film_of

    with progress("Rendering video", 100) as show, stoppable() as stopped:
        film_of(
            path, subject, recording, chosen, lambda share, _: show(round(100 * share)), stopped
        )
    say(f"Video written to {path}.")


COMMAND = Command(
    name="episodes",
    summary="detect failures in a run and their probable causes",
    description=(
        "List the failures of limbs: detected by their error where there is a reference, and by "
        "failure probability without it, each with its probable cause and the evidence for it. "
        "Optionally write image strips and a video of them."
    ),
    add_arguments=add_arguments,
    run=run,
)

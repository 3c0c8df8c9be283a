"""``stereotrack episodes``: the stretches in which a run fails, and why."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.cli.arguments import (
    JSON,
    OF_RUN,
    REFERENCE,
    STATED,
    changes,
    check_output,
    check_suffix,
    flag,
    option,
)
from stereotrack_core.cli.output import OK, put, put_json, put_table, say
from stereotrack_core.cli.progress import watched
from stereotrack_core.cli.sources import recording_of_run, reference_of_run, say_if_unfinished
from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.evaluation.failure_segments.export import film_of, write_strips
from stereotrack_core.evaluation.failure_segments.find import FailureSearch, find_failures
from stereotrack_core.evaluation.failure_segments.segment import (
    CAUSE_WORDS,
    Agreement,
    FailureSegment,
    agreement_of,
    limbs_words,
)
from stereotrack_core.evaluation.failure_segments.stretches import FailureRules, has_signs
from stereotrack_core.interop.run_file import read_run
from stereotrack_core.parameters import parsed_settings
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.tables import Table
from stereotrack_core.tracking.stored import fps_of_run

DESCRIPTION = (
    "List the failures of limbs: detected by their error where there is a reference, and by "
    "failure probability without it, each with its probable cause and the evidence for it. "
    "Optionally write image strips and a video of them."
)

OPTIONS = (
    option("run_file RUN", "a complete run (.npz)", type=Path),
    OF_RUN,
    flag(
        "--no-pictures",
        "classify causes from the run alone, without computing the recording's clouds",
    ),
    REFERENCE,
    *STATED,
    option(
        "--found",
        "only failures detected with the reference (truth), or without it (signs)",
        choices=("truth", "signs"),
    ),
    option("--limb LIMB", "only failures of this limb, for example left_forearm"),
    option("--cause CAUSE", "only failures with this cause, for example crossing"),
    changes("change a detection parameter, for example episode_error=30"),
    option("--strips DIR", "folder for an image strip of each failure", type=Path),
    option("--video MP4", "video of all failures", type=Path),
    option("--view VIEW", "view shown in the strips (default: the best one)"),
    JSON,
)

_INCOMPLETE = "The output is incomplete."


def run(args: Namespace) -> int:
    """Find, print, and write what is asked for."""
    _check(args)
    search = _search(args)
    with watched("Detecting failures", "Nothing was written.") as (report, stopped):
        every = find_failures(search, report, stopped)
    chosen = _chosen(every, args)
    agreed = agreement_of(every) if search.reference is not None else None
    if search.reference is None and not has_signs(search.run):
        say(
            "Without depth, failures are detected against a reference alone (--reference). Without "
            "one, only frames that are not tracked are listed."
        )
    if args.json:
        put_json(_facts(args, search, chosen, agreed))
    elif chosen:
        put_table(_table(args, search, chosen, agreed))
    else:
        put(f"{_heading(args, 0, agreed)}.")
    _export(args, search, chosen)
    return OK


def _check(args: Namespace) -> None:
    """Refuse at once what could only fail after the work."""
    for name, value, known in (
        ("--limb", args.limb, LIMBS),
        ("--cause", args.cause, tuple(CAUSE_WORDS)),
    ):
        if value is not None and value not in known:
            raise InputError(
                f"unknown value {value!r}", where=name, remedy=f"Use one of {', '.join(known)}."
            )
    if args.strips is not None and args.strips.exists() and not args.strips.is_dir():
        raise InputError(
            "this is a file", where=str(args.strips), remedy="Give the name of a folder."
        )
    if args.strips is not None:
        there = next(one for one in (args.strips, *args.strips.absolute().parents) if one.exists())
        check_output(there / "strip.png")
    if args.video is not None:
        check_suffix(args.video, ".mp4")
        check_output(args.video)


def _search(args: Namespace) -> FailureSearch:
    rules = FailureRules().replaced(**parsed_settings(args.changes))
    stored = read_run(args.run_file)
    say_if_unfinished(args.run_file, stored)
    recording = recording_of_run(args.recording, stored, "causes are classified from the run alone")
    reference: LandmarkTrajectory | None = None
    if args.reference is not None:
        reference = reference_of_run(args, stored, recording).trajectory()
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
    return FailureSearch(stored, fps, reference, recording, rules, pictures=not args.no_pictures)


def _chosen(every: Sequence[FailureSegment], args: Namespace) -> list[FailureSegment]:
    return [
        e
        for e in every
        if (args.limb is None or args.limb in e.limbs)
        and (args.cause is None or e.verdict.cause == args.cause)
        and (args.found is None or e.found == args.found)
    ]


def _facts(
    args: Namespace,
    search: FailureSearch,
    chosen: Sequence[FailureSegment],
    agreed: Agreement | None,
) -> dict[str, Any]:
    facts: dict[str, Any] = {
        "run": args.run_file,
        "fps": search.fps,
        "rules": search.rules.values(),
        "episodes": chosen,
    }
    if agreed is not None:
        facts["without_truth"] = {
            "precision": agreed.precision, "recall": agreed.recall, "true": agreed.true,
            "found": agreed.found, "called": agreed.called, "right": agreed.right,
        }  # fmt: skip
    return facts


def _table(
    args: Namespace,
    search: FailureSearch,
    chosen: Sequence[FailureSegment],
    agreed: Agreement | None,
) -> Table:
    rows = [
        (
            f"{e.first}-{e.last}",
            f"{e.first / search.fps:.1f}-{(e.last + 1) / search.fps:.1f}",
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
        *("frames", "seconds", "limbs", "detected by"),
        *(">peak", "cause", ">sure", "description"),
    )
    return Table(_heading(args, len(chosen), agreed), columns, rows)


def _heading(args: Namespace, count: int, agreed: Agreement | None) -> str:
    """How many failures there are, and how many of the run's are found without truth."""
    heading = f"{counted(count, 'failure') if count else 'No failures'} in {args.run_file}"
    if agreed is None or not (agreed.true or agreed.called):
        return heading
    return f"{heading}; {agreed.words}"


def _export(args: Namespace, search: FailureSearch, chosen: Sequence[FailureSegment]) -> None:
    recording = search.recording
    if recording is None or (args.strips is None and args.video is None):
        return
    if not chosen:
        say("No failures, so nothing was written.")
        return
    if args.strips is not None:
        with watched("Rendering image strips", _INCOMPLETE) as (report, stopped):
            count = write_strips(
                args.strips, search, recording, chosen, view=args.view, report=report,
                cancelled=stopped,
            )  # fmt: skip
        say(f"{counted(count, 'strip')} written to {args.strips}.")
    if args.video is not None:
        with watched("Rendering video", _INCOMPLETE) as (report, stopped):
            film_of(args.video, search, recording, chosen, report, stopped)
        say(f"Video written to {args.video}.")

"""``stereotrack fit --personalise``: a subject's file from a few clicked frames."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Mapping, Sequence
from pathlib import Path

from stereotrack_core.annotation.click import Click
from stereotrack_core.annotation.fit.settings import FitSettings
from stereotrack_core.annotation.personal_subject import (
    PersonalSubject,
    clicked_lengths,
    clicks_by_frame,
    lean_words,
    left_out_words,
    offset_table,
    personal_subject,
    tracked_for,
)
from stereotrack_core.body.proportions import Proportions, proportions_of
from stereotrack_core.cli.arguments import check_suffix
from stereotrack_core.cli.output import OK, put_json, put_table, say
from stereotrack_core.cli.progress import progress, stoppable
from stereotrack_core.errors import InputError
from stereotrack_core.interop.run_file import read_run
from stereotrack_core.recording.description import Recording, read_subject, write_subject
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.repeating import other_files

MEASURED = "measured"
"""What ``--subject`` names instead of a file: lengths measured from the clicks."""


def personal_lengths(args: Namespace, recording: Recording, clicks: Sequence[Click]) -> Proportions:
    """Lengths of a subject file, or those that the clicks tell where there is none."""
    if args.subject not in (None, MEASURED):
        return proportions_of(read_subject(Path(args.subject)))
    if args.subject is None and recording.subject is not None:
        return proportions_of(recording.subject)
    return clicked_lengths(recording, clicks, args.views)


def personalise(
    args: Namespace,
    recording: Recording,
    clicks: Sequence[Click],
    proportions: Proportions,
    settings: FitSettings,
    sigma: Mapping[str, float] | float,
) -> int:
    """Estimate, print, and write the subject file."""
    check_suffix(args.output, ".toml")
    by_frame = clicks_by_frame(recording, clicks, sigma, args.views)
    if not by_frame:
        raise InputError(
            "there is no click", where=str(args.clicks), remedy="Click a few frames first."
        )
    run = _run(args.tracked, recording, proportions, max(by_frame) + 1)
    found = personal_subject(run, by_frame, recording, settings, str(args.clicks))
    write_subject(args.output, found.subject)
    _tell(args, found)
    return OK


def _run(path: Path | None, recording: Recording, lengths: Proportions, end: int) -> Run:
    """The run that is named, or the frames up to the last clicked one, tracked now."""
    if path is not None:
        run = read_run(path)
        for sentence in other_files(run, recording):
            say(f"{path}: {sentence}")
        return run
    with progress("Tracking", end) as show, stoppable("Nothing was written.") as stopped:
        return tracked_for(recording, lengths, end, lambda frame: show(frame + 1), stopped)


def _tell(args: Namespace, one: PersonalSubject) -> None:
    if args.json:
        found, (degrees, spread) = one.found, one.lean
        put_json(
            {
                "subject": args.output,
                "frames": found.frames,
                "left_out": [{"frame": f, "landmark": name} for f, name in found.left_out],
                "offsets_m": dict(zip(LANDMARKS, found.offsets.tolist(), strict=True)),
                "sigma_m": dict(zip(LANDMARKS, found.sigma.tolist(), strict=True)),
                "lean_deg": degrees,
                "lean_sigma_deg": spread,
            }
        )
        return
    put_table(offset_table(one))
    say(lean_words(one))
    for words in left_out_words(one):
        say(words)
    say(f"Written to {args.output}. Name it as subject in recording.toml to use it.")

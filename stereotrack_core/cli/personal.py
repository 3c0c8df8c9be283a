"""``stereotrack fit --personalise``: a subject's file from a few clicked frames."""

from __future__ import annotations

import dataclasses
from argparse import Namespace
from collections import defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from stereotrack_core.annotation.click import Click, measurements
from stereotrack_core.annotation.click_points import click_pixels, measured_lengths
from stereotrack_core.annotation.fit.fit import ClickFit, clicks_in
from stereotrack_core.annotation.fit.settings import FitSettings
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.annotation.personalise import (
    PersonalOffsets,
    clicked_frame,
    lengths_by_clicks,
    personal_offsets,
)
from stereotrack_core.body.offsets import offsets_by_landmark
from stereotrack_core.body.proportions import Proportions, proportions_of
from stereotrack_core.cli.arguments import check_suffix
from stereotrack_core.cli.output import OK, put_json, put_table, say
from stereotrack_core.cli.progress import progress, stoppable
from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.interop.run_file import read_run
from stereotrack_core.recording.description import (
    Recording,
    Subject,
    read_subject,
    write_subject,
)
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.tables import Table
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.repeating import other_files
from stereotrack_core.tracking.run import track
from stereotrack_core.tracking.run_spec import RunSpec
from stereotrack_core.tracking.stored import body_of_run, pose_of_run, subject_of_meta

_PRESET = "accurate"

MEASURED = "measured"
"""What ``--subject`` names instead of a file: lengths measured from the clicks."""


def personal_lengths(args: Namespace, recording: Recording, clicks: Sequence[Click]) -> Proportions:
    """Lengths of a subject file, or those that the clicks tell where there is none."""
    if args.subject not in (None, MEASURED):
        return proportions_of(read_subject(Path(args.subject)))
    if args.subject is None and recording.subject is not None:
        return proportions_of(recording.subject)
    used = clicks_in(recording, clicks, args.views)
    return lengths_by_clicks(measured_lengths(click_pixels(used, recording.cameras, LANDMARKS)))


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
    by_frame: dict[int, list[Click]] = defaultdict(list)
    for click in measurements(clicks_in(recording, clicks, args.views), NINE.names, sigma):
        by_frame[click.frame].append(click)
    if not by_frame:
        raise InputError(
            "there is no click", where=str(args.clicks), remedy="Click a few frames first."
        )
    own = recording.subject or Subject(recording.name)
    known = dataclasses.replace(own, **dataclasses.asdict(proportions))
    run = _run(args.tracked, dataclasses.replace(recording, subject=known), max(by_frame) + 1)
    found = offsets_in(run, by_frame, recording, settings)
    if not found.frames:
        raise InputError(
            "no clicked frame is tracked and clicked well enough",
            where=str(args.clicks),
            remedy="Click the trunk and the arms in at least two views of frames in which the "
            "tracker follows the person.",
        )
    tracked = subject_of_meta(run.meta) or Subject()
    lengths = body_of_run(run).skeleton.proportions
    subject = dataclasses.replace(
        dataclasses.replace(tracked, **dataclasses.asdict(lengths)),
        name=own.name or recording.name,
        offsets=offsets_by_landmark(found.offsets),
    )
    write_subject(args.output, subject)
    _tell(args, found, lengths.torso_length)
    return OK


def _run(path: Path | None, recording: Recording, end: int) -> Run:
    """The run that is named, or the frames up to the last clicked one, tracked now."""
    if path is not None:
        run = read_run(path)
        for sentence in other_files(run, recording):
            say(f"{path}: {sentence}")
        return run
    unaided = dataclasses.replace(recording, reference=None)
    spec = RunSpec(preset(_PRESET, ()), preset=_PRESET, frames=range(end))
    with progress("Tracking", end) as show, stoppable("Nothing was written.") as stopped:
        return track(
            unaided, spec, on_frame=lambda tracked: show(tracked.frame + 1), cancelled=stopped
        )


def offsets_in(
    run: Run, by_frame: dict[int, list[Click]], recording: Recording, settings: FitSettings
) -> PersonalOffsets:
    """Offsets that the clicked frames of a run tell; frames that are not tracked tell nothing."""
    body = body_of_run(run)
    fit = ClickFit(recording.cameras, NINE, body.skeleton.proportions, settings, fps=recording.fps)
    clicked = []
    for i in np.flatnonzero(np.isin(run.frame, list(by_frame))):
        frame, pose = int(run.frame[i]), pose_of_run(run, int(i))
        if pose is not None:
            clicked.append(clicked_frame(frame, by_frame[frame], fit, body, pose))
    return personal_offsets(clicked)


def _tell(args: Namespace, found: PersonalOffsets, torso_length: float) -> None:
    offsets, sigma = 1000.0 * found.offsets, 1000.0 * found.sigma
    degrees, spread = found.lean(torso_length)
    if args.json:
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
    rows = [
        (name.replace("_", " "), *(f"{v:+.0f} ± {s:.0f}" for v, s in zip(*row, strict=True)))
        for name, *row in zip(LANDMARKS, offsets, sigma, strict=True)
    ]
    title = f"offsets from {counted(len(found.frames), 'clicked frame')}, mm"
    put_table(
        Table(title, ("landmark", ">right / along", ">front / inwards", ">up / across"), rows)
    )
    say(f"The trunk leans {degrees:+.1f} ± {spread:.1f} degrees forward of the tracked one.")
    for frame, name in found.left_out:
        place = name.replace("_", " ")
        say(f"frame {frame}, {place}: tracker and clicks contradict each other; left out")
    say(f"Written to {args.output}. Name it as subject in recording.toml to use it.")

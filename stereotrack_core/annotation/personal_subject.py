"""From a few clicked frames and what was tracked there to a subject: lengths and offsets."""

from __future__ import annotations

import dataclasses
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stereotrack_core.annotation.click import Click, measurements
from stereotrack_core.annotation.click_points import click_pixels, measured_lengths
from stereotrack_core.annotation.fit.fit import ClickFit, clicks_in
from stereotrack_core.annotation.fit.state import FitSettings
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.annotation.personalise import (
    PersonalOffsets,
    clicked_frame,
    lengths_by_clicks,
    personal_offsets,
)
from stereotrack_core.body.offsets import offsets_by_landmark
from stereotrack_core.body.proportions import Proportions, proportions_of
from stereotrack_core.counting import counted
from stereotrack_core.errors import Cancelled, InputError
from stereotrack_core.recording.description import Recording, Subject
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.tables import Table
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run import track
from stereotrack_core.tracking.run_spec import Hooks, RunSpec
from stereotrack_core.tracking.stored import body_of_run, pose_of_run, subject_of_meta
from stereotrack_core.worker_processes import Asker

PRESET = "accurate"
"""What a recording is tracked with where there is no run yet."""

FEWEST = 3
"""Clicked frames that bring the first gain (docs/personal.md)."""

ClicksByFrame = Mapping[int, Sequence[Click]]


@dataclass(frozen=True, eq=False)
class PersonalSubject:
    """A subject by clicks, the one that was tracked before, and how certain the offsets are."""

    subject: Subject
    before: Subject
    """With all lengths of the body that was tracked."""
    found: PersonalOffsets

    @property
    def lean(self) -> tuple[float, float]:
        """Degrees by which the trunk leans forward of the tracked one, and their sigma."""
        return self.found.lean(proportions_of(self.subject).torso_length)


def clicks_by_frame(
    recording: Recording,
    clicks: Sequence[Click],
    sigma: Mapping[str, float] | float,
    views: Sequence[str] | None = None,
) -> dict[int, list[Click]]:
    """Clicks of the nine landmarks as measurements, by frame."""
    by_frame: dict[int, list[Click]] = defaultdict(list)
    for click in measurements(clicks_in(recording, clicks, views), NINE.names, sigma):
        by_frame[click.frame].append(click)
    return dict(by_frame)


def clicked_lengths(
    recording: Recording, clicks: Sequence[Click], views: Sequence[str] | None = None
) -> Proportions:
    """Lengths that the clicks tell, held to those of average people."""
    used = clicks_in(recording, clicks, views)
    return lengths_by_clicks(measured_lengths(click_pixels(used, recording.cameras, LANDMARKS)))


def tracked_for(
    recording: Recording,
    lengths: Proportions,
    end: int,
    on_frame: Callable[[int], None],
    cancelled: Callable[[], bool],
) -> Run:
    """The frames before `end`, tracked now with these lengths."""
    own = recording.subject or Subject(recording.name)
    known = dataclasses.replace(own, **dataclasses.asdict(lengths))
    unaided = dataclasses.replace(recording, reference=None, subject=known)
    spec = RunSpec(preset(PRESET, ()), preset=PRESET, frames=range(end))
    return track(
        unaided,
        spec,
        on_advance=lambda advance: on_frame(advance.gained.first),
        hooks=Hooks(cancelled=cancelled),
    )


def personal_subject(
    run: Run, by_frame: ClicksByFrame, recording: Recording, settings: FitSettings, where: str
) -> PersonalSubject:
    """Lengths and offsets that clicked frames of a run tell; frames not tracked tell nothing.

    Raises InputError, of `where`, if no frame is tracked and clicked well enough.
    """
    body = body_of_run(run)
    fit = ClickFit(recording.cameras, NINE, body.skeleton.proportions, settings, fps=recording.fps)
    clicked = []
    for i in np.flatnonzero(np.isin(run.frame, list(by_frame))):
        frame, pose = int(run.frame[i]), pose_of_run(run, int(i))
        if pose is not None:
            clicked.append(clicked_frame(frame, by_frame[frame], fit, body, pose))
    found = personal_offsets(clicked)
    if not found.frames:
        raise InputError(
            "no clicked frame is tracked and clicked well enough",
            where=where,
            remedy="Click the trunk and the arms in at least two views of frames in which the "
            "tracker follows the person.",
        )
    tracked = subject_of_meta(run.meta) or Subject()
    lengths = body.skeleton.proportions
    before = dataclasses.replace(tracked, **dataclasses.asdict(lengths))
    own = recording.subject or Subject()
    return PersonalSubject(
        dataclasses.replace(
            before,
            name=own.name or recording.name,
            offsets=offsets_by_landmark(found.offsets),
        ),
        before,
        found,
    )


def offset_table(one: PersonalSubject) -> Table:
    """Offsets of every landmark with their standard deviations, and those before."""
    rows = []
    for name, offsets, sigma in zip(LANDMARKS, one.found.offsets, one.found.sigma, strict=True):
        before = 1000.0 * np.array(one.before.offsets.get(name, (0.0, 0.0, 0.0)))
        cells = (
            f"{1000 * value:+z.0f} ± {1000 * spread:.0f}"
            for value, spread in zip(offsets, sigma, strict=True)
        )
        was = " ".join(f"{value:+z.0f}" for value in before) if before.any() else "none"
        rows.append((name.replace("_", " "), *cells, was))
    title = f"Offsets from {counted(len(one.found.frames), 'clicked frame')}, mm"
    heads = ("landmark", ">right / along", ">front / inwards", ">up / across", ">before")
    return Table(title, heads, rows)


def lean_words(one: PersonalSubject) -> str:
    """``The trunk leans +1.2 ± 0.4 degrees forward of the tracked one.``"""
    degrees, spread = one.lean
    return f"The trunk leans {degrees:+z.1f} ± {spread:.1f} degrees forward of the tracked one."


def left_out_words(one: PersonalSubject) -> tuple[str, ...]:
    """Landmarks that the estimate leaves out, a sentence each."""
    return tuple(
        f"frame {frame}, {name.replace('_', ' ')}: tracker and clicks contradict each other; left "
        "out"
        for frame, name in one.found.left_out
    )


@dataclass(frozen=True, eq=False)
class Personalise:
    """The same as a task of a process, which tracks first where there is no run."""

    recording: Recording
    """With the subject that is known."""
    clicks: tuple[Click, ...]
    sigma: Mapping[str, float]
    settings: FitSettings
    where: str
    run: Run | None = None

    def __call__(self, asker: Asker) -> PersonalSubject:
        """Do it in the process."""
        by_frame = clicks_by_frame(self.recording, self.clicks, self.sigma)
        run = self.run
        if run is None:
            subject = self.recording.subject
            lengths = (
                clicked_lengths(self.recording, self.clicks)
                if subject is None
                else proportions_of(subject)
            )
            run = tracked_for(
                self.recording, lengths, max(by_frame) + 1, lambda _frame: asker.on_frames(1),
                asker.cancelled,
            )  # fmt: skip
            if asker.cancelled():
                raise Cancelled
        return personal_subject(run, by_frame, self.recording, self.settings, self.where)

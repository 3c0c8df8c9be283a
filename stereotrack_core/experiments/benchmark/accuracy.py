"""Errors of several ways of tracking on the same recordings, over several seeds."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stereotrack_core.errors import InputError
from stereotrack_core.evaluation.errors import knows_something, truth_of
from stereotrack_core.experiments.measures import measured
from stereotrack_core.experiments.runner.lockstep import RunInput, cloud_key, track_together
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.tracking.run_spec import RunSpec


@dataclass(frozen=True)
class Column:
    """One number of the table that a run is judged by; see the measure of that name.

    Attributes
    ----------
    name : str
    label : str
        For people.
    unit : str
    """

    name: str
    label: str
    unit: str


MEASURES: tuple[Column, ...] = (
    Column("torso_position", "torso", "mm"),
    Column("torso_long", "long axis", "deg"),
    Column("torso_cross", "cross axis", "deg"),
    Column("upper_arms", "upper arms", "deg"),
    Column("upper_arms_p95", "upper arms 95 %", "deg"),
    Column("forearms", "forearms", "deg"),
    Column("forearms_p95", "forearms 95 %", "deg"),
    Column("lost", "lost", "%"),
    Column("not_tracked", "not tracked", "%"),
)
"""What the table says of every run; a frame that is not tracked counts 90 deg and 500 mm."""


@dataclass(frozen=True)
class Score:
    """Errors of one run.

    Attributes
    ----------
    recording : str
    contestant : str
    seed : int
    frames : int
        Frames that the reference knows.
    values : mapping from measure to float
        In the measures' units.
    """

    recording: str
    contestant: str
    seed: int
    frames: int
    values: Mapping[str, float]


@dataclass(frozen=True)
class Row:
    """What all seeds of one contestant on one recording give together.

    Attributes
    ----------
    recording : str
    contestant : str
    seeds : int
    frames : int
    mean : mapping from measure to float
    spread : mapping from measure to float
        Standard deviation over the seeds; NaN for a single one.
    """

    recording: str
    contestant: str
    seeds: int
    frames: int
    mean: Mapping[str, float]
    spread: Mapping[str, float]


def accuracy(
    recording: Recording,
    specs: Mapping[str, RunSpec],
    seeds: Sequence[int],
    *,
    on_frames: Callable[[int], None] = lambda _: None,
    cancelled: Callable[[], bool] = lambda: False,
) -> tuple[Score, ...]:
    """Track a recording with every contestant and every seed, and measure the errors.

    All that see the same clouds go forward together.

    Parameters
    ----------
    recording : Recording
        Has a reference, which no tracker sees.
    specs : mapping from name to RunSpec
        The contestants, with the same frames.
    seeds : sequence of int
    on_frames : callable, optional
        Told how many frames more are tracked, of those of all contestants with all seeds.
    cancelled : callable, optional
        Asked after every frame whether to stop.

    Raises
    ------
    InputError
        Where the recording has no reference, or it knows none of the frames.
    Cancelled
    """
    reference = _reference_within(recording, specs)
    blind = dataclasses.replace(recording, reference=None)
    groups: dict[object, list[tuple[str, int]]] = {}
    for name, spec in specs.items():
        groups.setdefault(cloud_key(spec), []).extend((name, seed) for seed in seeds)
    scores: dict[tuple[str, int], Score] = {}
    for own in groups.values():
        inputs = [
            RunInput(blind, dataclasses.replace(specs[name], seed=seed)) for name, seed in own
        ]
        together = track_together(inputs, on_frames=on_frames, cancelled=cancelled)
        for (name, seed), tracked in zip(own, together, strict=True):
            values = measured(tracked.run(), reference)
            chosen = {column.name: values[column.name] for column in MEASURES}
            frames = int(knows_something(reference).sum())
            scores[name, seed] = Score(recording.name, name, seed, frames, chosen)
    return tuple(scores[name, seed] for name in specs for seed in seeds)


def pooled(scores: Sequence[Score]) -> tuple[Row, ...]:
    """Mean and spread over seeds, in the order in which recordings and contestants come."""
    groups: dict[tuple[str, str], list[Score]] = {}
    for score in scores:
        groups.setdefault((score.recording, score.contestant), []).append(score)
    rows = []
    for (recording, contestant), own in groups.items():
        values = np.array([[score.values[m.name] for m in MEASURES] for score in own])
        spread = values.std(axis=0, ddof=1) if len(own) > 1 else np.full(len(MEASURES), np.nan)
        names = [measure.name for measure in MEASURES]
        mean = dict(zip(names, values.mean(axis=0).tolist(), strict=True))
        row = Row(
            recording,
            contestant,
            len(own),
            own[0].frames,
            mean,
            dict(zip(names, spread.tolist(), strict=True)),
        )
        rows.append(row)
    return tuple(rows)


def _reference_within(recording: Recording, specs: Mapping[str, RunSpec]) -> LandmarkTrajectory:
    """What the reference knows of the frames that are tracked."""
    reference = truth_of(recording)
    with FrameReader(recording, read_ahead=0) as reader:
        frames = next(iter(specs.values())).frames_of(reader.frame_count)
    inside = (reference.frame >= frames.start) & (reference.frame < frames.stop)
    if not np.any(inside & knows_something(reference)):
        raise InputError(
            "the reference contains none of the frames",
            where=str(recording.folder),
            remedy="Choose frames that it contains.",
        )
    return LandmarkTrajectory(reference.frame[inside], reference.points[inside])

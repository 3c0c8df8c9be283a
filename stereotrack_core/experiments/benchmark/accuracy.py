"""Errors of several ways of tracking on the same recordings, over several seeds.

All runs of one recording go forward frame by frame together, so that each cloud is made once for
all that have the same depth parameters and forgotten when the last run has taken it.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.errors import Cancelled, InputError
from stereotrack_core.evaluation.errors import knows_something, truth_of
from stereotrack_core.evaluation.summary import Summary, evaluate
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.tracking.frame import TrackedFrame
from stereotrack_core.tracking.pipeline import Pipeline
from stereotrack_core.tracking.run_spec import FirstPose, RunSpec
from stereotrack_core.tracking.settings import Settings
from stereotrack_core.tracking.shared_clouds import SharedClouds


@dataclass(frozen=True)
class Contestant:
    """One way of tracking.

    Attributes
    ----------
    name : str
    settings : Settings
    """

    name: str
    settings: Settings


@dataclass(frozen=True)
class Measured:
    """One number that a run is judged by.

    Attributes
    ----------
    name : str
    label : str
        For people.
    unit : str
    of : callable
        Takes it from the errors of a run.
    """

    name: str
    label: str
    unit: str
    of: Callable[[Summary], float]


def _mean(name: str) -> Callable[[Summary], float]:
    return lambda summary: summary.measure(name).statistics.mean


def _p95(name: str) -> Callable[[Summary], float]:
    return lambda summary: summary.measure(name).statistics.p95


MEASURES: tuple[Measured, ...] = (
    Measured("torso_position", "torso", "mm", _mean("torso_position")),
    Measured("torso_long", "long axis", "deg", _mean("torso_long")),
    Measured("torso_cross", "cross axis", "deg", _mean("torso_cross")),
    Measured("upper_arms", "upper arms", "deg", _mean("upper_arms")),
    Measured("upper_arms_p95", "upper arms 95 %", "deg", _p95("upper_arms")),
    Measured("forearms", "forearms", "deg", _mean("forearms")),
    Measured("forearms_p95", "forearms 95 %", "deg", _p95("forearms")),
    Measured("lost", "lost", "%", lambda summary: 100.0 * summary.lost),
    Measured(
        "not_tracked",
        "not tracked",
        "%",
        lambda summary: 100.0 * summary.not_tracked / max(1, summary.frames),
    ),
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
    contestants: Sequence[Contestant],
    seeds: Sequence[int],
    frames: range,
    *,
    views: Sequence[str] | None = None,
    init: FirstPose = "auto",
    on_progress: Callable[[int], None] = lambda _: None,
    cancelled: Callable[[], bool] = lambda: False,
) -> tuple[Score, ...]:
    """Track a recording with every contestant and every seed, and measure the errors.

    Parameters
    ----------
    recording : Recording
        Has a reference, which no tracker sees.
    contestants : sequence of Contestant
    seeds : sequence of int
    frames : range
    views : sequence of str, optional
        Views to use; all that give depth when not given.
    init : str or Pose
        First pose; see :class:`Pipeline`.
    on_progress : callable, optional
        Told how many frames are tracked, of ``len(frames) * len(contestants) * len(seeds)``.
    cancelled : callable, optional
        Asked after every frame whether to stop.

    Raises
    ------
    InputError
        Where the recording has no reference, or it knows none of the frames.
    Cancelled
    """
    reference = _reference_within(recording, frames)
    blind = dataclasses.replace(recording, reference=None)
    scores: dict[tuple[str, int], Score] = {}
    done = 0
    for group in _same_clouds(contestants):
        entries = [(contestant, seed) for contestant in group for seed in seeds]
        landmarks: list[list[FloatArray]] = [[] for _ in entries]
        with closing(_abreast(blind, entries, frames, views, init)) as together:
            for tracked in together:
                for own, frame in zip(landmarks, tracked, strict=True):
                    own.append(frame.landmarks)
                done += len(entries)
                on_progress(done)
                if cancelled():
                    raise Cancelled
        for (contestant, seed), points in zip(entries, landmarks, strict=True):
            found = LandmarkTrajectory(np.array(frames), np.array(points))
            summary = evaluate(found, reference)
            values = {measure.name: measure.of(summary) for measure in MEASURES}
            score = Score(recording.name, contestant.name, seed, summary.frames, values)
            scores[contestant.name, seed] = score
    return tuple(scores[c.name, seed] for c in contestants for seed in seeds)


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


def _abreast(
    recording: Recording,
    entries: Sequence[tuple[Contestant, int]],
    frames: range,
    views: Sequence[str] | None,
    init: FirstPose,
) -> Generator[tuple[TrackedFrame, ...], None, None]:
    """Track with all entries at once, who see the same clouds, frame by frame."""
    with ExitStack() as stack:
        first = stack.enter_context(
            Pipeline(recording, RunSpec(entries[0][0].settings, views=views))
        )
        clouds = SharedClouds(first.chain, first.reader, len(entries))
        runs = []
        for contestant, seed in entries:
            pipeline = Pipeline(
                recording,
                RunSpec(contestant.settings, views=views, seed=seed, init=init),
                clouds=clouds,
            )
            stack.enter_context(pipeline)
            runs.append(stack.enter_context(closing(pipeline.frames(frames))))
        yield from zip(*runs, strict=True)


def _same_clouds(contestants: Sequence[Contestant]) -> list[list[Contestant]]:
    """Contestants in groups that see the same clouds."""
    groups: list[list[Contestant]] = []
    for contestant in contestants:
        for group in groups:
            if _seen(group[0].settings) == _seen(contestant.settings):
                group.append(contestant)
                break
        else:
            groups.append([contestant])
    return groups


def _seen(settings: Settings) -> tuple[DepthParameters, bool]:
    """All that clouds depend on."""
    return settings.depth, settings.tracking.wants_colour


def _reference_within(recording: Recording, frames: range) -> LandmarkTrajectory:
    reference = truth_of(recording)
    inside = (reference.frame >= frames.start) & (reference.frame < frames.stop)
    if not np.any(inside & knows_something(reference)):
        raise InputError(
            "the reference knows none of the frames",
            where=str(recording.folder),
            remedy="Choose frames that it knows.",
        )
    return LandmarkTrajectory(reference.frame[inside], reference.points[inside])

"""Errors of several ways of tracking on the same recordings, over several seeds."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from stereotrack_core.evaluation.errors import knows_something, reference_within
from stereotrack_core.evaluation.summary import Spread
from stereotrack_core.experiments.measures import measured
from stereotrack_core.experiments.runner.lockstep import RunInput, cloud_key, track_together
from stereotrack_core.parameters import Value
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.tracking.run_spec import RunSpec

MEASURES = (
    *("torso_position", "torso_long", "torso_cross", "upper_arms", "upper_arms_p95"),
    *("forearms", "forearms_p95", "lost", "not_tracked"),
)
"""What the table says of every run; a frame that is not tracked counts 90 deg and 500 mm."""


@dataclass(frozen=True)
class Score:
    """Errors of one run."""

    recording: str
    contestant: str
    seed: int
    frames: int
    """Frames that the reference knows."""
    values: Mapping[str, float]
    """By measure, in the measures' units."""


@dataclass(frozen=True)
class Row:
    """What all seeds of one contestant on one recording give together, by measure."""

    recording: str
    contestant: str
    seeds: int
    frames: int
    values: Mapping[str, Spread]
    speed: Mapping[str, float] = field(default_factory=dict)
    """Frames per second and ratio to block matching; empty where nothing was timed."""


def accuracy(
    recording: Recording,
    specs: Mapping[str, RunSpec],
    seeds: Sequence[int],
    *,
    on_frames: Callable[[int], None] = lambda _: None,
    cancelled: Callable[[], bool] = lambda: False,
) -> tuple[Score, ...]:
    """Track a recording with every contestant and every seed, and measure the errors.

    All that see the same clouds go forward together, through the same frames; none sees the
    reference. `on_frames` is told how many frames more are tracked, of those of all contestants
    with all seeds. Raises InputError where there is no reference, or it knows none of the frames,
    and Cancelled.
    """
    with FrameReader(recording, read_ahead=0) as reader:
        frames = next(iter(specs.values())).frames_of(reader.frame_count)
    reference = reference_within(recording, frames)
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
            chosen = {name: values[name] for name in MEASURES}
            known = int(knows_something(reference).sum())
            scores[name, seed] = Score(recording.name, name, seed, known, chosen)
    return tuple(scores[name, seed] for name in specs for seed in seeds)


def pooled(
    scores: Sequence[Score], speeds: Mapping[tuple[str, str], Mapping[str, float]]
) -> tuple[Row, ...]:
    """Mean and spread over seeds, in the order in which recordings and contestants come."""
    groups: dict[tuple[str, str], list[Score]] = {}
    for score in scores:
        groups.setdefault((score.recording, score.contestant), []).append(score)
    return tuple(
        Row(
            recording,
            contestant,
            len(own),
            own[0].frames,
            {name: Spread.of(score.values[name] for score in own) for name in MEASURES},
            speeds.get((recording, contestant), {}),
        )
        for (recording, contestant), own in groups.items()
    )


@dataclass(frozen=True)
class Ablation:
    """One part of ``accurate`` that is left out, or exchanged for the plain way."""

    name: str
    """As the table calls it."""
    changes: Mapping[str, Value] = field(default_factory=dict)
    """By parameter, what differs from ``accurate``."""


ABLATIONS: tuple[Ablation, ...] = (
    Ablation("no arm search", {"search_arms": False}),
    Ablation("no silhouettes", {"measure_silhouettes": False}),
    Ablation("no render-and-compare", {"picture_cost": 0.0}),
    Ablation("with free space", {"sight_cost": 1.0}),
    Ablation("a third of the proposals", {"search_proposals": 73}),
    Ablation("no fitted shape", {"fit_shape": False}),
    Ablation("no legs", {"legs": False}),
    Ablation("average proportions", {"proportions": "average"}),
    Ablation("no colours", {"colour_weight": 0.0}),
    Ablation("wide loss scale throughout", {"loss_scale": 0.12}),
    Ablation("no robust loss", {"first_loss_scale": 2.0, "loss_scale": 2.0}),
    Ablation("no prior inflation", {"prior_inflation_above": 100.0}),
    Ablation("the thesis's process noise", {"sigma_rotation": 20.0, "sigma_joint": 40.0}),
    Ablation("three iterations", {"iterations": 3}),
    Ablation("300 data", {"data_points": 300}),
    Ablation("no collisions", {"clearance": 0.0}),
    Ablation("full-image matching", {"match_region": "whole"}),
    Ablation("no left-right check", {"match_left_right": -1}),
    Ablation("background without silhouette evidence", {"background_doubt": False}),
)
"""Each row against ``accurate`` says what its part brings."""

"""Time of a frame, part by part, and how it grows with the number of points (figure 4.4)."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.experiments.benchmark.growth import step_milliseconds
from stereotrack_core.experiments.benchmark.speed import exponent, median
from stereotrack_core.recording.description import Recording
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run import Pipeline
from stereotrack_core.tracking.run_spec import RunSpec
from stereotrack_core.tracking.shared_clouds import read_cloud

MODEL_POINTS = (24, 40, 64, 120, 240, 480, 960)
DATA_POINTS = (200, 400, 800, 1600, 3200)
_STEREO = ("rectify", "match", "subpixel")
_SEGMENTATION = ("background", "patches", "points", "outliers", "colours")


@dataclass(frozen=True)
class StepCost:
    """Processor time of one correction of a frame with so many points."""

    points: int
    milliseconds: float


@dataclass(frozen=True)
class Timing:
    """Times of one preset.

    Attributes
    ----------
    usual_points : int
        Points that the preset uses.
    filter_ms : float
        Processor time of the tracker's step, without what it says about its own errors.
    stereo_ms_per_view, segmentation_ms : float
        Time of the stages before it: matching for each view; background, outliers and all else
        that makes the cloud of matched pictures, for all views together. Wall time.
    costs : tuple of StepCost
        The tracker's step by number of points: model points for ``thesis``, data for others.
    """

    preset: str
    usual_points: int
    filter_ms: float
    stereo_ms_per_view: float
    segmentation_ms: float
    costs: tuple[StepCost, ...]

    def exponent(self) -> float:
        """Exponent e of time ~ points^e over the measured range; NaN for a single size."""
        sizes = [cost.points for cost in self.costs]
        return exponent(sizes, [cost.milliseconds for cost in self.costs])


def timing(
    recording: Recording,
    name: str,
    *,
    frames: int = 8,
    on_progress: Callable[[int], None] = lambda _: None,
) -> Timing:
    """Time a preset on the first frames of a recording; nothing else should run meanwhile.

    Parameters
    ----------
    name : str
        Of the preset.
    frames : int
        Frames in each of which every size is timed; medians count.
    on_progress : callable, optional
        Told how many sizes are done.
    """
    settings = preset(name)
    samples = settings.tracking.matching == "model_to_data"
    key = "model_points" if samples else "data_points"
    usual = int(settings.values()[key])
    blind = dataclasses.replace(recording, reference=None)
    clouds = _clouds(blind, settings, frames)
    most = min((len(cloud.points) for cloud in clouds), default=0)
    wanted = sorted({usual, *(MODEL_POINTS if samples else DATA_POINTS)})
    sizes = [size for size in wanted if samples or size <= most or size == usual]
    costs = []
    # what is compiled at first use shall not be timed
    step_milliseconds(blind, settings.replaced(fit_shape=False), clouds[:2])
    for done, size in enumerate(sizes, start=1):
        own = settings.replaced(**{key: size, "fit_shape": False})
        costs.append(StepCost(size, step_milliseconds(blind, own, clouds, judging=False)))
        on_progress(done)
    return Timing(
        preset=name,
        usual_points=usual,
        filter_ms=next(cost.milliseconds for cost in costs if cost.points == usual),
        stereo_ms_per_view=_stage_ms(clouds, _STEREO) / max(1, len(clouds[0].view_names)),
        segmentation_ms=_stage_ms(clouds, _SEGMENTATION),
        costs=tuple(costs),
    )


def _clouds(recording: Recording, settings: Settings, frames: int) -> list[Cloud]:
    with Pipeline(recording, RunSpec(settings, init="tpose")) as pipeline:
        count = min(frames, pipeline.reader.frame_count)
        pipeline.chain.learn_background(pipeline.reader, range(count))
        return [read_cloud(pipeline.chain, pipeline.reader, frame)[0] for frame in range(count)]


def _stage_ms(clouds: Sequence[Cloud], stages: Sequence[str]) -> float:
    """Median over frames of the time of some stages, summed over views."""
    return 1000.0 * median([sum(c.seconds.get(s, 0.0) for s in stages) for c in clouds])

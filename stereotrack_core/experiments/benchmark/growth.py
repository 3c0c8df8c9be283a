"""How the cost of a frame grows with the measured points and with the views."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Sequence
from dataclasses import dataclass

from stereotrack_core.blas_threads import one_blas_thread
from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import proportions_of
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.experiments.benchmark.speed import exponent, median
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.selection import usable_views
from stereotrack_core.tracking.initialise.seeds import t_pose_in_cloud
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.pipeline import Pipeline
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run_spec import RunSpec
from stereotrack_core.tracking.shared_clouds import read_cloud
from stereotrack_core.tracking.tracker import cameras_of, tracker_for

DATA_POINTS = (500, 1000, 2000, 4000, 8000)


@dataclass(frozen=True)
class Cost:
    """Cost of a frame at one size."""

    size: int
    """Measured points, or views."""
    milliseconds: float
    """Median processor time over frames: of the tracker's step for points, from encoded images to
    the pose for views."""


def cost_of_points(
    recording: Recording,
    settings: Settings,
    sizes: Sequence[int] = DATA_POINTS,
    *,
    views: Sequence[str] | None = None,
    frames: int = 10,
) -> tuple[Cost, ...]:
    """Time the tracker's step with more and more data of the same clouds: of the first frames.

    Sizes beyond the smallest cloud are left out. The data are every pixel's, whatever
    ``pixel_step`` is otherwise.
    """
    dense = settings.replaced(pixel_step=1, fit_shape=False)
    least = settings.tracking.least_points
    found = _first_clouds(recording, dense, views, frames)
    clouds = [cloud for cloud in found if len(cloud.points) >= least]
    most = min((len(cloud.points) for cloud in clouds), default=0)
    costs = []
    for size in sizes:
        if size <= most:
            own = dense.replaced(data_points=size)
            costs.append(Cost(size, step_milliseconds(recording, own, clouds, views)))
    return tuple(costs)


def step_milliseconds(
    recording: Recording,
    settings: Settings,
    clouds: Sequence[Cloud],
    views: Sequence[str] | None = None,
    *,
    judging: bool = True,
) -> float:
    """Median processor time of the tracker's step over clouds, the first of them done before.

    What the step says about its own errors counts as well where `judging` is set.
    """
    positions = cameras_of(recording, usable_views(recording, views))
    body = body_model(proportions_of(recording.subject), settings.body)
    tracker = tracker_for(body, settings, positions, recording.fps, 0)
    tracker.start(t_pose_in_cloud(body, clouds[0].points))
    spent = []
    with one_blas_thread():
        tracker.step(clouds[0])
        for cloud in clouds:
            begun = time.process_time()
            estimate = tracker.step(cloud)
            seconds, whole = time.process_time() - begun, sum(estimate.seconds.values())
            if not judging and whole > 0:  # by the step's own clock
                seconds *= estimate.seconds.get("track", whole) / whole
            spent.append(seconds)
    return 1000.0 * median(spent)


def cost_of_views(
    recording: Recording,
    settings: Settings,
    *,
    views: Sequence[str] | None = None,
    frames: int = 10,
) -> tuple[Cost, ...]:
    """Processor time of the whole chain with one view, two views, and so on.

    Parameters are those of :func:`cost_of_points`.
    """
    used = usable_views(recording, views)
    plain = settings.replaced(fit_shape=False)
    return tuple(
        Cost(count, _processor_ms(recording, plain, used[:count], frames))
        for count in range(1, len(used) + 1)
    )


def _processor_ms(
    recording: Recording, settings: Settings, views: Sequence[str], frames: int
) -> float:
    spent = []
    with Pipeline(recording, RunSpec(settings, views=views)) as pipeline:
        reader = pipeline.reader
        count = min(frames + 1, reader.frame_count)
        pipeline.prepare(range(count))
        for frame in range(count):
            begun = time.process_time()
            cloud, _ = read_cloud(pipeline.chain, reader, frame)
            if frame == 0 and len(cloud.points):
                pipeline.tracker.start(pipeline.first_pose(cloud))
            pipeline.tracker.step(cloud)
            spent.append(time.process_time() - begun)
    return 1000.0 * median(spent[1:] or spent)


_MODEL_POINTS = (24, 40, 64, 120, 240, 480, 960)
_DATA_POINTS = (200, 400, 800, 1600, 3200)
_STEREO = ("rectify", "match", "subpixel")
_SEGMENTATION = ("background", "patches", "points", "outliers", "colours")


@dataclass(frozen=True)
class Timing:
    """Times of one preset."""

    preset: str
    usual_points: int
    """Points that the preset uses."""
    filter_ms: float
    """Processor time of the tracker's step, without what it says about its own errors."""
    stereo_ms_per_view: float
    segmentation_ms: float
    """`stereo_ms_per_view` and `segmentation_ms`: time of the stages before it: matching for each
    view; background, outliers and all else that makes the cloud of matched pictures, for all views
    together. Wall time."""
    costs: tuple[Cost, ...]
    """The tracker's step by number of points: model points for ``thesis``, data for others."""

    def exponent(self) -> float:
        """Exponent e of time ~ points^e over the measured range; NaN for a single size."""
        sizes = [cost.size for cost in self.costs]
        return exponent(sizes, [cost.milliseconds for cost in self.costs])


def timing(
    recording: Recording,
    name: str,
    *,
    frames: int = 8,
) -> Timing:
    """Time a preset on the first frames of a recording; nothing else should run meanwhile.

    Every size is timed in each of the frames; medians count.
    """
    settings = preset(name)
    samples = settings.tracking.matching == "model_to_data"
    key = "model_points" if samples else "data_points"
    usual = int(settings.values()[key])
    blind = dataclasses.replace(recording, reference=None)
    clouds = _first_clouds(blind, settings, None, frames)
    most = min((len(cloud.points) for cloud in clouds), default=0)
    wanted = sorted({usual, *(_MODEL_POINTS if samples else _DATA_POINTS)})
    sizes = [size for size in wanted if samples or size <= most or size == usual]
    # what is compiled at first use shall not be timed
    step_milliseconds(blind, settings.replaced(fit_shape=False), clouds[:2])
    costs = []
    for size in sizes:
        own = settings.replaced(**{key: size, "fit_shape": False})
        costs.append(Cost(size, step_milliseconds(blind, own, clouds, judging=False)))
    return Timing(
        preset=name,
        usual_points=usual,
        filter_ms=next(cost.milliseconds for cost in costs if cost.size == usual),
        stereo_ms_per_view=_stage_ms(clouds, _STEREO) / max(1, len(clouds[0].view_names)),
        segmentation_ms=_stage_ms(clouds, _SEGMENTATION),
        costs=tuple(costs),
    )


def _first_clouds(
    recording: Recording, settings: Settings, views: Sequence[str] | None, frames: int
) -> list[Cloud]:
    with Pipeline(recording, RunSpec(settings, views=views, init="tpose")) as pipeline:
        count = min(frames, pipeline.reader.frame_count)
        pipeline.chain.learn_background(pipeline.reader, range(count))
        return [read_cloud(pipeline.chain, pipeline.reader, frame)[0] for frame in range(count)]


def _stage_ms(clouds: Sequence[Cloud], stages: Sequence[str]) -> float:
    """Median over frames of the time of some stages, summed over views."""
    return 1000.0 * median([sum(c.seconds.get(s, 0.0) for s in stages) for c in clouds])

"""Time from encoded images to the pose, against bare block matching on the same images."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import cv2

from stereotrack_core.arrays import ImageArray
from stereotrack_core.errors import InputError
from stereotrack_core.experiments.benchmark.clock import median, seconds_of
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.tracking.frame import TrackedFrame
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.run import FIT_FRAMES, Pipeline
from stereotrack_core.tracking.run_spec import RunSpec

DISPARITIES, WINDOW = 64, 15
_WARM_UP = 3

Pair = tuple[ImageArray, ImageArray]


@dataclass(frozen=True)
class ChainSpeed:
    """Time of the whole chain per frame set, and of block matching alone.

    Attributes
    ----------
    preset : str
    frames : int
        Frame sets in a round.
    tracked : int
        Of them, those that the last round tracked.
    seconds : float
        Median over rounds of the time from encoded images to the last pose, over `frames`.
    preparation_seconds : float
        Median over rounds of what is done once before the first frame.
    matching_seconds : float
        Median over rounds of bare StereoBM for all views just before the chain, over `frames`.
    stage_ms : mapping from stage to milliseconds
        Medians over the frames of the last round; stages overlap.
    """

    preset: str
    frames: int
    tracked: int
    seconds: float
    preparation_seconds: float
    matching_seconds: float
    stage_ms: Mapping[str, float] = field(default_factory=dict)

    @property
    def ratio(self) -> float:
        """Time of the chain in units of bare block matching."""
        return self.seconds / self.matching_seconds


@dataclass(frozen=True)
class TimedPass:
    """One round of one preset.

    Attributes
    ----------
    seconds : float
        From the first encoded image to the last pose.
    preparation : float
        Seconds of what is done once before the first frame.
    tracked : int
        Frames that were tracked.
    stage_ms : mapping from stage to milliseconds
        Medians over the frames; stages overlap.
    """

    seconds: float
    preparation: float
    tracked: int
    stage_ms: Mapping[str, float]


def chain_speed(
    recording: Recording,
    presets: Mapping[str, Settings],
    *,
    views: Sequence[str] | None = None,
    frames: int = 40,
    rounds: int = 5,
    on_progress: Callable[[int], None] = lambda _: None,
) -> tuple[ChainSpeed, ...]:
    """Alternate bare block matching and the chain with every preset; medians over rounds.

    A round has a new pipeline, so that nothing is in a cache. What is done once for a recording,
    learning the background and fitting the shape, is told by itself.

    Parameters
    ----------
    recording : Recording
        Its stereo views are used.
    presets : mapping from name to Settings
    views : sequence of str, optional
        Only these of them.
    frames, rounds : int
    on_progress : callable, optional
        Told how many passes are done, of ``rounds * len(presets)``.

    Raises
    ------
    InputError
        Where the recording has no stereo view.
    """
    stereo = [view.name for view in recording.views if view.kind == "stereo"]
    views = [name for name in stereo if views is None or name in views]
    if not views:
        raise InputError(
            "the recording has no stereo view",
            where=str(recording.folder),
            remedy="Use a recording with stereo cameras.",
        )
    pairs = _decoded(recording, views, frames)
    count = len(pairs) // len(views)
    matcher = cv2.StereoBM.create(DISPARITIES, WINDOW)
    for settings in presets.values():
        timed_pass(recording, settings, views, min(_WARM_UP, count))
    matching: dict[str, list[float]] = {name: [] for name in presets}
    passes: dict[str, list[TimedPass]] = {name: [] for name in presets}
    for turn in range(rounds):
        for k, (name, settings) in enumerate(presets.items(), start=1):
            matching[name].append(seconds_of(lambda: _match(matcher, pairs)))
            passes[name].append(timed_pass(recording, settings, views, count))
            on_progress(turn * len(presets) + k)
    return tuple(
        ChainSpeed(
            preset=name,
            frames=count,
            tracked=of_preset[-1].tracked,
            seconds=median([one.seconds for one in of_preset]) / count,
            preparation_seconds=median([one.preparation for one in of_preset]),
            matching_seconds=median(matching[name]) / count,
            stage_ms=of_preset[-1].stage_ms,
        )
        for name, of_preset in passes.items()
    )


def _decoded(recording: Recording, views: Sequence[str], frames: int) -> list[Pair]:
    """Left and right grey images of the first frames, all views of a frame together."""
    pairs: list[Pair] = []
    with FrameReader(recording, views=views, colour=False) as reader:
        for k in range(min(frames, reader.frame_count)):
            images = reader.frame_set(k).views
            for name in views:
                left = images[name].left if name in images else None
                if left is None:
                    raise InputError(
                        f"view {name} has no images at frame {k}",
                        where=str(recording.folder),
                        remedy="See `stereotrack info --deep`.",
                    )
                pairs.append((left, images[name].image))
    return pairs


def _match(matcher: cv2.StereoBM, pairs: Sequence[Pair]) -> None:
    for left, right in pairs:
        matcher.compute(left, right)


def timed_pass(
    recording: Recording, settings: Settings, views: Sequence[str], frames: int
) -> TimedPass:
    """Track with a new pipeline; the clock for the frames starts when the track has settled.

    The shape is fitted to clouds that the first frames use again, so these are not timed.
    """
    found: list[TrackedFrame] = []
    with Pipeline(recording, RunSpec(settings, views=views)) as pipeline:
        begun = min(FIT_FRAMES, pipeline.reader.frame_count - frames)
        timed = range(begun, begun + frames)
        preparation = seconds_of(lambda: pipeline.prepare(range(timed.stop)))
        for _ in pipeline.frames(range(begun)):
            pass
        seconds = seconds_of(lambda: found.extend(pipeline.frames(timed)))
    stages = dict.fromkeys(name for frame in found for name in frame.seconds)
    stage_ms = {
        name: 1000.0 * median([frame.seconds.get(name, 0.0) for frame in found]) for name in stages
    }
    tracked = sum(frame.tracked for frame in found)
    return TimedPass(seconds, preparation, tracked, stage_ms)

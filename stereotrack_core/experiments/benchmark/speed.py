"""How fast each contestant is on a recording."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from stereotrack_core.experiments.benchmark.chain_speed import chain_speed, timed_pass
from stereotrack_core.experiments.benchmark.clock import median
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.recording.selection import usable_views
from stereotrack_core.tracking.parameters import Settings


@dataclass(frozen=True)
class Speed:
    """Speed of the whole chain, from encoded images to the pose.

    Attributes
    ----------
    frames_per_second : float
    ratio : float
        Time of the chain over that of bare block matching of the same pairs, taken in turn; NaN
        where not every view is a stereo one.
    """

    frames_per_second: float
    ratio: float


def speeds(
    recording: Recording,
    contestants: Mapping[str, Settings],
    *,
    views: Sequence[str] | None = None,
    frames: int = 20,
    rounds: int = 1,
    on_progress: Callable[[int], None] = lambda _: None,
) -> Mapping[str, Speed]:
    """Time every contestant on the recording's first frames once its track has settled.

    Parameters
    ----------
    recording : Recording
    contestants : mapping from name to Settings
    views : sequence of str, optional
        Views to use; all that give depth when not given.
    frames, rounds : int
        Frame sets in a round, and rounds; the median round counts.
    on_progress : callable, optional
        Told how many passes are done, of ``rounds * len(contestants)``.
    """
    used = usable_views(recording, views)
    if all(recording.view(name).kind == "stereo" for name in used):
        timed = chain_speed(
            recording,
            contestants,
            views=used,
            frames=frames,
            rounds=rounds,
            on_progress=on_progress,
        )
        return {speed.preset: Speed(1.0 / speed.seconds, speed.ratio) for speed in timed}
    with FrameReader(recording, views=used, read_ahead=0) as reader:
        count = min(frames, reader.frame_count)
    seconds: dict[str, list[float]] = {name: [] for name in contestants}
    for turn in range(rounds):
        for k, (name, own) in enumerate(contestants.items(), start=1):
            seconds[name].append(timed_pass(recording, own, used, count).seconds)
            on_progress(turn * len(contestants) + k)
    return {name: Speed(count / median(own), float("nan")) for name, own in seconds.items()}

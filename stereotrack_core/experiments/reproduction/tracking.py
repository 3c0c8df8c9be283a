"""Runs of one recording side by side over the same clouds, in bounded memory.

Running anew from the reference's pose for each segment is a protocol for judging. It lives here
and nowhere else: the poses are handed in from outside and reach only runs that say so in their
meta (``started_at_reference``); trackers of ordinary runs never see a reference.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Generator, Mapping
from contextlib import ExitStack, closing
from typing import Any

import numpy as np

from stereotrack_core.body.pose import Pose
from stereotrack_core.errors import Cancelled
from stereotrack_core.experiments.reproduction.plan import FEW_VIEWS, Entry, Group, recording_for
from stereotrack_core.recording.description import Recording, Subject
from stereotrack_core.tracking.frame import TrackedFrame, run_of
from stereotrack_core.tracking.pipeline import Pipeline
from stereotrack_core.tracking.run import Run
from stereotrack_core.tracking.run_spec import RunSpec
from stereotrack_core.tracking.shared_clouds import SharedClouds

_KEPT = 64
"""Tracked frames of a run that are held before they are packed into arrays."""

_PER_FRAME = (
    *("frame", "landmarks", "x", "P", "tracked", "unexplained_fraction", "residual", "innovation"),
    *("limb_sigma_deg", "limb_lost"),
)


class RunBuilder:
    """Takes one tracked frame after the other and keeps only numbers."""

    def __init__(self, pipeline: Pipeline, entry: Entry, starts: tuple[int, ...]) -> None:
        self._pipeline = pipeline
        self._entry = entry
        self._starts = starts
        self._frames: list[TrackedFrame] = []
        self._packed: list[Run] = []

    def add(self, frame: TrackedFrame) -> None:
        """Take the next frame."""
        self._frames.append(frame.without_cloud())
        if len(self._frames) >= _KEPT:
            self._pack()

    def run(self) -> Run:
        """All frames so far as one run."""
        if self._frames or not self._packed:
            self._pack()
        made = joined(self._packed)
        meta = {
            **made.meta,
            "way": self._entry.way.name,
            "proportions": "averaged" if self._entry.way.averaged else "individual",
            "started_at_reference": list(self._starts),
        }
        return dataclasses.replace(made, meta=meta)

    def _pack(self) -> None:
        self._packed.append(run_of(self._frames, self._pipeline.origin()))
        self._frames = []


def joined(runs: list[Run]) -> Run:
    """Successive stretches of one run as a whole; stages that one lacks took no time there."""
    stages = tuple(dict.fromkeys(name for run in runs for name in run.stage_names))
    seconds = [np.zeros((len(run.frame), len(stages))) for run in runs]
    for run, table in zip(runs, seconds, strict=True):
        table[:, [stages.index(name) for name in run.stage_names]] = run.seconds
    whole: dict[str, Any] = {
        name: np.concatenate([getattr(run, name) for run in runs]) for name in _PER_FRAME
    }
    return dataclasses.replace(
        runs[-1], **whole, seconds=np.concatenate(seconds), stage_names=stages
    )


def track_group(
    recording: Recording,
    group: Group,
    average: Subject,
    frames: range,
    starts: Mapping[int, Pose],
    *,
    on_frame: Callable[[int], None] = lambda _: None,
    cancelled: Callable[[], bool] = lambda: False,
) -> list[tuple[Entry, Run]]:
    """Track a recording with all entries of a group.

    Parameters
    ----------
    recording : Recording
    group : Group
    average : Subject
        The averaged proportions.
    frames : range
    starts : mapping from frame to Pose
        Where runs that start anew are put on which pose; the first frame must be among them
        where the group has such runs.
    on_frame : callable, optional
        Told how many frames all runs have tracked.
    cancelled : callable, optional
        Asked after every frame whether to stop.

    Raises
    ------
    Cancelled
        Nothing of the group is kept then.
    """
    views = FEW_VIEWS if group.entries[0].way.few_views else None
    with ExitStack() as stack:
        first = group.entries[0].way
        blind = recording_for(first, recording, average)
        lender = stack.enter_context(Pipeline(blind, RunSpec(first.settings, views=views)))
        clouds = SharedClouds(lender.chain, lender.reader, len(group.entries))
        builders, going = [], []
        for entry in group.entries:
            if cancelled():
                raise Cancelled
            way = entry.way
            pipeline = stack.enter_context(
                Pipeline(
                    recording_for(way, recording, average),
                    RunSpec(
                        way.settings,
                        views=views,
                        seed=entry.seed,
                        init=starts[frames.start] if way.anew else way.init,
                        preset=way.preset,
                    ),
                    clouds=clouds,
                )
            )
            pipeline.prepare(frames)
            own = _anew(pipeline, frames, starts) if way.anew else pipeline.frames(frames)
            going.append(stack.enter_context(closing(own)))
            begun = tuple(sorted(f for f in starts if f in frames)) if way.anew else ()
            builders.append(RunBuilder(pipeline, entry, begun))
        for done, together in enumerate(zip(*going, strict=True), start=1):
            for builder, frame in zip(builders, together, strict=True):
                builder.add(frame)
            on_frame(done * len(builders))
            if cancelled():
                raise Cancelled
        pairs = zip(group.entries, builders, strict=True)
        return [(entry, builder.run()) for entry, builder in pairs]


def _anew(
    pipeline: Pipeline, frames: range, starts: Mapping[int, Pose]
) -> Generator[TrackedFrame, None, None]:
    """Track, and put the tracker on the pose that is given for a frame before it sees it."""
    begins = sorted(frame for frame in starts if frame in frames)
    for begin, end in zip(begins, [*begins[1:], frames.stop], strict=True):
        pipeline.tracker.start(starts[begin])
        yield from pipeline.frames(range(begin, end))

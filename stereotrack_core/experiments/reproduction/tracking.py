"""Runs of one recording side by side over the same clouds, in bounded memory.

Running anew from the reference's pose for each segment is a protocol for judging. It lives here
and nowhere else: the poses are handed in from outside and reach only runs that say so in their
meta (``started_at_reference``); trackers of ordinary runs never see a reference.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from contextlib import closing

from stereotrack_core.body.pose import Pose
from stereotrack_core.experiments import lockstep
from stereotrack_core.experiments.reproduction.plan import Entry, Group, recording_for
from stereotrack_core.recording.description import Recording, Subject
from stereotrack_core.tracking.run import Run


def track_group(
    recording: Recording,
    group: Group,
    average: Subject,
    frames: range,
    starts: Mapping[int, Pose],
    *,
    on_frames: Callable[[int], None] = lambda _: None,
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
    on_frames : callable, optional
        Told how many frames more were tracked, over all runs.
    cancelled : callable, optional
        Asked after every frame whether to stop.

    Raises
    ------
    Cancelled
        Nothing of the group is kept then.
    """
    inside = {frame: pose for frame, pose in starts.items() if frame in frames}
    entries = []
    for entry in group.entries:
        own = inside if entry.way.anew else {}
        spec = entry.way.spec(entry.seed, frames, own.get(frames.start))
        blind = recording_for(entry.way, recording, average)
        entries.append(lockstep.Entry(blind, spec, own))
    together = lockstep.track_together(entries, on_frames=on_frames, cancelled=cancelled)
    with closing(together):
        return [
            (entry, _described(tracked.run(), entry, sorted(inside)))
            for entry, tracked in zip(group.entries, together, strict=True)
        ]


def _described(run: Run, entry: Entry, starts: list[int]) -> Run:
    way = entry.way
    own = {
        "way": way.name,
        "proportions": "averaged" if way.averaged else "individual",
        "started_at_reference": starts if way.anew else [],
    }
    return dataclasses.replace(run, meta={**run.meta, **own})

"""The runs of a reproduction: which are missing, and tracking them here or in several processes.

Running anew from the reference's pose for each segment is a protocol for judging. It lives here
and nowhere else: the poses reach only runs that say so in their meta (``started_at_reference``);
trackers of ordinary runs never see a reference.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias

from stereotrack_core.atomic import forget_unfinished
from stereotrack_core.body.landmark_pose import pose_of_landmarks
from stereotrack_core.body.pose import Pose
from stereotrack_core.experiments.reproduction.plan import (
    Group,
    Places,
    PlannedRun,
    averaged_subject,
    kept_runs,
    recording_for,
)
from stereotrack_core.experiments.runner import lockstep
from stereotrack_core.interop.run_npz import write_npz
from stereotrack_core.recording.description import Recording, Subject
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.tracking.frame import Run
from stereotrack_core.worker_processes import Asker, Lost, Pool

_Task: TypeAlias = tuple[Places, Sequence[Path], Group]


def track_groups(
    places: Places,
    recordings: Sequence[Recording],
    groups: Sequence[Group],
    workers: int,
    *,
    on_frames: Callable[[int], None],
    on_group: Callable[[Group], None],
    on_lost: Callable[[Group, Lost], None],
    cancelled: Callable[[], bool],
) -> None:
    """Track all runs of some groups and write them.

    `on_frames` is told how many frames of the groups in work are done, `on_group` every group that
    is finished, `on_lost` a group that is begun again because its process has ended by itself.
    Raises Lost where that happens twice, and Cancelled; finished groups of runs stay.
    """
    tasks = [(places, [recording.folder for recording in recordings], one) for one in groups]
    desk = _GroupDesk(tasks, on_frames, on_group, on_lost, cancelled)
    if workers > 1:
        with closing(Pool(_work, workers)) as pool:
            pool.work(desk)
        return
    while (task := desk.next()) is not None:
        _track_and_write(*task, partial(desk.heard, task), cancelled)
        desk.ended(task)


def missing_runs(
    places: Places, recordings: Sequence[Recording], groups: Sequence[Group]
) -> tuple[Group, ...]:
    """The groups without the runs that are there already."""
    left = []
    for group, kept in kept_runs(places, recordings, groups):
        missing = tuple(planned for _, planned, run in kept if run is None)
        if missing:
            left.append(Group(group.recording, missing))
    return tuple(left)


def _track_and_write(
    places: Places,
    folders: Sequence[Path],
    group: Group,
    on_frames: Callable[[int], None],
    cancelled: Callable[[], bool] = lambda: False,
) -> None:
    paths = {planned: places.run(group.recording, planned) for planned in group.runs}
    for path in paths.values():
        forget_unfinished(path)
    recordings = [open_recording(folder) for folder in folders]
    recording = next(one for one in recordings if one.name == group.recording)
    made = track_group(
        recording,
        group,
        averaged_subject([one.subject for one in recordings]),
        range(frames_of(recording)),
        reference_poses(recording),
        on_frames=on_frames,
        cancelled=cancelled,
    )
    for planned, run in made:
        paths[planned].parent.mkdir(parents=True, exist_ok=True)
        write_npz(paths[planned], run)


def track_group(
    recording: Recording,
    group: Group,
    average: Subject,
    frames: range,
    starts: Mapping[int, Pose],
    *,
    on_frames: Callable[[int], None] = lambda _: None,
    cancelled: Callable[[], bool] = lambda: False,
) -> list[tuple[PlannedRun, Run]]:
    """Track a recording with all runs of a group.

    Runs that start anew are put on the poses of `starts`, by frame; the first frame must be among
    them where the group has such runs. Where it is cancelled, nothing of the group is kept.
    """
    inside = {frame: pose for frame, pose in starts.items() if frame in frames}
    inputs = []
    for planned in group.runs:
        own = inside if planned.anew else {}
        spec = planned.spec(frames, own.get(frames.start))
        blind = recording_for(planned, recording, average)
        inputs.append(lockstep.RunInput(blind, spec, own))
    together = lockstep.track_together(inputs, on_frames=on_frames, cancelled=cancelled)
    with closing(together):
        return [
            (planned, _described(tracked.run(), planned, sorted(inside)))
            for planned, tracked in zip(group.runs, together, strict=True)
        ]


def _described(run: Run, planned: PlannedRun, starts: list[int]) -> Run:
    own = {
        "way": planned.way,
        "proportions": "averaged" if planned.averaged else "individual",
        "started_at_reference": starts if planned.anew else [],
    }
    return dataclasses.replace(run, meta={**run.meta, **own})


def reference_poses(recording: Recording) -> dict[int, Pose]:
    """The reference's pose at frame 0 and at the first frame of every segment.

    For the runs that are begun anew alone: they are told the truth there, to be judged by how
    they go on.
    """
    reference = recording.reference
    if reference is None:
        return {}
    at = {
        int(frame): points for frame, points in zip(reference.frame, reference.points, strict=True)
    }
    wanted = sorted({0, *(segment.first for segment in recording.segments)})
    return {frame: pose_of_landmarks(at[frame]) for frame in wanted if frame in at}


class _GroupDesk:
    """Hands out groups of runs, each anew where its process is lost."""

    def __init__(
        self,
        tasks: Sequence[_Task],
        on_frames: Callable[[int], None],
        on_group: Callable[[Group], None],
        on_lost: Callable[[Group, Lost], None],
        stopped: Callable[[], bool],
    ) -> None:
        self._waiting = list(tasks)
        self._on_frames, self._on_group, self._on_lost = on_frames, on_group, on_lost
        self.stopped = stopped
        self._again: set[Group] = set()
        self._frames: dict[Group, int] = {}

    def next(self) -> _Task | None:
        return self._waiting.pop(0) if self._waiting else None

    def heard(self, task: _Task, word: Any) -> None:
        if isinstance(word, Exception):
            raise word
        self._frames[task[-1]] = self._frames.get(task[-1], 0) + word
        self._on_frames(sum(self._frames.values()))

    def lost(self, task: _Task, why: Lost) -> None:
        group = task[-1]
        if group in self._again:
            raise why
        self._on_lost(group, why)
        self._again.add(group)
        self._waiting.append(task)
        self._frames.pop(group, None)

    def ended(self, task: _Task) -> None:
        self._frames.pop(task[-1], None)
        self._on_group(task[-1])


def _work(task: _Task, asker: Asker) -> None:
    _track_and_write(*task, asker.on_frames)


def frames_of(recording: Recording) -> int:
    """Frames of one of the four recordings."""
    return 0 if recording.reference is None else len(recording.reference.frame)

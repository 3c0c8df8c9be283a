"""Tracking all runs, in this process or in several."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from stereotrack_core.cli.output import counted, say
from stereotrack_core.cli.progress import stoppable
from stereotrack_core.cli.reproduction.pace import pace
from stereotrack_core.cli.reproduction.places import Places, kept_runs
from stereotrack_core.worker_processes import Asker, Lost, Pool

if TYPE_CHECKING:
    from stereotrack_core.body.pose import Pose
    from stereotrack_core.experiments.reproduction.plan import Group
    from stereotrack_core.recording.description import Recording, Subject

    _Task: TypeAlias = tuple[Places, Sequence[Path], Group]


def track_all(
    places: Places,
    recordings: Sequence[Recording],
    groups: Sequence[Group],
    workers: int,
    on_group: Callable[[], None],
) -> None:
    """Track every run that is not there yet; `on_group` is called whenever some are finished.

    Raises
    ------
    Cancelled
        When stopped with Ctrl-C; finished groups of runs stay.
    """
    left = missing_runs(places, recordings, groups)
    by_name = {recording.name: recording for recording in recordings}
    cost = {group: len(group.entries) * _frames(by_name[group.recording]) for group in left}
    total = sum(cost.values())
    if not left:
        return
    say(f"Tracking {counted(sum(len(g.entries) for g in left), 'run')}, {total} frames in all.")
    folders = [recording.folder for recording in recordings]
    with pace("Tracking", total) as going, stoppable() as stopped:

        def note(group: Group) -> None:
            going.next(cost[group])
            runs = f"{counted(len(group.entries), 'run')} like {group.entries[0].name}"
            say(f"{group.recording}: {runs} done; {going.words()}.")
            on_group()

        if workers == 1:
            for group in left:
                _track_group(places, folders, group, _counting(going.advance), stopped)
                note(group)
        else:
            desk = _GroupDesk(
                [(places, folders, group) for group in left], going.advance, note, stopped
            )
            pool = Pool(_work, workers)
            try:
                pool.work(desk)
            finally:
                pool.close()


def _counting(advance: Callable[[int], None]) -> Callable[[int], None]:
    """Tell how many frames are done in all, given how many more are."""
    total = 0

    def on_frames(count: int) -> None:
        nonlocal total
        total += count
        advance(total)

    return on_frames


def missing_runs(
    places: Places, recordings: Sequence[Recording], groups: Sequence[Group]
) -> tuple[Group, ...]:
    """The groups without the runs that are there already."""
    from stereotrack_core.experiments.reproduction.plan import Group

    left = []
    for group, kept in kept_runs(places, recordings, groups):
        entries = tuple(entry for _, entry, run in kept if run is None)
        if entries:
            left.append(Group(group.recording, entries))
    return tuple(left)


def _track_group(
    places: Places,
    folders: Sequence[Path],
    group: Group,
    on_frames: Callable[[int], None],
    cancelled: Callable[[], bool],
) -> None:
    """Track a group and write its runs."""
    from stereotrack_core.atomic import forget_unfinished
    from stereotrack_core.experiments.reproduction.plan import averaged_subject
    from stereotrack_core.experiments.reproduction.tracking import track_group
    from stereotrack_core.interop.run_npz import write_npz
    from stereotrack_core.recording.folder import open_recording

    paths = {entry: places.run(group.recording, entry) for entry in group.entries}
    for path in paths.values():
        forget_unfinished(path)
    recordings = [open_recording(folder) for folder in folders]
    recording = next(one for one in recordings if one.name == group.recording)
    average: Subject = averaged_subject([one.subject for one in recordings])
    made = track_group(
        recording,
        group,
        average,
        range(_frames(recording)),
        reference_poses(recording),
        on_frames=on_frames,
        cancelled=cancelled,
    )
    for entry, run in made:
        paths[entry].parent.mkdir(parents=True, exist_ok=True)
        write_npz(paths[entry], run)


def reference_poses(recording: Recording) -> dict[int, Pose]:
    """The reference's pose at frame 0 and at the first frame of every segment.

    For the runs that are begun anew alone: they are told the truth there, to be judged by how
    they go on.
    """
    from stereotrack_core.interop.landmark_pose import pose_of_landmarks

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
        note: Callable[[Group], None],
        stopped: Callable[[], bool],
    ) -> None:
        self._waiting = list(tasks)
        self._on_frames, self._note, self.stopped = on_frames, note, stopped
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
        say(f"{group.recording}: {why}; its runs are begun again.")
        self._again.add(group)
        self._waiting.append(task)
        self._frames.pop(group, None)

    def ended(self, task: _Task) -> None:
        self._frames.pop(task[-1], None)
        self._note(task[-1])


def _work(task: _Task, asker: Asker) -> None:
    _track_group(*task, asker.on_frames, asker.gone)


def _frames(recording: Recording) -> int:
    return 0 if recording.reference is None else len(recording.reference.frame)

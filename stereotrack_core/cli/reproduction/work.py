"""Tracking all runs, in this process or in several."""

from __future__ import annotations

import multiprocessing
import signal
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing.managers import SyncManager
from pathlib import Path
from typing import TYPE_CHECKING

from stereotrack_core.cli.output import say
from stereotrack_core.cli.progress import stoppable
from stereotrack_core.cli.reproduction.pace import pace
from stereotrack_core.cli.reproduction.places import Places, kept_run
from stereotrack_core.errors import Cancelled

if TYPE_CHECKING:
    from threading import Event

    from stereotrack_core.body.pose import Pose
    from stereotrack_core.evaluation.reproduction.plan import Group
    from stereotrack_core.recording.description import Recording, Subject

_POLL = 0.5


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
    say(f"Tracking {_runs(sum(len(g.entries) for g in left))}, {total} frames in all.")
    folders = [recording.folder for recording in recordings]
    with pace("Tracking", total) as going, stoppable() as stopped:

        def note(group: Group) -> None:
            going.next(cost[group])
            runs = f"{_runs(len(group.entries))} like {group.entries[0].name}"
            say(f"{group.recording}: {runs} done; {going.words()}.")
            on_group()

        if workers == 1:
            for group in left:
                _track_group(places, folders, group, going.advance, stopped)
                note(group)
        else:
            _in_processes(places, folders, left, workers, note, stopped)


def missing_runs(
    places: Places, recordings: Sequence[Recording], groups: Sequence[Group]
) -> tuple[Group, ...]:
    """The groups without the runs that are there already."""
    from stereotrack_core.evaluation.reproduction.plan import Group
    from stereotrack_core.recording.fingerprint import fingerprint

    by_name = {recording.name: (recording, fingerprint(recording)) for recording in recordings}
    left = []
    for group in groups:
        recording, print_ = by_name[group.recording]
        entries = tuple(e for e in group.entries if kept_run(places, recording, print_, e) is None)
        if entries:
            left.append(Group(group.recording, entries))
    return tuple(left)


def _track_group(
    places: Places,
    folders: Sequence[Path],
    group: Group,
    on_frame: Callable[[int], None],
    cancelled: Callable[[], bool],
) -> None:
    """Track a group and write its runs."""
    from stereotrack_core.evaluation.reproduction.plan import averaged_subject
    from stereotrack_core.evaluation.reproduction.tracking import track_group
    from stereotrack_core.interop.run_npz import write_npz
    from stereotrack_core.recording.folder import open_recording

    recordings = [open_recording(folder) for folder in folders]
    recording = next(one for one in recordings if one.name == group.recording)
    average: Subject = averaged_subject([one.subject for one in recordings])
    made = track_group(
        recording,
        group,
        average,
        range(_frames(recording)),
        reference_poses(recording),
        on_frame=on_frame,
        cancelled=cancelled,
    )
    for entry, run in made:
        path = places.run(group.recording, entry)
        path.parent.mkdir(parents=True, exist_ok=True)
        write_npz(path, run)


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


def _in_processes(
    places: Places,
    folders: Sequence[Path],
    groups: Sequence[Group],
    workers: int,
    note: Callable[[Group], None],
    stopped: Callable[[], bool],
) -> None:
    context = multiprocessing.get_context("spawn")
    manager = SyncManager(ctx=context)
    manager.start(_ignore_interrupts)
    with manager:
        stop = manager.Event()
        with ProcessPoolExecutor(workers, context, _ignore_interrupts) as pool:
            waiting = {pool.submit(_work, places, folders, g, stop): g for g in groups}
            try:
                while waiting:
                    done = [future for future in waiting if future.done()]
                    for future in done:
                        group = waiting.pop(future)
                        future.result()
                        note(group)
                    if stopped():
                        say("Stopping; every process ends the step that it is at.")
                        raise Cancelled
                    if not done:
                        time.sleep(_POLL)
            except BaseException:
                stop.set()
                pool.shutdown(cancel_futures=True)
                raise


def _ignore_interrupts() -> None:
    """Ctrl-C reaches every process of a terminal; only the first one decides."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _work(places: Places, folders: Sequence[Path], group: Group, stop: Event) -> None:
    _track_group(places, folders, group, lambda _: None, stop.is_set)


def _frames(recording: Recording) -> int:
    return 0 if recording.reference is None else len(recording.reference.frame)


def _runs(count: int) -> str:
    return "1 run" if count == 1 else f"{count} runs"

"""Keeps the joint angles of runs and of the reference, worked out in the background."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any
from weakref import WeakKeyDictionary

from PySide6.QtCore import QObject, Signal, Slot

from stereotrack_core.evaluation.joint_angles.motion import CUT_OFF_HZ, Motion, motion_of
from stereotrack_core.evaluation.joint_angles.series import (
    JointAngles,
    angles_of_reference,
    angles_of_run,
    angles_of_trajectory,
)

from ...services.tasks.task import Task, TaskList
from ...session.runs import RunEntry, RunList
from ...session.truth import Truth
from ...widgets.plots.angle_plot import REFERENCE_STYLE
from .angle_curves import Moved

_MORE = 1.25
"""A run that grows is worked out again when it has so many times the frames."""


class AnglePresenter(QObject):
    """Joint angles by run.

    Signals
    -------
    changed : ()
        Some angles are new.
    """

    changed = Signal()

    def __init__(self, runs: RunList, tasks: TaskList, growing: Callable[[], object]) -> None:
        super().__init__()
        self._runs, self._tasks, self._growing = runs, tasks, growing
        self._known: WeakKeyDictionary[RunEntry, tuple[int, JointAngles | None]]
        self._known = WeakKeyDictionary()
        self._truth: tuple[Truth, JointAngles] | None = None
        self._motions: WeakKeyDictionary[JointAngles, tuple[float, Motion]] = WeakKeyDictionary()
        self._task: Task | None = None
        tasks.changed.connect(self._on_tasks)

    def ask(self, truth: Truth | None) -> None:
        """Work out what is not known yet: one thing at a time, in the background."""
        if self._task is not None:
            return
        if truth is not None and (self._truth is None or self._truth[0] is not truth):
            self._begin(lambda: _of_truth(truth), lambda found: self._on_truth(truth, found))
            return
        for entry in self._runs.entries:
            if self._wants(entry):
                run, count = entry.run(), len(entry.frames)
                self._known[entry] = (count, self.of(entry))
                if run is not None:
                    self._begin(partial(angles_of_run, run), partial(self._on_run, entry, count))
                    return

    def of(self, entry: RunEntry) -> JointAngles | None:
        """Angles of a run; None while they are not known."""
        known = self._known.get(entry)
        return known[-1] if known is not None else None

    def shown(self, truth: Truth | None, fps: float, cut_off: float = CUT_OFF_HZ) -> list[Moved]:
        """Angles of all runs that are shown, the active one first, then of the reference."""
        active = self._runs.active
        entries = [active] if active is not None else []
        entries += [e for e in self._runs.entries if e.visible and e is not active]
        found = []
        for entry in entries:
            angles = self.of(entry)
            if angles is not None:
                style = self._runs.style(entry)
                motion = self._motion(angles, fps, cut_off)
                found.append(Moved(entry.name, style, angles, motion))
        if truth is not None and self._truth is not None and self._truth[0] is truth:
            angles = self._truth[1]
            motion = self._motion(angles, fps, cut_off)
            found.append(Moved("reference", REFERENCE_STYLE, angles, motion))
        return found

    def _motion(self, angles: JointAngles, fps: float, cut_off: float) -> Motion:
        known = self._motions.get(angles)
        if known is None or known[0] != cut_off:
            known = self._motions[angles] = (cut_off, motion_of(angles, fps, cut_off))
        return known[1]

    def _wants(self, entry: RunEntry) -> bool:
        before = self._known.get(entry)
        count, known = len(entry.frames), before[0] if before is not None else 0
        if entry is self._growing():
            return count >= _MORE * known + 8
        return count != known

    def _begin(self, work: Callable[[], JointAngles], done: Callable[[Any], None]) -> None:
        self._task = self._tasks.begin("computing joint angles", lambda _task: work(), done)

    def _on_run(self, entry: RunEntry, count: int, found: JointAngles) -> None:
        self._known[entry] = (count, found)

    def _on_truth(self, truth: Truth, found: JointAngles) -> None:
        self._truth = (truth, found)

    @Slot()
    def _on_tasks(self) -> None:
        if self._task is not None and self._task not in self._tasks.tasks:
            self._task = None
            self.changed.emit()


def _of_truth(truth: Truth) -> JointAngles:
    if truth.reference is not None:
        return angles_of_reference(truth.reference)
    return angles_of_trajectory(truth.trajectory)

"""What-if: a change of a parameter tracks a stretch again, in a process, beside the run."""

import logging
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from stereotrack_core.body.model import body_of_subject
from stereotrack_core.body.parameters import BodyShape
from stereotrack_core.body.proportions import Proportions
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.run_spec import RunSpec
from stereotrack_core.tracking.stored import began_of, shape_of_meta
from stereotrack_core.tracking.tuning.process import MakeClouds, TrackTrial, TrialBegun, TrialFrame
from stereotrack_core.tracking.tuning.stages import Stage, changes_in_words, stage_key
from stereotrack_core.tracking.tuning.trial import Trial, TrialStart, start_before

from ...session.changes import Part
from ...session.jobs import Job, NewestJob, Task, TaskList
from ...session.runs import RunEntry
from ...session.session import Session

_AHEAD_MS = 400


class TrialRunner:
    """Has trials tracked in the process.

    `wanted`: the next trial, or None if no clouds are to be made ahead.
    """

    def __init__(
        self, session: Session, tasks: TaskList, wanted: Callable[[], Trial | None]
    ) -> None:
        self._session, self._wanted = session, wanted
        self._ahead, self._trial = NewestJob(tasks, quiet=True), NewestJob(tasks)
        self._pause = session.later(self._begin, _AHEAD_MS)

    def track(
        self,
        title: str,
        entry: RunEntry,
        trial: Trial,
        grown: Callable[[RunEntry, list[int]], object],
        ended: Callable[[RunEntry], object],
    ) -> Task:
        """Have a trial tracked, when the one before has ended; its entry gets the frames.

        `grown` is told the numbers of the frames that have come, some of them again, and `ended`
        that nothing more comes; neither is called once the task is cancelled.
        """
        self.cancel()
        kept = self._session.kept
        assert kept is not None  # noqa: S101 - there are no trials without
        todo, process = TrackTrial(kept, trial), self._session.processes.trials

        def take(words: list[Any]) -> None:
            for begun in (word for word in words if isinstance(word, TrialBegun)):
                entry.body, entry.origin = begun.body, begun.origin
            frames = [word for word in words if isinstance(word, TrialFrame)]
            for word in frames:
                entry.wall_seconds = word.seconds
                entry.frames[word.frame.frame] = word.frame
            if frames:
                task.report(len(entry.frames) / len(entry.wanted))
                grown(entry, [word.frame.frame for word in frames])

        work, end = partial(Task.in_process, process=process, todo=todo), partial(ended, entry)
        task = self._trial.run(Job(title, work, ended=end, told=take))
        return task

    def leave(self) -> None:
        """Give up the trial, if any."""
        self._trial.give_up()

    def make_clouds_soon(self) -> None:
        self.cancel()
        self._pause.start()

    def cancel(self) -> None:
        """Make no more clouds; what is made is kept."""
        self._pause.stop()
        self._ahead.give_up()

    def _begin(self) -> None:
        trial, kept = self._wanted(), self._session.kept
        if trial is None or kept is None:
            return
        todo, process = MakeClouds(kept, trial), self._session.processes.trials
        work = partial(Task.in_process, process=process, todo=todo)
        self._ahead.run(Job("clouds", work, failed=_on_failed))


def _on_failed(error: Exception) -> None:
    """Log the error; a trial of the same stretch shows it to the person."""
    logging.getLogger(__name__).error("clouds could not be precomputed", exc_info=error)


_PAUSE_MS = 100  # time without a further change after which a trial begins


class TrialPresenter:
    """Trials as entries of the list of runs, drawn beside the active run until dismissed.

    `stretch`: frames that are to be tracked; `changed` is called when what is said of the trials
    is different.
    """

    def __init__(
        self,
        session: Session,
        runner: TrialRunner,
        stretch: Callable[[], range],
        changed: Callable[[], None],
    ) -> None:
        self._session, self._runs = session, session.runs
        self._runner, self._stretch, self._changed = runner, stretch, changed
        self.live = True
        """Whether a change is tried at once."""
        self.running: RunEntry | None = None
        self._made: WeakKeyDictionary[RunEntry, Trial] = WeakKeyDictionary()
        self._pause = session.later(self.run, _PAUSE_MS)
        session.changes.watch(Part.RUNS, self._on_runs)

    # ---- facts

    @property
    def entries(self) -> tuple[RunEntry, ...]:
        """Trials that are shown, the oldest first; those that were made runs are none."""
        return tuple(e for e in self._runs.entries if e in self._made and e.kind == "trial")

    @property
    def waits(self) -> bool:
        return self._pause.isActive()

    def settled(self) -> bool:
        return self.running is None and not self.waits

    def base(self) -> RunEntry | None:
        entry = self._runs.active
        return entry if entry is not None and entry.frames else None

    def wanted(self) -> Trial | None:
        stretch, base = self._stretch(), self.base()
        settings, preset = self._session.track.settings, self._session.track.preset
        if self._session.not_tried() or not len(stretch):
            return None
        seen = self._session.keypoints.for_trial(settings, stretch)
        first = self._session.track.first_pose
        spec = RunSpec(settings, preset, stretch, init=first, keypoints=seen)
        made = self._made.get(base) if base is not None else None
        kept = self._session.kept
        views = () if kept is None else kept.views
        return Trial(spec) if base is None else _trial_beside(base, made, spec, views)

    def words(self) -> str:
        entry = self.running
        if entry is not None:
            done, count = len(entry.frames), len(entry.wanted)
            if done == count:
                return f"Trial “{entry.name}”: looking again at frames with doubtful arms."
            return f"Trial “{entry.name}”: {done} of {count} frames."
        trial = self.wanted()
        return "" if trial is None else self._known(trial)

    def unlike(self, entry: RunEntry | None) -> tuple[str, ...]:
        """Differences from the run, besides parameters, of a trial or the next one."""
        trial = self._made.get(entry) if entry is not None else None
        trial = trial or (self.wanted() if self.base() is not None else None)
        return () if trial is None or trial.start is None else trial.start.unlike

    # ---- what a person does

    def on_settings(self) -> None:
        self.cancel()
        if self.live:
            self._pause.start()
        self._changed()

    def run(self) -> None:
        self.cancel()
        trial = self.wanted()
        if trial is not None and not self._known(trial):
            entry = self._new_entry(trial)
            # without a run to compare with it is the first one
            self._runs.add(entry, active=self._runs.active is None)
            self.running = entry
            title = f"tracking the trial {entry.name}"
            self._runner.track(title, entry, trial, self._on_grown, self._on_ended)
        self._changed()

    def cancel(self) -> None:
        entry = self._leave()
        if entry is not None:
            self._runs.remove(entry)

    def discard(self, *entries: RunEntry | None) -> None:
        for entry in self.entries:
            if entry in entries:
                self._runs.remove(entry)

    def make_run(self, entry: RunEntry) -> None:
        if entry is not self.running and entry in self.entries:
            if entry.settings is not None:
                entry.name = self._runs.next_name(self._session.track.name_of(entry.settings))
            entry.kind = "run"
            self._runs.activate(entry)
            self._runs.tell(Part.RUNS)

    def stop(self) -> None:
        self.cancel()
        self._made.clear()

    # ---- inside

    def _known(self, trial: Trial) -> str:
        """Which run has these settings already, as a sentence; empty where none has."""
        base = self.base()
        if base is None:
            return ""
        if base.made_with() == trial.settings:
            return "These are the settings of the run. Change a parameter to see its effect."
        for entry in self._runs.entries:
            if entry is self.running or entry not in self._made or entry.kind != "trial":
                continue
            other = self._made[entry]
            if other.settings == trial.settings and _starts_alike(other, trial):
                return f"The trial “{entry.name}” already has these settings."
        return ""

    def _new_entry(self, trial: Trial) -> RunEntry:
        base, as_run = self.base(), self._session.track.name_of(trial.settings)
        own = None if base is None else base.made_with()
        changes = "" if own is None else changes_in_words(own, trial.settings)
        runs, recording = self._runs, self._session.document.recording
        name = runs.next_name(as_run) if base is None else runs.free_name(changes or as_run)
        subject = recording.subject if recording is not None else None
        body = body_of_subject(subject, trial.settings.body)
        entry = RunEntry(name, trial.spec.preset, trial.settings, body, trial.stretch)
        entry.kind = "run" if base is None else "trial"
        self._made[entry] = trial
        return entry

    def _leave(self) -> RunEntry | None:
        self._pause.stop()
        self._runner.leave()
        entry, self.running = self.running, None
        return entry

    def _on_runs(self) -> None:
        if self.running is not None and self.running not in self._runs.entries:
            self._leave()
        self._changed()

    def _on_grown(self, entry: RunEntry, frames: list[int]) -> None:
        if self._session.document.frame in frames:
            self._session.instant.tell_soon()
        if len(entry.frames) == len(frames):
            # the first frame is shown at once, those after it now and then
            self._session.judging.judge()
        self._session.changes.tell(Part.RUN_FRAMES)

    def _on_ended(self, entry: RunEntry) -> None:
        self._leave()
        if entry.frames:
            self._session.edits.close_last()  # who changes a value again may want this one back
            self._session.judging.judge()
        else:
            self._runs.remove(entry)
        self._changed()


def _trial_beside(run: RunEntry, made: Trial | None, spec: RunSpec, views: Sequence[str]) -> Trial:
    """The trial to track a stretch from where a run was; by itself where it was nowhere near.

    `made` is the trial that the run was, if any; `spec` has settings, stretch and the first pose if
    the run states none; `views` are those that trials use.
    """
    known = run.spec()
    learned = made.known if made is not None else (known and known.frames) or run.wanted
    seed, seen = (0, None) if known is None else (known.seed, known.seen)
    spec = replace(spec, seed=seed, seen=seen)
    began = run.origin.began if run.origin is not None else None
    if run.stored is not None:
        began = began_of(run.stored.meta)
    first = spec.frames_of(0).start
    if made is not None and made.start is not None and first == made.stretch.start:
        start: TrialStart | None = made.start
    else:
        start = start_before(run.frames, first, began)
    if start is None:
        return Trial(spec, None, learned)
    unlike = (*start.unlike, *_unlike(run, known, spec, views, from_first=start.P is None))
    shape, lengths = _body_of(run, spec.settings)
    start = replace(start, shape=shape, lengths=lengths, unlike=tuple(dict.fromkeys(unlike)))
    if made is not None and made.start is not None:
        return Trial(replace(spec, init=made.spec.init), start, learned)
    pose = next((f.pose for f in run.ordered() if f.pose is not None), None)
    return Trial(replace(spec, init=pose or spec.init), start, learned)


def _starts_alike(trial: Trial, other: Trial) -> bool:
    if trial.reach != other.reach or trial.stretch != other.stretch:
        return False
    if trial.start is None or other.start is None:
        return trial.start is other.start
    return np.array_equal(trial.start.pose.position, other.start.pose.position)


def _body_of(run: RunEntry, settings: Settings) -> tuple[BodyShape | None, Proportions | None]:
    """Shape and lengths that a run found, if these settings would find them again."""
    own, shape = run.made_with(), None
    if own is None or stage_key(own, Stage.SHAPE) != stage_key(settings, Stage.SHAPE):
        return None, None
    if run.origin is not None:
        shape = run.origin.shape
    elif run.stored is not None:
        shape = shape_of_meta(run.stored.meta)
    return shape, run.body.skeleton.proportions


def _unlike(
    run: RunEntry, known: RunSpec | None, spec: RunSpec, views: Sequence[str], *, from_first: bool
) -> tuple[str, ...]:
    """Known differences of a trial from its run, besides parameters."""
    stored = {} if run.stored is None else run.stored.meta
    p = spec.settings.tracking
    if known is None:
        return ("The run does not state how it was made.",)
    used = {
        "clicks": known.clicks or stored.get("clicks"),
        "colours": known.colour and p.wants_colour,
    }
    found = [f"The run used {name}; trials do not." for name, there in used.items() if there]
    if known.views and sorted(known.views) != sorted(views):
        found.append(f"The run used the views {', '.join(known.views)}; trials use all.")
    if known.smooth:
        found.append("The run was smoothed; trials are not.")
    if stored:
        found.append("The run was read from a file, which rounds poses.")
    if not from_first and p.estimator == "annealed_particles":
        found.append("The run had particles of earlier frames.")
    if not from_first and p.matching == "model_to_data" and p.sampling == "random":
        found.append("The run had drawn other random points by then.")
    return tuple(found)

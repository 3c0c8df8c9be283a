"""What-if: a change of a parameter tracks a stretch again, in a process, beside the run."""

import logging
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from stereotrack_core.body.model import body_of_subject
from stereotrack_core.body.parameters import BodyShape
from stereotrack_core.body.proportions import Proportions
from stereotrack_core.counting import counted
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.run_spec import RunSpec
from stereotrack_core.tracking.stored import began_of, shape_of_meta
from stereotrack_core.tracking.tuning import stages
from stereotrack_core.tracking.tuning.process import MakeClouds, TrackTrial, TrialBegun, TrialFrame
from stereotrack_core.tracking.tuning.trial import Trial, TrialStart, start_before

from .base import Base
from .changes import Part
from .instant import InstantPresenter
from .jobs import Job, NewestJob, Task
from .judgement import JudgementPresenter, worst_frame
from .runs import RunEntry
from .tracking import TrackPresenter

_AHEAD_MS = 400
_PAUSE_MS = 100  # time without a further change after which a trial begins
_SECONDS = 2.0  # length of the stretch around the frame where nothing is selected
_LOOP_SECONDS = 0.5  # played before and after the worst frame of a trial


class TrialPresenter:
    """Trials as entries of the list of runs, drawn beside the active run until dismissed.

    Only one is tracked at a time; where none is, the clouds of the next one are made ahead.
    """

    def __init__(
        self,
        base: Base,
        track: TrackPresenter,
        judging: JudgementPresenter,
        instant: InstantPresenter,
        why_not: Callable[[], str],
    ) -> None:
        self._base, self._track, self._judging, self._instant = base, track, judging, instant
        self._why_not, self._runs = why_not, base.runs
        self._state, self._tell = base.view_state, base.changes.tell
        self._job, self._ahead = NewestJob(base.tasks), NewestJob(base.tasks, quiet=True)
        self.live = True  # whether a change is tried at once, in the workspace Tune
        self.loops = True
        """Whether the frames around the worst one of a trial are played, when it has ended."""
        self._loop: range | None = None
        self.running: RunEntry | None = None
        self._becomes_run = False  # whether what is tracked is made the active run at its end
        self._ended: RunEntry | None = None  # the trial that is looked at when it is judged
        self._pause = base.later(self.run, _PAUSE_MS)
        self._soon = base.later(self._make_clouds, _AHEAD_MS)
        watch = base.changes.watch
        watch(Part.RUNS, self._on_runs)
        watch(Part.SETTINGS, self._on_settings)
        watch(Part.WORKSPACE, self._on_workspace)
        watch(Part.JUDGEMENT, self._show_worst)
        watch(Part.ACTIVE_RUN | Part.SELECTION | Part.WORKSPACE, self._make_clouds_soon)
        watch(Part.LEAVING, self.stop)

    # ---- facts

    @property
    def entries(self) -> tuple[RunEntry, ...]:
        """Trials that are shown, the oldest first; those that were made runs are none."""
        return tuple(entry for entry in self._runs.entries if entry.kind == "trial")

    @property
    def waits(self) -> bool:
        return self._pause.isActive()

    def settled(self) -> bool:
        return self.running is None and not self.waits

    def base(self) -> RunEntry | None:
        entry = self._runs.active
        return entry if entry is not None and entry.frames else None

    def stretch(self) -> range:
        """Frames to try on: the selection, else two seconds around the frame that is shown."""
        document, selected = self._base.document, self._state.selection
        count = document.frame_count
        if document.recording is None or not count or selected:
            return selected or range(0)
        length = min(max(round(_SECONDS * document.recording.fps), 2), count)
        first = min(max(document.frame - length // 2, 0), count - length)
        return range(first, first + length)

    def wanted(self) -> Trial | None:
        track, stretch, base = self._track, self.stretch(), self.base()
        if self._why_not() or not len(stretch):
            return None
        kept, seen = track.kept, track.keypoints.for_trial(track.settings, stretch)
        spec = RunSpec(track.settings, track.preset, stretch, init=track.first_pose, keypoints=seen)
        views = () if kept is None else kept.views
        return Trial(spec) if base is None else trial_beside(base, spec, views)

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
        trial = None if entry is None else entry.trial
        trial = trial or (self.wanted() if self.base() is not None else None)
        return () if trial is None or trial.start is None else trial.start.unlike

    # ---- what a person does

    def toggle_live(self) -> None:
        self.live = not self.live
        self._tell(Part.TRIALS)

    def toggle_loops(self) -> None:
        self.loops = not self.loops
        self._end_loop()
        self._tell(Part.TRIALS)

    def run(self) -> None:
        self.cancel()
        trial = self.wanted()
        if trial is not None and not self._known(trial):
            self.begin(trial)
        self._tell(Part.TRIALS)

    def run_as(self, run: RunEntry, stretch: range) -> None:
        """Track frames from the state that a run had before them, as a run of its own."""
        self._track.stop()
        self.cancel()
        self._runs.activate(run)
        self._state.select(stretch)
        if (trial := self.wanted()) is not None:
            self.begin(trial)
            self._becomes_run = True

    def begin(self, trial: Trial) -> None:
        """Have a trial tracked; without a run to compare with it is the first one."""
        self._make_no_clouds()
        self._becomes_run = False
        entry, kept = self._new_entry(trial), self._track.kept
        assert kept is not None  # noqa: S101 - there are no trials without
        self._runs.add(entry, active=self._runs.active is None)
        self.running = entry
        todo, process = TrackTrial(kept, trial), self._base.processes.trials
        work = partial(Task.in_process, process=process, todo=todo)
        told, ended = partial(self._on_told, entry), partial(self._on_ended, entry)
        self._job.run(Job(f"tracking the trial {entry.name}", work, ended=ended, told=told))

    def cancel(self) -> None:
        """Give up the trial that is tracked, and the one that is about to begin."""
        self._pause.stop()
        self._job.give_up()
        entry, self.running = self.running, None
        if entry is not None:
            self._runs.remove(entry)

    def discard(self, *entries: RunEntry | None) -> None:
        for entry in self.entries:
            if entry in entries:
                self._runs.remove(entry)

    def lost_words(self) -> str:
        """``3 trials``; empty without any."""
        count = sum(bool(entry.frames) for entry in self.entries)
        return counted(count, "trial") if count else ""

    def keep(self) -> None:
        """Make runs of all trials, of the one that is tracked with the frames that it has."""
        self._pause.stop()
        self._job.give_up()
        self.running = None
        for entry in self.entries:
            if entry.frames:
                self.make_run(entry)

    def make_run(self, entry: RunEntry) -> None:
        if entry is not self.running and entry in self.entries:
            if entry.settings is not None:
                entry.name = self._runs.next_name(self._track.name_of(entry.settings))
            entry.kind = "run"
            self._runs.activate(entry)
            self._runs.tell(Part.RUNS)

    # ---- following

    @property
    def _is_tuning(self) -> bool:
        return self._state.workspace == "tune"

    def _on_settings(self) -> None:
        """Try the settings soon, on a stretch that is selected then, so that it stays."""
        if self._is_tuning or self.running is not None:
            self.cancel()
        if self._is_tuning and self.live:
            self._state.select(self.stretch() or None)
            self._pause.start()
        self._tell(Part.TRIALS)

    def _on_workspace(self) -> None:
        if not self._is_tuning:
            self._pause.stop()
            self._end_loop()

    def _on_runs(self) -> None:
        if self.running is not None and self.running not in self._runs.entries:
            self.running = None
            self.cancel()

    def stop(self) -> None:
        self._make_no_clouds()
        self.cancel()

    def _make_clouds_soon(self) -> None:
        self._make_no_clouds()
        self._soon.start()

    def _make_no_clouds(self) -> None:
        """Make no more clouds; what is made is kept."""
        self._soon.stop()
        self._ahead.give_up()

    def _make_clouds(self) -> None:
        kept, idle = self._track.kept, self.settled() and not self._track.running
        trial = self.wanted() if self._is_tuning and idle and self.base() is not None else None
        if trial is not None and kept is not None:
            todo, process = MakeClouds(kept, trial), self._base.processes.trials
            work = partial(Task.in_process, process=process, todo=todo)
            self._ahead.run(Job("clouds", work, failed=_on_failed))

    def _known(self, trial: Trial) -> str:
        """Which run has these settings already, as a sentence; empty where none has."""
        base = self.base()
        if base is None:
            return ""
        if base.made_with() == trial.settings:
            return "These are the settings of the run. Change a parameter to see its effect."
        for entry in self.entries:
            other = entry.trial
            if entry is self.running or other is None or other.settings != trial.settings:
                continue
            if _starts_alike(other, trial):
                return f"The trial “{entry.name}” already has these settings."
        return ""

    def _new_entry(self, trial: Trial) -> RunEntry:
        base, as_run = self.base(), self._track.name_of(trial.settings)
        own = None if base is None else base.made_with()
        last = next((one.settings for one in reversed(self.entries) if one.settings), None)
        newest = stages.changed_names(last or self._track.base, trial.settings)
        changes = "" if own is None else stages.changes_in_words(own, trial.settings, newest)
        runs, recording = self._runs, self._base.document.recording
        name = runs.next_name(as_run) if base is None else runs.free_name(changes or as_run)
        subject = recording.subject if recording is not None else None
        body = body_of_subject(subject, trial.settings.body)
        entry = RunEntry(name, trial.spec.preset, trial.settings, body, trial.stretch, trial=trial)
        entry.kind = "run" if base is None else "trial"
        return entry

    def _on_told(self, entry: RunEntry, words: list[Any]) -> None:
        frames = list[int]()
        for word in words:
            match word:
                case TrialBegun():
                    entry.body, entry.origin = word.body, word.origin
                case TrialFrame():
                    entry.wall_seconds = word.seconds
                    entry.frames[word.frame.frame] = word.frame
                    frames.append(word.frame.frame)
        if not frames:
            return
        if self._job.task is not None:
            self._job.task.report(len(entry.frames) / len(entry.wanted))
        if self._base.document.frame in frames:
            self._instant.tell_soon()
        if len(entry.frames) == len(frames):
            # the first frame is shown at once, those after it now and then
            self._judging.judge()
        self._tell(Part.RUN_FRAMES)

    def _on_ended(self, entry: RunEntry) -> None:
        self.running = None
        task = self._job.task
        given_up = task is not None and task.token.cancelled() and entry.kind == "run"
        if entry.frames and not given_up:
            self._base.edits.close_last()  # who changes a value again may want this one back
            self._ended = entry
            self._judging.judge()
            if self._becomes_run:
                self.make_run(entry)
        else:
            self._runs.remove(entry)
        self._tell(Part.TRIALS)

    def _show_worst(self) -> None:
        """Go to the worst frame of the trial that has ended, and play around it if wanted."""
        entry, document = self._ended, self._base.document
        judgement, recording = self._judging.of(entry), document.recording
        if entry is None or judgement is None or not self._judging.settled():
            return
        self._ended, worst = None, worst_frame(judgement)
        if worst is None or recording is None or not self._is_tuning:
            return
        document.go_to(worst)
        if self.loops:
            around, wanted = max(round(_LOOP_SECONDS * recording.fps), 1), entry.wanted
            first, end = max(worst - around, wanted.start), min(worst + around + 1, wanted.stop)
            document.loop = self._loop = range(first, end)
            document.play()

    def _end_loop(self) -> None:
        document = self._base.document
        if self._loop is not None and document.loop == self._loop:
            document.loop = None
            document.pause()
        self._loop = None


def _on_failed(error: Exception) -> None:
    """Log the error; a trial of the same stretch shows it to the person."""
    logging.getLogger(__name__).error("clouds could not be precomputed", exc_info=error)


def trial_beside(run: RunEntry, spec: RunSpec, views: Sequence[str]) -> Trial:
    """The trial to track a stretch from where a run was; by itself where it was nowhere near.

    `spec` has settings, stretch and the first pose if the run states none; `views` are those that
    trials use.
    """
    made, known = run.trial, run.spec()
    learned = made.known if made is not None else (known and known.frames) or run.wanted
    seed, seen = (0, None) if known is None else (known.seed, known.seen)
    spec = replace(spec, seed=seed, seen=seen)
    first = spec.frames_of(0).start
    if made is not None and made.start is not None and first == made.stretch.start:
        start: TrialStart | None = made.start
    else:
        start = start_before(run.frames, first, began_of(run.meta))
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
    own, shape = run.made_with(), stages.Stage.SHAPE
    if own is None or stages.stage_key(own, shape) != stages.stage_key(settings, shape):
        return None, None
    return shape_of_meta(run.meta) if run.meta else None, run.body.skeleton.proportions


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

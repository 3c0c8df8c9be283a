"""Remedies of a failure: other settings tried on it, the best also on stretches that were good."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Literal, TypeAlias

import numpy as np

from stereotrack_core.evaluation.failure_segments.find import good_stretches
from stereotrack_core.evaluation.failure_segments.segment import FailureSegment, limbs_words
from stereotrack_core.tracking.frame import TrackedFrame
from stereotrack_core.tracking.run_spec import RunSpec
from stereotrack_core.tracking.tuning.process import (
    KeptRecording,
    TrackTrial,
    TrialBegun,
    TrialFrame,
)
from stereotrack_core.tracking.tuning.remedy import Change, changes, without_parts
from stereotrack_core.tracking.tuning.trial import Trial, TrialStart
from stereotrack_core.worker_processes import TaskProcess

from .base import Base
from .changes import Part
from .failures import FailurePresenter
from .jobs import Job, NewestJob, Task
from .judgement import JudgementPresenter, Truth, judged
from .runs import RunEntry
from .tracking import TrackPresenter
from .trials import trial_beside

Kind: TypeAlias = Literal["remedy", "parts"]

_CHECKED, _GOOD, _GOOD_SECONDS = 3, 3, 1.0
_NOT_TRACKED = 90.0  # degrees that a frame without a pose counts
UNCHANGED = "no change"
HARMLESS = 1.0  # degrees by which a good stretch may get worse, as trials with other seeds do
WORTH = 1.0  # degrees by which a failure must get better to be called repaired in part


@dataclass(frozen=True, eq=False)
class Remedy:
    """One change that was tried on a failure."""

    change: Change
    entry: RunEntry  # the trial over the failure
    error: float  # of the arms over the failure; see :func:`arms_measure`
    gain: float  # by which the run has more
    harm: float | None = None  # most by which it makes a good stretch worse; None if not checked


@dataclass(frozen=True, eq=False)
class Tried:
    """All that was tried on a failure of a run."""

    kind: Kind
    run: RunEntry
    failure: FailureSegment
    stretch: range
    unit: str
    error: float  # of the run over the stretch
    count: int  # changes that are tried
    good: int  # stretches that the best are checked on
    remedies: tuple[Remedy, ...] = ()  # the largest gain first

    def with_remedy(self, remedy: Remedy) -> Tried:
        """The same with one more, or one that is known better than before."""
        others = [one for one in self.remedies if one.change != remedy.change]
        ordered = sorted([*others, remedy], key=lambda one: -one.gain)
        return replace(self, remedies=tuple(ordered))


def arms_measure(entry: RunEntry, truth: Truth | None, stretch: range) -> float:
    """Mean over frames and limbs of the arms: error in degrees, else failure probability in %."""
    one = judged(entry, truth)
    inside = (one.frame >= stretch.start) & (one.frame < stretch.stop)
    lost = {limb: 100.0 * chance for limb, chance in one.lost.items()}
    by_limb = one.limbs if one.measure == "error" else lost
    values = np.array([values for limb, values in by_limb.items() if "arm" in limb])[:, inside]
    values[:, ~one.tracked[inside]] = _NOT_TRACKED if one.measure == "error" else 100.0
    known = values[np.isfinite(values)]
    return float(known.mean()) if len(known) else float("nan")


@dataclass(frozen=True, eq=False)
class _Search:
    """The changes to try, in another thread; the run's entry is a copy of its own."""

    tried: Tried
    changes: tuple[Change, ...]
    good: tuple[range, ...]
    truth: Truth | None
    trial: Callable[[Change, range], Trial]
    kept: KeptRecording
    process: TaskProcess

    def work(self, task: Task) -> None:
        """Try all changes on the failure, then the best ones on good stretches."""
        tried, done = self.tried, 0
        total = len(self.changes) + len(self.good) * min(_CHECKED, len(self.changes))
        for change in self.changes:
            task.report(done / total, f"{done + 1} of {len(self.changes)} changes")
            entry = self._tracked(task, change, tried.stretch)
            error = arms_measure(entry, self.truth, tried.stretch)
            remedy = Remedy(change, entry, error, tried.error - error)
            tried, done = tried.with_remedy(remedy), done + 1
            task.tell(remedy)
        if tried.kind == "parts":
            return
        others = [one for one in tried.remedies if one.change.words != UNCHANGED]
        best = [one for one in others[:_CHECKED] if one.gain >= WORTH]
        usual = [self._error(task, self.changes[0], one) for one in self.good if best]
        for remedy in best:
            harm = -np.inf
            for stretch, before in zip(self.good, usual, strict=True):
                task.report(done / total, "checking stretches that were good")
                harm = max(harm, self._error(task, remedy.change, stretch) - before)
                done += 1
            if self.good:
                task.tell(replace(remedy, harm=float(harm)))

    def _error(self, task: Task, change: Change, stretch: range) -> float:
        return arms_measure(self._tracked(task, change, stretch), self.truth, stretch)

    def _tracked(self, task: Task, change: Change, stretch: range) -> RunEntry:
        """A trial of a stretch. Each is a task of its own, so that a person's come between."""
        trial = self.trial(change, stretch)
        frames, begun = dict[int, TrackedFrame](), list[TrialBegun]()

        def hear(word: Any) -> None:
            if isinstance(word, TrialFrame):
                frames[word.frame.frame] = word.frame
            elif isinstance(word, TrialBegun):
                begun.append(word)

        self.process(TrackTrial(self.kept, trial), hear, task.token.cancelled)
        body = begun[-1].body if begun else self.tried.run.body
        origin = begun[-1].origin if begun else None
        return RunEntry(
            change.words, trial.spec.preset, trial.settings, body, stretch, frames,
            origin=origin, kind="trial", trial=trial,
        )  # fmt: skip


class RemedyPresenter:
    """Looks for remedies of the chosen failure; a table of gain against harm."""

    def __init__(
        self,
        base: Base,
        track: TrackPresenter,
        judging: JudgementPresenter,
        failures: FailurePresenter,
    ) -> None:
        self._base, self._track, self._judging = base, track, judging
        self._failures = failures
        self._job = NewestJob(base.tasks)
        self.tried: Tried | None = None
        base.changes.watch(Part.LEAVING | Part.ACTIVE_RUN, self.forget)

    # ---- facts

    @property
    def running(self) -> bool:
        return self._job.busy

    def settled(self) -> bool:
        return not self._job.busy

    def why_not(self) -> str:
        """Why nothing can be tried now, as a sentence."""
        entry = self._base.runs.active
        if entry is None or entry.made_with() is None:
            return "The run does not state its settings. Run the tracker first."
        return "" if self._failures.at_hand() is not None else "Select a failure first."

    def words(self) -> str:
        tried = self.tried
        if tried is None:
            return ""
        first, last, done = tried.stretch.start, tried.stretch.stop - 1, len(tried.remedies)
        said = f"{limbs_words(tried.failure.limbs).capitalize()}, frames {first} to {last}: the "
        said += f"run has {tried.error:.1f}{tried.unit}. {done} of {tried.count} changes tried."
        if self.running:
            return said
        better = [one for one in tried.remedies if one.gain >= WORTH]
        luck = next((one for one in better if one.change.words == UNCHANGED), None)
        if luck is not None:
            said += (
                f" From the frame before, it has {luck.error:.1f}{tried.unit} without any change."
            )
        if not better:
            return f"{said} None makes it better."
        if tried.kind == "parts":
            return f"{said} Best {better[0].change.words}."
        harmless = next((one for one in better if is_harmless(one) and one is not luck), None)
        return f"{said} Best without harm: {harmless.change.words}." if harmless else said

    # ---- what a person does

    def find(self, kind: Kind) -> None:
        """Try changes that the chosen failure points to, or the run without single parts."""
        search = None if self.why_not() else self._search(kind)
        if search is None:
            return
        self.tried, first = search.tried, limbs_words(search.tried.failure.limbs)
        title = f"finding a remedy for {first}" if kind == "remedy" else f"trying parts for {first}"
        told, tell = self._on_told, partial(self._base.changes.tell, Part.REMEDIES)
        self._job.run(Job(title, search.work, ended=tell, told=told))
        tell()

    def stop(self) -> None:
        """Try no more; what was tried stays."""
        self._job.cancel()

    def forget(self) -> None:
        self._job.give_up()
        if self.tried is not None:
            self.tried = None
            self._base.changes.tell(Part.REMEDIES)

    def show(self, remedy: Remedy) -> None:
        """Make it a trial that is drawn beside the run, and go to the failure's worst frame."""
        runs, entry = self._base.runs, remedy.entry
        if entry not in runs.entries:
            entry.name = runs.free_name(entry.name)
            runs.add(entry, active=False)
            self._judging.judge()
        runs.bring_to_front(entry)
        if self.tried is not None:
            self._failures.jump(self.tried.failure)

    def use(self, remedy: Remedy) -> None:
        """Use its settings from now on."""
        self._track.use(remedy.change.settings, f"use remedy {remedy.change.words}")

    # ---- trying

    def _search(self, kind: Kind) -> _Search | None:
        failure, found = self._failures.at_hand(), self._failures.found
        entry, kept = self._base.runs.active, self._track.kept
        if failure is None or entry is None or kept is None or found is None:
            return None
        stretch, run = self._failures.stretch_of(failure), entry.now()
        settings, spec, truth = run.made_with(), run.spec(), self._judging.truth
        if stretch is None or settings is None or found.search is None:
            return None
        stated = None if spec is None else spec.views
        views = tuple(name for name in stated or kept.views if name in kept.views)
        if kind == "remedy":
            unchanged = Change(UNCHANGED, settings)
            tried: Sequence[Change] = (unchanged, *changes(settings, failure.parameters))
        else:
            tried = without_parts(settings, views)
        good = tuple(good_stretches(found.search, found.failures, _GOOD, _GOOD_SECONDS))
        error = arms_measure(run, truth, stretch)
        unit = "°" if judged(run, truth).measure == "error" else " % failure probability"

        def trial(change: Change, of: range) -> Trial:
            seen = None if spec is None else spec.keypoints
            used = RunSpec(
                change.settings, run.preset, of, change.views or stated,
                init=self._track.first_pose, keypoints=seen,
            )  # fmt: skip
            made, before = trial_beside(run, used, kept.views), run.at(of.start - 1)
            if made.start is None or before is None or not before.tracked:
                return made
            # many are tried: each begins at the frame before, and looks at no frame after
            begin = before.estimate.pose, before.P, made.start.shape
            start = TrialStart(*begin, lengths=made.start.lengths, end=of.stop)
            return replace(made, start=start)

        begun = Tried(kind, run, failure, stretch, unit, error, len(tried), len(good))
        process = self._base.processes.trials
        return _Search(begun, tuple(tried), good, truth, trial, kept, process)

    def _on_told(self, remedies: list[Remedy]) -> None:
        for remedy in remedies:
            if self.tried is not None:
                self.tried = self.tried.with_remedy(remedy)
        self._base.changes.tell(Part.REMEDIES)


def is_harmless(remedy: Remedy) -> bool:
    """Whether it was checked, and no good stretch gets worse."""
    return remedy.harm is not None and remedy.harm < HARMLESS

"""Remedies of a failure: other settings tried on it, the best also on stretches that were good."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Literal, TypeAlias

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.evaluation.failure_segments.find import good_stretches
from stereotrack_core.evaluation.failure_segments.segment import FailureSegment, limbs_words
from stereotrack_core.study.description import Study, StudyRecording
from stereotrack_core.study.run import good_run
from stereotrack_core.tracking.frame import TrackedFrame
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.run_spec import AUTO, FirstPose, RunSpec
from stereotrack_core.tracking.tuning.process import (
    KeptRecording,
    TrackTrial,
    TrialBegun,
    TrialFrame,
)
from stereotrack_core.tracking.tuning.remedy import Change, changes, without_parts
from stereotrack_core.tracking.tuning.stages import changed_names
from stereotrack_core.tracking.tuning.trial import Trial, TrialStart
from stereotrack_core.work import Work
from stereotrack_core.worker_processes import TaskProcess

from .base import Base
from .changes import Part
from .failures import FailurePresenter
from .jobs import Job, NewestJob, Task
from .judgement import JudgementPresenter, Truth, judged, recorded_truth
from .runs import RunEntry, entry_of_run
from .study import StudyPresenter
from .tracking import TrackPresenter
from .trials import trial_beside

Kind: TypeAlias = Literal["remedy", "parts"]

_CHECKED, _GOOD, _GOOD_SECONDS = 3, 3, 1.0
_NAMED = 3  # recordings that are named of those that were left out for the same reason
_NOT_TRACKED = 90.0  # degrees that a frame without a pose counts
UNCHANGED = "no change"
HARMLESS = 1.0  # degrees by which a good stretch may get worse, as trials with other seeds do
WORTH = 1.0  # degrees by which a failure must get better to be called repaired in part


@dataclass(frozen=True)
class Harm:
    """Most by which a change makes a good stretch of another recording of the study worse."""

    recording: str  # as the study lists it
    worst: float
    unit: str


@dataclass(frozen=True, eq=False)
class Remedy:
    """One change that was tried on a failure."""

    change: Change
    entry: RunEntry  # the trial over the failure
    error: float  # of the arms over the failure; see :func:`arms_measure`
    gain: float  # by which no change has more, as it begins alike; of no change, the run
    harm: float | None = None
    """Most by which it makes a good stretch worse, or one arm in the failure; None: not checked."""
    elsewhere: tuple[Harm, ...] = ()  # for each recording of the study that was checked so far

    @property
    def worst_elsewhere(self) -> Harm | None:
        """Where it harms most in the study; None if no other recording was checked."""
        return max(self.elsewhere, key=lambda one: one.worst, default=None)


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
    study: Study | None = None  # the best are checked on its other recordings, too
    others: tuple[StudyRecording, ...] = ()
    left_out: tuple[tuple[str, InputError], ...] = ()  # recordings that cannot be checked, and why
    remedies: tuple[Remedy, ...] = ()  # the largest gain first

    def with_remedies(self, *remedies: Remedy) -> Tried:
        """The same with more, or with some that are known better than before."""
        changes = [one.change for one in remedies]
        others = [one for one in self.remedies if one.change not in changes]
        ordered = sorted([*others, *remedies], key=lambda one: -one.gain)
        return replace(self, remedies=tuple(ordered))


def arms_measure(entry: RunEntry, truth: Truth | None, stretch: range, side: str = "") -> float:
    """Mean over frames and limbs of the arms, or of the one on a `side` (``left``, ``right``).

    Error in degrees, else failure probability in %.
    """
    one = judged(entry, truth)
    inside = (one.frame >= stretch.start) & (one.frame < stretch.stop)
    lost = {limb: 100.0 * chance for limb, chance in one.lost.items()}
    by_limb = one.limbs if one.measure == "error" else lost
    arms = (limb for limb in by_limb if "arm" in limb and side in limb)
    values = np.array([by_limb[limb] for limb in arms])[:, inside]
    values[:, ~one.tracked[inside]] = _NOT_TRACKED if one.measure == "error" else 100.0
    known = values[np.isfinite(values)]
    return float(known.mean()) if len(known) else float("nan")


@dataclass(frozen=True, eq=False)
class _Place:
    """A recording with a run that changes are tried on; the run's entry is a copy of its own."""

    kept: KeptRecording
    run: RunEntry
    truth: Truth | None
    good: tuple[range, ...]
    process: TaskProcess
    first_pose: FirstPose = AUTO

    @property
    def unit(self) -> str:
        """Unit of the errors here: degrees, or percent where only failure probability is known."""
        return "°" if judged(self.run, self.truth).measure == "error" else " %"

    def harms(self, work: Work, changes: Sequence[Change], words: str) -> FloatArray:
        """Most by which changes make a good stretch worse than the first one does; NaN unknown."""
        errors = np.full((len(self.good), len(changes)), np.nan)
        for done, (i, k) in enumerate(np.ndindex(errors.shape)):
            work.step(done / errors.size, words)
            entry = self.tracked(work, changes[k], self.good[i])
            errors[i, k] = arms_measure(entry, self.truth, self.good[i])
        worse = errors[:, 1:] - errors[:, :1]
        return np.asarray(np.fmax.reduce(worse, axis=0, initial=np.nan))

    def tracked(self, work: Work, change: Change, stretch: range) -> RunEntry:
        """A trial of a stretch. Each is a task of its own, so that a person's come between."""
        trial = self._trial(change, stretch)
        frames, begun = dict[int, TrackedFrame](), list[TrialBegun]()

        def hear(word: Any) -> None:
            if isinstance(word, TrialFrame):
                frames[word.frame.frame] = word.frame
            elif isinstance(word, TrialBegun):
                begun.append(word)

        self.process(TrackTrial(self.kept, trial), hear, work.stopped)
        body = begun[-1].body if begun else self.run.body
        origin = begun[-1].origin if begun else None
        return RunEntry(
            change.words, trial.spec.preset, trial.settings, body, stretch, frames,
            origin=origin, kind="trial", trial=trial,
        )  # fmt: skip

    def _trial(self, change: Change, of: range) -> Trial:
        run, spec = self.run, self.run.spec()
        stated, seen = (None, None) if spec is None else (spec.views, spec.keypoints)
        used = RunSpec(
            change.settings, run.preset, of, change.views or stated,
            init=self.first_pose, keypoints=seen,
        )  # fmt: skip
        made, before = trial_beside(run, used, self.kept.views), run.at(of.start - 1)
        if made.start is None or before is None or not before.tracked:
            return made
        # many are tried: each begins at the frame before, and looks at no frame after
        begin = before.estimate.pose, before.P, made.start.shape
        start = TrialStart(*begin, lengths=made.start.lengths, end=of.stop)
        return replace(made, start=start)


def _elsewhere(
    study: Study, row: StudyRecording, settings: Settings, process: TaskProcess
) -> _Place:
    """Another recording with the run that the study keeps of it. Raises InputError."""
    found = good_run(study, row, settings, _GOOD, _GOOD_SECONDS)
    unaided = replace(found.recording, reference=None)  # the tracker never sees the truth
    mono = [view.name for view in unaided.views if view.kind == "mono" and view.name in found.views]
    kept, run = KeptRecording(unaided, tuple(mono)), entry_of_run(found.run, found.path)
    return _Place(kept, run, recorded_truth(found.reference), found.stretches, process)


@dataclass(frozen=True, eq=False)
class _Search:
    """The changes to try, in another thread; what is known is told again and again."""

    tried: Tried
    changes: tuple[Change, ...]
    here: _Place

    def work(self, task: Task) -> None:
        """Try all changes on the failure, then the best ones where runs were good."""
        tried, count, truth = self.tried, len(self.changes), self.here.truth
        base, arms, worse = tried.error, np.full(2, np.nan), dict[Change, float]()
        checks = 0 if tried.kind == "parts" else _GOOD * (_CHECKED + 1)  # trials for a recording
        total = count + checks * (1 + len(tried.others))
        for done, change in enumerate(self.changes):
            task.report(done / total, f"{done + 1} of {count} changes")
            entry = self.here.tracked(task.work, change, tried.stretch)
            error = arms_measure(entry, truth, tried.stretch)
            each = [arms_measure(entry, truth, tried.stretch, side) for side in ("left", "right")]
            worse[change] = float(np.fmax.reduce(each - arms, initial=np.nan))
            tried = tried.with_remedies(Remedy(change, entry, error, base - error))
            task.tell(tried)
            if change.words == UNCHANGED:
                base, arms = error, np.array(each)
        others = [one for one in tried.remedies if one.change.words != UNCHANGED]
        best = [one for one in others[:_CHECKED] if one.gain >= WORTH]
        if tried.kind == "parts" or not best:
            return
        asked, end = (self.changes[0], *(one.change for one in best)), count + checks
        part = task.work.part(count / total, end / total)
        harms = self.here.harms(part, asked, "checking stretches that were good")
        own = [worse[one.change] for one in best]
        known = [None if np.isnan(harm) else float(harm) for harm in np.fmax(harms, own)]
        best = [replace(one, harm=harm) for one, harm in zip(best, known, strict=True)]
        tried = tried.with_remedies(*best)
        task.tell(tried)
        if tried.study is not None and tried.others:
            self._check_elsewhere(task, task.work.part(end / total, 1.0), tried, best)

    def _check_elsewhere(
        self, task: Task, work: Work, tried: Tried, best: Sequence[Remedy]
    ) -> None:
        """Check on the other recordings, in a process that ends with it and frees its memory.

        The process of the trials keeps the clouds of the open recording meanwhile.
        """
        assert tried.study is not None  # noqa: S101 - it has the recordings
        asked, count = (self.changes[0], *(one.change for one in best)), len(tried.others)
        with closing(TaskProcess()) as process:
            for k, row in enumerate(tried.others):
                part, words = work.part(k / count, (k + 1) / count), f"checking {row.recording}"
                part.step(0.0, words)
                try:
                    place = _elsewhere(tried.study, row, asked[0].settings, process)
                    harms = place.harms(part, asked, words)
                    if not np.isfinite(harms).all():
                        what = "no error or failure probability of its arms is known"
                        raise InputError(what, remedy="Give it a reference.")
                except InputError as error:
                    tried = replace(tried, left_out=(*tried.left_out, (row.recording, error)))
                else:
                    found = [Harm(row.recording, harm, place.unit) for harm in harms.tolist()]
                    best = [
                        replace(one, elsewhere=(*one.elsewhere, harm))
                        for one, harm in zip(best, found, strict=True)
                    ]
                    tried = tried.with_remedies(*best)
                task.tell(tried)


class RemedyPresenter:
    """Looks for remedies of the chosen failure; a table of gain against harm."""

    def __init__(
        self,
        base: Base,
        track: TrackPresenter,
        judging: JudgementPresenter,
        failures: FailurePresenter,
        study: StudyPresenter,
    ) -> None:
        self._base, self._track, self._judging = base, track, judging
        self._failures, self._study = failures, study
        self._job = NewestJob(base.tasks)
        self.tried: Tried | None = None
        base.changes.watch(Part.LEAVING, self.forget)
        base.changes.watch(Part.ACTIVE_RUN, self.stop)  # the next run is made by what was tried

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
        said = f"{limbs_words(tried.failure.limbs).capitalize()}, frames {first} to {last}: run "
        said += f"“{tried.run.name}” has {tried.error:.1f}{tried.unit}. "
        said += f"{done} of {tried.count} changes tried."
        if self.running:
            return f"{said}{_study_words(tried)}"
        found = [one for one in tried.remedies if one.gain >= WORTH]
        luck = next((one for one in found if one.change.words == UNCHANGED), None)
        better = [one for one in found if one is not luck]
        if luck is not None:
            said += (
                f" From the frame before, it has {luck.error:.1f}{tried.unit} without any change."
            )
        if not better:
            return f"{said} None makes it better."
        if tried.kind == "parts":
            return f"{said} Best {better[0].change.words}."
        harmless = next((one for one in better if is_harmless(one)), None)
        said = f"{said} Best without harm: {harmless.change.words}." if harmless else said
        return f"{said}{_study_words(tried)}"

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
        known = run.numbers()  # frames that the run does not have would be compared with nothing
        stretch = range(max(stretch.start, known[0]), min(stretch.stop, known[-1] + 1))
        stated = None if spec is None else spec.views
        views = tuple(name for name in stated or kept.views if name in kept.views)
        remedies = kind == "remedy"
        other = (
            changes(settings, failure.parameters) if remedies else without_parts(settings, views)
        )
        own, idle = partial(changed_names, settings), failure.idle
        acting = (one for one in other if one.views or not idle.issuperset(own(one.settings)))
        tried = (Change(UNCHANGED, settings), *acting)
        good = tuple(good_stretches(found.search, found.failures, _GOOD, _GOOD_SECONDS))
        process, first_pose = self._base.processes.trials, self._track.first_pose
        here = _Place(kept, run, truth, good, process, first_pose)
        study, folder = self._study.study, kept.recording.folder.resolve()
        others = () if study is None else study.rows_besides(folder)
        error = arms_measure(run, truth, stretch)
        unit = here.unit if here.unit == "°" else f"{here.unit} failure probability"
        counts = len(tried), len(good)
        begun = Tried(kind, run, failure, stretch, unit, error, *counts, study, others)
        return _Search(begun, tried, here)

    def _on_told(self, told: list[Tried]) -> None:
        self.tried = told[-1]
        self._base.changes.tell(Part.REMEDIES)


def is_harmless(remedy: Remedy) -> bool:
    """Whether it was checked, and no good stretch of any recording gets worse."""
    harms = [one.worst for one in remedy.elsewhere]
    harms += [] if remedy.harm is None else [remedy.harm]
    return bool(harms) and max(harms) < HARMLESS


def _study_words(tried: Tried) -> str:
    """Which recordings of the study were checked, and which were not and why."""
    if tried.kind == "parts":
        return ""
    if tried.study is None:
        return " No study is open, so harm is checked on this recording alone."
    said = f" Study {tried.study.stem}: "
    if not tried.others:
        return f"{said}no other recording."
    checked = max((len(one.elsewhere) for one in tried.remedies), default=0)
    said += f"{checked} of {counted(len(tried.others), 'other recording')} checked"
    whys: dict[str, list[str]] = {}
    for name, error in tried.left_out:
        whys.setdefault(error.what, []).append(name)
    left = (f"{_some(names)} ({what})" for what, names in whys.items())
    return f"{said}, but not {', '.join(left)}." if whys else f"{said}."


def _some(names: Sequence[str]) -> str:
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    return ", ".join(names[:_NAMED]) + more

"""One parameter at several values: each is tracked, judged, and can be shown in the views."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from PySide6.QtCore import QObject, Signal, Slot

from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import proportions_of
from stereotrack_core.errors import Cancelled
from stereotrack_core.parameters import ParameterRow, Value
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.run_spec import FirstPose
from stereotrack_core.tracking.tuning.attempt import Attempt

from ...services.failures import message_of
from ...services.tasks.task import Task, TaskList
from ...session.document import DocumentPresenter
from ...session.judgement import MEASURED_LIMBS, Judgement, JudgementPresenter, judged
from ...session.runs import RunEntry, RunList
from ...widgets.plots.small_multiples import Multiple
from .attempts import AttemptPresenter, take_over
from .base import attempt_from, with_unit
from .numbers import Summary, summary_of
from .runner import Request, Result, TrialRunner, Trials
from .stores import StoreKeeper

_LOOK_SECONDS = 0.1


@dataclass(eq=False)
class Tried:
    """One value, and what was tracked with it so far.

    Attributes
    ----------
    value : bool, int, float or str
    words : str
        With its unit.
    entry : RunEntry
    judgement : Judgement or None
        None while there is no frame.
    """

    value: Value
    words: str
    entry: RunEntry
    judgement: Judgement | None = None

    @property
    def summary(self) -> Summary | None:
        """Its numbers."""
        return summary_of(self.judgement) if self.judgement is not None else None

    @property
    def complete(self) -> bool:
        """Whether all frames are there."""
        return len(self.entry.frames) == len(self.entry.wanted)


class SeriesPresenter(QObject):
    """Tracks the stretch once for each value, in the background.

    Parameters
    ----------
    document, runs, judging, tasks
        Where the facts come from.
    runner : TrialRunner
        Tracks them; a series ends where something else is tried, and what it has stays.
    attempts : AttemptPresenter
        Knows the run that all are compared with.
    stores : StoreKeeper
    stretch, init : callable
        See :class:`AttemptPresenter`.

    Signals
    -------
    changed : ()
        There are more frames, or another value is shown.
    message : Message
    """

    changed = Signal()
    message = Signal(object)

    def __init__(
        self,
        document: DocumentPresenter,
        runs: RunList,
        judging: JudgementPresenter,
        tasks: TaskList,
        runner: TrialRunner,
        attempts: AttemptPresenter,
        stores: StoreKeeper,
        stretch: Callable[[], range],
        init: Callable[[], FirstPose],
    ) -> None:
        super().__init__()
        self._document, self._runs, self._judging = document, runs, judging
        self._tasks, self._runner = tasks, runner
        self._attempts, self._stores = attempts, stores
        self._stretch, self._init = stretch, init
        self._row: ParameterRow | None = None
        self._tried: list[Tried] = []
        self._trials: Trials | None = None
        self._task: Task | None = None
        self._shown: int | None = None
        runner.advanced.connect(self._on_advanced)
        runner.ended.connect(self._on_ended)
        runner.overtaken.connect(self._on_overtaken)

    # ---- facts

    @property
    def row(self) -> ParameterRow | None:
        """The parameter that is tried."""
        return self._row

    @property
    def tried(self) -> tuple[Tried, ...]:
        """Its values in their order."""
        return tuple(self._tried)

    @property
    def shown(self) -> int | None:
        """Place of the value whose model is shown."""
        return self._shown

    @property
    def running(self) -> bool:
        """Whether values are being tracked."""
        return self._trials is not None

    @property
    def share(self) -> float:
        """How much of it is done, 0 to 1."""
        wanted = sum(len(one.entry.wanted) for one in self._tried)
        return sum(len(one.entry.frames) for one in self._tried) / wanted if wanted else 0.0

    def best(self) -> int | None:
        """Place of the best value; None before two are complete."""
        complete = [(place, one.summary) for place, one in enumerate(self._tried) if one.complete]
        known = [(summary.order, place) for place, summary in complete if summary is not None]
        return min(known)[1] if len(known) > 1 else None

    def multiples(self) -> tuple[Multiple, ...]:
        """A small plot for each value."""
        best = self.best()
        return tuple(multiple_of(one, best=place == best) for place, one in enumerate(self._tried))

    # ---- what a person does

    def begin(self, row: ParameterRow, values: Sequence[Value], settings: Settings) -> None:
        """Track the stretch with each value; what was tried before is forgotten."""
        self.clear()
        self._attempts.cancel()
        store, stretch = self._stores.store(), self._stretch()
        if store is None or not len(stretch):
            return
        base, init = self._attempts.base(), self._init()
        self._row = row
        attempts = []
        for value in values:
            changed = settings.replaced(**{row.name: value})
            attempt = attempt_from(base, changed, stretch, init, "")
            attempts.append(attempt)
            self._tried.append(self._new(row, value, attempt))
        trials = self._trials = Trials(attempts, store)
        self._runner.begin(trials)
        self._task = self._tasks.begin(
            f"tracking with values of {row.name.replace('_', ' ')}",
            lambda task: _watch(task, trials),
        )
        self.changed.emit()

    def show(self, place: int | None) -> None:
        """Show the model of one value beside the run; None: of none."""
        if place == self._shown or (place is not None and not 0 <= place < len(self._tried)):
            return
        before, self._shown = self._shown, place
        if before is not None and self._tried[before].entry in self._runs.entries:
            self._runs.remove(self._tried[before].entry)
        if place is not None:
            self._runs.add(self._tried[place].entry, active=False)
        self.changed.emit()

    def cancel(self) -> None:
        """Track no further value; those that are complete stay."""
        if self._trials is not None:
            self._runner.cancel(self._trials)
            self._on_ended(self._trials, None)

    def clear(self) -> None:
        """Forget what was tried."""
        trials, self._trials = self._trials, None
        if trials is not None:
            self._runner.cancel(trials)
        self.show(None)
        self._tried, self._row, self._task = [], None, None
        self.changed.emit()

    # ---- inside

    def _new(self, row: ParameterRow, value: Value, attempt: Attempt) -> Tried:
        recording = self._document.recording
        subject = recording.subject if recording is not None else None
        words = with_unit("", value, row.unit)
        entry = RunEntry(
            with_unit(row.name, value, row.unit),
            "",
            attempt.settings,
            body_model(proportions_of(subject), attempt.settings.body),
            attempt.stretch,
            kind="attempt",
        )
        return Tried(value, words, entry)

    @Slot(object)
    def _on_advanced(self, request: Request) -> None:
        if request is self._trials and self._trials is not None:
            self._take(self._trials.taken())
            self.changed.emit()

    @Slot(object)
    def _on_overtaken(self, request: Request) -> None:
        self._on_ended(request, None)

    @Slot(object, object)
    def _on_ended(self, request: Request, error: Exception | None) -> None:
        trials = self._trials
        if request is not trials or trials is None:
            return
        self._take(trials.taken())
        self._trials = None
        if error is not None:
            self.message.emit(message_of(error))
        self._tried = [one for one in self._tried if one.entry.frames]
        self.changed.emit()

    def _take(self, results: Sequence[Result]) -> None:
        grown = {result.place for result in results}
        for place in grown:
            one = self._tried[place]
            take_over(one.entry, [result for result in results if result.place == place])
            one.judgement = judged(one.entry, self._judging.truth)
        if self._shown in grown:
            self._runs.grew.emit()
        if self._task is not None:
            done = sum(one.complete for one in self._tried)
            self._task.report(self.share, f"{done} of {len(self._tried)} values")


def _watch(task: Task, trials: Trials) -> None:
    """Last as long as the trials, so that they are seen among what is under way, and cancelled."""
    while not trials.over.wait(_LOOK_SECONDS):
        if task.token.cancelled():
            trials.cancel()
            raise Cancelled
    if not trials.wanted:
        raise Cancelled


def multiple_of(one: Tried, *, best: bool) -> Multiple:
    """The small plot of one value."""
    judgement, summary = one.judgement, one.summary
    if judgement is None or summary is None:
        return Multiple(one.words, "waits", (), {}, float("nan"), best=False)
    first = one.entry.wanted.start
    count = len(one.entry.frames)
    numbers = [f"{summary.arms:.1f}°"]
    if judgement.measure == "error":
        numbers.append(f"{summary.lost:.0f} % lost")
    if summary.missing:
        numbers.append(f"{summary.missing} not tracked")
    if not one.complete:
        numbers = [f"{count} of {len(one.entry.wanted)}"]
    return Multiple(
        title=one.words,
        summary=", ".join(numbers),
        frames=tuple(int(frame) - first for frame in judgement.frame),
        curves={limb: tuple(judgement.limbs[limb].tolist()) for limb in MEASURED_LIMBS},
        mean=summary.arms if one.complete else float("nan"),
        best=best,
        span=len(one.entry.wanted),
    )

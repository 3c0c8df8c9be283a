"""One parameter at several values: each is tracked, judged, and can be shown in the views."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from PySide6.QtCore import QObject, Signal, Slot

from stereotrack_core.parameters import ParameterRow, Value, value_text
from stereotrack_core.tracking.parameters import Settings

from ...session.judgement import Judgement
from ...session.runs import RunEntry
from ...session.session import Session
from ...widgets.forms.series_panel import SeriesValue
from .numbers import Summary, summary_of
from .runner import TrialRunner, Trials
from .trials import TrialPresenter, entry_of


@dataclass(eq=False)
class Tried:
    """One value, and what was tracked with it so far."""

    value: Value
    words: str
    """With its unit."""
    entry: RunEntry
    judgement: Judgement | None = None
    """None while there is no frame."""

    @property
    def summary(self) -> Summary | None:
        """Its numbers."""
        return summary_of(self.judgement) if self.judgement is not None else None

    @property
    def complete(self) -> bool:
        """Whether all frames are there."""
        return len(self.entry.frames) == len(self.entry.wanted)


class SeriesPresenter(QObject):
    """Tracks the stretch once for each value; ends where something else is tried.

    Parameters
    ----------
    session : Session
    runner : TrialRunner
    trials : TrialPresenter
        Knows the run that all are compared with.

    Attributes
    ----------
    row : ParameterRow or None
        The parameter that is tried.
    tried : tuple of Tried
        Its values in their order.
    shown : int or None
        Place of the value whose model is shown.
    """

    changed = Signal()
    """There are more frames, or another value is shown."""

    def __init__(self, session: Session, runner: TrialRunner, trials: TrialPresenter) -> None:
        super().__init__()
        self._session, self._runner, self._presenter = session, runner, trials
        self.row: ParameterRow | None = None
        self.tried: tuple[Tried, ...] = ()
        self.shown: int | None = None
        self._trials: Trials | None = None
        trials.begins.connect(self.cancel)
        session.judging.judged.connect(self._on_judged)

    # ---- facts

    @property
    def running(self) -> bool:
        """Whether values are being tracked."""
        return self._trials is not None

    @property
    def share(self) -> float:
        """How much of it is done, 0 to 1."""
        wanted = sum(len(one.entry.wanted) for one in self.tried)
        return sum(len(one.entry.frames) for one in self.tried) / wanted if wanted else 0.0

    def best(self) -> int | None:
        """Place of the best value; None before two are complete."""
        complete = [(place, one.summary) for place, one in enumerate(self.tried) if one.complete]
        known = [(summary.order, place) for place, summary in complete if summary is not None]
        return min(known)[1] if len(known) > 1 else None

    def values(self) -> tuple[SeriesValue, ...]:
        """What the panel shows of each value."""
        best = self.best()
        return tuple(_shown(one, best=place == best) for place, one in enumerate(self.tried))

    # ---- what a person does

    def begin(self, row: ParameterRow, values: Sequence[Value], settings: Settings) -> None:
        """Track the stretch with each value; what was tried before is forgotten."""
        self.clear()
        self._presenter.cancel()
        tracked, tried = [], []
        for value in values:
            trial = self._presenter.trial(settings.replaced(**{row.name: value}), "")
            if trial is None:
                return
            entry = entry_of(self._session, row.words(value), trial)
            tracked.append((entry, trial))
            tried.append(Tried(value, row.text(value), entry))
        self.row, self.tried = row, tuple(tried)
        self._session.judging.besides = tuple(one.entry for one in tried)
        title = f"tracking with values of {row.name.replace('_', ' ')}"
        self._trials = self._runner.track(title, tracked)
        self._trials.grown.connect(self._on_grown)
        self._trials.ended.connect(self._on_ended)
        self.changed.emit()

    def show(self, place: int | None) -> None:
        """Show the model of one value beside the run; None: of none."""
        if place == self.shown or (place is not None and not 0 <= place < len(self.tried)):
            return
        before, self.shown = self.shown, place
        runs = self._session.runs
        if before is not None and self.tried[before].entry in runs.entries:
            runs.remove(self.tried[before].entry)
        if place is not None:
            runs.add(self.tried[place].entry, active=False)
        self.changed.emit()

    @Slot()
    def cancel(self) -> None:
        """Track no further value; those that are complete stay."""
        if self._trials is not None:
            self._trials.cancel()
            self._on_ended()

    def clear(self) -> None:
        """Forget what was tried."""
        self.cancel()
        self.show(None)
        self.tried, self.row = (), None
        self._session.judging.besides = ()
        self.changed.emit()

    # ---- inside

    @Slot(object)
    def _on_grown(self, grown: dict[RunEntry, list[int]]) -> None:
        self._session.judging.judge_soon()
        if self.shown is not None and self.tried[self.shown].entry in grown:
            self._session.runs.grew.emit()

    @Slot()
    def _on_judged(self) -> None:
        if self.tried:
            for one in self.tried:
                one.judgement = self._session.judging.of(one.entry)
            self.changed.emit()

    @Slot()
    def _on_ended(self) -> None:
        self._trials = None
        self.tried = tuple(one for one in self.tried if one.entry.frames)
        self._session.judging.judge()
        self.changed.emit()


def _shown(one: Tried, *, best: bool) -> SeriesValue:
    judgement, summary = one.judgement, one.summary
    if judgement is None or summary is None:
        return SeriesValue(one.words, value_text(one.value), "waits")
    numbers = [f"{summary.arms:.1f}°"]
    if judgement.measure == "error":
        numbers.append(f"{summary.lost:.0f} % lost")
    if summary.missing:
        numbers.append(f"{summary.missing} not tracked")
    done = f"{len(one.entry.frames)} of {len(one.entry.wanted)} frames"
    said = ", ".join(numbers) if one.complete else done
    mean = summary.arms if one.complete else float("nan")
    return SeriesValue(one.words, value_text(one.value), said, mean, best=best)

"""What-if: a change of a parameter tracks a stretch again, beside the run that is there."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from weakref import WeakKeyDictionary

from PySide6.QtCore import QElapsedTimer, QObject, QTimer, Signal, Slot

from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import proportions_of
from stereotrack_core.tracking.frame import Origin
from stereotrack_core.tracking.run_spec import FirstPose
from stereotrack_core.tracking.tuning.attempt import Attempt, work_of

from ...services.failures import message_of
from ...session.clouds import CloudPresenter
from ...session.document import DocumentPresenter
from ...session.judgement import JudgementPresenter
from ...session.runs import RunEntry, RunList
from ...session.tracking import TrackPresenter
from .base import Base, attempt_from, base_of, changes_in_words
from .runner import Request, Result, TrialRunner, Trials
from .stores import StoreKeeper

PAUSE_MS = 100
"""Time without a further change after which an attempt begins."""


class AttemptPresenter(QObject):
    """Attempts as entries of the list of runs, drawn beside the active run until dismissed.

    Parameters
    ----------
    document, clouds, runs, track, judging
        Where the facts come from.
    runner : TrialRunner
        Tracks them.
    stores : StoreKeeper
    stretch : callable
        Frames that are to be tracked.
    init : callable
        First pose where no run is there.

    Attributes
    ----------
    live : bool
        Whether a change is tried at once.

    Signals
    -------
    arrived : ()
        An attempt has the frame that is shown.
    changed : ()
        What is said of the attempts, or how far they are, is different.
    message : Message
        Why an attempt has ended early.
    first_shown : float
        Seconds from a change to its first frame.
    """

    arrived = Signal()
    changed = Signal()
    message = Signal(object)
    first_shown = Signal(float)

    def __init__(
        self,
        document: DocumentPresenter,
        clouds: CloudPresenter,
        runs: RunList,
        track: TrackPresenter,
        judging: JudgementPresenter,
        runner: TrialRunner,
        stores: StoreKeeper,
        stretch: Callable[[], range],
        init: Callable[[], FirstPose],
    ) -> None:
        super().__init__()
        self._document, self._clouds, self._runs = document, clouds, runs
        self._track, self._judging = track, judging
        self._runner, self._stores = runner, stores
        self._stretch, self._init = stretch, init
        self.live = True
        self._made: WeakKeyDictionary[RunEntry, Attempt] = WeakKeyDictionary()
        self._changes: WeakKeyDictionary[RunEntry, str] = WeakKeyDictionary()
        self._trials: Trials | None = None
        self._entry: RunEntry | None = None
        self._base: tuple[RunEntry, Origin | None, Base] | None = None
        self._number = 0
        self._since = QElapsedTimer()
        self._pause = QTimer(self, singleShot=True, interval=PAUSE_MS)
        self._pause.timeout.connect(self.try_now)
        runs.changed.connect(self._on_runs)
        runner.advanced.connect(self._on_advanced)
        runner.ended.connect(self._on_ended)
        runner.overtaken.connect(self._on_overtaken)

    # ---- facts

    @property
    def entries(self) -> tuple[RunEntry, ...]:
        """Attempts that are shown, the oldest first."""
        return tuple(entry for entry in self._runs.entries if entry in self.made)

    @property
    def made(self) -> dict[RunEntry, Attempt]:
        """Attempts that are no runs yet, and what they are."""
        return {e: a for e, a in self._made.items() if e.kind == "attempt"}

    def changes(self, entry: RunEntry) -> str:
        """What an attempt changed, in words."""
        return self._changes.get(entry, "")

    @property
    def running(self) -> RunEntry | None:
        """The attempt in progress."""
        return self._entry

    @property
    def waits(self) -> bool:
        """Whether a change waits for the pause to be over."""
        return self._pause.isActive()

    def settled(self) -> bool:
        """Whether everything that was changed has been tried."""
        return self._trials is None and not self.waits

    def base(self) -> Base | None:
        """The run that attempts are compared with; None where there is none."""
        entry = self._runs.active
        if entry is None or not entry.frames:
            return None
        known = self._base
        if known is None or known[0] is not entry or known[1] is not entry.origin:
            self._base = known = entry, entry.origin, base_of(entry, self._made.get(entry))
        return known[2]

    def wanted(self) -> Attempt | None:
        """What would be tried now; None where there is nothing to track."""
        stretch = self._stretch()
        if not self._clouds.available or not len(stretch):
            return None
        track = self._track
        return attempt_from(self.base(), track.settings, stretch, self._init(), track.preset)

    def words(self) -> str:
        """What is being tracked, or what a further attempt would compute."""
        entry = self._entry
        if entry is not None:
            done, count = len(entry.frames), len(entry.wanted)
            return f"{entry.name.capitalize()}: {done} of {count} frames."
        attempt, store = self.wanted(), self._stores.store()
        if attempt is None or store is None:
            return ""
        if self._is_run(attempt):
            return "These are the settings of the run. Change a parameter to see its effect."
        known = self._same(attempt)
        if known is not None:
            return f"{known.name.capitalize()} already has these settings."
        return f"To compute: {work_of(attempt, store.resource).words}."

    # ---- what a person does

    @Slot()
    def on_settings(self) -> None:
        """Try the settings when they have stood for a moment; what is being tried ends."""
        self._since.start()
        self.cancel()
        if self.live:
            self._pause.start()
        self.changed.emit()

    @Slot()
    def try_now(self) -> None:
        """Track the stretch with the settings as they are."""
        self._pause.stop()
        self.cancel()
        attempt, store = self.wanted(), self._stores.store()
        if attempt is None or store is None or self._is_run(attempt):
            self.changed.emit()
            return
        if self._same(attempt) is not None:
            self.changed.emit()
            return
        trials = Trials([attempt], store)
        self._entry, self._trials = self._new_entry(attempt), trials
        self._runs.add(self._entry, active=self._runs.active is None)
        self._runner.begin(trials)

    def cancel(self) -> None:
        """End the attempt in progress, and forget it."""
        trials, entry = self._trials, self._entry
        self._trials = self._entry = None
        self._pause.stop()
        if trials is not None and entry is not None:
            self._runner.cancel(trials)
            self._number -= entry.kind == "attempt"
            self._runs.remove(entry)

    def dismiss(self, entry: RunEntry) -> None:
        """Take an attempt away."""
        if entry is self._entry:
            self.cancel()
        elif entry in self.made:
            self._runs.remove(entry)

    def dismiss_all(self) -> None:
        """Take all attempts away; they are counted from one again."""
        self.cancel()
        for entry in self.entries:
            self._runs.remove(entry)
        self._number = 0
        self.changed.emit()

    def make_run(self, entry: RunEntry) -> None:
        """Make an attempt the active run, over the frames that it has."""
        if entry is not self._entry and entry in self.made:
            entry.kind = "run"
            self._runs.activate(entry)
            self.changed.emit()

    def stop(self) -> None:
        """Forget everything, as another recording comes."""
        self.cancel()
        self._made.clear()
        self._base = None
        self._number = 0

    # ---- inside

    def _is_run(self, attempt: Attempt) -> bool:
        base = self.base()
        return base is not None and base.settings == attempt.settings

    def _same(self, attempt: Attempt) -> RunEntry | None:
        """An attempt that has been made with the same settings from the same run."""
        base = self.base()
        for entry, other in self.made.items():
            if entry is self._entry or entry not in self._runs.entries:
                continue
            alike = other.settings == attempt.settings and other.stretch == attempt.stretch
            start, begun = attempt.start, other.start
            together = (start is None) == (begun is None) and (
                start is None or begun is None or start.pose is begun.pose
            )
            if alike and together and base is not None:
                return entry
        return None

    def _new_entry(self, attempt: Attempt) -> RunEntry:
        recording, base = self._document.recording, self.base()
        subject = recording.subject if recording is not None else None
        if base is None:
            name = self._runs.next_name(attempt.preset, changed=self._track.differs_from_preset)
        else:
            self._number += 1
            name = f"trial {self._number}"
        entry = RunEntry(
            name,
            attempt.preset,
            attempt.settings,
            body_model(proportions_of(subject), attempt.settings.body),
            attempt.stretch,
            kind="run" if base is None else "attempt",
        )
        self._made[entry] = attempt
        self._changes[entry] = changes_in_words(base.settings if base else None, attempt.settings)
        return entry

    @Slot()
    def _on_runs(self) -> None:
        """Somebody may have taken the attempt away that is being made."""
        if self._trials is not None and self._entry not in self._runs.entries:
            self._runner.cancel(self._trials)
            self._trials = self._entry = None
        self.changed.emit()

    @Slot(object)
    def _on_advanced(self, request: Request) -> None:
        if request is self._trials and self._entry is not None:
            self._take(self._trials.taken(), self._entry)
            self.changed.emit()

    @Slot(object)
    def _on_overtaken(self, request: Request) -> None:
        if request is self._trials:
            self.cancel()

    @Slot(object, object)
    def _on_ended(self, request: Request, error: Exception | None) -> None:
        trials, entry = self._trials, self._entry
        if request is not trials or trials is None or entry is None:
            return
        self._take(trials.taken(), entry)
        self._trials = self._entry = None
        if error is not None:
            self.message.emit(message_of(error))
        if entry.frames:
            self._judging.judge()
        else:
            self._runs.remove(entry)
        self.changed.emit()

    def _take(self, results: Sequence[Result], entry: RunEntry) -> None:
        if not results:
            return
        first = not entry.frames
        take_over(entry, results)
        for result in results:
            tracked = result.tracked
            if entry.settings is not None and tracked.frame == self._document.frame:
                self._clouds.keep(tracked.cloud, entry.settings.depth)
                self.arrived.emit()
        if first:
            self._judging.judge()  # the first frame is shown at once, those after it now and then
            if self._since.isValid():
                self.first_shown.emit(self._since.elapsed() / 1000.0)
        self._runs.grew.emit()


def take_over(entry: RunEntry, results: Sequence[Result]) -> None:
    """Let an entry have these frames, and what is known of its attempt by then."""
    for result in results:
        entry.frames[result.tracked.frame] = result.tracked.without_cloud()
        entry.body, entry.origin = result.body, result.origin
        entry.wall_seconds = result.seconds

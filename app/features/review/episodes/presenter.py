"""Finds the episodes of the active run whenever a fact about them changes; nothing waits for it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from PySide6.QtCore import QObject, QTimer, Signal, Slot

from stereotrack_core.evaluation.episodes.episode import Episode
from stereotrack_core.evaluation.episodes.find import Subject, explained, stretches_of
from stereotrack_core.evaluation.episodes.stretches import EpisodeRules
from stereotrack_core.recording.description import Recording

from ....services.tasks.task import Task, TaskList
from ....session.document import DocumentPresenter
from ....session.judgement import JudgementPresenter
from ....session.runs import RunEntry, RunList, RunNow
from ....session.tracking import TrackPresenter
from ....session.truth import Truth
from .listing import Filter

_DELAY_MS = 200


@dataclass(frozen=True, eq=False)
class Question:
    """What episodes are looked for in.

    Attributes
    ----------
    entry : RunEntry
        Whose episodes they are.
    run : RunNow
        What it has; the work is given this.
    truth : Truth or None
    threshold : float, degrees
    recording : Recording
    """

    entry: RunEntry
    run: RunNow
    truth: Truth | None
    threshold: float
    recording: Recording

    def same_as(self, other: Question | None) -> bool:
        """Whether the answer to another question holds for this one."""
        return (
            other is not None
            and self.entry is other.entry
            and len(self.run.frames) == len(other.run.frames)
            and self.truth is other.truth
            and self.threshold == other.threshold
            and self.recording is other.recording
        )

    def subject(self) -> Subject | None:
        """What the core is asked; None where the run does not say where it comes from."""
        run = self.run.run()
        if run is None:
            return None
        rules = EpisodeRules().replaced(episode_error=min(max(self.threshold, 1.0), 180.0))
        reference = self.truth.trajectory if self.truth is not None else None
        return Subject(run, self.recording.fps, reference, self.recording, rules)


@dataclass(frozen=True, eq=False)
class Found:
    """The episodes that were found.

    Attributes
    ----------
    question : Question
    subject : Subject or None
    episodes : tuple of Episode
    looked : bool
        Whether their causes were judged by pictures, too.
    """

    question: Question
    subject: Subject | None
    episodes: tuple[Episode, ...]
    looked: bool = False


class EpisodePresenter(QObject):
    """The episodes of the active run, those that are listed, and the one that is chosen.

    Parameters
    ----------
    wants_pictures : callable
        Whether causes shall be judged by pictures as well, which takes seconds.
    threshold : callable
        Error in degrees from which an episode begins.

    Signals
    -------
    changed : ()
        Other episodes are known, listed or chosen, or more is known about them.
    """

    changed = Signal()

    def __init__(
        self,
        document: DocumentPresenter,
        runs: RunList,
        track: TrackPresenter,
        judging: JudgementPresenter,
        tasks: TaskList,
        *,
        wants_pictures: Callable[[], bool],
        threshold: Callable[[], float],
    ) -> None:
        super().__init__()
        self._document, self._runs, self._track = document, runs, track
        self._judging, self._tasks = judging, tasks
        self._wants_pictures, self._threshold = wants_pictures, threshold
        self._asked: Question | None = None
        self._found: Found | None = None
        self._work: Task | None = None
        self._looking = False
        self._chosen: Episode | None = None
        self.filter = Filter()
        self._timer = QTimer(self, singleShot=True, interval=_DELAY_MS)
        self._timer.timeout.connect(self._ask)
        judging.judged.connect(self.ask_soon)
        runs.active_changed.connect(self.ask_soon)
        track.finished.connect(self.ask_soon)
        document.closed.connect(self._forget)

    # ---- facts

    @property
    def found(self) -> Found | None:
        """What was found last; None while nothing is known."""
        return self._found

    @property
    def looking(self) -> bool:
        """Whether pictures are being looked at."""
        return self._looking and self._busy()

    @property
    def working(self) -> bool:
        """Whether episodes are being found."""
        return self._busy() or self._timer.isActive()

    @property
    def listed(self) -> tuple[Episode, ...]:
        """Episodes that the filter takes, in their order."""
        every = self._found.episodes if self._found is not None else ()
        return tuple(episode for episode in every if self.filter.takes(episode))

    @property
    def chosen(self) -> Episode | None:
        """The episode that is chosen, if it is listed."""
        return self._chosen

    def settled(self) -> bool:
        """Whether everything that was asked for is known."""
        return not self.working

    # ---- what a person does

    def set_filter(self, wanted: Filter) -> None:
        """List others."""
        if wanted != self.filter:
            self.filter = wanted
            self._keep_choice()
            self.changed.emit()

    def choose(self, episode: Episode | None) -> None:
        """Choose an episode."""
        if episode is not self._chosen:
            self._chosen = episode
            self.changed.emit()

    def beside(self, frame: int, direction: int) -> Episode | None:
        """The listed episode after (1) or before (-1) the chosen one, or else a frame."""
        listed = list(self.listed)
        if self._chosen in listed and frame in self._chosen.frames:
            place = listed.index(self._chosen) + direction
            return listed[place] if 0 <= place < len(listed) else None
        if direction > 0:
            return next((e for e in listed if e.last >= frame and e.peak_frame > frame), None)
        return next((e for e in reversed(listed) if e.peak_frame < frame), None)

    # ---- finding

    @Slot()
    def ask_soon(self, _what: object = None) -> None:
        """Look whether anything has changed, when things have come to rest."""
        self._timer.start()

    @Slot()
    def _ask(self) -> None:
        question = self._question()
        if question is None:
            if self._runs.active is None:
                self._forget()
            return
        if question.same_as(self._asked):
            self._look()
            return
        self._stop()
        self._asked = question
        self._work = self._tasks.begin(
            "detecting failures", lambda _task: _found(question), self._on_found
        )
        self._work.ended.connect(self._on_ended)

    def _question(self) -> Question | None:
        recording, entry = self._document.recording, self._runs.active
        if recording is None or entry is None or not entry.frames:
            return None
        if entry is self._track.entry and self._track.running:
            return None  # it still grows
        truth = self._judging.truth
        return Question(entry, entry.now(), truth, self._threshold(), recording)

    @Slot(object)
    def _on_found(self, found: Found) -> None:
        if found.question is not self._asked:
            return
        self._work, self._looking = None, False
        self._found = found
        self._keep_choice()
        self.changed.emit()
        if not found.looked:
            QTimer.singleShot(0, self._look)

    def _look(self) -> None:
        """Judge causes by pictures as well, where somebody sees it."""
        found = self._found
        if found is None or found.looked or found.subject is None or not found.episodes:
            return
        if self._busy() or not self._wants_pictures():
            return
        subject, episodes = found.subject, found.episodes

        def work(task: Task) -> Found:
            more = explained(subject, episodes, task.report, task.token.cancelled)
            return replace(found, episodes=more, looked=True)

        self._looking = True
        self._work = self._tasks.begin("classifying causes of failures", work, self._on_found)
        self._work.stopped.connect(self._on_stopped)
        self._work.ended.connect(self._on_ended)
        self.changed.emit()

    @Slot()
    def _on_stopped(self) -> None:
        """A person has had enough; what the run alone says stays."""
        if self._work is self.sender() and self._found is not None:
            self._found = replace(self._found, looked=True)

    @Slot()
    def _on_ended(self) -> None:
        if self._work is self.sender():
            self._work, self._looking = None, False
            self.changed.emit()

    def _busy(self) -> bool:
        # work may have ended before anybody listens for its end
        return self._work is not None and self._work in self._tasks.tasks

    def _stop(self) -> None:
        if self._work is not None:
            self._work.cancel()
            self._work, self._looking = None, False

    @Slot()
    def _forget(self) -> None:
        self._stop()
        known = self._found is not None
        self._asked = self._found = self._chosen = None
        if known:
            self.changed.emit()

    def _keep_choice(self) -> None:
        """Choose what has become of the chosen episode."""
        old = self._chosen
        if old is not None:
            same = [e for e in self.listed if e.found == old.found and e.overlaps(old)]
            self._chosen = same[0] if same else None


def _found(question: Question) -> Found:
    subject = question.subject()
    if subject is None:
        return Found(question, None, ())
    episodes = stretches_of(subject)
    return Found(question, subject, explained(replace(subject, pictures=False), episodes))

"""Finds the episodes of the active run whenever a fact about them changes; nothing waits for it."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass, replace

from PySide6.QtCore import QObject, QTimer, Signal, Slot

from stereotrack_core.evaluation.episodes.episode import Episode
from stereotrack_core.evaluation.episodes.find import Subject, explained, stretches_of
from stereotrack_core.evaluation.episodes.stretches import EpisodeRules
from stereotrack_core.recording.description import Recording

from ....services.tasks.task import Task, TaskList
from ....session.runs import RunNow
from ....session.session import Session
from ....session.truth import Truth
from .listing import Filter

_DELAY_MS = 200


@dataclass(frozen=True, eq=False)
class Question:
    """What episodes are looked for in.

    Attributes
    ----------
    facts : tuple
        Run, number of its frames, truth, threshold and recording; where these are the same, so is
        the answer.
    run : RunNow
        What the run has.
    truth : Truth or None
    threshold : float, degrees
    recording : Recording
    """

    facts: Hashable
    run: RunNow
    truth: Truth | None
    threshold: float
    recording: Recording

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
    session : Session
    tasks : TaskList
    wants_pictures : callable
        Whether causes shall be judged by pictures as well, which takes seconds.
    threshold : callable
        Error in degrees from which an episode begins.

    Attributes
    ----------
    found : Found or None
        What was found last; None while nothing is known.
    chosen : Episode or None
        The episode that is chosen, if it is listed.
    filter : Filter

    Signals
    -------
    changed : ()
        Other episodes are known, listed or chosen, or more is known about them.
    """

    changed = Signal()

    def __init__(
        self,
        session: Session,
        tasks: TaskList,
        *,
        wants_pictures: Callable[[], bool],
        threshold: Callable[[], float],
    ) -> None:
        super().__init__()
        self._session, self._tasks = session, tasks
        self._wants_pictures, self._threshold = wants_pictures, threshold
        self._asked: Question | None = None
        self.found: Found | None = None
        self.chosen: Episode | None = None
        self.filter = Filter()
        self._work: Task | None = None
        self._looking = False
        self._timer = QTimer(self, singleShot=True, interval=_DELAY_MS)
        self._timer.timeout.connect(self._ask)
        for signal in (
            session.judging.judged, session.runs.active_changed, session.track.finished,
        ):  # fmt: skip
            signal.connect(self.ask_soon)
        session.document.closed.connect(self._forget)

    # ---- facts

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
        every = self.found.episodes if self.found is not None else ()
        return tuple(episode for episode in every if self.filter.takes(episode))

    # ---- what a person does

    def set_filter(self, wanted: Filter) -> None:
        """List others."""
        if wanted != self.filter:
            self.filter = wanted
            self._keep_choice()
            self.changed.emit()

    def choose(self, episode: Episode | None) -> None:
        """Choose an episode."""
        if episode is not self.chosen:
            self.chosen = episode
            self.changed.emit()

    def beside(self, frame: int, direction: int) -> Episode | None:
        """The listed episode after (1) or before (-1) the chosen one, or else a frame."""
        listed = list(self.listed)
        if self.chosen in listed and frame in self.chosen.frames:
            place = listed.index(self.chosen) + direction
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
            if self._session.runs.active is None:
                self._forget()
        elif self._asked is not None and question.facts == self._asked.facts:
            self._look()
        else:
            self._stop()
            self._asked = question
            self._begin("detecting failures", lambda _task: _found(question))

    def _question(self) -> Question | None:
        session = self._session
        recording, entry = session.document.recording, session.runs.active
        if recording is None or entry is None or not entry.frames:
            return None
        if entry is session.track.entry and session.track.running:
            return None  # it still grows
        truth, threshold = session.judging.truth, self._threshold()
        facts = entry, len(entry.frames), truth, threshold, recording
        return Question(facts, entry.now(), truth, threshold, recording)

    def _begin(self, title: str, work: Callable[[Task], Found]) -> None:
        self._work = self._tasks.begin(title, work, self._on_found)
        self._work.stopped.connect(self._on_stopped)
        self._work.ended.connect(self._on_ended)

    @Slot(object)
    def _on_found(self, found: Found) -> None:
        if found.question is not self._asked:
            return
        self._work, self._looking = None, False
        self.found = found
        self._keep_choice()
        self.changed.emit()
        if not found.looked:
            QTimer.singleShot(0, self._look)

    def _look(self) -> None:
        """Judge causes by pictures as well, where somebody sees it."""
        found = self.found
        if found is None or found.looked or found.subject is None or not found.episodes:
            return
        if self._busy() or not self._wants_pictures():
            return
        subject = found.subject

        def work(task: Task) -> Found:
            more = explained(subject, found.episodes, task.report, task.token.cancelled)
            return replace(found, episodes=more, looked=True)

        self._looking = True
        self._begin("classifying causes of failures", work)
        self.changed.emit()

    @Slot()
    def _on_stopped(self) -> None:
        """A person has had enough; what the run alone says stays."""
        if self._looking and self._work is self.sender() and self.found is not None:
            self.found = replace(self.found, looked=True)

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
        known = self.found is not None
        self._asked = self.found = self.chosen = None
        if known:
            self.changed.emit()

    def _keep_choice(self) -> None:
        """Choose what has become of the chosen episode."""
        old = self.chosen
        if old is not None:
            same = [e for e in self.listed if e.found == old.found and e.overlaps(old)]
            self.chosen = same[0] if same else None


def _found(question: Question) -> Found:
    subject = question.subject()
    if subject is None:
        return Found(question, None, ())
    episodes = stretches_of(subject)
    return Found(question, subject, explained(replace(subject, pictures=False), episodes))

"""Before, worst and after of the chosen episode, drawn in a thread of its own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from PySide6.QtCore import QObject, Signal, Slot
from PySide6.QtGui import QColor

from stereotrack_core.arrays import ImageArray
from stereotrack_core.evaluation.episodes.episode import Episode
from stereotrack_core.evaluation.episodes.export import evidence_picture
from stereotrack_core.evaluation.episodes.find import Subject
from stereotrack_core.evaluation.episodes.strip import Paper
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.reader import FrameReader

from ....services.tasks.newest import NewestWins
from ....services.tasks.shared import Shared
from ....widgets.style.theme import current_theme


@dataclass(frozen=True, eq=False)
class _Wanted:
    subject: Subject
    recording: Recording
    episode: Episode
    reader: Shared[FrameReader]
    paper: Paper


class EpisodePictures(QObject):
    """Draws the newest episode that was asked for.

    Parameters
    ----------
    reader : callable
        Gives the reader of the open recording.
    """

    drawn = Signal(object)
    """ImageArray or None."""
    failed = Signal(object)
    """Exception."""

    def __init__(self, reader: Callable[[], Shared[FrameReader] | None]) -> None:
        super().__init__()
        self._reader = reader
        self._worker: NewestWins | None = None
        self._asked: _Wanted | None = None
        self._waits = False

    def settled(self) -> bool:
        """Whether what was asked for is drawn."""
        return not self._waits

    def ask(self, subject: Subject | None, episode: Episode | None) -> None:
        """Draw an episode; None shows nothing."""
        reader, recording = self._reader(), subject.recording if subject is not None else None
        if subject is None or episode is None or reader is None or recording is None:
            self._asked, self._waits = None, False
            self.drawn.emit(None)
            return
        theme, asked = current_theme(), self._asked
        paper = Paper(_bgr(theme.base), _bgr(theme.text), _bgr(theme.muted))
        if asked is not None and asked.episode is episode and asked.paper == paper:
            return
        if self._worker is None:
            self._worker = NewestWins(_drawn, "draw failures")
            self._worker.answered.connect(self._on_drawn)
            self._worker.failed.connect(self._on_failed)
        self._asked, self._waits = _Wanted(subject, recording, episode, reader, paper), True
        self._worker.ask(self._asked)

    def close(self) -> None:
        """End the thread."""
        self._asked, self._waits = None, False
        if self._worker is not None:
            self._worker.close()
            self._worker = None

    @Slot(object, object)
    def _on_drawn(self, wanted: _Wanted, pixels: ImageArray | None) -> None:
        if self._asked is not None and wanted.episode is self._asked.episode:
            self._waits = False
            self.drawn.emit(pixels)

    @Slot(object, object)
    def _on_failed(self, wanted: _Wanted, error: Exception) -> None:
        waited = self._waits
        self._on_drawn(wanted, None)
        if waited and not self._waits:
            self.failed.emit(error)


def _drawn(wanted: _Wanted) -> ImageArray:
    with wanted.reader.used() as reader:
        return evidence_picture(
            wanted.subject, wanted.recording, wanted.episode, reader=reader, paper=wanted.paper
        )


def _bgr(colour: str) -> tuple[int, int, int]:
    shown = QColor(colour)
    return shown.blue(), shown.green(), shown.red()

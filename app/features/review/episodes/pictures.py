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
from stereotrack_core.recording.reader import FrameReader

from ....services.tasks.newest import NewestWins
from ....services.tasks.shared import Shared
from ....widgets.style.theme import current_theme


@dataclass(frozen=True, eq=False)
class Wanted:
    """What shall be drawn."""

    subject: Subject
    episode: Episode
    reader: Shared[FrameReader]
    paper: Paper


class EpisodePictures(QObject):
    """Draws the newest episode that was asked for.

    Parameters
    ----------
    reader : callable
        Gives the reader of the open recording.

    Signals
    -------
    drawn : ImageArray or None
    failed : Exception
    """

    drawn = Signal(object)
    failed = Signal(object)

    def __init__(self, reader: Callable[[], Shared[FrameReader] | None]) -> None:
        super().__init__()
        self._reader = reader
        self._worker: NewestWins | None = None
        self._asked: tuple[Episode, str] | None = None
        self._waits = False

    def settled(self) -> bool:
        """Whether what was asked for is drawn."""
        return not self._waits

    def ask(self, subject: Subject | None, episode: Episode | None) -> None:
        """Draw an episode; None shows nothing."""
        reader, theme = self._reader(), current_theme()
        if subject is None or episode is None or reader is None or subject.recording is None:
            self._asked, self._waits = None, False
            self.drawn.emit(None)
            return
        asked = episode, theme.base
        if self._asked is not None and self._asked[0] is episode and self._asked[1] == theme.base:
            return
        if self._worker is None:
            self._worker = NewestWins(_drawn, "draw failures")
            self._worker.answered.connect(self._on_drawn)
            self._worker.failed.connect(self._on_failed)
        self._asked, self._waits = asked, True
        paper = Paper(_bgr(theme.base), _bgr(theme.text), _bgr(theme.muted))
        self._worker.ask(Wanted(subject, episode, reader, paper))

    def close(self) -> None:
        """End the thread."""
        self._asked, self._waits = None, False
        if self._worker is not None:
            self._worker.close()
            self._worker = None

    @Slot(object, object)
    def _on_drawn(self, wanted: Wanted, pixels: ImageArray) -> None:
        if self._asked is not None and wanted.episode is self._asked[0]:
            self._waits = False
            self.drawn.emit(pixels)

    @Slot(object, object)
    def _on_failed(self, wanted: Wanted, error: Exception) -> None:
        if self._asked is not None and wanted.episode is self._asked[0]:
            self._waits = False
            self.drawn.emit(None)
            self.failed.emit(error)


def _drawn(wanted: Wanted) -> ImageArray:
    recording = wanted.subject.recording
    assert recording is not None  # noqa: S101 - it is not asked for else
    with wanted.reader.used() as reader:
        return evidence_picture(
            wanted.subject, recording, wanted.episode, reader=reader, paper=wanted.paper
        )


def _bgr(colour: str) -> tuple[int, int, int]:
    shown = QColor(colour)
    return shown.blue(), shown.green(), shown.red()

"""Single pictures of the board, read off the window's thread."""

from __future__ import annotations

from dataclasses import dataclass

from PySide6.QtCore import QObject, Signal, Slot

from stereotrack_core.arrays import ImageArray
from stereotrack_core.calibrate.pictures import Pictures
from stereotrack_core.calibrate.work import Source
from stereotrack_core.errors import InputError
from stereotrack_core.recording.images import DamagedFrame

from ...services.tasks.newest import LatestOnly


@dataclass(frozen=True, eq=False)
class ReadPicture:
    """A picture that was read, or why it was not."""

    source: Source
    frame: int
    name: str
    image: ImageArray | None
    problem: str = ""


class _Reader:
    """Keeps the source open that was read last; used by one thread."""

    def __init__(self) -> None:
        self._source: Source | None = None
        self._pictures: Pictures | None = None

    def __call__(self, wanted: tuple[Source, int]) -> ReadPicture:
        source, frame = wanted
        try:
            pictures = self._opened(source)
            image = pictures.read(frame)
        except (InputError, DamagedFrame) as problem:
            return ReadPicture(source, frame, f"picture {frame}", None, str(problem))
        return ReadPicture(source, frame, pictures.name(frame), image)

    def _opened(self, source: Source) -> Pictures:
        if self._pictures is None or source != self._source:
            if self._pictures is not None:
                self._pictures.close()
            self._source, self._pictures = source, source.open()
        return self._pictures


class PictureReading(QObject):
    """Reads the picture that was asked for last."""

    read = Signal(object)
    """A :class:`ReadPicture`."""

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        self._worker = LatestOnly(_Reader(), "reading a picture of the board")
        self._worker.answered.connect(self._on_answered)
        self.settled = self._worker.settled

    def ask(self, source: Source, frame: int) -> None:
        """Read a picture."""
        self._worker.ask((source, frame))

    @Slot()
    def close(self) -> None:
        """End the thread."""
        self._worker.close()

    @Slot(object, object)
    def _on_answered(self, _wanted: object, answer: ReadPicture) -> None:
        self.read.emit(answer)

"""Reads single pictures of the board, and writes a calibration: to a file or into the recording."""

from dataclasses import dataclass
from pathlib import Path

from stereotrack_core.arrays import ImageArray
from stereotrack_core.calibrate.pictures import Pictures
from stereotrack_core.calibrate.work import Source
from stereotrack_core.errors import InputError
from stereotrack_core.recording.calibration import write_calibration
from stereotrack_core.recording.folder import named_file
from stereotrack_core.recording.images import DamagedFrame
from stereotrack_core.recording.writing import keep_beside

from .state import Calibration


def write_to(state: Calibration, path: Path) -> None:
    """Write the cameras to a file. Raises InputError if that is not possible."""
    if isinstance(state.alignment, InputError):
        raise state.alignment
    if not state.cameras:
        what = "nothing is calculated that could be saved"
        remedy = "Calculate the lenses, and place all cameras."
        raise InputError(what, where="calibration", remedy=remedy)
    write_calibration(path if path.suffix else path.with_suffix(".toml"), state.cameras)


def why_not_into(state: Calibration) -> str:
    """Why the calibration cannot replace that of the open recording."""
    if state.recording is None:
        return "No recording is open."
    if state.recording.guessed:
        return "The cameras of the recording are guessed, so that there is nothing to replace."
    if state.world is None and not (state.of_recording and state.cameras):
        return "Place all cameras first, or choose what the world is turned by."
    if isinstance(state.alignment, InputError):
        return f"The world is not turned yet: {state.alignment.what}."
    missing = [name for name in state.recorded if name not in state.cameras]
    if missing:
        return (
            f"The calibration lacks {', '.join(missing[:4])}. Name the cameras as the recording "
            "does: double-click a name in step 1."
        )
    for name, old in state.recorded.items():
        new = state.cameras[name]
        if (new.width, new.height) != (old.width, old.height):
            return (
                f"{name} was calibrated with pictures of {new.width} × {new.height}, the recording "
                f"has {old.width} × {old.height}."
            )
    return ""


def save_into(state: Calibration, folder: Path) -> Path:
    """Replace the calibration of a recording; the one before is kept beside it, and returned."""
    target = named_file(folder, "calibration")
    kept = keep_beside(target)
    write_to(state, target)
    return kept


@dataclass(frozen=True, eq=False)
class ReadPicture:
    """A picture that was read, or why it was not."""

    source: Source
    frame: int
    name: str
    image: ImageArray | None
    problem: str = ""


class PictureReader:
    """Reads a picture, and keeps its source open; used by one thread."""

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

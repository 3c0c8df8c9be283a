"""Where a reproduction keeps what it makes: its recordings, and which runs are there already."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from platformdirs import user_data_path

from stereotrack_core.errors import InputError
from stereotrack_core.experiments.reproduction.plan import Entry, Group
from stereotrack_core.interop.run_npz import read_npz
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.fingerprint import fingerprint
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.simulation.make import simulate
from stereotrack_core.simulation.thesis_recordings import ThesisRecording, thesis_recordings
from stereotrack_core.tracking.frame import Run

_SEED = 0


@dataclass(frozen=True)
class Places:
    """Folders of a reproduction.

    Attributes
    ----------
    folder : Path
    """

    folder: Path

    @property
    def recordings(self) -> Path:
        """Folder of the four recordings."""
        return self.folder / "recordings"

    @property
    def page(self) -> Path:
        """The page that shows everything."""
        return self.folder / "index.html"

    def recording(self, name: str) -> Path:
        """Folder of a recording."""
        return self.recordings / name

    def run(self, recording: str, entry: Entry) -> Path:
        """File of a run."""
        return self.folder / "runs" / recording / f"{entry.name}.npz"


def default_folder(*, short: bool) -> Path:
    """The program's own data folder."""
    name = "reproduce-short" if short else "reproduce"
    return user_data_path("stereotrack", appauthor=False) / name


def made_folder(folder: Path) -> Places:
    """Make the folder where it is missing.

    Raises
    ------
    InputError
        Where that cannot be.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"the folder cannot be created ({error.strerror})",
            where=str(folder),
            remedy="Give a folder that you may write to: stereotrack reproduce DIR.",
        ) from error
    return Places(folder)


def kept_run(places: Places, recording: Recording, fingerprint: str, entry: Entry) -> Run | None:
    """A run that is there and was made as it would be made now; else None.

    The program's version may be another one; it is told beside the results.
    """
    path = places.run(recording.name, entry)
    if not path.is_file():
        return None
    try:
        run = read_npz(path)
    except InputError:  # damaged: it is made anew
        return None
    wanted = {
        "parameters": entry.way.settings.values(),
        "seed": entry.seed,
        "fingerprint": fingerprint,
        "way": entry.way.name,
    }
    same = all(run.meta.get(key) == value for key, value in wanted.items())
    return run if same and _is_whole(run, recording) else None


def kept_runs(
    places: Places, recordings: Sequence[Recording], groups: Sequence[Group]
) -> Iterator[tuple[Group, list[tuple[Recording, Entry, Run | None]]]]:
    """Every group with its entries, their recordings and the runs that are there."""
    by_name = {recording.name: (recording, fingerprint(recording)) for recording in recordings}
    for group in groups:
        recording, print_ = by_name[group.recording]
        kept = [(entry, kept_run(places, recording, print_, entry)) for entry in group.entries]
        yield group, [(recording, entry, run) for entry, run in kept]


def _is_whole(run: Run, recording: Recording) -> bool:
    reference = recording.reference
    return reference is not None and len(run.frame) == len(reference.frame)


def missing_recordings(places: Places, *, short: bool) -> tuple[ThesisRecording, ...]:
    """What has to be rendered of the four recordings.

    Raises
    ------
    InputError
        Where a recording is there that is another one.
    """
    wanted = thesis_recordings(short=short)
    for one in wanted:
        if _is_there(places, one):
            _opened(places, one)
    return tuple(one for one in wanted if not _is_there(places, one))


def render_recording(
    places: Places,
    one: ThesisRecording,
    on_progress: Callable[[int, int], None],
    cancelled: Callable[[], bool],
) -> None:
    """Render a recording.

    Raises
    ------
    Cancelled
        Nothing of it is left behind.
    """
    places.recordings.mkdir(parents=True, exist_ok=True)
    simulate(
        places.recording(one.name),
        person=one.name,
        frames=one.frames,
        seed=_SEED,
        options=one.options,
        parts=one.parts,
        on_progress=on_progress,
        cancelled=cancelled,
    )


def opened_recordings(places: Places, *, short: bool) -> tuple[Recording, ...]:
    """The four recordings; all must be there."""
    return tuple(_opened(places, one) for one in thesis_recordings(short=short))


def _is_there(places: Places, one: ThesisRecording) -> bool:
    return (places.recording(one.name) / "recording.toml").is_file()


def _opened(places: Places, one: ThesisRecording) -> Recording:
    """Open a recording that is the wanted one: its motions, frames and lenses."""
    recording = open_recording(places.recording(one.name))
    frames = 0 if recording.reference is None else len(recording.reference.frame)
    planned = [(part.name, part.first, part.end) for part in one.parts]
    found = [(segment.name, segment.first, segment.end) for segment in recording.segments]
    options = one.options
    lenses = {
        (camera.width, camera.height, round(float(camera.matrix[0, 0]), 3))
        for camera in recording.cameras.values()
    }
    right = {(options.width, options.height, round(options.focal, 3))}
    if frames != one.frames or found != planned or lenses != right:
        raise InputError(
            "this is a different recording from the one that this version would create",
            where=str(recording.folder),
            remedy="Choose another folder, or delete this recording.",
        )
    return recording

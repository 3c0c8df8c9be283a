"""Where a reproduction keeps what it makes, and which runs are there already."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from stereotrack_core.errors import InputError

if TYPE_CHECKING:
    from stereotrack_core.experiments.reproduction.plan import Entry, Group
    from stereotrack_core.recording.description import Recording
    from stereotrack_core.tracking.run import Run


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
    from platformdirs import user_data_path

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
            f"the folder cannot be made ({error.strerror})",
            where=str(folder),
            remedy="Name a folder that you may write to: stereotrack reproduce DIR.",
        ) from error
    return Places(folder)


def kept_run(places: Places, recording: Recording, fingerprint: str, entry: Entry) -> Run | None:
    """A run that is there and was made as it would be made now; else None.

    The program's version may be another one; it is told beside the results.
    """
    from stereotrack_core.interop.run_npz import read_npz

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
    from stereotrack_core.recording.fingerprint import fingerprint

    by_name = {recording.name: (recording, fingerprint(recording)) for recording in recordings}
    for group in groups:
        recording, print_ = by_name[group.recording]
        kept = [(entry, kept_run(places, recording, print_, entry)) for entry in group.entries]
        yield group, [(recording, entry, run) for entry, run in kept]


def _is_whole(run: Run, recording: Recording) -> bool:
    reference = recording.reference
    return reference is not None and len(run.frame) == len(reference.frame)

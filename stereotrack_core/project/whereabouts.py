"""Find a project's recording again when folders have moved; where a new project goes."""

import os
import sqlite3
from collections.abc import Iterable
from contextlib import closing
from dataclasses import astuple, dataclass
from pathlib import Path

import platformdirs

from stereotrack_core.errors import Finding, InputError
from stereotrack_core.project.connection import connect_for_reading
from stereotrack_core.project.database import beside, making_sense
from stereotrack_core.recording.folder import DESCRIPTION, fingerprint, open_recording
from stereotrack_core.recording.toml_table import load_toml

SUFFIX = ".stereotrack"


@dataclass(frozen=True)
class RecordingPlace:
    """Where a project's recording was, and how to know it again."""

    name: str
    relative: str  # to the project's folder, with ``/``; empty on another drive
    absolute: str
    fingerprint: str


@dataclass(frozen=True)
class Whereabouts:
    """Result of looking for a recording; without a folder, the person has to be asked."""

    folder: Path | None
    finding: Finding | None = None


def place_of(folder: Path, project: Path) -> RecordingPlace:
    """How a project remembers a recording; InputError where the folder is no usable recording."""
    recording = open_recording(folder)
    absolute = folder.resolve()
    try:
        relative = Path(os.path.relpath(absolute, project.resolve().parent)).as_posix()
    except ValueError:  # another drive of Windows
        relative = ""
    place = RecordingPlace(recording.name, relative, str(absolute), fingerprint(recording))
    try:
        "".join(astuple(place)).encode()
    except UnicodeEncodeError as error:
        remedy = "Rename the folder with these characters in its name."
        raise InputError("its path contains invalid characters", folder, remedy) from error
    return place


def find_recording(
    place: RecordingPlace, project: Path, folders: Iterable[Path] = ()
) -> Whereabouts:
    """Look where the recording was, relative and absolute, then around there and in `folders`.

    In its old place it is taken even if changed (with a warning), elsewhere by its fingerprint.
    """
    base = project.resolve().parent
    stated = [base / place.relative] if place.relative else []
    stated.append(Path(place.absolute))
    old = list(dict.fromkeys(Path(os.path.normpath(path)) for path in stated))
    seen = [(folder, _fingerprint_of(folder)) for folder in old]
    for folder, found in seen:
        if found == place.fingerprint:
            return Whereabouts(folder)
    around = dict.fromkeys([base, *(folder.parent for folder in old), *folders])
    for folder in _recordings(place, around):
        if _fingerprint_of(folder) == place.fingerprint:
            what = f"the recording {place.name!r} has moved here from {place.absolute}"
            remedy = "No action is needed. The project stores the new place."
            return Whereabouts(folder, Finding("note", str(folder), what, remedy))
    for folder, found in seen:
        if found is not None:
            changed = Finding(
                "warning",
                str(folder),
                "the recording's description or images have changed since the project was created",
                "Check that the clicks still fit the images. If this is a different recording, "
                "choose another folder.",
            )
            return Whereabouts(folder, changed)
    what = f"the recording {place.name!r} was not found"
    remedy = "Choose the folder where it is now. The clicks are not affected."
    return Whereabouts(None, Finding("error", place.absolute, what, remedy))


def _recordings(place: RecordingPlace, folders: Iterable[Path]) -> Iterable[Path]:
    """Folders among these, and one level below, whose recording has that name or none."""
    for folder in folders:
        try:
            below = sorted(path for path in folder.iterdir() if path.is_dir())
        except OSError:
            continue
        for path in (folder, *below):
            try:
                name = load_toml(path / DESCRIPTION).get("name") or place.name
            except (InputError, OSError):
                continue
            if name == place.name:
                yield path


def _fingerprint_of(folder: Path) -> str | None:
    try:
        return fingerprint(open_recording(folder))
    except (InputError, OSError):  # a path that somebody made up may not even be one
        return None


def documents_folder() -> Path:
    """Where projects go whose recording is in a folder that cannot be written to."""
    return platformdirs.user_documents_path() / "stereotrack"


def projects_of(folder: Path, documents: Path | None = None) -> tuple[Path, ...]:
    """Readable projects of a recording beside it and in the user's documents, newest first."""
    folder = folder.resolve()
    places = (folder.parent, documents or documents_folder())
    files = [path for place in places for path in place.glob(f"*{SUFFIX}")]
    found = [path for path in dict.fromkeys(files) if folder in stated_folders(path)]
    return tuple(sorted(found, key=lambda path: path.stat().st_mtime, reverse=True))


def stated_folders(project: Path) -> tuple[Path, ...]:
    """Where a project says its recording is, relative and absolute; empty if it does not."""
    try:
        with closing(connect_for_reading(project)) as database, making_sense(project):
            row = database.execute("SELECT relative, absolute FROM recording").fetchone()
            if row is None:
                return ()
            stated = project.parent / row[0] if row[0] else Path(row[1])
            return Path(os.path.normpath(stated)), Path(row[1])
    except (InputError, OSError, sqlite3.Error):
        return ()


def project_path_for(folder: Path, documents: Path | None = None, home: Path | None = None) -> Path:
    """Where a new project goes: beside the recording, in the user's documents, or `home`."""
    folder = folder.resolve()
    if home is None:
        writable = os.access(folder.parent, os.W_OK)
        home = folder.parent if writable else documents or documents_folder()
    path = home / f"{folder.name}{SUFFIX}"
    number = 2
    while path.exists() or beside(path):
        path = home / f"{folder.name}-{number}{SUFFIX}"
        number += 1
    return path

"""Where the recording of a run is."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from stereotrack_core.errors import InputError
from stereotrack_core.interop.run_file import read_run
from stereotrack_core.interop.run_journal import PART_SUFFIX
from stereotrack_core.interop.run_npz import read_meta
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.folder import DESCRIPTION, describe, fingerprint

_MOST_FILES = 60
"""More files or folders than this are not looked into, the newest first."""


def meta_of_run(path: Path) -> Mapping[str, Any]:
    """What a run file says about itself.

    Raises InputError where it is no run of this program, or is damaged.
    """
    if Path(path).suffix.lower() == PART_SUFFIX:
        return read_run(path).meta
    return read_meta(Path(path))


def recording_of_run_file(path: Path) -> Path | None:
    """The folder of the recording that a run was tracked in; None where it is not found.

    It is the folder that the run names, also where both have moved together, or a recording of the
    same content beside the run. Raises InputError where the file is no run.
    """
    meta = meta_of_run(path)
    named, content = str(meta.get("recording_folder") or ""), meta.get("fingerprint")
    if named and _is_recording(Path(named)):
        return Path(named)
    parent = Path(path).absolute().parent
    for folder in (parent, *_newest(parent, os.path.isdir)):
        if _is_recording(folder) and content is not None and _content_of(folder) == content:
            return folder
    return None


def is_run_of(path: Path, recording: Recording) -> bool:
    """Whether a run was tracked in a recording, or in a copy of it; False for no run."""
    try:
        meta = meta_of_run(path)
    except InputError:
        return False
    return _belongs(meta, fingerprint(recording), recording.folder.resolve())


def _belongs(meta: Mapping[str, Any], content: str, folder: Path) -> bool:
    if meta.get("fingerprint") is not None:
        return bool(meta["fingerprint"] == content)
    named = str(meta.get("recording_folder") or "")
    return bool(named) and Path(os.path.realpath(named)) == folder


def _is_recording(folder: Path) -> bool:
    return (folder / DESCRIPTION).is_file()


def _content_of(folder: Path) -> str | None:
    recording = describe(folder, [])
    return None if recording is None else fingerprint(recording)


def _newest(folder: Path, wanted: Any) -> Iterator[Path]:
    """Entries of a folder that are wanted, the newest first; none where it cannot be read."""
    try:
        entries = [path for path in folder.iterdir() if wanted(path)]
    except OSError:
        return
    yield from sorted(entries, key=_changed, reverse=True)[:_MOST_FILES]


def _changed(path: Path) -> float:
    try:
        return path.stat().st_mtime
    except OSError:
        return 0.0

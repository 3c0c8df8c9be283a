"""Where the recording of a run is."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from stereotrack_core.errors import InputError
from stereotrack_core.interop.run_file import read_run
from stereotrack_core.interop.run_journal import PART_SUFFIX
from stereotrack_core.interop.run_npz import read_meta
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.folder import DESCRIPTION, describe, fingerprint

_MOST_FOLDERS = 60  # more recordings beside a run than this are not looked at


def meta_of_run(path: Path) -> Mapping[str, Any]:
    """What a run file says about itself; InputError where it is no run, or damaged."""
    path = Path(path)
    return read_run(path).meta if path.suffix.lower() == PART_SUFFIX else read_meta(path)


def recording_of_run_file(path: Path) -> Path | None:
    """The folder of the recording that a run was tracked in; None where it is not found.

    It is the folder that the run names, also where both have moved together, or a recording of the
    same content beside the run. Raises InputError where the file is no run.
    """
    meta = meta_of_run(path)
    named, content = str(meta.get("recording_folder") or ""), meta.get("fingerprint")
    if named and (Path(named) / DESCRIPTION).is_file():
        return Path(named)
    parent = Path(path).absolute().parent
    beside = (parent / DESCRIPTION, *sorted(parent.glob(f"*/{DESCRIPTION}"))[:_MOST_FOLDERS])
    for folder in (one.parent for one in beside if content is not None and one.is_file()):
        recording = describe(folder, [])
        if recording is not None and fingerprint(recording) == content:
            return folder
    return None


def is_run_of(path: Path, recording: Recording) -> bool:
    """Whether a run was tracked in a recording, or in a copy of it; False for no run."""
    try:
        meta = meta_of_run(path)
    except InputError:
        return False
    if meta.get("fingerprint") is not None:
        return bool(meta["fingerprint"] == fingerprint(recording))
    named = str(meta.get("recording_folder") or "")
    return bool(named) and os.path.realpath(named) == os.path.realpath(recording.folder)

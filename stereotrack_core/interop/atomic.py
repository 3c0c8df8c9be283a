"""Files that are either written completely or not at all."""

from __future__ import annotations

import glob
import os
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from stereotrack_core.errors import InputError


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Give a temporary path in the same folder that becomes `path` when the block succeeds.

    A block that fails leaves what stood at `path` before. The temporary file has the suffix
    of `path`, for libraries that look at it.

    Raises
    ------
    InputError
        Where the folder does not exist or cannot be written to.
    """
    path = Path(path)
    if path.is_dir():
        raise InputError("this is a folder", where=str(path), remedy="Name a file in it.")
    temporary = path.with_name(f".{path.stem}-{uuid.uuid4().hex}{path.suffix}")
    try:
        temporary.touch(exist_ok=False)
    except OSError as error:
        raise InputError(
            f"no file can be written there ({error.strerror})",
            where=str(path),
            remedy="Choose a folder that exists and that you may write to.",
        ) from error
    try:
        yield temporary
        _flush(temporary)
        temporary.replace(path)
    except OSError as error:
        raise InputError(
            f"the file could not be written ({error.strerror or error})",
            where=str(path),
            remedy="Make room on the drive, or name another place; nothing was lost.",
        ) from error
    finally:
        temporary.unlink(missing_ok=True)


def forget_unfinished(path: Path) -> None:
    """Delete what programs have left that were killed while they wrote `path`.

    To be called only while nobody else can be writing it.
    """
    unfinished = f".{glob.escape(path.stem)}-{'[0-9a-f]' * 32}{glob.escape(path.suffix)}"
    for left in path.parent.glob(unfinished):
        left.unlink(missing_ok=True)


def _flush(path: Path) -> None:
    with path.open("rb+") as file:
        os.fsync(file.fileno())

"""Files and folders that are written completely or not at all.

Whatever the program writes goes through here. What is new is on the drive and has been looked at
before it takes the place of what is old: many libraries do not notice that a drive is full.
"""

import contextlib
import glob
import os
import shutil
import uuid
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from functools import partial
from pathlib import Path
from typing import TypeAlias

from stereotrack_core.errors import InputError
from stereotrack_core.locks import writing

Check: TypeAlias = Callable[[Path], bool]
"""Reads a file back: whether it is what was to be written. OSError, ValueError and InputError say
that it is not."""


def write_file(path: Path, content: str | bytes) -> None:
    """Write bytes, or a text as UTF-8; a write that fails leaves what stood there before.

    Raises InputError where the file cannot be written.
    """
    write_files({path: content})


def write_files(contents: Mapping[Path, str | bytes]) -> None:
    """Write files that belong together: where one of them cannot be written, all stay as they were.

    Raises InputError where one of them cannot be written.
    """
    with ExitStack() as pending:
        for path, content in contents.items():
            data = content.encode() if isinstance(content, str) else content
            whole = partial(lambda data, written: written.read_bytes() == data, data)
            temporary = pending.enter_context(replacing(path, whole))
            temporary.write_bytes(data)
            _flush(temporary)  # all that is left to be done for any of them is renaming


@contextmanager
def replacing(path: Path, is_whole: Check | None = None) -> Iterator[Path]:
    """Give a temporary path in the same folder that becomes `path` when the block succeeds.

    A block that fails leaves what stood at `path` before. The temporary file has the suffix of
    `path`, for libraries that look at it; `is_whole` looks at it at the end. Only SQLite, which
    looks itself, can do without. Raises InputError where the folder does not exist or cannot be
    written to, or the file is not whole.
    """
    path = Path(path)
    if path.is_dir():
        raise InputError("this is a folder", path, "Give the name of a file in it.")
    temporary = path.with_name(f".{path.stem}-{uuid.uuid4().hex}{path.suffix}")
    try:
        temporary.touch(exist_ok=False)
    except OSError as error:
        remedy = "Choose a folder that exists and that you may write to."
        raise InputError(f"cannot write a file here ({error.strerror})", path, remedy) from error
    whole = False
    try:
        yield temporary
        _flush(temporary)
        with contextlib.suppress(OSError, ValueError, InputError):
            whole = is_whole is None or is_whole(temporary)
        if not whole:
            raise OSError("not all data reached the drive")
        temporary.replace(path)
    except OSError as error:
        raise _unwritten("file", path, error) from error
    finally:
        temporary.unlink(missing_ok=True)
    _flush_names(path.parent)


def make_folder(folder: Path) -> None:
    """Make a folder, and those above it, unless it is there. Raises InputError."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        what = f"the folder cannot be created ({error.strerror})"
        raise InputError(what, folder, "Choose another place.") from error


@contextmanager
def filling(folder: Path) -> Iterator[Path]:
    """Give a hidden folder; what is in it is in `folder` when the block succeeds.

    A block that fails leaves `folder` as it was, or absent. What has the name of a new file is
    replaced, everything else in `folder` stays. Raises InputError where nothing can be written
    there.
    """
    target = Path(folder).resolve()
    there = target.is_dir()  # then perhaps a drive of its own, and nothing may be made beside it
    if target.exists() and not there:
        raise InputError("this is not a folder", folder, "Give the name of a folder.")
    workplace = (target if there else target.parent) / f".{target.name}-{uuid.uuid4().hex}"
    try:
        workplace.mkdir(parents=True)
    except OSError as error:
        what = f"cannot write here ({error.strerror})"
        raise InputError(what, folder, "Choose a folder that you may write to.") from error
    try:
        with writing(None if there else target):
            yield workplace
            if there:
                for made in sorted(workplace.iterdir()):
                    made.replace(target / made.name)
            else:
                workplace.rename(target)
    except InputError as error:
        where = error.where.replace(str(workplace), str(folder))
        raise InputError(error.what, where, error.remedy) from error
    except OSError as error:
        raise _unwritten("folder", folder, error) from error
    finally:
        shutil.rmtree(workplace, ignore_errors=True)
    _flush_names(target if there else target.parent)


def forget_unfinished(path: Path) -> None:
    """Delete what killed programs have left of writing `path`; only while nobody writes it."""
    unfinished = f".{glob.escape(path.stem)}-{'[0-9a-f]' * 32}{glob.escape(path.suffix)}"
    for left in path.parent.glob(unfinished):
        left.unlink(missing_ok=True)


def _unwritten(what: str, path: Path, error: OSError) -> InputError:
    return InputError(
        f"the {what} could not be written ({error.strerror or error})",
        path,
        "Free space on the drive, or choose another place. No data were lost.",
    )


def _flush(path: Path) -> None:
    with path.open("rb+") as file:
        os.fsync(file.fileno())


def _flush_names(folder: Path) -> None:
    """Bring the new names to the drive as well, where the system lets us; the content is there."""
    with contextlib.suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)

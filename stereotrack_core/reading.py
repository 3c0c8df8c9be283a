"""Read what somebody gave us: regular files of a limited size, and a sentence for what is wrong.

Whatever a format's decoder raises about a file that is damaged, or no file of its kind, becomes
the one sentence here, in :func:`decoding`; readers themselves only say what the file should be.
"""

import csv
import json
import lzma
import os
import stat
import struct
import tokenize
import tomllib
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

from stereotrack_core.errors import InputError
from stereotrack_core.plain_data import checked_tree

MB = 1024 * 1024
SETTINGS_BYTES = 4 * MB  # of TOML files and other settings: thousands of times what they hold
TABLE_BYTES = 512 * MB  # of tables and labels: hours of a person's landmarks
PICTURE_BYTES = 512 * MB  # of a picture
_AGAIN = "Use another copy of the file."
_WRITE_AGAIN = "Write the file again."
_KINDS = {stat.S_IFDIR: "a folder", stat.S_IFIFO: "a named pipe", stat.S_IFCHR: "a device"}

_OF_DECODERS = (
    *(ArithmeticError, AssertionError, AttributeError, BufferError, EOFError, LookupError),
    *(MemoryError, NameError, OSError, RuntimeError, TypeError, ValueError),
    *(csv.Error, lzma.LZMAError, struct.error, zipfile.BadZipFile, zlib.error),
    *(SyntaxError, tokenize.TokenError),  # of the headers of NumPy's arrays
)
"""What decoders raise; RuntimeError includes too deep a recursion, NameError a local variable of
theirs that has no value."""


def open_file(path: Path, at_most: int | None = None) -> BinaryIO:
    """Open a regular file of at most so many bytes for reading; never waits, as a named pipe would.

    Raises InputError where there is no such file, it is no regular one, too large, or may not be
    read.
    """
    flags = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
    with decoding(path, "the file cannot be read", _AGAIN):
        check_file(path)  # before: a device may do something when it is opened
        file = os.fdopen(os.open(path, flags), "rb")
        try:
            found = os.fstat(file.fileno())
            _check_kind(path, found)
            _check_size(path, found.st_size, at_most)
        except BaseException:
            file.close()
            raise
    return file


def check_file(path: Path, where: str = "") -> None:
    """Refuse what is no regular file, for libraries that open files themselves.

    Raises InputError where there is no such file, or it is no regular one; `where` names it there.
    """
    with decoding(where or path, "the file cannot be read", _AGAIN):
        _check_kind(where or path, os.stat(path))


def read_bytes(path: Path, at_most: int) -> bytes:
    """Content of a regular file; raises InputError: see :func:`open_file`."""
    with open_file(path, at_most) as file, decoding(path, "the file cannot be read", _AGAIN):
        content = file.read(at_most + 1)
    _check_size(path, len(content), at_most)
    return content


def read_text(path: Path, at_most: int = SETTINGS_BYTES) -> str:
    """Content of a regular UTF-8 file; InputError: see :func:`open_file`, and for no text."""
    content = read_bytes(path, at_most)
    with decoding(path, "the file cannot be read", "It must be a UTF-8 text file."):
        return content.decode("utf-8-sig")


def read_json(path: Path, at_most: int = SETTINGS_BYTES, remedy: str = _WRITE_AGAIN) -> Any:
    """Content of a JSON file; InputError: see :func:`read_text`, and where it is no JSON."""
    return parsed_json(read_text(path, at_most), str(path), remedy)


def parsed_json(text: str | bytes, where: str, remedy: str = _WRITE_AGAIN) -> Any:
    """What JSON text says; InputError where it is none, too deep, or with endless numbers."""
    with decoding(where, "this is not valid JSON", remedy):
        content = json.loads(text)
    checked_tree(content, where)
    return content


@contextmanager
def decoding(where: Path | str, what: str, remedy: str) -> Iterator[None]:
    """Say in a sentence what a decoder raises about a file; for decoding alone, not for its use.

    Raises InputError in place of every error that a decoder raises: about the file, or a place in
    it, `where`, with `what` is wrong as a clause; the error's own words are added where they help.
    """
    try:
        yield
    except FileNotFoundError:
        raise InputError("there is no such file", where, "Check the path.") from None
    except _OF_DECODERS as error:
        why = reason(error)
        what = f"{what} ({why})" if why else what
        raise InputError(what, where, readable(error, remedy)) from error


def reason(error: Exception) -> str:
    """The reason within a decoder's error, in a few words; empty where it has none for people."""
    match error:
        case UnicodeDecodeError():
            return f"byte {error.start} is not text"
        case OSError() if error.strerror:
            return error.strerror
        case RecursionError():
            return "it is nested too deeply"
        case MemoryError():
            return "it is too large for the memory"
        case OverflowError():
            return "a number is too large"
        case tomllib.TOMLDecodeError() | json.JSONDecodeError() | csv.Error():
            return str(error)
        case zipfile.BadZipFile() | zlib.error() | EOFError():
            return "it ends too early or has changed"
        case ValueError() if "integer string conversion" in str(error):
            return "a number is too large"
    return ""


def readable(error: Exception, otherwise: str) -> str:
    """What to do about a file that may not be read, else `otherwise`."""
    if isinstance(error, PermissionError):
        return "Change its permissions so that you may read it."
    return otherwise


def _check_kind(where: Path | str, found: os.stat_result) -> None:
    if stat.S_ISREG(found.st_mode):
        return
    kind = _KINDS.get(stat.S_IFMT(found.st_mode), "something else")
    raise InputError(f"this is {kind}, not a file", where, "Use a regular file.")


def _check_size(path: Path, size: int, at_most: int | None) -> None:
    if at_most is not None and size > at_most:
        what = f"the file has more than {at_most // MB} MB, too large for this type of file"
        raise InputError(what, path, "Check that it is the right file.")

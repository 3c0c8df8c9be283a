"""HDF5 files from anybody, read where they can do no harm.

The library trusts the sizes that a file states: a damaged one has it take all memory, or end the
process. What this program has written itself may be read without this.
"""

from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from stereotrack_core.limited_process import read_apart
from stereotrack_core.reading import check_file, decoding, open_file

Result = TypeVar("Result")

_SIGNATURE = b"\x89HDF\r\n\x1a\n"
_FIRST_PLACE = 512  # where it is looked for behind the beginning, and at each power of 2 after that


def read_hdf5(path: Path, read: Callable[[Path], Result], what: str, remedy: str) -> Result:
    """What `read` makes of an HDF5 file, in a process of its own.

    Raises InputError where it is none, with `what` is wrong as a clause, or damaged, and what
    `read` raises; see :func:`stereotrack_core.limited_process.read_apart`.
    """
    check_file(path)
    with decoding(path, what, remedy):
        if not is_hdf5(path):
            raise ValueError("it has no signature of HDF5")
    return read_apart(read, path, remedy)


def is_hdf5(path: Path) -> bool:
    """Whether a file has HDF5's signature at one of its places; InputError as of `open_file`."""
    with open_file(path) as file:
        size = file.seek(0, 2)
        place = 0
        while place < size:
            file.seek(place)
            if file.read(len(_SIGNATURE)) == _SIGNATURE:
                return True
            place = max(_FIRST_PLACE, 2 * place)
    return False

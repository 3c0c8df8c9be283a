"""Files of other programs that are not read as landmarks: a sentence that says what they are."""

from __future__ import annotations

from pathlib import Path

from stereotrack_core.errors import InputError
from stereotrack_core.tables import read_cells

_SUFFIXES = {
    ".bvh": (
        "the suffix .bvh means rotations of a skeleton, which are not read",
        "Export its joints as .trc or .c3d from the program that made it.",
    ),
    ".mot": (
        "the suffix .mot means joint angles, not landmarks",
        "Use the .trc or .c3d file that they were computed from.",
    ),
    ".sto": (
        "the suffix .sto means values of a model, not landmarks",
        "Use the .trc or .c3d file that they were computed from.",
    ),
}


def refuse_other_suffix(path: Path) -> None:
    """Refuse a file that is known not to hold landmarks in space, by its suffix.

    Raises InputError that says what the file is.
    """
    suffix = path.suffix.lower()
    if suffix in _SUFFIXES:
        what, remedy = _SUFFIXES[suffix]
        raise InputError(what, where=str(path), remedy=remedy)


def refuse_other_table(path: Path) -> None:
    """Refuse anipose's table of 3-D points, which states neither unit nor axes."""
    header = (read_cells(path) or [[]])[0]
    bodyparts = {name.removesuffix("_ncams") for name in header if name.endswith("_ncams")}
    if any({f"{part}_{axis}" for axis in "xyz"} <= set(header) for part in bodyparts):
        raise InputError(
            "this is anipose's table of 3-D points, which states neither unit nor axes",
            where=str(path),
            remedy="Write its points as .trc or .c3d, which state unit and labels.",
        )

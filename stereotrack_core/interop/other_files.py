"""Files of other programs that are not read as landmarks: a sentence that says what they are."""

from __future__ import annotations

from pathlib import Path

from stereotrack_core.errors import InputError
from stereotrack_core.interop.hdf5 import is_hdf5, read_hdf5
from stereotrack_core.reading import decoding
from stereotrack_core.tables import read_cells
from stereotrack_core.versions import check_library

_CONVERT = "Write its points as .trc or .c3d, which state unit and labels, and use that file."
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
_HDF5 = (".h5", ".hdf5", ".hdf")


def refuse_other_suffix(path: Path) -> None:
    """Refuse a file that is known not to hold landmarks in space, by its suffix or content.

    Raises InputError that says what the file is.
    """
    suffix = path.suffix.lower()
    if suffix in _SUFFIXES:
        what, remedy = _SUFFIXES[suffix]
        raise InputError(what, where=str(path), remedy=remedy)
    if suffix in _HDF5:
        refuse_other_hdf5(path)


def refuse_other_table(path: Path) -> None:
    """Refuse anipose's table of 3-D points, which states neither unit nor axes."""
    header = (read_cells(path) or [[]])[0]
    bodyparts = {name.removesuffix("_ncams") for name in header if name.endswith("_ncams")}
    if any({f"{part}_{axis}" for axis in "xyz"} <= set(header) for part in bodyparts):
        raise InputError(
            "this is anipose's table of 3-D points, which states neither unit nor axes",
            where=str(path),
            remedy=_CONVERT,
        )


_UNREADABLE, _COPY = "the file cannot be read", "Use another copy of the file."


def refuse_other_hdf5(path: Path) -> None:
    """Refuse SLEAP's analysis and sleap-anipose's 3-D points; other files are passed over.

    Raises InputError that says what the file is.
    """
    if not path.is_file() or not is_hdf5(path):
        return
    missing = "HDF5 files need the library h5py, which is not installed"
    check_library("h5py", "sleap", missing=missing, where=str(path), instead="a .csv")
    kind = read_hdf5(path, _kind, _UNREADABLE, _COPY)
    if kind == "analysis":
        raise InputError(
            "this is SLEAP's analysis of a video, which holds predictions in pixels",
            where=str(path),
            remedy="Import it with `stereotrack import predictions`.",
        )
    if kind == "points":
        raise InputError(
            "this is sleap-anipose's file of 3-D points, which states neither landmarks nor unit",
            where=str(path),
            remedy=_CONVERT,
        )


def _kind(path: Path) -> str:
    """What an HDF5 file with a data set ``tracks`` holds; empty for others."""
    import h5py

    with decoding(path, _UNREADABLE, _COPY), h5py.File(path) as file:
        tracks = file.get("tracks")
        shape: tuple[int, ...] = getattr(tracks, "shape", ())
        if len(shape) != 4:
            return ""
        if "node_names" in file:
            return "analysis"
        return "points" if shape[-1] == 3 else ""

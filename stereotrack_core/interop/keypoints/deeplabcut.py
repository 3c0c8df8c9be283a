"""DeepLabCut's predictions and labels: CSV or HDF5, one file for each video.

Several individuals are people, whose names hold over all frames.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from stereotrack_core.interop.deeplabcut import places_of_rows, table_of
from stereotrack_core.interop.deeplabcut_hdf5 import StoredTable
from stereotrack_core.interop.keypoints.people import FileRow, Who
from stereotrack_core.interop.keypoints.source import KeypointSource
from stereotrack_core.interop.label_source import LabelSource
from stereotrack_core.tables import finite_number, read_cells

_REMEDY = (
    "Use a .csv or .h5 file written by DeepLabCut's analyze_videos; have it write a damaged one "
    "again."
)


def read_csv(source: KeypointSource) -> Iterator[FileRow]:
    """Rows of a CSV file; InputError where it cannot be read or its camera cannot be told."""
    table = table_of(source.path, read_cells(source.path, headers=3), _REMEDY)
    place_of = places_of_rows((named for _, named, _ in table.rows), _video(source))
    for where, named, cells in table.rows:
        if (place := place_of(named, where)) is not None:
            line = int(where.rpartition(" ")[2])
            values = [
                finite_number(cell, source.path, line, column[1])
                if cell and cell.lower() != "nan"
                else float("nan")
                for cell, column in zip(cells, table.columns, strict=True)
            ]
            yield from _rows(values, table.columns, source, place)


def read_h5(source: KeypointSource, table: StoredTable) -> Iterator[FileRow]:
    """Rows of an HDF5 file; InputError where its camera cannot be told."""
    columns = [(*("",) * (4 - len(name)), *name[1:]) for name in table.columns]
    place_of = places_of_rows(table.rows, _video(source))
    for row, values in zip(table.rows, table.values.tolist(), strict=True):
        place = place_of(row, f"{source.path}, row {'/'.join(row)}")
        if place is not None:
            yield from _rows(values, columns, source, place)


def _video(source: KeypointSource) -> LabelSource:
    """The source, named after its video: ``cam1`` for ``cam1DLC_resnet50_walk_1.csv``."""
    path = source.path
    return replace(source.labels, path=path.with_name(path.stem.split("DLC")[0] or path.stem))


def _rows(
    values: Sequence[float],
    columns: Sequence[tuple[str, ...]],
    source: KeypointSource,
    place: tuple[int, str],
) -> Iterator[FileRow]:
    """Rows of one frame, from the numbers of columns of individual, body part and coordinate."""
    found: dict[tuple[str, str], dict[str, float]] = {}
    for value, (individual, part, coordinate) in zip(values, columns, strict=True):
        found.setdefault((individual, part), {})[coordinate] = value
    people = list(dict.fromkeys(individual for individual, _ in found))
    nothing = float("nan")
    for (individual, part), own in found.items():
        x, y = own.get("x", nothing), own.get("y", nothing)
        who = Who(people.index(individual), individual)
        yield *place, part, x, y, own.get("likelihood", 1.0), source.name, who

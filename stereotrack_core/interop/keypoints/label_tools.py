"""Keypoints that DeepLabCut and SLEAP have predicted.

DeepLabCut writes CSV or HDF5, one file for each video; several individuals are people, whose names
hold over all frames. SLEAP writes projects (.slp) and analyses (.h5). An analysis holds one video
as arrays: ``tracks`` (track, x y, node, frame), ``point_scores`` (track, node, frame), and the
names of tracks and nodes.
"""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.interop.deeplabcut import DeepLabCutTable, places_of_rows
from stereotrack_core.interop.keypoints.source import FileRow, KeypointSource, Who
from stereotrack_core.interop.label_source import LabelSource
from stereotrack_core.interop.sleap import places_of_labelled, read_sleap_file
from stereotrack_core.reading import TABLE_BYTES, decoding

DEEPLABCUT_REMEDY = (
    "Use a .csv or .h5 file written by DeepLabCut's analyze_videos; have it write a damaged one "
    "again."
)


def read_deeplabcut(source: KeypointSource, table: DeepLabCutTable) -> Iterator[FileRow]:
    """Rows of a table; InputError where a number cannot be read or its camera cannot be told."""
    place_of = places_of_rows((named for _, named, _ in table.rows), _video(source))
    people = list(dict.fromkeys(individual for individual, *_ in table.columns))
    for row in table.rows:
        if (place := place_of(row[1], row[0])) is None:
            continue
        for individual, part, x, y, likelihood in table.points(row):
            who = Who(people.index(individual), individual)
            yield *place, part, x, y, likelihood, source.name, who


def _video(source: KeypointSource) -> LabelSource:
    """The source, named after its video: ``cam1`` for ``cam1DLC_resnet50_walk_1.csv``."""
    path = source.path
    return replace(source, path=path.with_name(path.stem.split("DLC")[0] or path.stem))


_MOST_NAMES = 100_000
_WHAT = "this is not an analysis of SLEAP"
_SLEAP_REMEDY = "Export it again with SLEAP's File, Export Analysis HDF5."


def read_slp(source: KeypointSource) -> Iterator[FileRow]:
    """Rows of what SLEAP has predicted, not of labels; InputError where it cannot be read."""
    path = source.path
    frames = [one for one in read_sleap_file(path, predicted=True)[1] if one.people]
    place_of = places_of_labelled(frames, source)
    for labelled in frames:
        if labelled.problem is not None:
            raise labelled.problem
        place = place_of(labelled, f"{path}, frame {labelled.number}")
        if place is None:
            continue
        for number, person in enumerate(labelled.people):
            who = Who(number, person.track)
            for point, x, y, score in person.points:
                yield *place, point, x, y, score, source.name, who


Analysis: TypeAlias = tuple[list[str], list[str], FloatArray, FloatArray]
"""Names of nodes and tracks, places (track, node, frame, 2) and scores (track, node, frame)."""


def stored_analysis(stored: Any, path: Path) -> Analysis:
    """What an open file holds; InputError where its parts do not fit together."""
    with decoding(path, _WHAT, _SLEAP_REMEDY):
        names = stored["node_names"], stored["track_names"]
        if any(one.size > _MOST_NAMES for one in names):
            raise ValueError("it has too many nodes or tracks")
        nodes, tracks = (
            [name.decode() if isinstance(name, bytes) else str(name) for name in one[()]]
            for one in names
        )
        data = stored["tracks"]
        if data.size * data.dtype.itemsize > TABLE_BYTES or data.dtype.kind not in "fiu":
            raise ValueError("its tracks are no numbers of a usual size")
        if data.ndim != 4 or data.shape[1:3] != (2, len(nodes)):
            raise ValueError("its parts do not fit together")
        places = np.moveaxis(data[()].astype(np.float64), 1, 3)
        scores = np.ones(places.shape[:3])
        if "point_scores" in stored and stored["point_scores"].shape == scores.shape:
            scores = stored["point_scores"][()].astype(np.float64)
        tracks = tracks if len(tracks) == len(places) else [""] * len(places)
        return nodes, tracks, places, scores


def rows_of_analysis(found: Analysis, source: KeypointSource) -> Iterator[FileRow]:
    """Rows of an analysis, whose camera is stated or told by the file's name."""
    nodes, tracks, places, scores = found
    camera = source.camera_of(source.path.name, str(source.path))
    for track, node, frame in np.argwhere(np.isfinite(places).all(axis=3)).tolist():
        x, y = places[track, node, frame].tolist()
        sure, who = float(scores[track, node, frame]), Who(track, tracks[track])
        yield frame, camera, nodes[node], x, y, sure, source.name, who

"""SLEAP's predicted instances (.slp), with the scores of their points."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from stereotrack_core.interop.keypoints.source import KeypointSource
from stereotrack_core.interop.sleap import place_of_labelled, sleap_library
from stereotrack_core.reading import check_file, decoding
from stereotrack_core.recording.keypoints import Row


def read_slp(source: KeypointSource) -> Iterator[Row]:
    """Rows of what SLEAP has predicted; what people have labelled is left out.

    InputError where the file cannot be read, or sleap-io is not installed.
    """
    path = source.path
    sio = sleap_library(path)
    check_file(path)
    with decoding(path, "this is not a SLEAP file", "Use an .slp file saved by SLEAP."):
        stored = sio.load_slp(str(path), open_videos=False)
    for labelled in stored.labeled_frames:
        where = f"{path}, frame {labelled.frame_idx}"
        with decoding(where, "it cannot be read", "Predict it again in SLEAP."):
            people = labelled.predicted_instances
        if people:
            place = place_of_labelled(labelled, source.labels, where)
            for person, instance in enumerate(people):
                yield from _rows(instance, place, source.name, person)


def _rows(instance: Any, place: tuple[int, str], name: str, person: int) -> Iterator[Row]:
    for point in instance.points:
        x, y = point["xy"].tolist()
        if np.isfinite([x, y]).all():
            yield *place, str(point["name"]), x, y, float(point["score"]), name, person

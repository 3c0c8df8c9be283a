"""SLEAP's predicted instances (.slp), with the scores of their points."""

from __future__ import annotations

from collections.abc import Iterator

from stereotrack_core.interop.keypoints.source import KeypointSource
from stereotrack_core.interop.sleap import place_of_labelled
from stereotrack_core.interop.sleap_file import SleapPerson, read_sleap_file
from stereotrack_core.recording.keypoints import Row


def read_slp(source: KeypointSource) -> Iterator[Row]:
    """Rows of what SLEAP has predicted; what people have labelled is left out.

    InputError where the file cannot be read, or sleap-io is not installed.
    """
    path = source.path
    for labelled in read_sleap_file(path, predicted=True).frames:
        if labelled.problem is not None:
            raise labelled.problem
        if labelled.people:
            where = f"{path}, frame {labelled.number}"
            place = place_of_labelled(labelled, source.labels, where)
            for number, person in enumerate(labelled.people):
                yield from _rows(person, place, source.name, number)


def _rows(person: SleapPerson, place: tuple[int, str], name: str, number: int) -> Iterator[Row]:
    for point, x, y, score in person.points():
        yield *place, point, x, y, score, name, number

"""Who is who in a detector's file: each person has one number over all frames.

Where the file states identities (individuals, tracks), they hold. Elsewhere people are followed by
place from picture to picture in each camera, the one with the highest confidences over all frames
as number 0.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np
import scipy

from stereotrack_core.arrays import FloatArray
from stereotrack_core.recording.keypoints import Row

_NEAR = 0.5
"""Distance, in sizes of a person, within which the next picture shows the same one."""

_DRIFT = 0.25
"""The same that is added for each frame without the person."""


class Who(NamedTuple):
    """A person of one picture, as a file has it."""

    place: int
    """Place among the people of the picture."""
    name: str = ""
    """Identity that the file states over all frames; empty if it states none."""


FileRow: TypeAlias = tuple[int, str, str, float, float, float, str, Who]
"""Frame, camera, keypoint, column, row, confidence, source and person."""


def stated_name(value: object) -> str:
    """Identity that a JSON file states, from ``[3]``, ``3.0`` or a text; negative ones are none."""
    if isinstance(value, list):
        value = value[0] if len(value) == 1 else None
    if isinstance(value, str):
        return value.strip()
    if isinstance(value, bool) or not isinstance(value, int | float) or value < 0:
        return ""
    return str(int(value))


def identified(rows: Sequence[FileRow]) -> tuple[list[Row], Mapping[int, str]]:
    """Rows with numbers of people that hold over all frames, and stated names by number."""
    groups: dict[tuple[str, str], list[FileRow]] = {}
    for row in rows:
        groups.setdefault((row[6], row[1]), []).append(row)
    stated = {key for key, own in groups.items() if _is_stated(own)}
    names = dict.fromkeys(row[7].name for key in stated for row in groups[key])
    numbers = numbered(tuple(names))
    found: list[Row] = []
    for key, own in groups.items():
        if key in stated:
            found += [(*row[:7], numbers[row[7].name]) for row in own]
        else:
            found += _followed(own)
    return found, {number: name for name, number in numbers.items()}


def numbered(names: Sequence[str]) -> dict[str, int]:
    """A number for each name: its own if it is one, otherwise the next that is free."""
    own = {name: int(name) for name in names if name.isdecimal()}
    free = (number for number in range(len(names) + len(own)) if number not in own.values())
    return {name: own[name] if name in own else next(free) for name in names}


def _is_stated(rows: Sequence[FileRow]) -> bool:
    """Whether all people of a camera have names, and nobody in a picture that of another."""
    people = {(row[0], row[7]) for row in rows}
    return all(who.name for _, who in people) and len(people) == len(
        {(frame, who.name) for frame, who in people}
    )


@dataclass
class _Track:
    """A person as seen last."""

    places: FloatArray
    """(K, 2), pixels. NaN where never seen."""
    velocity: FloatArray
    """(2,), pixels a frame."""
    frame: int
    size: float
    confidence: float = 0.0

    def distance(self, frame: int, places: FloatArray) -> float:
        """From the place where the person would be, in sizes of a person."""
        gap = frame - self.frame
        moved = self.places + self.velocity * min(gap, 3)
        off = np.linalg.norm(places - moved, axis=1)
        known = off[np.isfinite(off)]
        if not len(known):
            known = np.linalg.norm([np.nanmean(places, axis=0) - np.nanmean(moved, axis=0)], axis=1)
        return float(np.median(known)) / self.size / (_NEAR + _DRIFT * (gap - 1))

    def go_on(self, frame: int, places: FloatArray) -> None:
        """Take the person's next picture."""
        step = np.nanmedian(places - self.places, axis=0) / (frame - self.frame)
        if np.isfinite(step).all():
            self.velocity = 0.5 * (self.velocity + step)
        self.places = np.where(np.isfinite(places), places, self.places)
        self.frame, self.size = frame, 0.5 * (self.size + _size(places))


def _size(places: FloatArray) -> float:
    low, high = np.nanmin(places, axis=0), np.nanmax(places, axis=0)
    return max(float(np.linalg.norm(high - low)), 1.0)


def _followed(rows: Sequence[FileRow]) -> list[Row]:
    """Rows of one camera with the people followed by place; 0 is the surest of all frames."""
    if len({row[7].place for row in rows}) == 1:
        return [(*row[:7], 0) for row in rows]
    keypoints = {name: k for k, name in enumerate(dict.fromkeys(row[2] for row in rows))}
    pictures: dict[int, dict[int, FloatArray]] = {}
    sums: dict[tuple[int, int], float] = {}
    for frame, _, name, x, y, sure, _, who in rows:
        if np.isfinite((x, y)).all():
            people = pictures.setdefault(frame, {})
            if who.place not in people:
                people[who.place] = np.full((len(keypoints), 2), np.nan)
            people[who.place][keypoints[name]] = x, y
            sums[frame, who.place] = sums.get((frame, who.place), 0.0) + sure
    tracks: list[_Track] = []
    found: dict[tuple[int, int], int] = {}
    for frame in sorted(pictures):
        own = pictures[frame]
        for index, track in _matches(tracks, frame, own).items():
            found[frame, index] = track
            tracks[track].confidence += sums[frame, index]
    order = sorted(range(len(tracks)), key=lambda k: -tracks[k].confidence)
    rank = {track: number for number, track in enumerate(order)}
    return [
        (*row[:7], rank[found[row[0], row[7].place]])
        for row in rows
        if (row[0], row[7].place) in found
    ]


def _matches(tracks: list[_Track], frame: int, people: Mapping[int, FloatArray]) -> dict[int, int]:
    """The track of each person of a picture by index; new people begin one."""
    indices = list(people)
    cost = np.array(
        [[track.distance(frame, people[index]) for track in tracks] for index in indices]
    ).reshape(len(indices), len(tracks))
    # what is too far is as bad as any other, so that it does not push aside what is near
    pairs = zip(*scipy.optimize.linear_sum_assignment(np.minimum(cost, 1.0)), strict=True)
    found = {indices[row]: int(track) for row, track in pairs if cost[row, track] < 1.0}
    for index, places in people.items():
        if index in found:
            tracks[found[index]].go_on(frame, places)
        else:
            found[index] = len(tracks)
            tracks.append(_Track(places, np.zeros(2), frame, _size(places)))
    return found

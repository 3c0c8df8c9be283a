"""A detector's file and what a person says about it, and what came of reading it.

Who is who in a detector's file: each person has one number over all frames.

Where the file states identities (individuals, tracks), they hold. Elsewhere people are followed by
place from picture to picture in each camera, the one with the highest confidences over all frames
as number 0.
"""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple, TypeAlias

import numpy as np
import scipy

from stereotrack_core.arrays import FloatArray
from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.interop.label_source import LabelSource
from stereotrack_core.recording import keypoint_names
from stereotrack_core.recording.keypoints import (
    Keypoints,
    Row,
    changes_of_surest,
    keypoints_of,
    of_one_person,
    rows_of,
)
from stereotrack_core.recording.landmarks import LANDMARKS

_NEAR = 0.5  # distance, in sizes of a person, within which the next picture shows the same one
_DRIFT = 0.25  # the same that is added for each frame without the person


class Who(NamedTuple):
    """A person of one picture, as a file has it."""

    place: int  # place among the people of the picture
    name: str = ""  # identity that the file states over all frames; empty if it states none


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
    stated = set()  # where all people of a camera have names, and nobody in a picture two
    for key, own in groups.items():
        people = {(row[0], row[7]) for row in own}
        named = {(frame, who.name) for frame, who in people if who.name}
        if len(named) == len(people):
            stated.add(key)
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


@dataclass
class _Track:
    """A person as seen last."""

    places: FloatArray  # (K, 2), pixels. NaN where never seen.
    velocity: FloatArray  # (2,), pixels a frame
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
            nowhere = np.full((len(keypoints), 2), np.nan)
            pictures.setdefault(frame, {}).setdefault(who.place, nowhere)[keypoints[name]] = x, y
            sums[frame, who.place] = sums.get((frame, who.place), 0.0) + sure
    tracks: list[_Track] = []
    found: dict[tuple[int, int], int] = {}
    for frame, people in sorted(pictures.items()):
        cost = np.array(
            [[track.distance(frame, places) for track in tracks] for places in people.values()]
        ).reshape(len(people), len(tracks))
        # what is too far is as bad as any other, so that it does not push aside what is near
        pairs = zip(*scipy.optimize.linear_sum_assignment(np.minimum(cost, 1.0)), strict=True)
        matched = {int(row): int(track) for row, track in pairs if cost[row, track] < 1.0}
        for row, (index, places) in enumerate(people.items()):
            if row in matched:
                tracks[matched[row]].go_on(frame, places)
            else:
                matched[row] = len(tracks)
                tracks.append(_Track(places, np.zeros(2), frame, _size(places)))
            found[frame, index] = matched[row]
            tracks[matched[row]].confidence += sums[frame, index]
    order = sorted(range(len(tracks)), key=lambda k: -tracks[k].confidence)
    rank = {track: number for number, track in enumerate(order)}
    numbers = {key: rank[track] for key, track in found.items()}
    return [(*r[:7], numbers[r[0], r[7].place]) for r in rows if (r[0], r[7].place) in numbers]


_OTHERS = "of other people"
_SHOWN = 12

_POINTS = {name for names in keypoint_names.LAYOUTS.values() for name in names}
_POINTS = {name for name in _POINTS if not name.startswith("point_")}
_KNOWN = {*LANDMARKS, *keypoint_names.LANDMARK_OF} | _POINTS


@dataclass(frozen=True)
class KeypointSource(LabelSource):
    """A file or folder of a detector."""

    layout: str | None = None
    """Name in ``LAYOUTS`` of the points' order, where neither names nor number tell it."""
    detector: str = ""  # name of the detector; that of the file where it is empty

    @property
    def name(self) -> str:
        """What the rows call their source."""
        return self.detector or self.path.stem

    def points_of(self, count: int, where: str) -> Sequence[str]:
        """Names of so many points until all of the file is read; InputError if unknown."""
        return keypoint_names.unnamed(count, where, stated=self.layout)


@dataclass(frozen=True, eq=False)
class FoundKeypoints:
    """Keypoints of a file, and what of it is not among them."""

    keypoints: Keypoints
    left_out: Mapping[str, int] = field(default_factory=dict)
    """Rows by the reason for which they are left out, in words."""
    notes: tuple[str, ...] = ()  # decisions about them, such as the order of points without names
    people: Mapping[int, str] = field(default_factory=dict)
    """Names of people by their number, as far as the file states identities."""

    def summary(self) -> str:
        """What was left out, in a line; ``nothing`` where all is there."""
        told = [f"{count} {why}" for why, count in self.left_out.items()]
        return "; ".join(told) or "nothing"


def found_in(
    source: KeypointSource, rows: Iterable[FileRow], frames: int | None = None
) -> FoundKeypoints:
    """Take the rows that make sense; InputError where a stated name is unknown, or none is left."""
    for theirs, ours in source.names.items():
        if ours not in _KNOWN:
            what, some = f"unknown keypoint {ours!r}", ", ".join(keypoint_names.COCO_17[:7])
            remedy = f"Write a landmark or a keypoint, such as {some}."
            raise InputError(what, f"--name {theirs}={ours}", remedy)
    left: Counter[str] = Counter()
    kept: list[FileRow] = []
    named, layouts = keypoint_names.with_layouts(list(rows), source.layout)
    for row in named:
        frame, camera, theirs, x, y, sure, told, person = row
        name = source.names.get(theirs) or keypoint_names.keypoint_name(theirs)
        if name not in _KNOWN:
            left["of keypoints that are no part of the body's layouts"] += 1
        elif frame < 0 or (frames is not None and frame >= frames):
            left[f"of frames that the recording does not have (0:{frames})"] += 1
        elif sure <= 0.0:
            left["without confidence"] += 1
        else:
            kept.append((frame, camera, name, x, y, sure, told, person))
    identities, people = identified(kept)
    keypoints = keypoints_of(identities)
    if lost := len(kept) - len(keypoints):
        left["without a place"] += lost
    if not len(keypoints):
        said = "; ".join(f"{count} {why}" for why, count in left.items()) or "no person is there"
        names = "state names with --name THEIRS=OURS where they are unusual"
        remedy = f"Check that the file is of this recording, and {names}."
        raise InputError(f"there is no keypoint to use ({said})", source.path, remedy)
    notes = list(dict.fromkeys(choice.sentence() for choice in layouts))
    seen = np.unique(keypoints.frame)
    if len(seen) > 1 and seen[0] == 1 and seen[-1] == len(seen):
        notes.append(
            f"its frames run from 1 to {len(seen)} without a gap; here 0 is the first frame. If "
            "the file counts from 1, all its keypoints are one frame late"
        )
    return FoundKeypoints(keypoints, dict(left), tuple(notes), people)


def joined(found: Sequence[FoundKeypoints]) -> FoundKeypoints:
    """Keypoints of several files as of one; of two in the same place the later one counts."""
    names = dict.fromkeys(name for one in found for name in one.people.values())
    numbers, left = numbered(tuple(names)), Counter[str]()
    rows: list[Row] = []
    for one in found:
        left.update(one.left_out)
        own = {number: numbers[name] for number, name in one.people.items()}
        rows += [(*row[:7], own.get(row[7], row[7])) for row in rows_of(one.keypoints)]
    keypoints = keypoints_of({(row[:3], row[6:]): row for row in rows}.values())
    if twice := len(rows) - len(keypoints):
        left["that another one of the same name replaces"] += twice
    notes = dict.fromkeys(note for one in found for note in one.notes)
    people = {number: name for name, number in numbers.items()}
    return FoundKeypoints(keypoints, dict(left), tuple(notes), people)


def of_chosen_person(found: FoundKeypoints, person: str | None = None) -> FoundKeypoints:
    """Keypoints of the person stated, else of the surest; InputError if nobody is called so."""
    keypoints, names = found.keypoints, found.people
    shown = [names.get(number, str(number)) for number in np.unique(keypoints.person).tolist()]
    if person is None and len(shown) < 2:
        return found
    if person is None:
        kept = of_one_person(keypoints)
    else:
        number = next((n for n, name in names.items() if name.lower() == person.lower()), None)
        if number is None and person not in shown:
            what = f"the keypoints have no person {person!r}"
            raise InputError(what, "--person", f"Their people are {', '.join(shown[:_SHOWN])}.")
        kept = keypoints[keypoints.person == (int(person) if number is None else number)]
    others = len(keypoints) - len(kept)
    if not others:
        return found
    own = sorted({names.get(n, str(n)) for n in kept.person.tolist()})
    what = "as stated" if person is not None else "the surest of all frames"
    more = f" and {len(shown) - _SHOWN} more" if len(shown) > _SHOWN else ""
    note = (
        f"{len(shown)} people ({', '.join(shown[:_SHOWN])}{more}): {', '.join(own)} is kept in all "
        f"frames, {what}; the surest of each picture would have changed "
        f"{counted(changes_of_surest(keypoints), 'time')}; another person can be stated (--person)"
    )
    left = {**found.left_out, _OTHERS: found.left_out.get(_OTHERS, 0) + others}
    return replace(found, keypoints=kept, left_out=left, notes=(*found.notes, note))

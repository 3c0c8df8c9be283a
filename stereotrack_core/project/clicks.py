"""Clicks in a project: as rows of their tables, read, and edited."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from stereotrack_core.annotation.agreement import Difference, differences
from stereotrack_core.annotation.click import (
    ACCEPTED,
    DETECTED,
    UNCERTAIN,
    Click,
    ClickKey,
    Prediction,
    Seen,
    Visibility,
)
from stereotrack_core.arrays import IntArray
from stereotrack_core.errors import InputError
from stereotrack_core.project.connection import Access
from stereotrack_core.project.database import making_sense
from stereotrack_core.project.edit import Change, Edit, Stamp, State
from stereotrack_core.project.schema import CLICK, KEYPOINT, REPEAT_CLICK, Row, Table, Value


def _click(row: Sequence[Any]) -> Click:
    """The click of a row: key (with or without round) and values."""
    *_, frame, camera, landmark, x, y, visibility, flag, sigma, origin, who, at, deleted = row
    position = None if x is None else (x, y)
    own = (position, Visibility(visibility), flag, sigma, origin, who, at, bool(deleted))
    return Click(frame, camera, landmark, *own)


def _values(click: Click, stamp: Stamp) -> Row:
    """Values of a click's row; who and when are filled in where it does not say them itself."""
    x, y = (None, None) if click.position is None else map(float, click.position)
    sigma = None if click.sigma is None else float(click.sigma)
    origin = (click.origin, click.who or stamp.who, click.at or stamp.at, int(click.deleted))
    return (x, y, int(click.visibility), click.flag, sigma, *origin)


class Clicks:
    """Clicks of people. Deleted ones are left out where not said otherwise."""

    def __init__(self, access: Access) -> None:
        self._access = access

    def get(self, key: ClickKey) -> Click | None:
        """One click, also a deleted one; None where there never was one."""
        values = self._access.read(CLICK, key)
        with making_sense(self._access.path):
            return None if values is None else _click((*key, *values))

    def at(self, frame: int, camera: str | None = None) -> tuple[Click, ...]:
        """Clicks of a frame, of all cameras or of one."""
        own = () if camera is None else (camera,)
        where = "WHERE frame = ? AND deleted = 0" + " AND camera = ?" * len(own)
        return self._clicks(where, frame, *own)

    def deleted_at(self, frame: int) -> tuple[Click, ...]:
        """Clicks of a frame that were taken away."""
        return self._clicks("WHERE frame = ? AND deleted = 1", frame)

    def between(self, first: int, end: int) -> tuple[Click, ...]:
        """Clicks of the frames from `first` to before `end`."""
        condition = "WHERE frame >= ? AND frame < ? AND deleted = 0 ORDER BY frame"
        return self._clicks(condition, first, end)

    def all(self, *, with_deleted: bool = False) -> tuple[Click, ...]:
        """All clicks by frame."""
        condition = "" if with_deleted else "WHERE deleted = 0"
        return self._clicks(f"{condition} ORDER BY frame, camera, landmark")

    def used(self, first: int = 0, end: int = 2**62) -> tuple[Click, ...]:
        """Those of :meth:`between` in cameras that are not left out."""
        return self._clicks(
            "WHERE frame >= ? AND frame < ? AND deleted = 0 AND camera NOT IN"
            " (SELECT camera FROM camera_use WHERE used = 0 AND deleted = 0) ORDER BY frame",
            *(first, end),
        )

    def frames(self) -> IntArray:
        """Frames (F,) that have a click, ascending."""
        found = self._access.rows(
            "SELECT DISTINCT frame FROM click WHERE deleted = 0 ORDER BY frame"
        )
        return np.array([row[0] for row in found], dtype=np.int64)

    def count(self) -> int:
        """Number of clicks."""
        count: int = self._access.row("SELECT count(*) FROM click WHERE deleted = 0")[0]
        return count

    def seen(self, first: int = 0, end: int = 2**62) -> tuple[Seen, ...]:
        """Every landmark at every frame from `first` to before `end`, over all cameras."""
        rows = self._access.rows(
            "SELECT frame, landmark, sum(x IS NOT NULL), max(flag = ?) FROM click"
            " WHERE frame >= ? AND frame < ? AND deleted = 0 GROUP BY frame, landmark",
            (UNCERTAIN, first, end),
        )
        return tuple(Seen(row[0], row[1], row[2], bool(row[3])) for row in rows)

    def doubted_frames(self) -> frozenset[int]:
        """Frames with a click that its author doubts."""
        flagged = "SELECT DISTINCT frame FROM click WHERE flag = ? AND flag <> '' AND deleted = 0"
        rows = self._access.rows(flagged, (UNCERTAIN,))
        return frozenset(row[0] for row in rows)

    def again(self) -> tuple[Click, ...]:
        """Clicks of the second, blind reading."""
        return self._clicks("WHERE deleted = 0 ORDER BY frame", table="repeat_click")

    def again_at(self, frame: int) -> tuple[Click, ...]:
        """Clicks of one frame in the blind reading."""
        return tuple(one for one in self.again() if one.frame == frame)

    def repeat_differences(self) -> tuple[Difference, ...]:
        """First against second readings of frames that were annotated again.

        What was accepted at first is left out: a person's reading of it is the first one.
        """
        second = self.again()
        frames = sorted({click.frame for click in second})
        found = differences([one for frame in frames for one in self.at(frame)], second)
        return tuple(one for one in found if one.first is None or not one.first.accepted)

    def _clicks(self, condition: str, *values: Value, table: str = "click") -> tuple[Click, ...]:
        rows = self._access.rows(
            f"SELECT {CLICK.columns} FROM {table} {condition}",  # noqa: S608 - constants
            values,
        )
        with making_sense(self._access.path):
            return tuple(_click(row) for row in rows)


def _place_text(keys: Sequence[ClickKey]) -> str:
    """Where clicks are: ``left elbow in N_right, frame 213``."""
    landmarks = {key.landmark.replace("_", " ") for key in keys}
    cameras = {key.camera for key in keys}
    frames = sorted({key.frame for key in keys})
    what = next(iter(landmarks)) if len(landmarks) == 1 else f"{len(landmarks)} landmarks"
    where = next(iter(cameras)) if len(cameras) == 1 else f"{len(cameras)} cameras"
    when = f"frame {frames[0]}" if len(frames) == 1 else f"frames {frames[0]} to {frames[-1]}"
    return f"{what} in {where}, {when}"


def _present(state: State, keys: Iterable[ClickKey]) -> Iterable[Click]:
    """The clicks of these keys that are there and not deleted."""
    for key in keys:
        values = state.row(CLICK, key)
        if values is not None and not (click := _click((*key, *values))).deleted:
            yield click


def _set(state: State, click: Click, stamp: Stamp) -> Change:
    """The change that lets `click` stand, unless it says what stands there."""
    before = state.row(CLICK, click.key)
    if before is not None and _click((*click.key, *before)).says_the_same(click):
        return Change(CLICK, click.key, before, before)
    return Change(CLICK, click.key, before, _values(click, stamp))


def _restated(state: State, click: Click, stamp: Stamp, **changes: Any) -> Change:
    """The change to a click by whoever makes the edit."""
    return _set(state, replace(click, who="", at="", **changes), stamp)


def place_clicks(clicks: Sequence[Click], words: str = "") -> Edit:
    """Set clicks, whether the landmarks had one before or not.

    Those without author and time get the project's. Without `words` they are told from the clicks.
    """

    def changes(state: State, stamp: Stamp) -> Iterable[Change]:
        return (_set(state, click, stamp) for click in clicks)

    words = words or f"place {_place_text([click.key for click in clicks])}"
    return Edit("place clicks", words, changes)


def place(click: Click) -> Edit:
    """Set one click."""
    return place_clicks((click,))


def move_clicks(keys: Sequence[ClickKey], by: tuple[float, float]) -> Edit:
    """Move existing clicks in their image, in pixels; they are a person's own then."""
    if not all(map(math.isfinite, by)):
        raise ValueError(f"{by} is not a displacement in an image")

    def changes(state: State, stamp: Stamp) -> Iterable[Change]:
        for click in _present(state, keys):
            if click.position is not None:
                position = (click.position[0] + by[0], click.position[1] + by[1])
                yield _restated(state, click, stamp, position=position, origin="hand")

    return Edit("move clicks", f"move {_place_text(keys)}", changes)


def delete_clicks(keys: Sequence[ClickKey]) -> Edit:
    """Take clicks away; that they were taken away is kept as a fact. Missing ones are passed."""

    def changes(state: State, stamp: Stamp) -> Iterable[Change]:
        for click in _present(state, keys):
            yield _restated(state, click, stamp, deleted=True)

    return Edit("delete clicks", f"delete {_place_text(keys)}", changes)


def mark_clicks(
    keys: Sequence[ClickKey],
    *,
    visibility: Visibility | None = None,
    flag: str | None = None,
    sigma: float | None = None,
    usual_sigma: bool = False,
) -> Edit:
    """State how existing clicks are seen, how sure they are (pixels per axis), or flag them.

    `OUTSIDE` takes the position away, an empty flag the flag, `usual_sigma` a stated sigma.
    """
    if sigma is not None and not 0 < sigma < math.inf:
        what = f"{sigma:g} px is not a valid click uncertainty"
        raise InputError(what, remedy="Enter a number above 0.")

    def changes(state: State, stamp: Stamp) -> Iterable[Change]:
        for click in _present(state, keys):
            seen = click.visibility if visibility is None else visibility
            outside = seen == Visibility.OUTSIDE
            if click.position is None and not outside:
                what = f"{_place_text([click.key])} is outside the image and has no position"
                raise InputError(what, remedy="Click its position instead.")
            known = click.sigma if sigma is None else sigma
            stated: dict[str, Any] = {
                "position": None if outside else click.position,
                "visibility": seen,
                "flag": click.flag if flag is None else flag,
                "sigma": None if usual_sigma else known,
            }
            yield _restated(state, click, stamp, **stated)

    said = [
        "" if visibility is None else visibility.name.lower(),
        "" if flag is None else flag or "not flagged",
        "" if sigma is None else f"uncertainty {sigma:g} px",
        "usual uncertainty" if usual_sigma else "",
    ]
    words = f"mark {_place_text(keys)}, as {', '.join(filter(None, said))}"
    return Edit("mark clicks", words, changes)


def swap_landmarks(frame: int, camera: str, first: str, second: str) -> Edit:
    """Exchange the clicks of two landmarks in one image; a lone click changes its landmark."""
    keys = [ClickKey(frame, camera, name) for name in (first, second)]

    def changes(state: State, stamp: Stamp) -> Iterable[Change]:
        found = [next(iter(_present(state, [key])), None) for key in keys]
        for here, there in ((0, 1), (1, 0)):
            click, own = found[there], found[here]
            if click is not None:
                yield _restated(state, click, stamp, landmark=keys[here].landmark)
            elif own is not None:
                yield _restated(state, own, stamp, deleted=True)

    names = f"{first} and {second}".replace("_", " ")
    return Edit("swap landmarks", f"swap {names} in {camera}, frame {frame}", changes)


_ROUND = 1  # of blind repeats, whose table has room for more


def blind_repeat(edit: Edit) -> Edit:
    """An edit of clicks in the blind reading; the first reading is not touched."""

    def changes(state: State, stamp: Stamp) -> Iterable[Change]:
        for change in edit.changes(_Reading(state.database), stamp):
            yield replace(change, table=REPEAT_CLICK, key=(_ROUND, *change.key))

    return Edit("place repeats", f"{edit.words}, blind repeat", changes)


class _Reading(State):
    """The project with the clicks of the second reading in place of the first."""

    def row(self, table: Table, key: Row) -> Row | None:
        return super().row(REPEAT_CLICK, (_ROUND, *key)) if table is CLICK else None


_DETECTORS = f"SELECT DISTINCT source FROM {KEYPOINT}"  # noqa: S608 - a constant


def accept_points(
    predictions: Sequence[Prediction], *, even_deleted: bool = False, left_open: str = ""
) -> Edit:
    """Let predictions be clicks, noted as accepted; where a person has clicked, that click stays.

    Those of a detector that the project has keypoints of are noted as such. The last of several
    counts. With `even_deleted`, also where somebody has taken a click away.
    `left_open`: what was not certain enough, in words without a full stop.
    """

    def changes(state: State, stamp: Stamp) -> Iterable[Change]:
        detectors = {one for (one,) in state.database.execute(_DETECTORS)}
        for prediction in predictions:
            before = state.row(CLICK, prediction.key)
            if before is None or (before[-1] and even_deleted):
                outside = prediction.visibility == Visibility.OUTSIDE
                position = None if outside else prediction.position
                origin = DETECTED if prediction.source in detectors else ACCEPTED
                click = Click(*prediction.key, position, prediction.visibility, origin=origin)
                yield Change(CLICK, prediction.key, before, _values(click, stamp))

    words = f"accept {_place_text([one.key for one in predictions])}"
    return Edit("accept predictions", f"{words}; {left_open}" if left_open else words, changes)

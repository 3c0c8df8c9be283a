"""Clicks: as rows of their tables, and read by frame and camera, by landmark, or all of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from stereotrack_core.annotation.click import UNCERTAIN, Click, ClickKey, Visibility
from stereotrack_core.annotation.progress import Seen
from stereotrack_core.arrays import IntArray
from stereotrack_core.project.connection import Access
from stereotrack_core.project.edit import Stamp
from stereotrack_core.project.schema import CLICK, Row, Value

COLUMNS = CLICK.columns


def click_of(row: Sequence[Any]) -> Click:
    """The click of a row in the order of :data:`COLUMNS`."""
    frame, camera, landmark, x, y, visibility, flag, sigma, origin, who, at, deleted = row
    return Click(
        frame=frame,
        camera=camera,
        landmark=landmark,
        position=None if x is None else (x, y),
        visibility=Visibility(visibility),
        flag=flag,
        sigma=sigma,
        origin=origin,
        who=who,
        at=at,
        deleted=bool(deleted),
    )


def values_of(click: Click, stamp: Stamp) -> Row:
    """Values of a click's row; who and when are filled in where it does not say them itself."""
    x, y = click.position or (None, None)
    return (
        None if x is None else float(x),
        None if y is None else float(y),
        int(click.visibility),
        click.flag,
        None if click.sigma is None else float(click.sigma),
        click.origin,
        click.who or stamp.who,
        click.at or stamp.at,
        int(click.deleted),
    )


def click_in(key: Row, values: Row) -> Click:
    """The click of a row's key (with or without round) and values."""
    return click_of((*key[-3:], *values))


def taken_away(click: Click) -> Click:
    """The click as deleted, to be stamped anew."""
    return replace(click, deleted=True, who="", at="")


def place_in_words(keys: Sequence[ClickKey]) -> str:
    """Where clicks are: ``left elbow in N_right, frame 213``."""
    landmarks = {key.landmark for key in keys}
    cameras = {key.camera for key in keys}
    frames = sorted({key.frame for key in keys})
    what = _named(next(iter(landmarks))) if len(landmarks) == 1 else f"{len(landmarks)} landmarks"
    where = next(iter(cameras)) if len(cameras) == 1 else f"{len(cameras)} cameras"
    when = f"frame {frames[0]}" if len(frames) == 1 else f"frames {frames[0]} to {frames[-1]}"
    return f"{what} in {where}, {when}"


def _named(landmark: str) -> str:
    return landmark.replace("_", " ")


_FROM = f"SELECT {COLUMNS} FROM click"  # noqa: S608 - constants
_AGAIN = f"SELECT {COLUMNS} FROM repeat_click"  # noqa: S608 - constants


class Clicks:
    """What people have clicked. Deleted clicks are left out where not said otherwise."""

    def __init__(self, access: Access) -> None:
        self._access = access

    def get(self, key: ClickKey) -> Click | None:
        """One click, also a deleted one; None where there never was one."""
        values = self._access.read(CLICK, key)
        with self._access.making_sense():
            return None if values is None else click_in(key, values)

    def at(self, frame: int, camera: str | None = None) -> tuple[Click, ...]:
        """Clicks of a frame, of all cameras or of one."""
        if camera is None:
            return self._clicks(f"{_FROM} WHERE frame = ? AND deleted = 0", frame)
        return self._clicks(
            f"{_FROM} WHERE frame = ? AND camera = ? AND deleted = 0", frame, camera
        )

    def deleted_at(self, frame: int) -> tuple[Click, ...]:
        """Clicks of a frame that were taken away."""
        return self._clicks(f"{_FROM} WHERE frame = ? AND deleted = 1", frame)

    def between(self, first: int, end: int) -> tuple[Click, ...]:
        """Clicks of the frames from `first` to before `end`."""
        return self._clicks(
            f"{_FROM} WHERE frame >= ? AND frame < ? AND deleted = 0 ORDER BY frame", first, end
        )

    def nearest(self, key: ClickKey, *, backwards: bool = False) -> Click | None:
        """The landmark's next (previous) click in the same camera; None where there is none."""
        sign, order = ("<", "DESC") if backwards else (">", "ASC")
        found = self._clicks(
            f"{_FROM} WHERE landmark = ? AND camera = ? AND frame {sign} ? AND deleted = 0"
            f" ORDER BY frame {order} LIMIT 1",
            *(key.landmark, key.camera, key.frame),
        )
        return found[0] if found else None

    def all(self, *, with_deleted: bool = False) -> tuple[Click, ...]:
        """All clicks by frame."""
        condition = "" if with_deleted else "WHERE deleted = 0"
        return self._clicks(f"{_FROM} {condition} ORDER BY frame, camera, landmark")

    def keys(self) -> frozenset[ClickKey]:
        """Everything that a person has said something about: deleted clicks too."""
        rows = self._access.rows("SELECT frame, camera, landmark FROM click")
        return frozenset(ClickKey(*row) for row in rows)

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

    def seen(self, first: int = 0, end: int | None = None) -> tuple[Seen, ...]:
        """Every landmark at every frame that has one, summed up over the cameras.

        Parameters
        ----------
        first, end : int
            Frames from `first` to before `end`; all without them.
        """
        rows = self._access.rows(
            "SELECT frame, landmark, sum(x IS NOT NULL), max(flag = ?) FROM click"
            " WHERE frame >= ? AND frame < ? AND deleted = 0 GROUP BY frame, landmark",
            (UNCERTAIN, first, 2**62 if end is None else end),
        )
        return tuple(Seen(row[0], row[1], row[2], bool(row[3])) for row in rows)

    def doubted_frames(self) -> frozenset[int]:
        """Frames with a click that its author doubts."""
        rows = self._access.rows(
            "SELECT DISTINCT frame FROM click WHERE flag = ? AND flag <> '' AND deleted = 0",
            (UNCERTAIN,),
        )
        return frozenset(row[0] for row in rows)

    def again(self, round_number: int | None = None) -> tuple[Click, ...]:
        """Clicks of second, blind readings: of one round, or of all of them."""
        if round_number is None:
            return self._clicks(f"{_AGAIN} WHERE deleted = 0 ORDER BY round, frame")
        return self._clicks(f"{_AGAIN} WHERE round = ? AND deleted = 0", round_number)

    def again_at(self, round_number: int, frame: int) -> tuple[Click, ...]:
        """Clicks of one frame in a blind reading."""
        return self._clicks(
            f"{_AGAIN} WHERE round = ? AND frame = ? AND deleted = 0", round_number, frame
        )

    def rounds(self) -> tuple[int, ...]:
        """The blind readings that there are."""
        found = self._access.rows(
            "SELECT DISTINCT round FROM repeat_click WHERE deleted = 0 ORDER BY round"
        )
        return tuple(row[0] for row in found)

    def _clicks(self, statement: str, *values: Value) -> tuple[Click, ...]:
        rows = self._access.rows(statement, values)
        with self._access.making_sense():
            return tuple(click_of(row) for row in rows)

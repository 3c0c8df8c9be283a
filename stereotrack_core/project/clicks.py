"""Read clicks: by frame and camera, by landmark, all of them."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterable
from threading import RLock

import numpy as np

from stereotrack_core.annotation.click import Click, ClickKey
from stereotrack_core.arrays import IntArray
from stereotrack_core.project.click_rows import COLUMNS, click_in, click_of
from stereotrack_core.project.rows import Value
from stereotrack_core.project.schema import CLICK

_FROM = f"SELECT {COLUMNS} FROM click"  # noqa: S608 - constants
_AGAIN = f"SELECT {COLUMNS} FROM repeat_click"  # noqa: S608 - constants


class Clicks:
    """What people have clicked. Deleted clicks are left out where not said otherwise."""

    def __init__(self, database: sqlite3.Connection, lock: RLock) -> None:
        self._database = database
        self._lock = lock

    def get(self, key: ClickKey) -> Click | None:
        """One click, also a deleted one; None where there never was one."""
        with self._lock:
            values = CLICK.read(self._database, key)
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

    def of_landmark(self, landmark: str, camera: str) -> tuple[Click, ...]:
        """Clicks of a landmark in one camera, over the frames."""
        return self._clicks(
            f"{_FROM} WHERE landmark = ? AND camera = ? AND deleted = 0 ORDER BY frame",
            *(landmark, camera),
        )

    def all(self, *, with_deleted: bool = False) -> tuple[Click, ...]:
        """All clicks by frame."""
        condition = "" if with_deleted else "WHERE deleted = 0"
        return self._clicks(f"{_FROM} {condition} ORDER BY frame, camera, landmark")

    def frames(self) -> IntArray:
        """Frames (F,) that have a click, ascending."""
        with self._lock:
            found = self._database.execute(
                "SELECT DISTINCT frame FROM click WHERE deleted = 0 ORDER BY frame"
            ).fetchall()
        return np.array([row[0] for row in found], dtype=np.int64)

    def count(self) -> int:
        """Number of clicks."""
        with self._lock:
            count: int = self._database.execute(
                "SELECT count(*) FROM click WHERE deleted = 0"
            ).fetchone()[0]
        return count

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
        with self._lock:
            found: Iterable[tuple[int]] = self._database.execute(
                "SELECT DISTINCT round FROM repeat_click WHERE deleted = 0 ORDER BY round"
            ).fetchall()
        return tuple(row[0] for row in found)

    def _clicks(self, statement: str, *values: Value) -> tuple[Click, ...]:
        with self._lock:
            rows = self._database.execute(statement, values).fetchall()
        return tuple(click_of(row) for row in rows)

"""What 2-D detectors have predicted, kept in a table of its own, apart from clicks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from stereotrack_core.annotation.click import Prediction
from stereotrack_core.project.connection import Access
from stereotrack_core.project.schema import KEYPOINT, Value
from stereotrack_core.recording.keypoints import Keypoints, keypoints_of, rows_of


@dataclass(frozen=True, eq=False)
class DetectorState:
    """All that a project keeps of some detectors."""

    sources: tuple[str, ...]
    """Names of the detectors."""
    keypoints: Keypoints
    proposed: tuple[Prediction, ...]
    """Landmarks that they propose as clicks."""


class StoredKeypoints:
    """Read and replace predicted keypoints. They are no edits: nothing of a person's is lost."""

    def __init__(self, access: Access) -> None:
        self._access = access

    def sources(self) -> dict[str, int]:
        """Number of rows by detector."""
        if not self._there():
            return {}
        rows = self._access.rows(f"SELECT source, count(*) FROM {KEYPOINT} GROUP BY source")  # noqa: S608
        return {str(source): int(count) for source, count in rows}

    def cameras(self) -> tuple[str, ...]:
        """Cameras that anything is predicted of."""
        if not self._there():
            return ()
        rows = self._access.rows(f"SELECT DISTINCT camera FROM {KEYPOINT} ORDER BY camera")  # noqa: S608
        return tuple(str(camera) for (camera,) in rows)

    def all(self, source: str | None = None) -> Keypoints:
        """All rows, or those of one detector."""
        return self._rows() if source is None else self._rows("source = ?", source)

    def at(self, frame: int) -> Keypoints:
        """Rows of one frame."""
        return self._rows("frame = ?", frame)

    def replace(self, keypoints: Keypoints) -> int:
        """Let these be all rows of their detectors in their cameras; how many there are.

        Raises InputError where the project cannot be written to.
        """
        places = zip(keypoints.source.tolist(), keypoints.camera.tolist(), strict=True)
        with self._access.writing() as database:
            database.executemany(
                f"DELETE FROM {KEYPOINT} WHERE source = ? AND camera = ?",  # noqa: S608
                sorted(set(places)),
            )
            database.executemany(_INSERT, rows_of(keypoints))
        return len(keypoints)

    def state(self, sources: Sequence[str]) -> DetectorState:
        """What is kept of these detectors, to be put back by :meth:`put`."""
        rows, marks = keypoints_of(()), ", ".join("?" * len(sources))
        if self._there():
            rows = self._rows(f"source IN ({marks})", *sources)
        proposed = self._access.rows(
            "SELECT frame, camera, landmark, source, x, y, sigma FROM prediction"  # noqa: S608
            f" WHERE source IN ({marks}) ORDER BY frame",
            tuple(sources),
        )
        return DetectorState(
            tuple(sources),
            rows,
            tuple(
                Prediction(frame, camera, landmark, source, (x, y), sigma)
                for frame, camera, landmark, source, x, y, sigma in proposed
            ),
        )

    def put(self, state: DetectorState) -> None:
        """Let this be all that is kept of some detectors; all of it, or nothing is written.

        Nothing is proposed where a person has said anything. Raises InputError where the project
        cannot be written to.
        """
        own = [(source,) for source in state.sources]
        with self._access.writing() as database:
            for table in (KEYPOINT, "prediction"):
                database.executemany(f"DELETE FROM {table} WHERE source = ?", own)  # noqa: S608
            database.executemany(_INSERT, rows_of(state.keypoints))
            database.executemany(
                "INSERT OR REPLACE INTO prediction VALUES (?, ?, ?, ?, ?, ?, ?)",
                (
                    (*one.key, one.source, *map(float, one.position), one.sigma)
                    for one in state.proposed
                ),
            )
            database.executemany(
                "DELETE FROM prediction WHERE source = ? AND EXISTS (SELECT 1 FROM click WHERE"
                " click.frame = prediction.frame AND click.camera = prediction.camera"
                " AND click.landmark = prediction.landmark)",
                own,
            )

    def _rows(self, condition: str = "1", *values: Value) -> Keypoints:
        if not self._there():
            return keypoints_of(())
        rows = self._access.rows(
            "SELECT frame, camera, keypoint, x, y, confidence, source, person"  # noqa: S608
            f" FROM {KEYPOINT} WHERE {condition} ORDER BY frame",
            values,
        )
        return keypoints_of(rows)

    def _there(self) -> bool:
        """Whether the project has the table: one of format 1 that is only read has none."""
        found = self._access.row(
            "SELECT 1 FROM sqlite_schema WHERE type = 'table' AND name = ?", (KEYPOINT,)
        )
        return found is not None


_INSERT = (
    f"INSERT OR REPLACE INTO {KEYPOINT} (frame, camera, keypoint, x, y, confidence,"  # noqa: S608
    " source, person) VALUES (?, ?, ?, ?, ?, ?, ?, ?)"
)

"""What 2-D detectors have predicted, kept in a table of its own, apart from clicks."""

from __future__ import annotations

from stereotrack_core.project.connection import Access
from stereotrack_core.project.schema import KEYPOINT
from stereotrack_core.recording.keypoints import Keypoints, keypoints_of, rows_of


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
        return self._rows("1" if source is None else "source = ?", source)

    def at(self, frame: int) -> Keypoints:
        """Rows of one frame."""
        return self._rows("frame = ?", frame)

    def replace(self, keypoints: Keypoints) -> int:
        """Let these be all rows of their detectors; how many there are.

        Raises InputError where the project cannot be written to.
        """
        with self._access.writing() as database:
            for source in sorted(set(keypoints.source.tolist())):
                database.execute(f"DELETE FROM {KEYPOINT} WHERE source = ?", (source,))  # noqa: S608
            database.executemany(
                f"INSERT OR REPLACE INTO {KEYPOINT} (frame, camera, keypoint, x, y, confidence,"  # noqa: S608
                " source, person) VALUES (?, ?, ?, ?, ?, ?, ?, ?)",
                rows_of(keypoints),
            )
        return len(keypoints)

    def forget(self, source: str) -> int:
        """Take a detector's rows away; how many there were."""
        count = self.sources().get(source, 0)
        if count:
            with self._access.writing() as database:
                database.execute(f"DELETE FROM {KEYPOINT} WHERE source = ?", (source,))  # noqa: S608
        return count

    def _rows(self, condition: str, value: str | int | None) -> Keypoints:
        if not self._there():
            return keypoints_of(())
        rows = self._access.rows(
            "SELECT frame, camera, keypoint, x, y, confidence, source, person"  # noqa: S608
            f" FROM {KEYPOINT} WHERE {condition} ORDER BY frame",
            () if value is None else (value,),
        )
        return keypoints_of(rows)

    def _there(self) -> bool:
        """Whether the project has the table: one of format 1 that is only read has none."""
        found = self._access.row(
            "SELECT 1 FROM sqlite_schema WHERE type = 'table' AND name = ?", (KEYPOINT,)
        )
        return found is not None

"""What programs place: kept apart from clicks, replaced at will, never taken for a person's."""

from __future__ import annotations

from collections.abc import Iterable

from stereotrack_core.annotation.prediction import Prediction
from stereotrack_core.project.access import Access


class Predictions:
    """Read and replace predictions. They are no edits: nothing of a person's is lost by them."""

    def __init__(self, access: Access) -> None:
        self._access = access

    def at(self, frame: int) -> tuple[Prediction, ...]:
        """Predictions of all sources at a frame."""
        rows = self._access.rows(
            "SELECT frame, camera, landmark, source, x, y, sigma FROM prediction WHERE frame = ?",
            (frame,),
        )
        return tuple(
            Prediction(frame, camera, landmark, source, (x, y), sigma)
            for frame, camera, landmark, source, x, y, sigma in rows
        )

    def sources(self) -> tuple[str, ...]:
        """Everything that predictions come from."""
        rows = self._access.rows("SELECT DISTINCT source FROM prediction ORDER BY source")
        return tuple(row[0] for row in rows)

    def replace(self, source: str, predictions: Iterable[Prediction]) -> None:
        """Let these be all predictions of a source.

        Raises
        ------
        ValueError
            Where one of them names another source.
        """
        rows = [(*p.key, p.source, *map(float, p.position), p.sigma) for p in predictions]
        if any(row[3] != source for row in rows):
            raise ValueError(f"not all predictions are of {source!r}")
        with self._access.writing() as database:
            database.execute("DELETE FROM prediction WHERE source = ?", (source,))
            database.executemany("INSERT INTO prediction VALUES (?, ?, ?, ?, ?, ?, ?)", rows)

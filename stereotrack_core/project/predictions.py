"""What programs place: kept apart from clicks, replaced at will, never taken for a person's."""

from __future__ import annotations

from collections.abc import Iterable

from stereotrack_core.annotation.prediction import Prediction
from stereotrack_core.project.connection import Access
from stereotrack_core.project.schema import Value
from stereotrack_core.project.validity import LARGEST_REAL

_FROM = "SELECT frame, camera, landmark, source, x, y, sigma FROM prediction"


class Predictions:
    """Read and replace predictions. They are no edits: nothing of a person's is lost by them."""

    def __init__(self, access: Access) -> None:
        self._access = access

    def at(self, frame: int) -> tuple[Prediction, ...]:
        """Predictions of all sources at a frame."""
        return self._predictions("WHERE frame = ?", frame)

    def of_source(self, source: str) -> tuple[Prediction, ...]:
        """All predictions of a source, by frame."""
        return self._predictions("WHERE source = ? ORDER BY frame", source)

    def sources(self) -> tuple[str, ...]:
        """Everything that predictions come from."""
        rows = self._access.rows("SELECT DISTINCT source FROM prediction ORDER BY source")
        return tuple(row[0] for row in rows)

    def replace(
        self, source: str, predictions: Iterable[Prediction], *, frames: range | None = None
    ) -> None:
        """Let these be all predictions of a source, in these frames or altogether.

        Those that are nowhere near an image are left out.

        Raises
        ------
        ValueError
            Where one of them names another source, or is of another frame.
        """
        rows = [
            (*p.key, p.source, *map(float, p.position), p.sigma)
            for p in predictions
            if all(abs(value) <= LARGEST_REAL for value in p.position)
        ]
        if any(row[3] != source for row in rows):
            raise ValueError(f"not all predictions are of {source!r}")
        if frames is not None and any(row[0] not in frames for row in rows):
            raise ValueError(f"not all predictions are of the frames {frames}")
        low, high = (0, 2**62) if frames is None else (frames.start, frames.stop)
        with self._access.writing() as database:
            database.execute(
                "DELETE FROM prediction WHERE source = ? AND frame >= ? AND frame < ?",
                (source, low, high),
            )
            database.executemany("INSERT INTO prediction VALUES (?, ?, ?, ?, ?, ?, ?)", rows)

    def _predictions(self, condition: str, value: Value) -> tuple[Prediction, ...]:
        rows = self._access.rows(f"{_FROM} {condition}", (value,))
        return tuple(
            Prediction(frame, camera, landmark, source, (x, y), sigma)
            for frame, camera, landmark, source, x, y, sigma in rows
        )

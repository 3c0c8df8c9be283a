"""What programs place: kept apart from clicks, replaced at will, never taken for a person's."""

from __future__ import annotations

from collections.abc import Collection, Iterable

from stereotrack_core.annotation.click import ClickKey, Prediction
from stereotrack_core.project.clicks import AcceptPredictions
from stereotrack_core.project.connection import Access
from stereotrack_core.project.schema import Value
from stereotrack_core.project.validity import LARGEST_REAL


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

    def places(self) -> dict[int, frozenset[str]]:
        """Landmarks that something is predicted of, by frame."""
        rows = self._access.rows("SELECT DISTINCT frame, landmark FROM prediction")
        found: dict[int, set[str]] = {}
        for frame, landmark in rows:
            found.setdefault(int(frame), set()).add(str(landmark))
        return {frame: frozenset(names) for frame, names in found.items()}

    def replace(
        self, source: str, predictions: Iterable[Prediction], *, frames: range | None = None
    ) -> int:
        """Let these be all predictions of a source, in these frames or altogether; how many.

        None is kept where a person has said anything (a click, that it is outside, that a click
        was wrong), and none that is nowhere near an image.

        Raises InputError where the project cannot be written to; ValueError where one of them is of
        another source, or another frame.
        """
        predictions = tuple(predictions)
        if any(one.source != source for one in predictions):
            raise ValueError(f"not all predictions are of {source!r}")
        if frames is not None and any(one.frame not in frames for one in predictions):
            raise ValueError(f"not all predictions are of the frames {frames}")
        rows = [
            (*one.key, source, *map(float, one.position), one.sigma)
            for one in self._unclicked(predictions)
            if all(abs(value) <= LARGEST_REAL for value in one.position)
        ]
        low, high = (0, 2**62) if frames is None else (frames.start, frames.stop)
        with self._access.writing() as database:
            database.execute(
                "DELETE FROM prediction WHERE source = ? AND frame >= ? AND frame < ?",
                (source, low, high),
            )
            database.executemany("INSERT INTO prediction VALUES (?, ?, ?, ?, ?, ?, ?)", rows)
        return len(rows)

    def acceptance(
        self, source: str, frames: range | None = None, landmarks: Collection[str] = ()
    ) -> AcceptPredictions | None:
        """The edit that makes clicks of a source's predictions; None where there are none to take.

        Those of all frames and landmarks, or of these; places that a person has said anything
        about are left out.
        """
        chosen = tuple(
            one
            for one in self._unclicked(self.of_source(source))
            if (frames is None or one.frame in frames)
            and (not landmarks or one.landmark in landmarks)
        )
        return AcceptPredictions(chosen) if chosen else None

    def _unclicked(self, predictions: Iterable[Prediction]) -> list[Prediction]:
        """Those of places that nobody has said anything about, not even that it is nothing."""
        rows = self._access.rows("SELECT frame, camera, landmark FROM click")
        said = {ClickKey(*row) for row in rows}
        return [one for one in predictions if one.key not in said]

    def _predictions(self, condition: str, value: Value) -> tuple[Prediction, ...]:
        rows = self._access.rows(
            f"SELECT frame, camera, landmark, source, x, y, sigma FROM prediction {condition}",  # noqa: S608 - constants
            (value,),
        )
        return tuple(
            Prediction(frame, camera, landmark, source, (x, y), sigma)
            for frame, camera, landmark, source, x, y, sigma in rows
        )

"""Keypoints of detectors and predictions of landmarks, as a project keeps them."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from stereotrack_core.annotation.click import FARTHEST, ClickKey, Prediction, Visibility
from stereotrack_core.project.connection import Access
from stereotrack_core.project.database import making_sense
from stereotrack_core.project.schema import KEYPOINT, Row, Value
from stereotrack_core.recording.keypoints import Keypoints, keypoints_of, rows_of


class Predictions:
    """Read and replace predictions. They are no edits: nothing of a person's is lost by them."""

    def __init__(self, access: Access) -> None:
        self._access = access

    def at(self, frame: int) -> tuple[Prediction, ...]:
        """Predictions of all sources at a frame."""
        return self._predictions("WHERE frame = ?", frame)

    def of_source(self, *sources: str) -> tuple[Prediction, ...]:
        """All predictions of a source, or of several, by frame."""
        marks = ", ".join("?" * len(sources))
        return self._predictions(f"WHERE source IN ({marks}) ORDER BY frame", *sources)

    def places(self) -> dict[int, frozenset[str]]:
        """Landmarks that something is predicted of, by frame."""
        rows = self._access.rows("SELECT DISTINCT frame, landmark FROM prediction")
        found: dict[int, frozenset[str]] = {}
        for frame, landmark in rows:
            found[frame] = found.get(frame, frozenset()) | {landmark}
        return found

    def replace(
        self, source: str, predictions: Iterable[Prediction], *, frames: range | None = None
    ) -> int:
        """Let these be all predictions of a source, in these frames or altogether; how many.

        None is kept where a person has said anything, or far from an image. Raises InputError.
        """
        new = self.unclicked(predictions)
        rows = [_row(one) for one in new if max(map(abs, one.position)) <= FARTHEST]
        low, high = (0, 2**62) if frames is None else (frames.start, frames.stop)
        with self._access.writing() as database:
            stretch = "DELETE FROM prediction WHERE source = ? AND frame >= ? AND frame < ?"
            database.execute(stretch, (source, low, high))
            database.executemany("INSERT INTO prediction VALUES (?, ?, ?, ?, ?, ?, ?, ?)", rows)
        return len(rows)

    def unclicked(self, predictions: Iterable[Prediction]) -> list[Prediction]:
        """Those of places that nobody has said anything about, not even that it is nothing."""
        rows = self._access.rows("SELECT frame, camera, landmark FROM click")
        said = {ClickKey(*row) for row in rows}
        return [one for one in predictions if one.key not in said]

    def _predictions(self, condition: str, *values: Value) -> tuple[Prediction, ...]:
        rows = self._access.rows(
            "SELECT frame, camera, landmark, source, x, y, sigma, visibility FROM prediction "  # noqa: S608 - constants
            f"{condition}",
            values,
        )
        with making_sense(self._access.path):
            return tuple(
                Prediction(frame, camera, landmark, source, (x, y), sigma, Visibility(seen))
                for frame, camera, landmark, source, x, y, sigma, seen in rows
            )


def _row(one: Prediction) -> Row:
    place = map(float, one.position)
    return (*one.key, one.source, *place, one.sigma, int(one.visibility))


@dataclass(frozen=True, eq=False)
class DetectorState:
    """All that a project keeps of some detectors."""

    sources: tuple[str, ...]  # names of the detectors
    keypoints: Keypoints
    proposed: tuple[Prediction, ...]  # landmarks that they propose as clicks


class StoredKeypoints:
    """Read and replace predicted keypoints. They are no edits: nothing of a person's is lost."""

    def __init__(self, access: Access) -> None:
        self._access = access

    def sources(self) -> dict[str, int]:
        """Number of rows by detector."""
        rows = self._access.rows(f"SELECT source, count(*) FROM {KEYPOINT} GROUP BY source")  # noqa: S608
        return {str(source): int(count) for source, count in rows}

    def cameras(self) -> tuple[str, ...]:
        """Cameras that anything is predicted of."""
        rows = self._access.rows(f"SELECT DISTINCT camera FROM {KEYPOINT} ORDER BY camera")  # noqa: S608
        return tuple(str(camera) for (camera,) in rows)

    def all(self, source: str | None = None) -> Keypoints:
        """All rows, or those of one detector."""
        return self._rows() if source is None else self._rows("source = ?", source)

    def at(self, frame: int) -> Keypoints:
        """Rows of one frame."""
        return self._rows("frame = ?", frame)

    def state(self, sources: Sequence[str]) -> DetectorState:
        """Content by these detectors, to be put back by :meth:`put`."""
        rows = self._rows(f"source IN ({', '.join('?' * len(sources))})", *sources)
        proposed = Predictions(self._access).of_source(*sources)
        return DetectorState(tuple(sources), rows, proposed)

    def put(self, state: DetectorState) -> None:
        """Let this be all of some detectors, without what a person has clicked; or do nothing."""
        own = [(source,) for source in state.sources]
        with self._access.writing() as database:
            for table in (KEYPOINT, "prediction"):
                database.executemany(f"DELETE FROM {table} WHERE source = ?", own)  # noqa: S608
            database.executemany(
                f"INSERT OR REPLACE INTO {KEYPOINT} ({_COLUMNS}) VALUES (?, ?, ?, ?, ?, ?, ?, ?)",  # noqa: S608
                rows_of(state.keypoints),
            )
            insert = "INSERT OR REPLACE INTO prediction VALUES (?, ?, ?, ?, ?, ?, ?, ?)"
            database.executemany(insert, map(_row, state.proposed))
            database.executemany(
                "DELETE FROM prediction WHERE source = ? AND EXISTS (SELECT 1 FROM click WHERE"
                " click.frame = prediction.frame AND click.camera = prediction.camera"
                " AND click.landmark = prediction.landmark)",
                own,
            )

    def _rows(self, condition: str = "1", *values: Value) -> Keypoints:
        rows = self._access.rows(
            f"SELECT {_COLUMNS} FROM {KEYPOINT} WHERE {condition} ORDER BY frame",  # noqa: S608
            values,
        )
        with making_sense(self._access.path):
            return keypoints_of(rows)


_COLUMNS = "frame, camera, keypoint, x, y, confidence, source, person"

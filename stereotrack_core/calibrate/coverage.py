"""How much of a camera's image the board has reached, and how it was held."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import BoolArray
from stereotrack_core.calibrate.board_pose import tilts
from stereotrack_core.calibrate.sightings import Sightings
from stereotrack_core.errors import Finding
from stereotrack_core.geometry.transform import RigidTransform

_COLUMNS, _ROWS = 8, 6
_LEAST_SHARE = 0.6
_LEAST_BAND = 0.35  # share of the cells along a side of the image
_SMALL, _LARGE = 0.2, 0.4  # share of the image that a board should fill at least, and well


@dataclass(frozen=True, eq=False)
class Coverage:
    """Cells (6, 8) of the image that hold corners; tilt and distances of the boards.

    `tilt_deg` is the largest angle between a board's normal and their mean; distances in metres.
    """

    cells: BoolArray
    tilt_deg: float
    nearest_m: float
    farthest_m: float
    fills: float = float("nan")
    """Share of the image's width or height, the larger one, that the board fills in the median."""

    @property
    def advice(self) -> str:
        """What to film where the lens is not known well enough.

        The focal length shows by how the sides of a tilted board differ, in proportion to the
        square of the board's size in the image.
        """
        turned = (
            "tilt the board by 30 to 45 degrees to all sides, and bring it into every corner of "
            "the image."
        )
        if not self.fills < _SMALL:
            return f"Film again, near and far: {turned}"
        distance = 0.5 * (self.nearest_m + self.farthest_m) * self.fills / _LARGE
        return (
            f"The board is too small in the pictures: it fills {100 * self.fills:.0f} % of the "
            f"image. Film again with the board about {distance:.1f} m away, where it fills "
            f"{100 * _LARGE:.0f} %, or with a larger board: {turned}"
        )

    @property
    def share(self) -> float:
        """Share of the image's cells that hold a corner."""
        return float(self.cells.mean())

    def findings(self) -> Iterator[Finding]:
        """What the board has not reached."""
        bands = {
            "left": self.cells[:, :1],
            "right": self.cells[:, -1:],
            "top": self.cells[:1],
            "bottom": self.cells[-1:],
        }
        empty = [name for name, band in bands.items() if band.mean() < _LEAST_BAND]
        if empty:
            yield Finding(
                "warning",
                "",
                f"the board hardly came to the {' and '.join(empty)} of the image",
                "The distortion there is a guess: film the board there too.",
            )
        elif self.share < _LEAST_SHARE:
            yield Finding(
                "warning",
                "",
                f"the board covered only {100 * self.share:.0f} % of the image",
                "Film it in the other parts of the image too.",
            )


def coverage_of(sightings: Sightings, poses: Sequence[RigidTransform]) -> Coverage:
    """What pictures with the boards at `poses` (camera_from_board) cover."""
    seen = sightings.pixels[np.isfinite(sightings.pixels[..., 0])]
    place = (seen + 0.5) / sightings.size * (_COLUMNS, _ROWS)
    column, row = np.clip(place.astype(int), 0, (_COLUMNS - 1, _ROWS - 1)).T
    cells = np.zeros((_ROWS, _COLUMNS), dtype=bool)
    cells[row, column] = True
    distance = [float(np.linalg.norm(pose.translation)) for pose in poses]
    tilt = float(np.degrees(tilts(poses).max())) if len(poses) else 0.0
    near, far = min(distance, default=np.nan), max(distance, default=np.nan)
    return Coverage(cells, tilt, near, far, _filled(sightings))


def _filled(sightings: Sightings) -> float:
    """Median share of the image's width or height, the larger one, between a board's corners."""
    if not len(sightings):
        return float("nan")
    span = np.nanmax(sightings.pixels, axis=1) - np.nanmin(sightings.pixels, axis=1)
    return float(np.median((span / sightings.size).max(axis=1)))

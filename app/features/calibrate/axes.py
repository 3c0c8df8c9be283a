"""What says where up, north and the origin are, and the world that follows from it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal, TypeAlias

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.calibrate.align import ORIGIN, POINTS, Alignment, from_board, from_clicks
from stereotrack_core.calibrate.board import Board
from stereotrack_core.calibrate.pictures import Sightings
from stereotrack_core.calibrate.world_checks import seen_board
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.geometry.triangulation import Sightings as SeenPoint
from stereotrack_core.geometry.triangulation import point_of_sightings

AxesWay: TypeAlias = Literal["first", "board", "floor", "points", "recording"]
PointClicks: TypeAlias = Mapping[str, Mapping[str, tuple[float, float]]]
"""Raw pixels of points of the floor, by the point and the camera."""


@dataclass(frozen=True, eq=False)
class Axes:
    """What a person chose to turn the world by."""

    way: AxesWay = "first"
    board_frame: int = -1
    """Number of the pictures in which the board lies on the floor."""
    frame: int = 0
    """The frame that shows the floor, and in which its points are clicked."""
    north: str = ""
    """Camera in the north for the floor; empty for that of the first view."""
    floor: Alignment | None = None
    """That of the floor in the depth of the open recording."""
    clicks: PointClicks = field(default_factory=dict)
    point: str = ORIGIN
    """The point that the next click places."""
    camera: str = ""
    """The camera whose picture is shown for clicking."""

    def clicked_in(self, point: str) -> tuple[str, ...]:
        """Cameras in which a point is clicked."""
        return tuple(self.clicks.get(point, {}))

    def with_click(self, camera: str, point: str, pixel: tuple[float, float] | None) -> PointClicks:
        """The clicks with one placed elsewhere, or without it."""
        own = {name: at for name, at in self.clicks.get(point, {}).items() if name != camera}
        if pixel is not None:
            own[camera] = pixel
        return {**self.clicks, point: own}

    def next_point(self, clicks: PointClicks) -> str:
        """The first point without a click in the picture that is shown; else the same as now."""
        left = (one for one in POINTS if self.camera not in clicks.get(one, {}))
        return next(left, self.point)


def alignment_by_clicks(axes: Axes, cameras: Mapping[str, Camera]) -> Alignment:
    """By three points of the floor; raises InputError where they are not placed."""
    clicks = {
        point: {name: np.array(at) for name, at in own.items() if name in cameras}
        for point, own in axes.clicks.items()
    }
    return from_clicks(cameras, clicks)


def alignment_by_board(
    axes: Axes,
    cameras: Mapping[str, Camera],
    board: Board,
    places: Mapping[int, RigidTransform] | None,
    sightings: Sequence[Sightings],
) -> Alignment:
    """By a board on the floor: one that is placed, or that calibrated cameras see.

    Raises InputError where it is not chosen, or cannot be placed.
    """
    frame = axes.board_frame
    seeing = [one for one in sightings if frame in one.frames and one.camera in cameras]
    if (places is not None and frame not in places) or (places is None and not seeing):
        raise InputError(
            "the picture in which the board lies on the floor is not chosen",
            where="axes",
            remedy="Choose it in the list. The board has to be found in the pictures first.",
        )
    if places is not None:
        return from_board(places[frame], board.corners)
    alone = [one.only(np.flatnonzero(one.frames == frame)) for one in seeing]
    return from_board(seen_board(cameras, alone, board).world_from_board, board.corners)


def alignment_by_floor(axes: Axes) -> Alignment:
    """By the floor that was looked for; raises InputError where none is found."""
    if axes.floor is None:
        raise InputError(
            "no floor is found in the depth of the recording",
            where="axes",
            remedy="Choose another way, or a frame in which much of the floor is seen.",
        )
    return axes.floor


def points_in(
    cameras: Mapping[str, Camera], clicks: Mapping[str, tuple[float, float]], camera: str
) -> FloatArray:
    """Where a point is in a camera's picture by its clicks in others: one place, or a line.

    Parameters
    ----------
    clicks : mapping from str to tuple of float
        Of one point, by camera.

    Returns
    -------
    (K, 2) raw pixels; nothing without a click in another camera.
    """
    others = [name for name in clicks if name != camera and name in cameras]
    if camera not in cameras or not others:
        return np.empty((0, 2))
    pixels = np.array([clicks[name] for name in others])
    if len(others) > 1:
        seen = SeenPoint.of([cameras[name] for name in others], pixels, np.ones(len(others)))
        point = point_of_sightings(seen)
        found = np.empty((0, 3)) if point is None else point.world[None]
    else:
        other = cameras[others[0]]
        along = np.geomspace(_NEAREST_M, _FARTHEST_M, _SAMPLES)[:, None]
        found = other.position_world + along * other.rays_world(pixels[0])
    places = cameras[camera].project(found)
    known: FloatArray = places[np.isfinite(places).all(axis=1)]
    return known


_NEAREST_M, _FARTHEST_M, _SAMPLES = 0.3, 20.0, 150
"""Metres from a camera within which a point of the floor is looked for."""

"""What a calibration of several cameras is worth: uncertainty, scale, contradictions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.calibrate.board import Board
from stereotrack_core.calibrate.bundle import Bundle
from stereotrack_core.calibrate.sightings import Sightings
from stereotrack_core.counting import counted
from stereotrack_core.errors import Finding, InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.rotation import skew
from stereotrack_core.geometry.triangulation import nearest_to_rays

_NOISE_PX = 0.1
_UNKNOWN_M, _VAGUE_M = 0.1, 0.005  # standard deviation of a camera's place
_FEW_SHARED = 5
_CONTRADICTS = 2.5  # how much larger a camera's error is than the others'
_WRONG_SCALE = 0.01
_REFILM = (
    "Film again with the board in 15 positions or more that this camera and another one see at the "
    "same time, near and far, tilted to all sides."
)


@dataclass(frozen=True)
class ScaleCheck:
    """Sides of squares triangulated by two cameras or more, compared with the board.

    `ratio` of measured to given length; `spread_m` their standard deviation; NaN without any.
    """

    ratio: float
    spread_m: float
    count: int


def place_sigmas(bundle: Bundle) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Standard deviations of place (metres, of the worst axis) and rotation (radians).

    Of every camera relative to the first, whose own are 0.
    """
    positions, rotations = [], []
    for i, camera in enumerate(bundle.cameras):
        if not camera.pose_free:
            positions.append(0.0)
            rotations.append(0.0)
            continue
        own = bundle.covariance_of(i)[-6:, -6:]
        if not np.isfinite(own).all():
            positions.append(float("inf"))
            rotations.append(float("inf"))
            continue
        pose = camera.camera_from_world
        change = -pose.rotation.T @ np.hstack([skew(pose.translation), np.eye(3)])
        place = change @ own @ change.T
        positions.append(_widest(place))
        rotations.append(_widest(own[:3, :3]))
    return tuple(positions), tuple(rotations)


def _widest(covariance: FloatArray) -> float:
    return float(np.sqrt(max(np.linalg.eigvalsh(covariance)[-1], 0.0)))


def check_places(bundle: Bundle, sightings: Sequence[Sightings]) -> None:
    """Refuse cameras whose place is not determined; raises InputError with what to film."""
    factor = max(1.0, _NOISE_PX * np.sqrt(2.0) / max(bundle.rms, 1e-12))
    for own, sigma in zip(sightings, place_sigmas(bundle)[0], strict=True):
        if not factor * sigma < _UNKNOWN_M:
            known = f"only known to {100 * factor * sigma:.0f} cm" if sigma < 10 else "not known"
            raise InputError(f"its place is {known}", where=f"camera {own.camera}", remedy=_REFILM)


def scale_check(
    cameras: Sequence[Camera], sightings: Sequence[Sightings], board: Board
) -> ScaleCheck:
    """Triangulate every corner that several cameras see and measure the squares."""
    frames = sorted({int(frame) for one in sightings for frame in one.frames})
    number = {frame: i for i, frame in enumerate(frames)}
    shape = (len(frames), len(board.corners), len(cameras), 3)
    directions = np.full(shape, np.nan)
    for c, (camera, one) in enumerate(zip(cameras, sightings, strict=True)):
        rows = [number[int(frame)] for frame in one.frames]
        directions[rows, :, c] = camera.rays_world(one.pixels)
    places = np.array([camera.position_world for camera in cameras])
    points = nearest_to_rays(np.broadcast_to(places, shape), directions)
    ends = points[:, board.neighbours]
    lengths = np.linalg.norm(ends[:, :, 1] - ends[:, :, 0], axis=-1)
    lengths = lengths[np.isfinite(lengths)]
    if not lengths.size:
        return ScaleCheck(float("nan"), float("nan"), 0)
    return ScaleCheck(
        float(np.median(lengths) / board.square), float(lengths.std()), int(lengths.size)
    )


def world_findings(
    sightings: Sequence[Sightings],
    rms: Sequence[float],
    position_sigma: Sequence[float],
    shared: IntArray,
    scale: ScaleCheck,
) -> list[Finding]:
    """What looks wrong about the result, and what to do."""
    found = []
    usual = float(np.median(rms))
    for i, own in enumerate(sightings):
        where = f"camera {own.camera}"
        if rms[i] > max(_CONTRADICTS * usual, 0.5):
            what = f"its error of {rms[i]:.2f} px is {rms[i] / usual:.1f} times the usual one"
            remedy = (
                "It may be out of step with the others, have moved, or be mirrored. Check that "
                "frame k of all cameras is the same instant, and film again."
            )
            found.append(Finding("warning", where, what, remedy))
        if position_sigma[i] > _VAGUE_M:
            what = f"its place is only known to {1000 * position_sigma[i]:.0f} mm"
            found.append(Finding("warning", where, what, _REFILM))
        most = int(shared[i].max(initial=0))
        if most < _FEW_SHARED:
            what = f"it saw the board together with another camera in {counted(most, 'frame')} only"
            found.append(Finding("warning", where, what, _REFILM))
    if np.isfinite(scale.ratio) and abs(scale.ratio - 1.0) > _WRONG_SCALE:
        found.append(
            Finding(
                "warning",
                "scale",
                f"squares measured with the cameras are {100 * (scale.ratio - 1):+z.1f} % longer "
                "than given",
                "Check that the board is flat and its squares are square, and measure their side.",
            )
        )
    return found


def distances(cameras: Sequence[Camera]) -> list[tuple[str, str, float]]:
    """Distances in metres between all pairs of cameras, to be checked with a tape measure."""
    return [
        (a.name, b.name, float(np.linalg.norm(a.position_world - b.position_world)))
        for a, b in combinations(cameras, 2)
    ]

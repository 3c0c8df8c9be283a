"""Quality of a calibration of several cameras: uncertainty, scale, contradictions."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.calibrate.board import Board
from stereotrack_core.calibrate.bundle import Bundle, BundleCamera, adjusted, rms_of
from stereotrack_core.calibrate.connection import corner_errors
from stereotrack_core.calibrate.detection import board_poses
from stereotrack_core.calibrate.lens import lens_of
from stereotrack_core.calibrate.pictures import Sightings
from stereotrack_core.counting import counted
from stereotrack_core.errors import Finding, InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.rotation import skew
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.geometry.triangulation import nearest_to_rays
from stereotrack_core.recording.description import Cameras

_LEAST_FACTOR, _SPREADS = 2.5, 5.0
_LEAST_OFF_PX = 0.3  # pictures that lie off by less are as good as any
_FAR_CORNER = 6.0  # standard deviations from which a single corner is an outlier
_LEAST_CORNER_PX = 0.5
_NORMAL = 1.4826  # standard deviations of a normal distribution in a median deviation


def outlying_views(errors: FloatArray, most: int) -> tuple[list[int], list[str]]:
    """Rows of at most so many pictures far worse than usual by errors (F, n, 2), and reasons."""
    rms = np.array([rms_of(one) for one in errors])
    if len(rms) < 3:
        return [], []
    level = np.log(np.maximum(rms, 1e-9))
    usual = float(np.nanmedian(level))
    spread = _NORMAL * float(np.nanmedian(np.abs(level - usual)))
    limit = max(np.exp(usual + max(_SPREADS * spread, np.log(_LEAST_FACTOR))), _LEAST_OFF_PX)
    rows = [int(i) for i in np.argsort(-rms) if rms[i] > limit][: max(most, 0)]
    reasons = []
    for i in rows:
        few = np.nanmedian(np.linalg.norm(errors[i], axis=1)) < 0.3 * rms[i]
        cause = "some corners are in wrong places" if few else "blurred, bent or wrongly detected"
        said = f"its corners lie {rms[i]:.2f} px off, usual are {np.exp(usual):.2f} px: {cause}"
        reasons.append(said)
    return rows, reasons


def without_far_corners(sightings: Sightings, errors: FloatArray) -> Sightings:
    """The same with single corners that lie far off made unseen."""
    length = np.linalg.norm(errors, axis=-1)
    scale = float(np.nanmedian(length)) / 1.1774  # median of Rayleigh's distribution
    far = length > max(_FAR_CORNER * scale, _LEAST_CORNER_PX)
    usual = far.mean(axis=1) < 0.2  # where more are off the whole picture is judged
    far &= usual[:, None]
    if not far.any():
        return sightings
    pixels = sightings.pixels.copy()
    pixels[far] = np.nan
    return replace(sightings, pixels=pixels)


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
    """Sides of squares, triangulated, over the board's; deviation in metres; NaN of none."""

    ratio: float
    spread_m: float
    count: int


def place_sigmas(bundle: Bundle) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Standard deviations of places (m, worst axis) and rotations (rad) against the first one."""
    sigmas = np.zeros((len(bundle.cameras), 2))
    for i, camera in enumerate(bundle.cameras):
        if not camera.pose_free:
            continue
        own = bundle.covariance_of(i)[-6:, -6:]
        if not np.isfinite(own).all():
            sigmas[i] = np.inf
            continue
        pose = camera.camera_from_world
        change = -pose.rotation.T @ np.hstack([skew(pose.translation), np.eye(3)])
        widest = np.linalg.eigvalsh([change @ own @ change.T, own[:3, :3]])[:, -1]
        sigmas[i] = np.sqrt(np.maximum(widest, 0.0))
    positions, rotations = sigmas.T.tolist()
    return tuple(positions), tuple(rotations)


def check_places(bundle: Bundle, sightings: Sequence[Sightings]) -> None:
    """Refuse cameras whose place is not determined; raises InputError with what to film."""
    factor = max(1.0, _NOISE_PX * np.sqrt(2.0) / max(bundle.rms, 1e-12))
    for own, sigma in zip(sightings, place_sigmas(bundle)[0], strict=True):
        if not factor * sigma < _UNKNOWN_M:
            known = f"only known to {100 * factor * sigma:.0f} cm" if sigma < 10 else "not known"
            raise InputError(f"its place is {known}", f"camera {own.camera}", _REFILM)


def scale_check(
    cameras: Sequence[Camera], sightings: Sequence[Sightings], board: Board
) -> ScaleCheck:
    """Triangulate every corner that several cameras see and measure the squares."""
    frames = sorted({int(frame) for one in sightings for frame in one.frames})
    shape = (len(frames), len(board.corners), len(cameras), 3)
    directions = np.full(shape, np.nan)
    for c, (camera, one) in enumerate(zip(cameras, sightings, strict=True)):
        directions[np.searchsorted(frames, one.frames), :, c] = camera.rays_world(one.pixels)
    places = np.array([camera.position_world for camera in cameras])
    points = nearest_to_rays(np.broadcast_to(places, shape), directions)
    ends = points[:, board.neighbours]
    lengths = np.linalg.norm(ends[:, :, 1] - ends[:, :, 0], axis=-1)
    lengths = lengths[np.isfinite(lengths)]
    if not lengths.size:
        return ScaleCheck(float("nan"), float("nan"), 0)
    ratio = float(np.median(lengths) / board.square)
    return ScaleCheck(ratio, float(lengths.std()), int(lengths.size))


def world_findings(
    sightings: Sequence[Sightings],
    rms: Sequence[float],
    position_sigma: Sequence[float],
    shared: IntArray,
    scale: ScaleCheck,
) -> list[Finding]:
    """Findings about the result."""
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
    if abs(scale.ratio - 1.0) > _WRONG_SCALE:
        longer = f"{100 * (scale.ratio - 1):+z.1f} % longer than given"
        what = f"squares measured with the cameras are {longer}"
        remedy = "Check that the board is flat and its squares are square, and measure their side."
        found.append(Finding("warning", "scale", what, remedy))
    return found


def distances(cameras: Sequence[Camera]) -> list[tuple[str, str, float]]:
    """Distances in metres between all pairs of cameras, to be checked with a tape measure."""
    apart = ((a, b, a.position_world - b.position_world) for a, b in combinations(cameras, 2))
    return [(a.name, b.name, float(np.linalg.norm(off))) for a, b, off in apart]


_MOST_PX = 5.0


@dataclass(frozen=True, eq=False)
class SeenBoard:
    """Place of a board, its error in pixels, and its squares measured by the cameras."""

    world_from_board: RigidTransform
    rms_px: float
    scale: ScaleCheck
    cameras: tuple[str, ...]


def seen_board(cameras: Cameras, sightings: Sequence[Sightings], board: Board) -> SeenBoard:
    """The board of the last frame that most cameras see. Raises InputError."""
    known = [one for one in sightings if one.camera in cameras and len(one)]
    counts = Counter(int(frame) for one in known for frame in one.frames)
    if not counts:
        remedy = "Name the videos or folders as the cameras, and check the size of the board."
        raise InputError("no camera of the calibration sees the board", "--board-on-floor", remedy)
    frame = max(counts, key=lambda one: (counts[one], one))
    seeing = [one.only(np.flatnonzero(one.frames == frame)) for one in known if frame in one.frames]
    seen_by = [_bundle_camera(cameras[one.camera], one) for one in seeing]
    poses = [(own, board_poses(own.lens, board.corners, own.pixels[0])) for own in seen_by]
    candidates = [one.camera_from_world.inverse() @ pose for one, own in poses for pose in own]
    if not candidates:
        raise InputError("the board cannot be placed", "--board-on-floor", "Use another picture.")
    best = min(candidates, key=lambda one: _cost(one, seen_by, board))
    found = adjusted(seen_by, [best], board.corners)
    if found.rms > _MOST_PX:
        raise InputError(
            f"{counted(len(seeing), 'camera')} that see the board contradict each other by "
            f"{found.rms:.0f} px",
            "--board-on-floor",
            "Check that the pictures were taken after the calibration, with no camera "
            "moved, and that picture k of all cameras is the same instant.",
        )
    names = tuple(one.camera for one in seeing)
    scale = scale_check([cameras[name] for name in names], seeing, board)
    return SeenBoard(found.boards[0], found.rms, scale, names)


def _bundle_camera(camera: Camera, sightings: Sightings) -> BundleCamera:
    lens = lens_of(camera, "Leave its pictures out of the folder.")
    nothing, first = np.zeros(lens.values.size, dtype=bool), np.zeros(1, dtype=np.int64)
    return BundleCamera(lens, camera.camera_from_world, first, sightings.pixels, nothing, False)


def _cost(world_from_board: RigidTransform, cameras: Sequence[BundleCamera], board: Board) -> float:
    """Sum over the cameras of the median error in pixels."""
    errors = (
        corner_errors(own.lens, own.camera_from_world @ world_from_board, own.pixels[0], board)
        for own in cameras
    )
    return sum(float(np.nanmedian(one)) for one in errors)

"""All cameras in one world, from boards that some of them saw together."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.calibrate.board import Board
from stereotrack_core.calibrate.bundle import Bundle, BundleCamera, adjusted, rms_of
from stereotrack_core.calibrate.connection import Connected, connected
from stereotrack_core.calibrate.intrinsics import (
    Intrinsics,
    calibrate_intrinsics,
    check_known,
)
from stereotrack_core.calibrate.lens import Lens, lens_of
from stereotrack_core.calibrate.pictures import Sightings
from stereotrack_core.calibrate.world_checks import (
    ScaleCheck,
    check_places,
    outlying_views,
    place_sigmas,
    scale_check,
    without_far_corners,
    world_findings,
)
from stereotrack_core.errors import Finding, InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.recording.description import Cameras

_LOSS_PX = 1.0
_ROUNDS = 3  # in which outlying pictures are looked for
_HELD_OUT = 5  # every fifth board is left out to measure what the cameras are worth
LOOKING_SOUTH = np.array([[-1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, -1.0, 0.0]])
"""world_from_camera of a level camera that looks south, as the view N does."""


@dataclass(frozen=True, eq=False)
class World:
    """Calibrated cameras in one frame, and what is known about them, per camera.

    `boards` are world_from_board by frame; `errors` (F, n, 2) pixels belong to `sightings`;
    standard deviations are relative to the first camera.
    """

    board: Board
    cameras: tuple[Camera, ...]
    lenses: tuple[Intrinsics | None, ...]  # None where the lens was given
    sightings: tuple[Sightings, ...]
    boards: Mapping[int, RigidTransform]
    errors: tuple[FloatArray, ...]
    rms_px: float
    held_out_px: float
    rms_by_camera: tuple[float, ...]
    held_out_by_camera: tuple[float, ...]
    position_sigma_m: tuple[float, ...]
    rotation_sigma_rad: tuple[float, ...]
    shared: IntArray  # (C, C) frames in which two cameras saw the board together
    scale: ScaleCheck
    findings: tuple[Finding, ...]


def calibrate_world(
    sightings: Sequence[Sightings], board: Board, model: str = "auto", given: Cameras | None = None
) -> World:
    """Calibrate cameras that saw boards, in the frame of the first one. Raises InputError.

    Lenses are `given` and stay, or are calibrated first and then together with all places. The
    first camera is put at the origin, level, looking south.
    """
    if len(sightings) < 2:
        remedy = "Give two cameras or more, or use `stereotrack calibrate intrinsics`."
        raise InputError("one camera has no place relative to others", "cameras", remedy)
    fits = [_lens(one, board, model, given or {}) for one in sightings]
    lenses = [fit.lens if isinstance(fit, Intrinsics) else fit for fit in fits]
    fixed = [not isinstance(fit, Intrinsics) for fit in fits]
    start = connected(sightings, lenses, board)
    bundle, used = _adjusted(start, lenses, fixed, board)
    for i, fit in enumerate(fits):
        if isinstance(fit, Intrinsics):
            sigma = np.sqrt(np.maximum(np.diag(bundle.covariance_of(i))[:4], 0.0))
            check_known(bundle.rms, sigma, bundle.cameras[i].lens, fit.coverage, used[i])
    check_places(bundle, used)
    held_out = _held_out(bundle, used, board)
    return _world(bundle, used, board, fits, held_out, start.shared)


def _world(
    bundle: Bundle,
    used: tuple[Sightings, ...],
    board: Board,
    fits: Sequence[Intrinsics | Lens],
    held_out: Sequence[FloatArray],
    shared: IntArray,
) -> World:
    """The result with all its measures; the first camera level and looking south."""
    cameras = tuple(
        one.lens.camera(own.camera, own.size, one.camera_from_world @ FIRST_FROM_WORLD)
        for one, own in zip(bundle.cameras, used, strict=True)
    )
    frames = _frames(used)
    world_from_first = FIRST_FROM_WORLD.inverse()
    boards = {f: world_from_first @ bundle.boards[i] for i, f in enumerate(frames)}
    positions, rotations = place_sigmas(bundle)
    scale = scale_check(cameras, used, board)
    own_rms = tuple(rms_of(one) for one in bundle.errors)
    everywhere = np.concatenate([one.reshape(-1, 2) for one in held_out])
    lenses = tuple(fit if isinstance(fit, Intrinsics) else None for fit in fits)
    own_findings = [one for lens in lenses if lens is not None for one in lens.findings]
    findings = (*own_findings, *world_findings(used, own_rms, positions, shared, scale))
    return World(
        board, cameras, lenses, used, boards, bundle.errors, bundle.rms, rms_of(everywhere),
        own_rms, tuple(map(rms_of, held_out)), positions, rotations, shared, scale, findings,
    )  # fmt: skip


FIRST_FROM_WORLD = RigidTransform(LOOKING_SOUTH.T, np.zeros(3))


def _lens(sightings: Sightings, board: Board, model: str, given: Cameras) -> Intrinsics | Lens:
    camera = given.get(sightings.camera)
    if camera is None:
        return calibrate_intrinsics(sightings, board, model=model, alone=False)
    if (camera.width, camera.height) != sightings.size:
        shown = f"the pictures are {sightings.size[0]}x{sightings.size[1]}"
        what = f"its lens was calibrated for {camera.width}x{camera.height}, {shown}"
        remedy = "Use the same picture size, or calibrate the lens again."
        raise InputError(what, f"camera {sightings.camera}", remedy)
    return lens_of(camera, "Leave it out of the given lenses, so that it is calibrated again.")


def _frames(sightings: Sequence[Sightings]) -> list[int]:
    return sorted({int(frame) for one in sightings for frame in one.frames})


def _adjusted(
    start: Connected, lenses: Sequence[Lens], fixed: Sequence[bool], board: Board
) -> tuple[Bundle, tuple[Sightings, ...]]:
    """Cameras and boards adjusted without the pictures that do not fit, and those that do."""
    used, poses, boards = start.sightings, start.cameras, dict(start.boards)
    lenses, most = list(lenses), [len(one) // 3 for one in used]
    for attempt in range(_ROUNDS + 1):
        last = attempt == _ROUNDS
        cameras = _bundle_cameras(used, lenses, poses, fixed)
        places = [boards[frame] for frame in _frames(used)]
        bundle = adjusted(cameras, places, board.corners, loss_scale=_LOSS_PX)
        lenses = [one.lens for one in bundle.cameras]
        poses = tuple(one.camera_from_world for one in bundle.cameras)
        boards = dict(zip(_frames(used), bundle.boards, strict=True))
        kept = []
        for i, (one, errors) in enumerate(zip(used, bundle.errors, strict=True)):
            clean = without_far_corners(one, errors)
            rows, reasons = outlying_views(errors, 0 if last else most[i])
            most[i] -= len(rows)
            kept.append(clean.without(rows, reasons))
        removed = sum(map(len, used)) - sum(map(len, kept))
        used = tuple(kept)
        if not removed:
            break
    cameras = _bundle_cameras(used, lenses, poses, fixed)
    places = [boards[frame] for frame in _frames(used)]
    return adjusted(cameras, places, board.corners), used


def _bundle_cameras(
    sightings: Sequence[Sightings],
    lenses: Sequence[Lens],
    poses: Sequence[RigidTransform],
    fixed: Sequence[bool],
) -> list[BundleCamera]:
    frames, each = _frames(sightings), zip(sightings, lenses, poses, fixed, strict=True)
    return [
        BundleCamera(
            lens, pose, np.searchsorted(frames, one.frames), one.pixels,
            lens.model.free & (not keep), pose_free=i > 0,
        )
        for i, (one, lens, pose, keep) in enumerate(each)
    ]  # fmt: skip


def _held_out(bundle: Bundle, sightings: Sequence[Sightings], board: Board) -> list[FloatArray]:
    """Errors (F, n, 2) by camera for every fifth board, left out but for its place; or empty."""
    frames = _frames(sightings)
    everyone = np.concatenate([camera.boards for camera in bundle.cameras])
    seen = np.bincount(everyone, minlength=len(frames))
    several = np.flatnonzero(seen > 1)
    out = set(several[_HELD_OUT // 2 :: _HELD_OUT].tolist())
    corners = len(board.corners)
    if len(several) - len(out) < 3 or not out:
        return [np.zeros((0, corners, 2)) for _ in bundle.cameras]
    left = [np.isin(camera.boards, list(out)) for camera in bundle.cameras]
    pairs = zip(bundle.cameras, left, strict=True)
    train = [replace(one, boards=one.boards[~own], pixels=one.pixels[~own]) for one, own in pairs]
    others = adjusted(train, bundle.boards, board.corners)
    test = [
        replace(
            found, boards=camera.boards[own], pixels=camera.pixels[own], pose_free=False,
            lens_free=np.zeros_like(found.lens_free),
        )
        for camera, found, own in zip(bundle.cameras, others.cameras, left, strict=True)
    ]  # fmt: skip
    return list(adjusted(test, bundle.boards, board.corners).errors)


@dataclass(frozen=True)
class Pair:
    """A stereo camera: base line, angle between the axes, rms row difference of `corners`."""

    left: str
    right: str
    baseline_m: float
    convergence_deg: float
    row_error_px: float
    corners: int


def pair_of(left: Camera, right: Camera, of_left: Sightings, of_right: Sightings) -> Pair:
    """Measure a stereo camera by corners that both saw. Raises InputError if exchanged."""
    offset = right.camera_from_world.apply(left.position_world)
    baseline = float(np.linalg.norm(offset))
    if offset[0] > 0.5 * baseline:
        what = f"left and right are exchanged: {left.name} stands to the right of {right.name}"
        remedy = "Exchange the two, as seen from behind the camera."
        raise InputError(what, "--left and --right", remedy)
    x = (right.position_world - left.position_world) / max(baseline, 1e-12)
    axes = np.array([one.camera_from_world.rotation[2] for one in (left, right)])
    y = np.cross(axes.sum(axis=0), x)
    y /= np.linalg.norm(y)
    rectified_from_world = np.stack([x, y, np.cross(x, y)])
    common = np.intersect1d(of_left.frames, of_right.frames)
    rows = []
    for camera, seen in ((left, of_left), (right, of_right)):
        pixels = seen.pixels[np.isin(seen.frames, common)]
        directions = camera.rays_world(pixels) @ rectified_from_world.T
        rows.append(directions[..., 1] / directions[..., 2])
    off = 0.5 * (left.focal + right.focal) * (rows[1] - rows[0])
    off = off[np.isfinite(off)]
    error = float(np.sqrt(np.mean(np.square(off)))) if off.size else float("nan")
    angle = float(np.degrees(np.arccos(np.clip(axes[0] @ axes[1], -1.0, 1.0))))
    return Pair(left.name, right.name, baseline, angle, error, int(off.size))

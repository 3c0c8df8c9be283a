"""One lens model fitted to one camera's pictures, and how far off unseen pictures are."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.calibrate.bundle import Bundle, BundleCamera, adjusted, rms_of
from stereotrack_core.calibrate.detection import likeliest_poses
from stereotrack_core.calibrate.lens import FISHEYE, RADIAL, Lens, LensModel
from stereotrack_core.geometry.transform import RigidTransform

_FOCALS = (0.3, 0.45, 0.65, 0.9, 1.3, 1.9, 2.8, 4.2)  # shares of the image's longer side
_START_VIEWS, _START_ROUNDS = 12, 12
_LOSS_PX, _FIRST_PX = 2.0, 20.0  # pixels from which errors count linearly, and from first lenses
_FOLDS = 5

Stop = Callable[[], bool]


@dataclass(frozen=True, eq=False)
class LensFit:
    """A lens, the boards before it, and their errors."""

    lens: Lens
    poses: tuple[RigidTransform, ...]  # camera_from_board
    bundle: Bundle

    @property
    def errors(self) -> FloatArray:
        """Errors (F, n, 2) in pixels."""
        return self.bundle.errors[0]

    @property
    def median_px(self) -> float:
        """Median length of the errors."""
        return float(np.nanmedian(np.linalg.norm(self.errors, axis=-1)))


@dataclass(frozen=True, eq=False)
class BoardPictures:
    """Pixels (F, n, 2) of a board's corners (n, 3) in pictures; NaN where unseen."""

    pixels: FloatArray
    corners: FloatArray
    stop: Stop = lambda: False

    def of(self, rows: BoolArray | IntArray | list[int]) -> BoardPictures:
        """Some of the pictures."""
        return replace(self, pixels=self.pixels[rows])


def fitted(
    lens: Lens,
    seen: BoardPictures,
    poses: tuple[RigidTransform, ...],
    *,
    free: BoolArray | None = None,
    loss_scale: float | None = None,
    rounds: int = 100,
) -> LensFit:
    """The lens, with its `free` values or those of its model, and the boards that fit pictures."""
    frames, free = np.arange(len(seen.pixels)), lens.model.free if free is None else free
    camera = BundleCamera(
        lens, RigidTransform.identity(), frames, seen.pixels, free, pose_free=False
    )
    bundle = adjusted(
        [camera], poses, seen.corners, loss_scale=loss_scale, rounds=rounds, cancelled=seen.stop
    )
    return LensFit(bundle.cameras[0].lens, bundle.boards, bundle)


def first_lens(seen: BoardPictures, size: tuple[int, int], *, fisheye: bool) -> Lens | None:
    """The best of several focal lengths with little or no distortion; None if none fits."""
    model = FISHEYE if fisheye else RADIAL
    some = seen.of(np.unique(np.linspace(0, len(seen.pixels) - 1, _START_VIEWS).astype(int)))
    best, cost = None, np.inf
    for share in _FOCALS:
        values = np.zeros(model.free.size)
        values[:2] = share * max(size)
        values[2:4] = (size[0] - 1) / 2, (size[1] - 1) / 2
        fit = _begun(Lens(model, values), some)
        if fit is not None and _is_possible(fit.lens, size) and fit.median_px < cost:
            best, cost = fit.lens, fit.median_px
    return best


def _begun(lens: Lens, seen: BoardPictures) -> LensFit | None:
    """The focal length, then all of the model, fitted to the pictures that can be placed."""
    found = likeliest_poses(lens, seen.corners, seen.pixels)
    placed = [i for i, pose in enumerate(found) if pose is not None]
    if 2 * len(placed) < len(found):
        return None
    seen, poses = seen.of(placed), tuple(pose for pose in found if pose is not None)
    focal_only = np.zeros(lens.values.size, dtype=bool)
    focal_only[:2] = True
    once = fitted(lens, seen, poses, free=focal_only, loss_scale=_FIRST_PX, rounds=_START_ROUNDS)
    return fitted(once.lens, seen, once.poses, loss_scale=_FIRST_PX, rounds=_START_ROUNDS)


def _is_possible(lens: Lens, size: tuple[int, int]) -> bool:
    focal, centre = lens.values[:2] / max(size), lens.values[2:4] / size
    within = ((focal > 0.05) & (focal < 100) & (centre > -0.5) & (centre < 1.5)).all()
    return bool(within and np.isfinite(lens.values).all())


def best_fit(model: LensModel, start: Lens, seen: BoardPictures) -> LensFit | None:
    """A model fitted to all pictures, robustly first; None where that does not lead anywhere."""
    lens = start.as_model(model)
    found = likeliest_poses(lens, seen.corners, seen.pixels)
    poses = tuple(pose for pose in found if pose is not None)
    if not poses or len(poses) < len(found):
        return None
    rough = fitted(lens, seen, poses, loss_scale=_LOSS_PX)
    fit = fitted(rough.lens, seen, rough.poses)
    return fit if np.isfinite(fit.lens.values).all() else None


def held_out_errors(fit: LensFit, seen: BoardPictures) -> FloatArray | None:
    """Mean squared errors (F,), px^2, of pictures the lens was not fitted to; None of too few."""
    count = len(seen.pixels)
    folds = min(_FOLDS, count)
    result, nothing = np.full(count, np.nan), np.zeros(fit.lens.values.size, dtype=bool)
    for k in range(folds):
        out = np.arange(count) % folds == k
        kept, left = (
            tuple(pose for pose, own in zip(fit.poses, rows, strict=True) if own)
            for rows in (~out, out)
        )
        if len(kept) < 2:
            return None
        others = fitted(fit.lens, seen.of(~out), kept)
        placed = fitted(others.lens, seen.of(out), left, free=nothing)
        result[out] = [rms_of(one) ** 2 for one in placed.errors]
    return result

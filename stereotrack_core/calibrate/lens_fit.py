"""One lens model fitted to one camera's pictures, and how far off unseen pictures are."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray
from stereotrack_core.calibrate.bundle import Bundle, BundleCamera, adjusted, rms_of
from stereotrack_core.calibrate.detection import likeliest_poses
from stereotrack_core.calibrate.lens import FISHEYE, RADIAL, Lens, LensModel
from stereotrack_core.geometry.transform import RigidTransform

_FOCALS = (0.3, 0.45, 0.65, 0.9, 1.3, 1.9, 2.8, 4.2)
"""Focal lengths that a search begins with, as shares of the image's longer side."""

_START_VIEWS, _START_ROUNDS = 12, 12
_LOSS_PX = 2.0
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


def fitted(
    lens: Lens,
    pixels: FloatArray,
    corners: FloatArray,
    *,
    free: BoolArray | None = None,
    poses: tuple[RigidTransform, ...] | None = None,
    loss_scale: float | None = None,
    rounds: int = 100,
    stop: Stop = lambda: False,
) -> LensFit | None:
    """The lens and the boards that fit pictures (F, n, 2); None where a board cannot be placed.

    `free` are the values that are estimated (default: those of the lens's model).
    """
    if poses is None:
        found = likeliest_poses(lens, corners, pixels)
        if not found or any(pose is None for pose in found):
            return None
        poses = tuple(pose for pose in found if pose is not None)
    camera = BundleCamera(
        lens,
        RigidTransform.identity(),
        np.arange(len(pixels)),
        pixels,
        lens.model.free if free is None else free,
        pose_free=False,
    )
    bundle = adjusted(
        [camera], poses, corners, loss_scale=loss_scale, rounds=rounds, cancelled=stop
    )
    return LensFit(bundle.cameras[0].lens, bundle.boards, bundle)


def first_lens(
    pixels: FloatArray, corners: FloatArray, size: tuple[int, int], *, fisheye: bool, stop: Stop
) -> Lens | None:
    """A lens to begin with: the best of several focal lengths with little or no distortion.

    None where the board cannot be placed with any of them.
    """
    model = FISHEYE if fisheye else RADIAL
    rows = np.unique(np.linspace(0, len(pixels) - 1, _START_VIEWS).astype(int))
    some, best, cost = pixels[rows], None, np.inf
    for share in _FOCALS:
        values = np.zeros(model.free.size)
        values[:2] = share * max(size)
        values[2:4] = (size[0] - 1) / 2, (size[1] - 1) / 2
        fit = _begun(Lens(model, values), some, corners, stop)
        if fit is not None and _is_possible(fit.lens, size):
            off = float(np.nanmedian(np.linalg.norm(fit.errors, axis=-1)))
            if off < cost:
                best, cost = fit.lens, off
    return best


def _begun(lens: Lens, pixels: FloatArray, corners: FloatArray, stop: Stop) -> LensFit | None:
    """The focal length, then all of the model, fitted to the pictures that can be placed."""
    found = likeliest_poses(lens, corners, pixels)
    placed = [i for i, pose in enumerate(found) if pose is not None]
    if 2 * len(placed) < len(pixels):
        return None
    poses = tuple(pose for pose in found if pose is not None)
    focal_only = np.zeros(lens.values.size, dtype=bool)
    focal_only[:2] = True
    fit = None
    for free in (focal_only, lens.model.free):
        fit = fitted(
            lens, pixels[placed], corners, free=free, poses=poses, loss_scale=10 * _LOSS_PX,
            rounds=_START_ROUNDS, stop=stop,
        )  # fmt: skip
        assert fit is not None  # noqa: S101 - poses were given
        lens, poses = fit.lens, fit.poses
    return fit


def _is_possible(lens: Lens, size: tuple[int, int]) -> bool:
    focal, centre = lens.values[:2] / max(size), lens.values[2:4] / size
    return bool(
        np.isfinite(lens.values).all()
        and (focal > 0.05).all()
        and (focal < 100).all()
        and (centre > -0.5).all()
        and (centre < 1.5).all()
    )


def best_fit(
    model: LensModel, start: Lens, pixels: FloatArray, corners: FloatArray, stop: Stop
) -> LensFit | None:
    """A model fitted to all pictures, robustly first; None where that does not lead anywhere."""
    rough = fitted(start.as_model(model), pixels, corners, loss_scale=_LOSS_PX, stop=stop)
    if rough is None:
        return None
    fit = fitted(rough.lens, pixels, corners, poses=rough.poses, stop=stop)
    return fit if fit is not None and np.isfinite(fit.lens.values).all() else None


def held_out_errors(
    fit: LensFit, pixels: FloatArray, corners: FloatArray, stop: Stop
) -> FloatArray | None:
    """Mean squared errors (F,) of pictures that the lens was not fitted to, square pixels.

    Every fifth picture is left out in turn; with the lens of the others only the board's place is
    fitted to it. None where there are too few pictures.
    """
    count = len(pixels)
    folds = min(_FOLDS, count)
    result = np.full(count, np.nan)
    for k in range(folds):
        out = np.arange(count) % folds == k
        kept = tuple(pose for pose, gone in zip(fit.poses, out, strict=True) if not gone)
        if len(kept) < 2:
            return None
        others = fitted(fit.lens, pixels[~out], corners, poses=kept, stop=stop)
        assert others is not None  # noqa: S101 - poses were given
        result[out] = view_errors(others.lens, fit, pixels, corners, out, stop)
    return result


def view_errors(
    lens: Lens, fit: LensFit, pixels: FloatArray, corners: FloatArray, rows: BoolArray, stop: Stop
) -> FloatArray:
    """Mean squared errors of some pictures with a given lens, the boards' places fitted."""
    poses = tuple(pose for pose, own in zip(fit.poses, rows, strict=True) if own)
    nothing = np.zeros(lens.values.size, dtype=bool)
    placed = fitted(lens, pixels[rows], corners, free=nothing, poses=poses, stop=stop)
    assert placed is not None  # noqa: S101 - poses were given
    return np.array([rms_of(one) ** 2 for one in placed.errors])

"""One camera's lens from its pictures: which pictures, which model, and how well it is known."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.calibrate.board import Board
from stereotrack_core.calibrate.bundle import Bundle, BundleCamera, adjusted, rms_of
from stereotrack_core.calibrate.detection import likeliest_poses, tilts
from stereotrack_core.calibrate.lens import (
    BROWN,
    BROWN5,
    FISHEYE,
    LENS_MODELS,
    RADIAL,
    Lens,
    LensModel,
)
from stereotrack_core.calibrate.pictures import Sightings
from stereotrack_core.calibrate.world_checks import outlying_views, without_far_corners
from stereotrack_core.counting import counted
from stereotrack_core.errors import Finding, InputError, did_you_mean
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform

_FOCALS = (0.3, 0.45, 0.65, 0.9, 1.3, 1.9, 2.8, 4.2)  # shares of the image's longer side
_START_VIEWS, _START_ROUNDS = 12, 12
_LOSS_PX, _FIRST_PX = 2.0, 20.0  # pixels from which errors count linearly, and from first lenses
_FOLDS = 5


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
    still = RigidTransform.identity()
    camera = BundleCamera(lens, still, frames, seen.pixels, free, pose_free=False)
    bundle = adjusted([camera], poses, seen.corners, loss_scale=loss_scale, rounds=rounds)
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
        if fit is None or not np.isfinite(fit.lens.values).all():
            continue
        focal, centre = fit.lens.values[:2] / max(size), fit.lens.values[2:4] / size
        possible = (focal > 0.05) & (focal < 100) & (centre > -0.5) & (centre < 1.5)
        if possible.all() and fit.median_px < cost:
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
        kept = tuple(pose for pose, left in zip(fit.poses, out, strict=True) if not left)
        left = tuple(fit.poses[k::folds])
        if len(kept) < 2:
            return None
        others = fitted(fit.lens, seen.of(~out), kept)
        placed = fitted(others.lens, seen.of(out), left, free=nothing)
        result[out] = [rms_of(one) ** 2 for one in placed.errors]
    return result


_COLUMNS, _ROWS = 8, 6
_LEAST_SHARE = 0.6
_LEAST_BAND = 0.35  # share of the cells along a side of the image
_SMALL, _LARGE = 0.2, 0.4  # share of the image that a board should fill at least, and well
_TILT = "tilt the board by 30 to 45 degrees to all sides"
_CORNERS = "bring it into every corner of the image."


@dataclass(frozen=True, eq=False)
class Coverage:
    """Cells (6, 8) of the image that hold corners; tilt (degrees) and distances of the boards."""

    cells: BoolArray
    tilt_deg: float
    nearest_m: float
    farthest_m: float
    fills: float = float("nan")  # share of the image's width or height that the board fills, median

    @property
    def advice(self) -> str:
        """Advice on filming: tilted boards show the focal length, large ones better."""
        if not self.fills < _SMALL:
            return f"Film again, near and far: {_TILT}, and {_CORNERS}"
        distance = 0.5 * (self.nearest_m + self.farthest_m) * self.fills / _LARGE
        return (
            f"The board is too small in the pictures: it fills {100 * self.fills:.0f} % of the "
            f"image. Film again with the board about {distance:.1f} m away, where it fills "
            f"{100 * _LARGE:.0f} %, or with a larger board: {_TILT}, and {_CORNERS}"
        )

    @property
    def share(self) -> float:
        """Share of the image's cells that hold a corner."""
        return float(self.cells.mean())

    def findings(self) -> Iterator[Finding]:
        """Parts of the image that the board has not reached."""
        own = self.cells
        bands = {"left": own[:, :1], "right": own[:, -1:], "top": own[:1], "bottom": own[-1:]}
        empty = [name for name, band in bands.items() if band.mean() < _LEAST_BAND]
        if empty:
            what = f"the board hardly came to the {' and '.join(empty)} of the image"
            remedy = "The distortion there is a guess: film the board there too."
            yield Finding("warning", "", what, remedy)
        elif self.share < _LEAST_SHARE:
            what = f"the board covered only {100 * self.share:.0f} % of the image"
            yield Finding("warning", "", what, "Film it in the other parts of the image too.")


def coverage_of(sightings: Sightings, poses: Sequence[RigidTransform]) -> Coverage:
    """Coverage by one picture or more with the boards at `poses` (camera_from_board)."""
    seen = sightings.pixels[np.isfinite(sightings.pixels[..., 0])]
    place = (seen + 0.5) / sightings.size * (_COLUMNS, _ROWS)
    column, row = np.clip(place.astype(int), 0, (_COLUMNS - 1, _ROWS - 1)).T
    cells = np.zeros((_ROWS, _COLUMNS), dtype=bool)
    cells[row, column] = True
    distance = [float(np.linalg.norm(pose.translation)) for pose in poses]
    tilt = float(np.degrees(tilts(poses).max()))
    span = np.nanmax(sightings.pixels, axis=1) - np.nanmin(sightings.pixels, axis=1)
    fills = float(np.median((span / sightings.size).max(axis=1)))
    return Coverage(cells, tilt, min(distance), max(distance), fills)


_LEAST_VIEWS, _FEW_VIEWS, _MOST_VIEWS = 4, 12, 60
_ROUNDS = 3  # in which outlying pictures are looked for
_PENALTY = 4.0
_WORTH = 0.01  # share by which a model's held-out error may be above the least one
_NOISE_PX = 0.1  # error per axis that corners have at least, whatever the fit says
_UNKNOWN_FOCAL, _VAGUE_FOCAL = 0.02, 0.003  # shares of the focal length
_LEAST_TILT_DEG = 12.0
_REFILM = f"Film again: {_TILT}, near and far, and {_CORNERS}"


@dataclass(frozen=True)
class Candidate:
    """A lens model that was tried, with its error on all pictures and on those left out."""

    model: LensModel
    rms_px: float
    held_out_px: float


@dataclass(frozen=True, eq=False)
class Intrinsics:
    """A calibrated lens of a `camera` at the origin, by the `sightings` that were used."""

    camera: Camera
    lens: Lens
    sightings: Sightings
    poses: tuple[RigidTransform, ...]  # camera_from_board of each
    errors: FloatArray  # (F, n, 2) pixels
    rms_px: float
    held_out_px: float
    sigma: FloatArray  # (4,) standard deviations of f_x, f_y, c_x, c_y in pixels
    candidates: tuple[Candidate, ...]
    coverage: Coverage
    findings: tuple[Finding, ...]


def calibrate_intrinsics(
    sightings: Sightings, board: Board, *, model: str = "auto", alone: bool = True
) -> Intrinsics:
    """The lens of one camera, if not `alone` to be adjusted with others. Raises InputError.

    Outlying pictures are removed, at most a third. Of the models whose held-out error is within one
    percent of the least, the one with the least information criterion is taken, no fisheye lens
    where a plain one does; or `model`.
    """
    check_model(model)
    check_count(sightings)
    used, start = _without_outliers(_spread_views(sightings), board, model)
    fits = _fits(start, used, board, model)
    chosen, candidates, held_out = _chosen(fits, used, board)
    fit = fits[chosen]
    coverage = coverage_of(used, fit.poses)
    sigma = _sigma(fit)
    if alone:
        check_known(fit.bundle.rms, sigma, fit.lens, coverage, used)
    camera = fit.lens.camera(used.camera, used.size, RigidTransform.identity())
    return Intrinsics(
        camera, fit.lens, used, fit.poses, fit.errors, fit.bundle.rms, held_out, sigma,
        candidates, coverage, tuple(_findings(fit, sigma, coverage, used)),
    )  # fmt: skip


def check_model(name: str) -> None:
    """Refuse a name that no lens model has; raises InputError."""
    if name != "auto" and name not in LENS_MODELS:
        remedy = f"{did_you_mean(name, LENS_MODELS)}Use auto, {', '.join(LENS_MODELS)}."
        raise InputError(f"unknown lens model {name!r}", "--model", remedy)


def check_count(sightings: Sightings) -> None:
    """Refuse too few pictures of the board; raises InputError with what to film."""
    if len(sightings) < _LEAST_VIEWS:
        found = counted(len(sightings), "picture") if len(sightings) else "none"
        searched = max(sightings.searched, len(sightings))
        what = f"the board was found in {found} of {searched}"
        film = "in 15 to 30 positions, whole, sharp and evenly lit, with a white margin around it"
        remedy = f"Check the size of the board. Film it again {film}."
        where = f"camera {sightings.camera}"
        raise InputError(f"{what}, and at least {_LEAST_VIEWS} are needed", where, remedy)


def _spread_views(sightings: Sightings) -> Sightings:
    """At most `_MOST_VIEWS` of them, as different from each other as possible."""
    if len(sightings) <= _MOST_VIEWS:
        return sightings
    scaled = sightings.pixels / max(sightings.size)
    low, high = np.nanmin(scaled, axis=1), np.nanmax(scaled, axis=1)
    slant = np.nanstd(scaled[..., 0] * scaled[..., 1], axis=1)
    features = np.column_stack([0.5 * (low + high), high - low, slant])
    chosen = [int(np.argmin(np.linalg.norm(features - features.mean(axis=0), axis=1)))]
    distance = np.full(len(features), np.inf)
    while len(chosen) < _MOST_VIEWS:
        to_last = np.linalg.norm(features - features[chosen[-1]], axis=1)
        distance = np.minimum(distance, to_last)
        chosen.append(int(np.argmax(distance)))
    others = [i for i in range(len(sightings)) if i not in chosen]
    return sightings.without(others, ["much like another picture, not needed"] * len(others))


def _without_outliers(
    sightings: Sightings, board: Board, model: str
) -> tuple[Sightings, dict[bool, Lens]]:
    """Pictures that agree with each other, and first lenses by whether they are fisheye lenses."""
    seen = BoardPictures(sightings.pixels, board.corners)
    kinds = sorted({one.fisheye for one in _models(model)})
    begun = {kind: first_lens(seen, sightings.size, fisheye=kind) for kind in kinds}
    start = {kind: lens for kind, lens in begun.items() if lens is not None}
    if not start:
        raise _undetermined(sightings, "no focal length explains the pictures")
    poses = [likeliest_poses(one, board.corners, sightings.pixels) for one in start.values()]
    rows = [i for i, own in enumerate(zip(*poses, strict=True)) if not any(own)]
    sightings = sightings.without(rows, ["the board cannot be placed"] * len(rows))
    check_count(sightings)
    most = len(sightings) // 3
    for _ in range(_ROUNDS):
        fits = _fits(start, sightings, board, model)
        fit = min(fits.values(), key=lambda one: one.median_px)
        sightings = without_far_corners(sightings, fit.errors)
        rows, reasons = outlying_views(fit.errors, most)
        if not rows:
            break
        most -= len(rows)
        sightings = sightings.without(rows, reasons)
        check_count(sightings)
    return sightings, start


def _models(name: str) -> list[LensModel]:
    return list(LENS_MODELS.values()) if name == "auto" else [LENS_MODELS[name]]


def _fits(
    start: dict[bool, Lens], sightings: Sightings, board: Board, model: str
) -> dict[str, LensFit]:
    """Every model fitted, by name; each begins with the simpler one before it."""
    fits: dict[str, LensFit] = {}
    latest = dict(start)
    seen = BoardPictures(sightings.pixels, board.corners)
    spare = int(np.isfinite(sightings.pixels).sum()) - 6 * len(sightings)
    for one in _models(model):
        if one.fisheye not in latest or spare <= one.free.sum():
            continue
        if (fit := best_fit(one, latest[one.fisheye], seen)) is not None:
            fits[one.name] = fit
            latest[one.fisheye] = fit.lens
    if not fits:
        raise _undetermined(sightings, "no lens model explains the pictures")
    return fits


def _chosen(
    fits: dict[str, LensFit], sightings: Sightings, board: Board
) -> tuple[str, tuple[Candidate, ...], float]:
    """Name of the model taken, all that were tried, and its held-out error in pixels.

    A rational lens without distortion may be any lens whose numerator and denominator are equal: it
    is not taken where it leaves the focal length open that a simpler model knows.
    """
    seen = BoardPictures(sightings.pixels, board.corners)
    roots = {}
    for name, fit in fits.items():
        squares = held_out_errors(fit, seen)
        roots[name] = float("nan") if squares is None else float(np.sqrt(squares.mean()))
    vague = {n: _focal_uncertainty(f.bundle.rms, _sigma(f), f.lens) for n, f in fits.items()}
    known = [name for name in fits if vague[name] < _UNKNOWN_FOCAL] or list(fits)
    least = np.nanmin([roots[name] for name in known], initial=np.inf)
    within = [name for name in known if not roots[name] > (1.0 + _WORTH) * least]
    if any(fits[name].lens.model in (RADIAL, BROWN, BROWN5) for name in within):
        within = [name for name in within if not fits[name].lens.model.fisheye]
    best = min(within, key=lambda name: _criterion(fits[name]))
    candidates = tuple(Candidate(f.lens.model, f.bundle.rms, roots[n]) for n, f in fits.items())
    return best, candidates, roots[best]


def _criterion(fit: LensFit) -> float:
    """Information criterion N log(mean squared error) + 4 k of N coordinates, k coefficients.

    Akaike's 2 k lets in coefficients of no use; Bayes' k log N leaves out the tangential distortion
    of ordinary lenses, and the camera then seems turned by a tenth of a degree.
    """
    count = float(np.isfinite(fit.errors).sum())
    error = max(float(np.nanmean(np.square(fit.errors))), 1e-12)
    unknowns = len(fit.lens.model.estimated)
    return float(count * np.log(error) + _PENALTY * unknowns)


def check_known(
    rms: float, sigma: FloatArray, lens: Lens, coverage: Coverage, sightings: Sightings
) -> None:
    """Refuse a lens whose focal length is not determined; raises InputError with what to film."""
    share = _focal_uncertainty(rms, sigma, lens)
    if share < _UNKNOWN_FOCAL:
        return
    remedy = coverage.advice
    what = f"the focal length is only known to {100 * min(share, 1.0):.0f} %"
    if coverage.tilt_deg < _LEAST_TILT_DEG:
        tilt = f"tilted by {coverage.tilt_deg:.0f} degrees at most"
        what = f"the boards are all nearly parallel ({tilt}): the focal length is not determined"
        remedy = _REFILM
    raise _undetermined(sightings, what, remedy)


def _sigma(fit: LensFit) -> FloatArray:
    """Standard deviations (4,) of f_x, f_y, c_x, c_y in pixels."""
    return np.sqrt(np.maximum(np.diag(fit.bundle.covariance)[:4], 0.0))


def _focal_uncertainty(rms: float, sigma: FloatArray, lens: Lens) -> float:
    """Standard deviation of the focal length as a share of it, for corners of usual noise."""
    factor = max(1.0, _NOISE_PX / max(rms / np.sqrt(2.0), 1e-12))
    share = float(factor * np.max(sigma[:2]) / lens.focal)
    return share if np.isfinite(share) else float("inf")


def _undetermined(sightings: Sightings, what: str, remedy: str = _REFILM) -> InputError:
    return InputError(what, f"camera {sightings.camera}", remedy)


def _findings(
    fit: LensFit, sigma: FloatArray, coverage: Coverage, sightings: Sightings
) -> Sequence[Finding]:
    where = f"camera {sightings.camera}"
    found = []
    if len(sightings) < _FEW_VIEWS:
        few = f"only {counted(len(sightings), 'picture')} of the board could be used"
        found.append(Finding("warning", where, few, "Film 15 to 30 positions."))
    share = _focal_uncertainty(fit.bundle.rms, sigma, fit.lens)
    if share > _VAGUE_FOCAL:
        what = f"the focal length is only known to {100 * share:.1f} %"
        found.append(Finding("warning", where, what, coverage.advice))
    found += [replace(one, where=where) for one in coverage.findings()]
    return found

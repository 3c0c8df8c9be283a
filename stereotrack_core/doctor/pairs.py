"""Do the two images of a stereo view fit its calibration? By details that both show.

They are kept where any epipolar geometry explains them. After rectification they have to lie in the
same rows, and farther to the right in the left image; else usual slips are undone in turn.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import TypeAlias

import cv2
import numpy as np
import scipy
from numpy.typing import NDArray

from stereotrack_core.arrays import FloatArray, ImageArray, IntArray
from stereotrack_core.depth.rectify import common_rotation
from stereotrack_core.errors import Correction, Finding, Severity
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.camera_checks import inverted, transposed
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.images import spread
from stereotrack_core.recording.reader import FrameReader

_DETAILS = 800
_ENOUGH_WIDTH = 360.0  # pixels of width of the images in which details are looked for, about
_RATIO = 0.75  # of the best match's distance to the second's, up to which it is unambiguous
_EPIPOLAR_PX = 1.5
FEWEST, _PLENTY = 40, 200  # details without which nothing is said, and of a pair that are enough
_BEHIND_PX = 1.0  # parallax of the wrong sign from which a detail lies behind the cameras

Pair: TypeAlias = tuple[Camera, Camera]  # left and right camera


@dataclass(frozen=True, eq=False)
class Details:
    """Raw pixels (N, 2) of the same details in the left image and in the reference image."""

    left: FloatArray
    image: FloatArray
    seen: int = 0  # details of the image that has fewer of them, matched or not

    @property
    def exchanged(self) -> Details:
        """The same with the images exchanged."""
        return Details(self.image, self.left, self.seen)


@dataclass(frozen=True)
class RowFit:
    """How details of a pair lie to each other after rectification."""

    row_px: float  # median distance of their rows, pixels of the raw images
    wrong_side: float  # share that would lie behind the cameras

    @property
    def misfit(self) -> float:
        """Row offset, larger where most details are on the wrong side."""
        return self.row_px + (100.0 if self.wrong_side > 0.5 else 0.0)


def details_of(pairs: Sequence[tuple[ImageArray, ImageArray]]) -> Details:
    """Details that the two grey images of every pair, all by the same cameras, show."""
    finder = cv2.SIFT.create(_DETAILS)
    found: list[FloatArray] = [np.zeros((0, 4))]
    seen = 0
    for left, image in pairs:
        (pixels_l, own_l), (pixels_r, own_r) = (_described(finder, one) for one in (left, image))
        if min(len(own_l), len(own_r)) < 2:
            continue
        seen += min(len(own_l), len(own_r))
        rows, columns = _matched(own_l, own_r)
        found.append(np.hstack([pixels_l[rows], pixels_r[columns]]))
        if len(rows) >= _PLENTY:
            break
    every = np.concatenate(found)
    kept = np.zeros(len(every), dtype=bool)
    if len(every) >= FEWEST:
        cv2.setRNGSeed(0)
        _, mask = cv2.findFundamentalMat(
            every[:, :2], every[:, 2:], cv2.FM_RANSAC, _EPIPOLAR_PX, 0.999, 2000
        )
        if mask is not None:
            kept = mask.ravel().astype(bool)
    return Details(every[kept, :2], every[kept, 2:], seen)


def _described(finder: cv2.SIFT, image: ImageArray) -> tuple[FloatArray, NDArray[np.float32]]:
    """Pixels (N, 2) of an image's details, and what describes them (N, 128), whole numbers.

    Large images are looked at in a smaller size: four times faster, and the rows of details are
    as exact in 320 as in 640 pixels of width (median 0.12 px instead of 0.09).
    """
    height, width = image.shape
    factor = max(1, round(width / _ENOUGH_WIDTH))
    small = cv2.resize(image, (width // factor, height // factor), interpolation=cv2.INTER_AREA)
    points, described = finder.detectAndCompute(small, None)
    scale = np.array([width, height]) / small.shape[::-1]
    pixels = (np.array([one.pt for one in points]).reshape(-1, 2) + 0.5) * scale - 0.5
    if described is None:
        return pixels, np.zeros((0, 128), np.float32)
    return pixels, np.asarray(described, dtype=np.float32)


def _matched(own: NDArray[np.float32], other: NDArray[np.float32]) -> tuple[IntArray, IntArray]:
    """Details (M,) of one image, and those of the other one that are alike, without ambiguity."""
    # Squares of whole numbers are exact in single precision.
    squares = (own**2).sum(axis=1)[:, None] + (other**2).sum(axis=1) - 2.0 * (own @ other.T)
    nearest = squares.argmin(axis=1)
    best, second = np.sqrt(np.partition(squares, 1, axis=1)[:, :2].T)
    both_ways = squares.argmin(axis=0)[nearest] == np.arange(len(own))
    rows = np.flatnonzero((best < _RATIO * second) & both_ways)
    return rows, nearest[rows]


def row_fit(cameras: Pair, details: Details) -> RowFit:
    """How details lie to each other after rectification with these cameras."""
    rows, parallax = offsets(cameras, details)
    known = np.isfinite(rows) & np.isfinite(parallax)
    if np.count_nonzero(known) < 0.5 * len(rows):
        return RowFit(np.inf, 0.0)
    misfit = float(np.median(np.abs(rows[known])))
    return RowFit(misfit, float(np.mean(parallax[known] < -_BEHIND_PX)))


def offsets(cameras: Pair, details: Details) -> tuple[FloatArray, FloatArray]:
    """Row offsets and parallaxes (N,), pixels, after rectification."""
    left, right = cameras
    rotation = common_rotation(left, right)
    own = left.rays_world(details.left) @ rotation.T
    other = right.rays_world(details.image) @ rotation.T
    with np.errstate(divide="ignore", invalid="ignore"):
        apart = left.focal * (own[:, :2] / own[:, 2:] - other[:, :2] / other[:, 2:])
    apart[(own[:, 2] < 0.1) | (other[:, 2] < 0.1)] = np.nan
    return apart[:, 1], apart[:, 0]


def exchanged_views(a: str, b: str) -> Finding:
    """The finding that the images of two views are exchanged."""
    remedy = f"Exchange the files, or the cameras, of the views {a} and {b}."
    correction = Correction("exchange_views", (a, b))
    return Finding("error", f"views {a}, {b}", "they are exchanged", remedy, correction)


MENDED_PX = 0.7
_MENDED_SHARE = 0.4  # row offset, and share of the one before, that a correction leaves
_MENDED_TURN = np.radians(45.0)
_TIE_PX = 0.1
_CLEARLY = 0.7  # share of another one's row offset that a better explanation leaves
_NOISE_PX = 0.3  # row offset from which details count less while a turn is fitted


Remedy: TypeAlias = tuple[str, Correction | None]
"""Sentences on what to do, and the correction if it is a mechanical one."""


def px(pixels: float) -> str:
    """Pixels as people read them."""
    return f"{pixels:.1f} px" if np.isfinite(pixels) else "too far"


def remedy_of(view: str, cameras: Pair, details: Details, fit: RowFit, scale: float) -> Remedy:
    """The correction that lays the details into the same rows, or what to do without one."""
    limit = max(MENDED_PX * scale, _MENDED_SHARE * min(fit.row_px, 2.0 * scale))
    exchanged = row_fit(cameras, details.exchanged).misfit
    if fit.wrong_side > 0.5 and exchanged < limit:
        return _exchange(view, exchanged)
    likely = _likeliest(cameras, details, limit)
    if likely is not None:
        return likely
    if exchanged < limit:  # images of cameras that look askew at each other
        return _exchange(view, exchanged)
    return (
        "Calibrate this pair again: no usual slip explains it. Check that both images belong to "
        "this view and its cameras, and that they are stored as they were calibrated: neither "
        "mirrored nor upside down, with the distortions and the image size of the calibration."
    ), None


def _exchange(view: str, left: float) -> Remedy:
    words = (
        "The left and the right image are exchanged: swap the files of left and right (tested: "
        f"then the rows agree within {px(left)}). Both images mirrored or upside down look alike."
    )
    return words, Correction("exchange_pair", (view,))


def _likeliest(cameras: Pair, details: Details, limit: float) -> Remedy | None:
    """The best explanation of row offsets; a turn that leaves less beats a slip."""
    turn, turned = _turn(cameras, details)
    slip, slipped = _slip(cameras, details)
    if slipped < min(limit, turned / _CLEARLY + _TIE_PX):
        return slip
    if turned < limit:
        return (
            f"One camera is turned by {np.degrees(turn):.1f} degrees against the calibration "
            f"(tested: with it turned back the rows agree within {px(turned)}). Calibrate this "
            "pair again."
        ), None
    return slip if slipped < limit else None


def _slip(cameras: Pair, details: Details) -> tuple[Remedy, float]:
    """The usual slip, of one camera or both, that leaves the least row offset, and that offset."""
    tried = []
    for said, change in (
        ("Transpose the rotation of {}", transposed),
        ("Invert rotation and translation of {}", inverted),
    ):
        for chosen in ((0,), (1,), (0, 1)):
            left, right = (change(c) if i in chosen else c for i, c in enumerate(cameras))
            names = tuple(cameras[i].name for i in chosen)
            if np.linalg.norm(left.position_world - right.position_world) > 1e-6:
                misfit = row_fit((left, right), details).misfit
                tried.append((misfit, said.format(" and ".join(names)), names))
    best, said, names = min(tried, default=(np.inf, "", ()))
    correction = Correction("transpose", names) if said.startswith("Transpose") else None
    return (f"{said} (tested: then the rows agree within {px(best)}).", correction), best


def _turn(cameras: Pair, details: Details) -> tuple[float, float]:
    """Angle, radians, by which turning the right camera helps most, and the row offset then."""
    common, ahead, ways = common_rotation(*cameras), [], []
    for camera, pixels in zip(cameras, (details.left, details.image), strict=True):
        rotation = camera.camera_from_world.rotation
        rays = camera.rays_world(pixels) @ rotation.T
        with np.errstate(divide="ignore", invalid="ignore"):
            ahead.append(rays / rays[:, 2:])
        ways.append(common @ rotation.T)

    def rows(turn: FloatArray) -> FloatArray:
        back = scipy.spatial.transform.Rotation.from_rotvec(turn).as_matrix()
        heights = []
        for rays, way in zip(ahead, (ways[0], ways[1] @ back), strict=True):
            _, y, z = way @ rays.T
            with np.errstate(divide="ignore", invalid="ignore"):
                heights.append(np.where(z > 0.1, y / z, np.nan))
        return np.asarray(cameras[0].focal * (heights[0] - heights[1]))

    solved = scipy.optimize.least_squares(
        lambda turn: np.nan_to_num(rows(turn), nan=0.0), np.zeros(3),
        loss="soft_l1", f_scale=_NOISE_PX, x_scale=0.01, max_nfev=30,
    )  # fmt: skip
    turn = float(np.linalg.norm(solved.x))
    offset = float(np.nanmedian(np.abs(rows(solved.x))))
    return turn, offset if turn < _MENDED_TURN else np.inf


_FRAMES = 2  # Few: things that stand still give most details, and are the same in all frames
_MANY, _SHARED = 400, 0.04  # details to be matched in an image, and least share that are
_WIDTH = 640.0  # width of the images, in pixels, that the limits refer to
_TOLD_PX, _DOUBTFUL_PX, _WRONG_PX = 0.5, 1.0, 2.5  # row offsets: told, matching suffers, fails


def check_pairs(recording: Recording, reader: FrameReader) -> Iterator[Finding]:
    """Findings about the stereo views of a recording."""
    sets = [reader.frame_set(k) for k in spread(reader.frame_count, _FRAMES)]
    matched: dict[str, tuple[Pair, Details]] = {}
    for view in recording.views:
        if view.left is None:
            continue
        seen = [s.views[view.name] for s in sets if view.name in s.views]
        pairs = [(one.left, one.image) for one in seen if one.left is not None]
        cameras = recording.cameras.get(view.left.camera), recording.cameras.get(view.image.camera)
        if cameras[0] is not None and cameras[1] is not None:
            details = details_of(pairs)
            if details.seen > FEWEST and all(np.array_equal(*pair) for pair in pairs):
                what = "the left and right images are identical, so there is no depth"
                remedy = "Give each camera of the stereo pair its own file."
                yield Finding("error", f"view {view.name}", what, remedy)
            elif details.seen > _MANY and len(details.left) < _SHARED * details.seen:
                share = 100 * len(details.left) / details.seen
                alike = f"left and right image share {share:.0f} % of their details"
                what = f"{alike} (more than 20 % in good pairs)"
                check = "Check that both files belong to this view, to the same instants, are sharp"
                remedy = f"{check}, and that neither is mirrored."
                yield Finding("error", f"view {view.name}", what, remedy)
            else:
                matched[view.name] = (cameras[0], cameras[1]), details
    tried = {name: list(check_pair(name, *own)) for name, own in matched.items()}
    wrong = {name: found for name, found in tried.items() if found}
    for (a, (one, of_one)), (b, (other, of_other)) in combinations(matched.items(), 2):
        exchanged = a in wrong and b in wrong and _fit(of_one, one, other)
        if exchanged and _fit(of_other, other, one):
            del wrong[a], wrong[b]
            fit = "they are exchanged: the images of each fit the cameras of the other one"
            yield replace(exchanged_views(a, b), what=fit)
    for found in wrong.values():
        yield from found


def _fit(details: Details, own: Pair, cameras: Pair) -> bool:
    """Whether a view's details lie in the same rows with other cameras than its own."""
    sizes = [[(one.width, one.height) for one in pair] for pair in (own, cameras)]
    limit = MENDED_PX * _scale(cameras)
    return sizes[0] == sizes[1] and row_fit(cameras, details).misfit < limit


def _scale(cameras: Pair) -> float:
    """How much larger the images are than those that the limits refer to."""
    return max(cameras[1].width / _WIDTH, 0.5)


def check_pair(view: str, cameras: Pair, details: Details) -> Iterator[Finding]:
    """Findings about the pair of a view, by its details."""
    where, scale = f"view {view}", _scale(cameras)
    if np.linalg.norm(cameras[0].position_world - cameras[1].position_world) < 1e-6:
        return  # told by the checks of the cameras
    if len(details.left) < FEWEST:
        return
    fit = row_fit(cameras, details)
    if fit.misfit < _DOUBTFUL_PX * scale:
        if fit.misfit > _TOLD_PX * scale:
            told = f"the rows of both images differ by {px(fit.row_px)} after rectification"
            taken = "The tracker measures that and takes it off (`align_rows`)."
            yield Finding("note", where, told, taken)
        return
    what = (
        f"{100 * fit.wrong_side:.0f} % of {len(details.left)} details that both images of the pair "
        "show lie on the wrong side, as if behind the cameras"
        if fit.wrong_side > 0.5
        else f"details that both images of the pair show lie {px(fit.row_px)} apart in their "
        f"rows after rectification (median of {len(details.left)}; less than 1 px in good pairs)"
    )
    severity: Severity = "error" if fit.misfit > _WRONG_PX * scale else "warning"
    yield Finding(severity, where, what, *remedy_of(view, cameras, details, fit, scale))

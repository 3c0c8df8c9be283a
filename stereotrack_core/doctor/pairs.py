"""Do the two images of a stereo view fit its calibration? By details that both show.

Details are matched in the raw images and kept where any epipolar geometry explains them, so that
this does not depend on the calibration. After rectification they have to lie in the same rows, and
farther to the right in the left image. Where they do not, usual slips are undone in turn: what
lays them into the same rows is the tested correction.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations, product
from typing import TypeAlias

import cv2
import numpy as np
import scipy

from stereotrack_core.arrays import FloatArray, ImageArray
from stereotrack_core.depth.rectify import common_rotation
from stereotrack_core.doctor.slips import (
    centre_exchanged,
    focused,
    inverted,
    resized,
    transposed,
    undistorted,
)
from stereotrack_core.errors import Finding, Severity
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.recording.camera_checks import IMAGE_SIZES
from stereotrack_core.recording.description import Recording, View
from stereotrack_core.recording.reader import FrameReader

_FRAMES = 2
"""What stands still, and gives most details, is the same in all of them."""

_DETAILS = 1500
_RATIO = 0.75
"""Distance of the best match over that of the second best up to which it is unambiguous."""

_EPIPOLAR_PX = 1.5
_FEWEST = 40
"""Details without which nothing is said."""

_MANY, _SHARED = 400, 0.04
"""Details of an image from which it shows enough to be matched, and the share that has to be."""

_WIDTH = 640.0
"""Width of the images, in pixels, that the limits refer to."""

_DOUBTFUL_PX, _WRONG_PX = 1.0, 2.5
"""Median row offset from which matching suffers, and from which it fails."""

_MENDED_PX, _MENDED_SHARE = 0.7, 0.4
"""Row offset, and share of the one before, below which a correction explains a fault."""

_STRAIGHTENED = 0.6
"""The same share for distortions, of which one of several coefficients is tried."""

_MENDED_TURN = np.radians(45.0)

Pair: TypeAlias = tuple[Camera, Camera]


@dataclass(frozen=True, eq=False)
class Details:
    """Raw pixels (N, 2) of the same details in the left image and in the reference image."""

    left: FloatArray
    image: FloatArray
    seen: int = 0
    """Details of the image that has fewer of them, matched or not."""

    @property
    def exchanged(self) -> Details:
        """The same with the images exchanged."""
        return Details(self.image, self.left, self.seen)

    def left_turned(self, camera: Camera) -> Details:
        """The same with the left image, by this camera, turned upside down."""
        turned = np.array([camera.width - 1.0, camera.height - 1.0]) - self.left
        return replace(self, left=turned)


@dataclass(frozen=True)
class RowFit:
    """How details of a pair lie to each other after rectification."""

    row_px: float
    """Median distance of their rows, pixels of the raw images."""
    wrong_side: float
    """Share that would lie behind the cameras."""

    @property
    def misfit(self) -> float:
        """Row offset, larger where most details are on the wrong side."""
        return self.row_px + (100.0 if self.wrong_side > 0.5 else 0.0)


def check_pairs(recording: Recording, reader: FrameReader) -> Iterator[Finding]:
    """Findings about the stereo views of a recording."""
    count = reader.frame_count
    frames = np.unique(np.linspace(0, count - 1, min(_FRAMES, count)).astype(int))
    sets = [reader.frame_set(int(k)) for k in frames]
    matched: dict[str, Matched] = {}
    for view in recording.views:
        if view.left is None:
            continue
        seen = [s.views[view.name] for s in sets if view.name in s.views]
        pairs = [(one.left, one.image) for one in seen if one.left is not None]
        cameras = recording.cameras.get(view.left.camera), recording.cameras.get(view.image.camera)
        if cameras[0] is not None and cameras[1] is not None:
            details = details_of(pairs)
            if details.seen > _MANY and len(details.left) < _SHARED * details.seen:
                yield _unlike(view, pairs, details)
            else:
                matched[view.name] = Matched(view, (cameras[0], cameras[1]), details)
    wrong = {name: found for name, one in matched.items() if (found := list(_found_in(one)))}
    for (a, one), (b, other) in combinations(matched.items(), 2):
        if a in wrong and b in wrong and _fit(one, other.cameras) and _fit(other, one.cameras):
            del wrong[a], wrong[b]
            yield Finding(
                "error",
                f"views {a}, {b}",
                "they are exchanged: the images of each fit the cameras of the other one",
                f"Exchange the files, or the cameras, of the views {a} and {b} (tested: then the "
                "rows of both pairs agree).",
            )
    for found in wrong.values():
        yield from found


@dataclass(frozen=True, eq=False)
class Matched:
    """A stereo view with its left and right camera, and the details that both images show."""

    view: View
    cameras: Pair
    details: Details


def _found_in(one: Matched) -> Iterator[Finding]:
    return check_pair(one.view, one.cameras, one.details)


def _fit(one: Matched, cameras: Pair) -> bool:
    """Whether a view's details lie in the same rows with these cameras."""
    same = all(
        (a.width, a.height) == (b.width, b.height)
        for a, b in zip(one.cameras, cameras, strict=True)
    )
    return same and row_fit(cameras, one.details).misfit < _MENDED_PX * _scale(cameras)


def _scale(cameras: Pair) -> float:
    """How much larger the images are than those that the limits refer to."""
    return max(cameras[1].width / _WIDTH, 0.5)


def _unlike(
    view: View, pairs: Sequence[tuple[ImageArray, ImageArray]], details: Details
) -> Finding:
    """The images of a pair share nearly nothing; whether one of them is mirrored."""
    mirrored = details_of([(np.ascontiguousarray(left[:, ::-1]), image) for left, image in pairs])
    share = 100 * len(mirrored.left) / max(mirrored.seen, 1)
    return Finding(
        "error",
        f"view {view.name}",
        f"left and right image share {100 * len(details.left) / details.seen:.0f} % of their "
        "details (more than 20 % in good pairs)",
        f"One of the two images is mirrored (tested: with the left one turned round they share "
        f"{share:.0f} %). Store both as the camera saw them."
        if share > 200 * _SHARED
        else "Check that both files belong to this view, to the same instants, and are sharp.",
    )


def details_of(pairs: Sequence[tuple[ImageArray, ImageArray]]) -> Details:
    """Details that the two grey images of every pair, all by the same cameras, show."""
    finder = cv2.SIFT.create(_DETAILS)
    matcher = cv2.BFMatcher.create(cv2.NORM_L2)
    found: list[FloatArray] = [np.zeros((0, 4))]
    seen = 0
    for left, image in pairs:
        (points_l, own_l), (points_r, own_r) = (
            finder.detectAndCompute(one, None) for one in (left, image)
        )
        if own_l is None or own_r is None or min(len(own_l), len(own_r)) < 2:
            continue
        seen += min(len(own_l), len(own_r))
        back = {m[0].queryIdx: m[0].trainIdx for m in matcher.knnMatch(own_r, own_l, k=1)}
        rows = [
            (*points_l[best.queryIdx].pt, *points_r[best.trainIdx].pt)
            for best, second in matcher.knnMatch(own_l, own_r, k=2)
            if best.distance < _RATIO * second.distance and back[best.trainIdx] == best.queryIdx
        ]
        found.append(np.array(rows, dtype=np.float64).reshape(-1, 4))
    every = np.concatenate(found)
    kept = np.zeros(len(every), dtype=bool)
    if len(every) >= _FEWEST:
        cv2.setRNGSeed(0)
        _, mask = cv2.findFundamentalMat(
            every[:, :2], every[:, 2:], cv2.FM_RANSAC, _EPIPOLAR_PX, 0.999, 2000
        )
        if mask is not None:
            kept = mask.ravel().astype(bool)
    return Details(every[kept, :2], every[kept, 2:], seen)


def row_fit(cameras: Pair, details: Details) -> RowFit:
    """How details lie to each other after rectification with these cameras."""
    rows, parallax = _offsets(cameras, details)
    known = np.isfinite(rows) & np.isfinite(parallax)
    if np.count_nonzero(known) < 0.5 * len(rows):
        return RowFit(np.inf, 0.0)
    return RowFit(
        float(np.median(np.abs(rows[known]))), float(np.mean(parallax[known] < -_DOUBTFUL_PX))
    )


def _offsets(cameras: Pair, details: Details) -> tuple[FloatArray, FloatArray]:
    """Row offsets and parallaxes (N,), pixels, after rectification."""
    left, right = cameras
    rotation = common_rotation(left, right)
    own = left.rays_world(details.left) @ rotation.T
    other = right.rays_world(details.image) @ rotation.T
    with np.errstate(divide="ignore", invalid="ignore"):
        apart = left.focal * (own[:, :2] / own[:, 2:] - other[:, :2] / other[:, 2:])
    apart[(own[:, 2] < 0.1) | (other[:, 2] < 0.1)] = np.nan
    return apart[:, 1], apart[:, 0]


def check_pair(view: View, cameras: Pair, details: Details) -> Iterator[Finding]:
    """Findings about one pair, by its details."""
    where, scale = f"view {view.name}", _scale(cameras)
    if np.linalg.norm(cameras[0].position_world - cameras[1].position_world) < 1e-6:
        return  # told by the checks of the cameras
    if len(details.left) < _FEWEST:
        return
    fit = row_fit(cameras, details)
    if fit.misfit < _DOUBTFUL_PX * scale:
        return
    what = (
        f"{100 * fit.wrong_side:.0f} % of {len(details.left)} details that both images of the pair "
        "show lie on the wrong side, as if behind the cameras"
        if fit.wrong_side > 0.5
        else f"details that both images of the pair show lie {_px(fit.row_px)} apart in their "
        f"rows after rectification (median of {len(details.left)}; less than 1 px in good pairs)"
    )
    severity: Severity = "error" if fit.misfit > _WRONG_PX * scale else "warning"
    yield Finding(severity, where, what, _remedy(cameras, details, fit, scale))


def _px(pixels: float) -> str:
    return f"{pixels:.1f} px" if np.isfinite(pixels) else "too far"


def _remedy(cameras: Pair, details: Details, fit: RowFit, scale: float) -> str:
    """The correction that lays the details into the same rows, or what to do without one."""
    limit = max(_MENDED_PX * scale, _MENDED_SHARE * min(fit.row_px, 2.0 * scale))
    if fit.wrong_side > 0.5 and (said := _overturned(cameras, details, limit)):
        return said
    tried = [
        (row_fit(changed, details).misfit, _off_centre(changed), said)
        for said, changed in _corrections(cameras)
    ]
    best = min(misfit for misfit, _, _ in tried)
    _, misfit, said = min(
        (aside, misfit, said) for misfit, aside, said in tried if misfit < best + _TIE_PX
    )
    if misfit < limit:
        return f"{said} (tested: then the rows agree within {_px(misfit)})."
    for which, turned in (
        ("left", details.left_turned(cameras[0])),
        ("right", details.exchanged.left_turned(cameras[1]).exchanged),
    ):
        if (upright := row_fit(cameras, turned)).misfit < limit:
            return (
                f"The {which} image is upside down: store it as the camera saw it (tested: then "
                f"the rows agree within {_px(upright.row_px)})."
            )
    if not any(np.any(one.distortions) for one in cameras):
        bent, left = _bent(cameras, details)
        if left < max(limit, _STRAIGHTENED * fit.row_px):
            return (
                "The calibration states no distortions, but the lenses have some, of about k_1 = "
                f"{bent:.2f} (tested: with it the rows agree within {_px(left)}). Write them, or "
                "calibrate with them."
            )
    turn, left = _turn(cameras, details)
    if left < limit:
        return (
            f"One camera is turned by {np.degrees(turn):.1f} degrees against the calibration "
            f"(tested: with it turned back the rows agree within {_px(left)}). Calibrate this pair "
            "again."
        )
    return (
        "Calibrate this pair again: no usual slip explains it. Check that both images belong to "
        "this view and its cameras, and that they are stored as they were calibrated."
    )


_FOCALS = (0.9, 0.92, 0.95, 0.97, 1.03, 1.05, 1.08, 1.1)


_TIE_PX = 0.1


def _off_centre(cameras: Pair) -> float:
    """How far principal points are from the middle of their images, pixels."""
    return sum(
        float(np.hypot(*(one.matrix[:2, 2] - [one.width / 2, one.height / 2]))) for one in cameras
    )


def _corrections(cameras: Pair) -> Iterator[tuple[str, Pair]]:
    """Usual slips, undone in one camera or both, and what to say of each."""
    changes: list[tuple[str, Callable[[Camera], Camera]]] = [
        ("Exchange c_x and c_y in the matrix of {}", centre_exchanged),
        ("Transpose the rotation of {}", transposed),
        ("Invert rotation and translation of {}", inverted),
        ("Leave out the distortions of {}", undistorted),
    ]
    for factor in IMAGE_SIZES:
        said = f"The matrix of {{}} belongs to another image size: multiply it by {factor:.3g}"
        changes.append((said, partial(resized, factor=factor)))
    for factor in _FOCALS:
        said = (
            "The focal lengths of the two cameras do not fit each other: multiply that of {} by "
            f"about {factor:.3g}, or divide the other one by it"
        )
        changes.append((said, partial(focused, factor=factor)))
    left, right = cameras
    for (said, change), (first, second) in product(
        changes, ((True, False), (False, True), (True, True))
    ):
        names = [c.name for c, chosen in ((left, first), (right, second)) if chosen]
        changed = change(left) if first else left, change(right) if second else right
        if np.linalg.norm(changed[0].position_world - changed[1].position_world) > 1e-6:
            yield said.format(" and ".join(names)), changed


def _overturned(cameras: Pair, details: Details, limit: float) -> str:
    """What lays the details before the cameras: other files, or images that are turned back."""
    width, height = (np.array([[one.width, one.height] for one in cameras]) - 1.0).T
    size = np.stack([width, height], axis=1)
    mirrored = np.array([1.0, 0.0])
    turned = replace(details, left=size[0] - details.left, image=size[1] - details.image)
    back = replace(
        details,
        left=np.abs(size[0] * mirrored - details.left),
        image=np.abs(size[1] * mirrored - details.image),
    )
    tried = [
        (row_fit(cameras, details.exchanged).misfit,
         "The left and the right image are exchanged: swap the files of left and right"),
        (row_fit(cameras, turned).misfit, "Both images are upside down: turn them round"),
        (row_fit(cameras, back).misfit, "Both images are mirrored: store them as they were seen"),
    ]  # fmt: skip
    fitting = sorted((misfit, said) for misfit, said in tried if misfit < limit)
    if not fitting:
        return ""
    best, said = fitting[0]
    others = [other for misfit, other in fitting[1:] if misfit < best + 2 * _TIE_PX]
    or_else = "".join(f" Or else: {other[0].lower()}{other[1:]}." for other in others)
    return f"{said} (tested: then the rows agree within {_px(best)}).{or_else}"


def _bent(cameras: Pair, details: Details) -> tuple[float, float]:
    """First radial coefficient that helps most in both lenses, and the row offset then."""

    def changed(coefficient: float) -> Pair:
        bent = np.array([coefficient, 0.0, 0.0, 0.0])
        left, right = (replace(one, distortions=bent, fisheye=False) for one in cameras)
        return left, right

    def offset(coefficient: float) -> float:
        return row_fit(changed(coefficient), details).misfit

    solved = scipy.optimize.minimize_scalar(offset, bounds=(-0.5, 0.5), method="bounded")
    return float(solved.x), float(solved.fun)


def _turn(cameras: Pair, details: Details) -> tuple[float, float]:
    """Angle by which turning the right camera helps most, radians, and the row offset then."""
    left, right = cameras

    def turned(vector: FloatArray) -> Pair:
        old = right.camera_from_world
        turn = rotation_from_vector(vector)
        # about its centre, which stays where it is
        moved = RigidTransform(turn @ old.rotation, turn @ old.translation)
        return left, replace(right, camera_from_world=moved)

    def rows(vector: FloatArray) -> FloatArray:
        return np.nan_to_num(_offsets(turned(vector), details)[0], nan=1e3)

    solved = scipy.optimize.least_squares(rows, np.zeros(3), loss="soft_l1", max_nfev=40)
    angle = float(np.linalg.norm(solved.x))
    if angle > _MENDED_TURN:
        return angle, np.inf
    return angle, row_fit(turned(solved.x), details).misfit

"""What is wrong about a pair whose details do not lie in the same rows, and how it is corrected."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import product

import numpy as np

from stereotrack_core.doctor.details import Details, Pair, RowFit, row_fit
from stereotrack_core.doctor.lenses import Lenses, distortions_left_out
from stereotrack_core.doctor.row_changes import LEFT_FOCAL, RIGHT_FOCAL, TURN, RowChanges
from stereotrack_core.doctor.slips import (
    centre_exchanged,
    inverted,
    resized,
    transposed,
    undistorted,
)
from stereotrack_core.errors import Correction
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.camera_checks import IMAGE_SIZES

MENDED_PX = 0.7
_MENDED_SHARE = 0.4
"""Row offset, and share of the one before, below which a correction explains a fault."""

_STRAIGHTENED = 0.6
"""The same share for distortions, of which one of several coefficients is tried."""

_MENDED_TURN = np.radians(45.0)
_TIE_PX = 0.1
_LEAST_FOCAL, _MOST_FOCAL = 0.005, 0.2
"""Shares by which a focal length is taken to be wrong."""

_CLEARLY = 0.7
"""Share of the row offset that one explanation leaves of another one's, from which it is better."""


@dataclass(frozen=True)
class Remedy:
    """What to do, as sentences, and the correction where it is a mechanical one."""

    words: str
    correction: Correction | None = None


def px(pixels: float) -> str:
    """Pixels as people read them."""
    return f"{pixels:.1f} px" if np.isfinite(pixels) else "too far"


def remedy_of(view: str, cameras: Pair, details: Details, fit: RowFit, scale: float) -> Remedy:
    """The correction that lays the details into the same rows, or what to do without one."""
    limit = max(MENDED_PX * scale, _MENDED_SHARE * min(fit.row_px, 2.0 * scale))
    if fit.wrong_side > 0.5:
        overturned = _overturned(view, cameras, details, limit)
        if overturned is not None:
            return overturned
    likely = _likeliest(cameras, details, fit, limit)
    if likely is None and fit.wrong_side <= 0.5:  # images of cameras that look askew at each other
        likely = _overturned(view, cameras, details, limit)
    if likely is not None:
        return likely
    for which, turned in (
        ("left", details.left_turned(cameras[0])),
        ("right", details.exchanged.left_turned(cameras[1]).exchanged),
    ):
        if (upright := row_fit(cameras, turned)).misfit < limit:
            return Remedy(
                f"The {which} image is upside down: store it as the camera saw it (tested: then "
                f"the rows agree within {px(upright.row_px)})."
            )
    return Remedy(
        "Calibrate this pair again: no usual slip explains it. Check that both images belong to "
        "this view and its cameras, and that they are stored as they were calibrated."
    )


def _likeliest(cameras: Pair, details: Details, fit: RowFit, limit: float) -> Remedy | None:
    """What explains the row offsets best, of distortions, slips, focal lengths and a turn.

    A turn has three degrees of freedom, and slips are many: where a small turn or another focal
    length leaves clearly less than a slip, the slip helps by chance.
    """
    lenses = distortions_left_out(cameras, details)
    if lenses is not None and lenses.row_px < max(limit, _STRAIGHTENED * fit.row_px):
        slip = _slip(cameras, details, _CLEARLY * lenses.row_px)
        return Remedy(straightened(lenses)) if slip is None else slip
    rows = RowChanges(cameras, details)
    turn, turned = _turn(rows)
    focal, scaled = _focal(cameras, rows)
    slip = _slip(cameras, details, min(limit, min(turned, scaled) / _CLEARLY + _TIE_PX))
    if slip is not None:
        return slip
    if scaled < min(limit, turned / _CLEARLY + _TIE_PX):
        return Remedy(focal)
    if turned < limit:
        return Remedy(_turned(turn, turned))
    return _slip(cameras, details, limit)


def straightened(lenses: Lenses) -> str:
    """What to do about distortions that a calibration lacks."""
    return (
        f"{lenses.words} (tested: with it the rows agree within {px(lenses.row_px)}). Write them, "
        "or calibrate with them."
    )


def _turned(turn: float, left: float) -> str:
    return (
        f"One camera is turned by {np.degrees(turn):.1f} degrees against the calibration "
        f"(tested: with it turned back the rows agree within {px(left)}). Calibrate this pair "
        "again."
    )


def _focal(cameras: Pair, rows: RowChanges) -> tuple[str, float]:
    """What to say of the focal length that helps most, and the row offset then."""
    tried = []
    for camera, free in zip(cameras, (LEFT_FOCAL, RIGHT_FOCAL), strict=True):
        change = rows.fitted(free)
        share = abs(change[free[0]])
        offset = float(np.nanmedian(np.abs(rows.rows(change))))
        if _LEAST_FOCAL < share < _MOST_FOCAL:
            tried.append((offset, camera.name, 1 / (1 + change[free[0]])))
    if not tried:
        return "", np.inf
    (best, name, factor), *others = sorted(tried)
    alone = any(best < _CLEARLY * offset for offset, _, _ in others)
    other = "" if alone else ", or divide the other one by it"
    return (
        "The focal lengths of the two cameras do not fit each other: multiply that of "
        f"{name} by about {factor:.3g}{other} (tested: then the rows agree within {px(best)})."
    ), best


def _slip(cameras: Pair, details: Details, limit: float) -> Remedy | None:
    """The usual slip that, undone, lays the details into the same rows."""
    tried = [(row_fit(changed, details).misfit, changed, one) for changed, one in _undone(cameras)]
    best = min(misfit for misfit, _, _ in tried)
    alike = [one for one in tried if one[0] < best + _TIE_PX]
    misfit, _, found = min(alike, key=lambda one: _off_centre(one[1]))
    if not misfit < limit:
        return None
    return Remedy(
        f"{found.words} (tested: then the rows agree within {px(misfit)}).", found.correction
    )


def _off_centre(cameras: Pair) -> float:
    """How far principal points are from the middle of their images, pixels."""
    return sum(
        float(np.hypot(*(one.matrix[:2, 2] - [one.width / 2, one.height / 2]))) for one in cameras
    )


def _undone(cameras: Pair) -> Iterator[tuple[Pair, Remedy]]:
    """Cameras in which usual slips are undone, of one camera or both."""
    changes: list[tuple[str, Callable[[Camera], Camera]]] = [
        ("Exchange c_x and c_y in the matrix of {}", centre_exchanged),
        ("Transpose the rotation of {}", transposed),
        ("Invert rotation and translation of {}", inverted),
        ("Leave out the distortions of {}", undistorted),
    ]
    for factor in IMAGE_SIZES:
        said = f"The matrix of {{}} belongs to another image size: multiply it by {factor:.3g}"
        changes.append((said, partial(resized, factor=factor)))
    left, right = cameras
    for (said, change), (first, second) in product(
        changes, ((True, False), (False, True), (True, True))
    ):
        names = tuple(c.name for c, chosen in ((left, first), (right, second)) if chosen)
        changed = change(left) if first else left, change(right) if second else right
        if np.linalg.norm(changed[0].position_world - changed[1].position_world) > 1e-6:
            correction = Correction("transpose", names) if change is transposed else None
            yield changed, Remedy(said.format(" and ".join(names)), correction)


def _overturned(view: str, cameras: Pair, details: Details, limit: float) -> Remedy | None:
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
    exchange = Correction("exchange_pair", (view,))
    tried = [
        (row_fit(cameras, details.exchanged).misfit, exchange,
         "The left and the right image are exchanged: swap the files of left and right"),
        (row_fit(cameras, turned).misfit, None, "Both images are upside down: turn them round"),
        (row_fit(cameras, back).misfit, None,
         "Both images are mirrored: store them as they were seen"),
    ]  # fmt: skip
    best = min(misfit for misfit, _, _ in tried)
    if not best < limit:
        return None
    alike = [one for one in tried if one[0] < best + 2 * _TIE_PX]  # the most frequent one first
    (best, correction, said), others = alike[0], [other for _, _, other in alike[1:]]
    or_else = "".join(f" Or else: {other[0].lower()}{other[1:]}." for other in others)
    words = f"{said} (tested: then the rows agree within {px(best)}).{or_else}"
    return Remedy(words, correction)  # whether it is this one, the other views tell then


def _turn(rows: RowChanges) -> tuple[float, float]:
    """Angle by which turning the right camera helps most, radians, and the row offset then."""
    change = rows.fitted(TURN)
    angle = float(np.linalg.norm(change))
    offset = float(np.nanmedian(np.abs(rows.rows(change))))
    return angle, offset if angle < _MENDED_TURN else np.inf

"""Compiled loops that compare what views should see of each part with what they saw."""

from __future__ import annotations

from typing import Any

import numba

from stereotrack_core.tracking.arm_search.picture_kernels import near_at, reached

THROUGH, BEHIND, BEFORE, UNKNOWN, AGREED, VISIBLE = range(6)
"""Columns of the looks: pixels beside the person, with a range behind or before the body's,
without a range, with the body's range, and all that are in sight."""

_HALF = 0.5


@numba.njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def draw_owned(
    images: Any, part: Any, left: float, top: float, step: float, picture: Any, owner: Any
) -> None:
    """Draw cones as :func:`draw` does, and note the part that is in front; -1 is none."""
    for c in range(images.shape[0]):
        im = images[c]
        if im[10] < _HALF:
            continue
        i0, i1, j0, j1 = reached(im, left, top, step, picture.shape[0], picture.shape[1])
        for i in range(i0, i1 + 1):
            for j in range(j0, j1 + 1):
                near = near_at(im, left + step * j, top + step * i)
                if near > picture[i, j]:
                    picture[i, j] = near
                    owner[i, j] = part[c]


@numba.njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def look(
    picture: Any,
    owner: Any,
    measured: Any,
    person: Any,
    scale: float,
    squared_sigma: float,
    looks: Any,
) -> None:
    """Add the pixels of one view to the looks (P, 6) of the parts in front.

    Parameters
    ----------
    picture : (h, w) float32, 1/metres
        Of the body; 0 where it is not.
    owner : (h, w) int8
    measured : (h, w) float32, 1/metres
        0 where not known.
    person : (h, w) int8
    scale : float
        Disparity over inverse range.
    squared_sigma : float, pixels squared
    """
    for i in range(picture.shape[0]):
        for j in range(picture.shape[1]):
            p = owner[i, j]
            if p < 0:
                continue
            looks[p, VISIBLE] += 1.0
            if person[i, j] == 0:
                looks[p, THROUGH] += 1.0
            elif measured[i, j] > 0.0:
                e = scale * (picture[i, j] - measured[i, j])
                off = e * e / (e * e + squared_sigma)
                looks[p, AGREED] += 1.0 - off
                looks[p, BEHIND if e > 0.0 else BEFORE] += off
            else:
                looks[p, UNKNOWN] += 1.0


@numba.njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def unexplained_near(
    picture: Any,
    measured: Any,
    person: Any,
    scale: float,
    frame: Any,
    pinhole: Any,
    joints: Any,
    reach: Any,
    found: Any,
) -> None:
    """Count for each joint the pixels of the person in its reach that the body does not explain.

    A pixel is not explained where the body is not, or clearly behind what was measured.

    Parameters
    ----------
    frame : (3,) float64, pixels
        Left, top and step of the picture.
    pinhole : (3,) float64
    joints : (J, 3) float64, camera
    reach : (J,) float64, metres
    found : (J,) float64
        Is added to.
    """
    for i in range(picture.shape[0]):
        for j in range(picture.shape[1]):
            model, seen = picture[i, j], measured[i, j]
            if person[i, j] == 0 or (model > 0.0 and not scale * (seen - model) > 2.0):
                continue
            x = (frame[0] + frame[2] * j - pinhole[1]) / pinhole[0]
            y = (frame[1] + frame[2] * i - pinhole[2]) / pinhole[0]
            for k in range(joints.shape[0]):
                z = 1.0 / seen if seen > 0.0 else joints[k, 2]
                dx, dy, dz = x * z - joints[k, 0], y * z - joints[k, 1], z - joints[k, 2]
                if dx * dx + dy * dy + dz * dz < reach[k] * reach[k]:
                    found[k] += 1.0

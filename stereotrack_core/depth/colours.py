"""Colours of points, made alike over cameras that see colours differently.

Where two views show the same place they should show the same colour: the median of the logarithm
of the ratio over all such places of floor, walls and person tells the gains of one view against
another, channel by channel. More than gains cannot be had: what views share is mostly the floor,
which has a single colour, and neighbouring blots of a pattern are mistaken for each other.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
import scipy

from stereotrack_core.arrays import FloatArray, ImageArray, IntArray
from stereotrack_core.depth.cloud import ViewDepth

_ACROSS = 128
"""Columns that are looked at, evenly spread; as densely in the rows."""

_SAME = 0.02
"""Metres within which two views show the same place."""

_FARTHEST = 6.0
"""Metres from a camera beyond which ranges are too uncertain."""

_LEAST_PAIRS = 60
"""Places without which two views are not compared."""

_DARKEST, _BRIGHTEST = 15.0, 245.0
"""Levels beyond which noise or the sensor's limit decides."""


@dataclass(frozen=True, eq=False)
class ColourPairs:
    """Colours (M, 3), BGR from 0 to 255, that views `a` and `b` give to the same places."""

    a: int
    b: int
    of_a: FloatArray
    of_b: FloatArray


@dataclass(frozen=True, eq=False)
class ColourCalibration:
    """How every view's colours become those of the first view."""

    views: tuple[str, ...]
    gains: FloatArray
    """(V, 3). c_first = gains[v] c_v, for each channel."""

    @staticmethod
    def none(views: Sequence[str]) -> ColourCalibration:
        """Every view keeps its colours."""
        return ColourCalibration(tuple(views), np.ones((len(views), 3)))

    @staticmethod
    def of(views: Sequence[str], instants: Sequence[Mapping[str, ViewDepth]]) -> ColourCalibration:
        """Fit the gains to all that several views see at some instants."""
        found = [pair for depths in instants for pair in shared_colours(views, depths)]
        return ColourCalibration(tuple(views), fitted_gains(len(views), found))

    def of_pixels(
        self, depths: Mapping[str, ViewDepth], view: IntArray, pixels: IntArray
    ) -> FloatArray | None:
        """Calibrated colours (N, 3) at pixels (N, 2) of views (N,); None without any picture."""
        pictures = {name: d.picture for name, d in depths.items() if d.picture is not None}
        if not pictures:
            return None
        colours = np.full((len(view), 3), np.nan)
        for name, picture in pictures.items():
            number = self.views.index(name)
            of_view = view == number
            colours[of_view] = self.gains[number] * colours_at(picture, pixels[of_view])
        return colours


def colours_at(picture: ImageArray, pixels: IntArray) -> FloatArray:
    """Colours (N, 3) of a picture (H, W, 3) at pixels (N, 2), over 3 x 3 of its pixels."""
    smooth = cv2.blur(picture, (3, 3))
    return smooth[pixels[:, 1], pixels[:, 0]].astype(np.float64)


def shared_colours(views: Sequence[str], depths: Mapping[str, ViewDepth]) -> list[ColourPairs]:
    """Colours of places that two views show at one instant."""
    seen = {}
    for number, name in enumerate(views):
        depth = depths.get(name)
        if depth is not None and depth.picture is not None:
            seen[number] = _places_and_colours(depth, depth.picture)
    pairs = []
    for a, (places_a, colours_a) in seen.items():
        for b, (places_b, colours_b) in seen.items():
            if b <= a or not len(places_a) or not len(places_b):
                continue
            distance, nearest = scipy.spatial.cKDTree(places_b).query(
                places_a, distance_upper_bound=_SAME
            )
            near = np.isfinite(distance)
            pairs.append(ColourPairs(a, b, colours_a[near], colours_b[nearest[near]]))
    return pairs


def _places_and_colours(depth: ViewDepth, picture: ImageArray) -> tuple[FloatArray, FloatArray]:
    g = depth.geometry
    step = max(1, g.width // _ACROSS)
    rows, columns = np.mgrid[step // 2 : g.height : step, step // 2 : g.width : step]
    z = depth.range_z[rows, columns].astype(np.float64)
    known = z < _FARTHEST
    z, u, v = z[known], columns[known], rows[known]
    return g.points(u, v, z), colours_at(picture, np.stack([u, v], axis=1))


def fitted_gains(views: int, pairs: Sequence[ColourPairs]) -> FloatArray:
    """Gains (V, 3) under which paired colours agree; the first view keeps its colours.

    Least squares over the medians of all pairs of views. Views that are connected with the first
    one by no pair keep the mean of their group.
    """
    ratios: dict[tuple[int, int], list[FloatArray]] = {}
    for pair in pairs:
        darkest = np.minimum(pair.of_a, pair.of_b).min(axis=1)
        brightest = np.maximum(pair.of_a, pair.of_b).max(axis=1)
        fair = (darkest > _DARKEST) & (brightest < _BRIGHTEST)
        ratio = np.log(pair.of_b[fair] / pair.of_a[fair])
        ratios.setdefault((pair.a, pair.b), []).append(ratio)
    rows, right = [], []
    for (a, b), parts in ratios.items():
        ratio = np.concatenate(parts)
        if len(ratio) < _LEAST_PAIRS:
            continue
        row = np.zeros(views)
        row[a], row[b] = 1.0, -1.0
        rows.append(np.sqrt(len(ratio)) * row)
        right.append(np.sqrt(len(ratio)) * np.median(ratio, axis=0))
    if not rows:
        return np.ones((views, 3))
    solved, *_ = np.linalg.lstsq(np.array(rows), np.array(right), rcond=None)
    result: FloatArray = np.exp(solved - solved[0] * _reached(np.array(rows))[:, None])
    return result


def _reached(rows: FloatArray) -> FloatArray:
    """1 for views (V,) that pairs connect with the first one, else 0."""
    linked = (rows != 0.0).astype(np.float64)
    _, group = scipy.sparse.csgraph.connected_components(linked.T @ linked, directed=False)
    result: FloatArray = (group == group[0]).astype(np.float64)
    return result

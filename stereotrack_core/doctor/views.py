"""Do the depths of the views fit each other? Each view's points against what the others see.

Where a view sees through what another one measured, or does not show it, one of both is elsewhere.
Exchanging two views is tried; else points are laid onto those of the others, by iterated closest
points, point to plane, over several instants at once, of surfaces that face the same way.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from itertools import combinations, permutations
from typing import NamedTuple, TypeAlias

import numpy as np
import scipy

from stereotrack_core.arrays import FloatArray
from stereotrack_core.depth.chain import DepthChain, rectification_of
from stereotrack_core.depth.cloud import ViewDepth, seen_through
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.volume import settled
from stereotrack_core.doctor.pairs import exchanged_views
from stereotrack_core.errors import Finding, InputError
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.images import spread
from stereotrack_core.recording.reader import FrameReader

MEASURED = 8  # frames that views are measured in, spread over the recording
_EVERYWHERE = 100_000.0  # metres of a working volume that leaves nothing out
_FARTHEST = 8.0  # metres from a camera beyond which nothing is a person that this measures
_MOST_POINTS = 1500  # points of a view and frame that are compared
_FEWEST = 60
_LARGE = 0.03  # mean of :class:`Misfits` from which exchanged views are looked for
_LEFT = 0.2  # share of it that may be left with two views exchanged, or without one
_PLAIN = 0.15
"""Mean from which views contradict each other though no view is to blame: where there is no image
of the empty scene and clothes are plain, sound ones reach 0.1."""


@dataclass(frozen=True, eq=False)
class Seen:
    """The person as measured by one view at one instant."""

    depth: ViewDepth
    points: FloatArray  # (N, 3), metres, in the frame of the rectified camera

    def placed(self, world_from_depth: RigidTransform) -> FloatArray:
        """The points in the world, for a place of the camera."""
        return world_from_depth.apply(self.points)


Instants = Sequence[Mapping[str, Seen]]  # of the views, instant by instant, by name


def measured_views(
    recording: Recording,
    reader: FrameReader,
    views: Sequence[str],
    parameters: DepthParameters | None = None,
    frames: Sequence[int] | None = None,
) -> tuple[Instants, Places]:
    """Measure the person in some views, in frames spread or given. Raises InputError."""
    given = settled(recording, parameters or DepthParameters(), reader, views)
    everywhere = given.replaced(
        volume_x=_EVERYWHERE, volume_y=_EVERYWHERE, volume_z=_EVERYWHERE,
        volume_bottom=-0.5 * _EVERYWHERE, disparity_from_volume=False, subpixel="matcher",
    )  # fmt: skip
    frames = spread(reader.frame_count, MEASURED) if frames is None else frames
    with closing(DepthChain(recording, everywhere, views=views)) as chain:
        chain.learn_background(reader, range(reader.frame_count))
        clouds = [chain.process(reader.frame_set(k)) for k in frames]
        places = {name: one.world_from_depth for name, one in chain.geometry.items()}
    instants = []
    for cloud in clouds:
        seen = {}
        for v, name in enumerate(cloud.view_names):
            depth = cloud.depths.get(name)
            if depth is None:
                continue
            own = places[name].inverse().apply(cloud.points[cloud.view == v])
            own = own[own[:, 2] < _FARTHEST]
            step = max(1, len(own) // _MOST_POINTS)
            if len(own) >= _FEWEST:
                seen[name] = Seen(depth, own[::step])
        instants.append(seen)
    return instants, places


@dataclass(frozen=True, eq=False)
class Misfits:
    """Shares (V, V) of the second view's points that the first contradicts, median; or NaN."""

    views: tuple[str, ...]
    values: FloatArray

    def mean(self, without: str = "") -> float:
        """Mean over the pairs of views, or those without one view; NaN where there are none."""
        kept = [name != without for name in self.views]
        values = self.values[np.ix_(kept, kept)]
        return float(np.nanmean(values)) if np.isfinite(values).any() else float("nan")


def misfits(instants: Instants, places: Places) -> Misfits:
    """How the views contradict each other if their cameras are at these places."""
    names = tuple(places)
    values = np.full((len(names), len(names), len(instants)), np.nan)
    for k, seen in enumerate(instants):
        for v, w in permutations(range(len(names)), 2):
            if names[v] not in seen or names[w] not in seen:
                continue
            geometry = replace(seen[names[v]].depth.geometry, world_from_depth=places[names[v]])
            depth = replace(seen[names[v]].depth, geometry=geometry)
            values[v, w, k] = _contradicted(depth, seen[names[w]].placed(places[names[w]]))
    with np.errstate(all="ignore"):
        known = np.isfinite(values).any(axis=2)
        median = np.full(known.shape, np.nan)
        median[known] = np.nanmedian(values[known], axis=1)
    return Misfits(names, median)


def _contradicted(depth: ViewDepth, points: FloatArray) -> float:
    """Share of points (N, 3), world, that a view sees through or does not have in its image."""
    with np.errstate(divide="ignore", invalid="ignore"):
        u, v, z = depth.geometry.project(points)
    width, height, margin = depth.geometry.width, depth.geometry.height, 0.1 * depth.geometry.width
    across = (u > -margin) & (u < width + margin)
    shown = float(np.mean((z > 0) & across & (v > -margin) & (v < height + margin)))
    through = seen_through(depth, points)
    return 1.0 - shown + shown * (0.0 if through is None else through)


def measurable(recording: Recording, doubtful: Sequence[str] = ()) -> Sequence[str]:
    """Names of the views that measure depth, without those that are `doubtful`."""
    return [
        view.name for view in recording.views
        if view.kind != "mono" and view.name not in doubtful and _rectifies(recording, view.name)
    ]  # fmt: skip


def _rectifies(recording: Recording, view: str) -> bool:
    try:
        rectification_of(recording, recording.view(view), DepthParameters())
    except (InputError, KeyError):
        return False
    return True


def check_views(recording: Recording, instants: Instants, places: Places) -> Iterator[Finding]:
    """Findings about what the views measured with their cameras at these places."""
    absent = [name for name in places if not any(name in seen for seen in instants)]
    measured = {name: place for name, place in places.items() if name not in absent}
    for name in absent if len(measured) > 1 else ():
        what = "it measures nothing of the person, whom the other views see"
        remedy = "Check its images, its calibration, and that it belongs to this recording."
        yield Finding("warning", f"view {name}", what, remedy)
    if len(measured) < 2:
        return
    given = misfits(instants, measured)
    if given.mean() > _LARGE:
        exchanged = _exchanged(instants, measured, given)
        if exchanged is not None:
            yield exchanged
            return
    surfaces = []
    for seen in instants:
        own = {name: (one, measured[name]) for name, one in seen.items() if name in measured}
        surfaces.append({n: surface_of(s.placed(m), m.translation) for n, (s, m) in own.items()})
    off = list(check_displacements(recording, surfaces, measured))
    if not off and given.mean() > (_LARGE if _without_which(given) else _PLAIN):
        off.append(_contradiction(given))
    yield from off


def _without_which(given: Misfits) -> str:
    """The view without which the others agree; empty where there is none."""
    means = {name: given.mean(name) for name in given.views}
    known = {name: mean for name, mean in means.items() if np.isfinite(mean)}
    best = min(known, key=lambda name: known[name], default="")
    return best if best and known[best] < _LEFT * given.mean() else ""


def _exchanged(instants: Instants, places: Places, given: Misfits) -> Finding | None:
    """Two views that hardly contradict the others once they are exchanged."""
    tried = []
    for a, b in combinations(places, 2):
        left = misfits(instants, {**places, a: places[b], b: places[a]}).mean()
        tried.append((left, a, b))
    left, a, b = min(tried)
    if not left < _LEFT * given.mean():
        return None
    found = exchanged_views(a, b)
    return replace(
        found,
        what=f"{found.what}: other views see through {100 * given.mean():.0f} % of the points or "
        f"do not show them, and {100 * left:.1f} % with this corrected",
    )


def _contradiction(given: Misfits) -> Finding:
    """Views do not fit, and no movement explains it; the view without which the rest does."""
    named = _without_which(given)
    beside = f"{100 * given.mean(named):.1f} % without this view" if named else "hardly any usually"
    return Finding(
        "error",
        f"view {named}" if named else f"views {', '.join(given.views)}",
        f"other views see through {100 * given.mean():.0f} % of the points or do not show them "
        f"({beside})",
        "Check calibration, files, background and synchronisation: no usual slip explains it.",
    )


_REACHES = (0.35, 0.35, 0.3, 0.25, 0.2, 0.15, 0.12, 0.1, 0.08, 0.06, 0.06, 0.06, 0.06, 0.06)
"""Metres within which points are laid onto each other, round by round."""

_SAME_WAY = 0.6  # cosine between normals from which two surfaces may be the same
_NEIGHBOURS = 12
_CLOSE = 0.02  # metres from a surface within which a point fits it
_FEWEST_LAID = 150  # points


@dataclass(frozen=True, eq=False)
class Surface:
    """Points (N, 3) and normals (N, 3) at one instant, world, metres."""

    points: FloatArray
    normals: FloatArray


Surfaces: TypeAlias = Sequence[Mapping[str, Surface]]  # in the world, instant by instant, by view

Places: TypeAlias = Mapping[str, RigidTransform]  # where the rectified cameras are, by view name


@dataclass(frozen=True)
class CloudFit:
    """How a view's points would have to be moved to lie on those of the others."""

    shift: float  # metres by which points move, median
    before: float  # share of the points near another view's surface that lie close to it
    after: float  # the same share after the move

    @property
    def gain(self) -> float:
        """By how much the share rises."""
        return self.after - self.before


def surface_of(points: FloatArray, eye: FloatArray) -> Surface:
    """Points (N, 3) with normals that look at a camera at `eye` (3,)."""
    if len(points) <= _NEIGHBOURS:
        return Surface(np.zeros((0, 3)), np.zeros((0, 3)))
    _, near = scipy.spatial.cKDTree(points).query(points, _NEIGHBOURS)
    patch = points[near] - points[near].mean(axis=1, keepdims=True)
    _, vectors = np.linalg.eigh(np.einsum("nki,nkj->nij", patch, patch))
    normals = vectors[:, :, 0]
    away = np.einsum("ij,ij->i", normals, points - eye) > 0
    normals[away] *= -1.0
    return Surface(points, normals)


class _Pair(NamedTuple):
    """A view's surface and those of the others at one instant."""

    own: Surface
    others: Surface
    tree: scipy.spatial.cKDTree  # of the others' points


def fit_view(surfaces: Surfaces, view: str) -> CloudFit | None:
    """The movement that lays a view's surfaces onto those of the others; None if none are near."""
    pairs = []
    for seen in surfaces:
        rest = [surface for name, surface in seen.items() if name != view]
        if view in seen and len(seen[view].points) and any(len(one.points) for one in rest):
            own = Surface(seen[view].points[::2], seen[view].normals[::2])
            points = np.concatenate([one.points for one in rest])
            others = Surface(points, np.concatenate([one.normals for one in rest]))
            pairs.append(_Pair(own, others, scipy.spatial.cKDTree(points)))
    if not pairs:
        return None
    every = np.concatenate([pair.own.points for pair in pairs])
    about, moved = every.mean(axis=0), RigidTransform.identity()
    for reach in _REACHES:
        laid = [_laid(pair, moved, reach) for pair in pairs]
        points, normal, distances = (np.concatenate(one) for one in zip(*laid, strict=True))
        if len(points) < _FEWEST_LAID:
            return None
        design = np.hstack([np.cross(points - about, normal), normal])
        step = _step(design, distances, 0.3 * reach)
        turn = rotation_from_vector(step[:3])
        moved = RigidTransform(turn, about - turn @ about + step[3:]) @ moved
    close, count = _close(pairs, moved)
    if count < _FEWEST_LAID:
        return None
    before, _ = _close(pairs, RigidTransform.identity())
    shift = float(np.median(np.linalg.norm(moved.apply(every) - every, axis=1)))
    return CloudFit(shift, before / count, close / count)


def _laid(
    pair: _Pair, moved: RigidTransform, reach: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Moved points, the normals of what they are laid onto, and the distances along them."""
    points = moved.apply(pair.own.points)
    far, near = pair.tree.query(points, distance_upper_bound=reach)
    found = np.flatnonzero(np.isfinite(far))
    normal = pair.others.normals[near[found]]
    turned = pair.own.normals[found] @ moved.rotation.T
    same = np.einsum("ij,ij->i", turned, normal) > _SAME_WAY
    found, normal = found[same], normal[same]
    gap = pair.others.points[near[found]] - points[found]
    return points[found], normal, np.einsum("ij,ij->i", gap, normal)


def _step(design: FloatArray, distances: FloatArray, scale: float) -> FloatArray:
    """Small change (6,) that takes the distances away, robustly (Geman-McClure)."""
    weight = 1.0 / np.square(1.0 + np.square(distances / scale))
    weighted = design * weight[:, None]
    normal = weighted.T @ design + 1e-6 * len(design) * np.eye(6)
    return np.asarray(np.linalg.solve(normal, weighted.T @ distances), dtype=np.float64)


def _close(pairs: Sequence[_Pair], moved: RigidTransform) -> tuple[int, int]:
    """Points that lie close to a surface, and those that are near one."""
    distance = np.concatenate([_laid(pair, moved, _REACHES[-1])[2] for pair in pairs])
    return int(np.count_nonzero(np.abs(distance) < _CLOSE)), len(distance)


_LEAST_GAIN, _CLEAR_GAIN = 0.15, 1.5
"""Rise of the share of points that fit, from which a view is off, and how much larger than that of
any other view it is where this one is to blame."""

_LEAST_SHIFT, _WRONG_SHIFT = 0.03, 0.06
"""Metres by which points have to move where a view is doubtful, and plainly wrong. Stereo matching
alone moves surfaces of plain clothes by up to 5 cm."""

_MOST_NAMED = 2  # views that are told where it is not clear which is wrong


def check_displacements(
    recording: Recording, surfaces: Surfaces, places: Places
) -> Iterator[Finding]:
    """The view whose points lie beside those of the others, and by how much."""
    fits = {name: one for name in places if (one := fit_view(surfaces, name)) is not None}
    accurate = len(places) > 2 and all(recording.view(name).kind == "depth" for name in places)
    least = _LEAST_SHIFT if accurate else _WRONG_SHIFT
    off = [name for name, one in fits.items() if one.gain > _LEAST_GAIN and one.shift > least]
    if not off:
        return
    off.sort(key=lambda name: -fits[name].gain)
    first = off[0]
    clear = len(places) > 2 and all(
        fits[first].gain > _CLEAR_GAIN * one.gain for name, one in fits.items() if name != first
    )
    named = [first] if clear else off[:_MOST_NAMED]
    told = [f"the camera is turned, or displaced by {100 * fits[n].shift:.0f} cm" for n in named]
    what = told[0]
    if not clear:
        each = " or ".join(f"of view {n} {words}" for n, words in zip(named, told, strict=True))
        what = f"their depths do not fit, and it cannot be told which view is wrong: {each}"
    grave = max(fits[name].shift for name in named) > _WRONG_SHIFT
    where = named if len(places) > 2 else list(places)  # either of two may be wrong
    where.sort(key=list(places).index)
    yield Finding(
        "error" if grave else "warning",
        f"view{'s' if len(where) > 1 else ''} {', '.join(where)}",
        f"{what}: {100 * fits[first].before:.0f} % of the points lie within 2 cm of the other "
        f"views' surfaces, {100 * fits[first].after:.0f} % with this corrected",
        " ".join(
            f"Calibrate the place of view {name} again, and check that it is synchronised."
            for name in named
        ),
    )

"""Do the depths of the views fit each other? Each view's points against what the others see.

Where a view sees through what another one measured, or does not show it, one of both is elsewhere.
Exchanging two views is tried; else points are laid onto those of the others.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, permutations

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.depth.chain import DepthChain, rectification_of
from stereotrack_core.depth.cloud import ViewDepth, seen_through
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.volume import settled
from stereotrack_core.doctor.displacements import Places, check_displacements, surface_of
from stereotrack_core.doctor.pairs import exchanged_views
from stereotrack_core.errors import Finding, InputError
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
    chain = DepthChain(recording, everywhere, views=views)
    try:
        chain.learn_background(reader, range(reader.frame_count))
        clouds = [chain.process(reader.frame_set(k)) for k in frames]
        places = {name: one.world_from_depth for name, one in chain.geometry.items()}
    finally:
        chain.close()
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
    surfaces = [
        {
            name: surface_of(one.placed(measured[name]), measured[name].translation)
            for name, one in seen.items()
            if name in measured
        }
        for seen in instants
    ]
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

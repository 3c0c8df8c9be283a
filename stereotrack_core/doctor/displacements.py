"""Do the points of a view lie beside those of the others, and what about it may be wrong?

The points of each view are laid onto those of the others, with as little freedom as explains them:
a factor of its distances, or a turn and another place of its camera. The view that gains most is
named.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TypeAlias

from stereotrack_core.doctor.cloud_fit import CloudFit, Surface, Way, fit_clouds, joined
from stereotrack_core.errors import Finding, Severity
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.recording.description import Recording

_LEAST_GAIN, _CLEAR_GAIN = 0.15, 1.5
"""Rise of the share of points that fit, from which a view is off, and how much larger than that of
any other view it is where this one is to blame."""

_FITS = 0.85
"""Share of points close to the others' surfaces from which a view is where it should be."""

_WORTH = 0.2
"""Share of that rise for which a movement is worth more freedom than a factor."""

_LEAST_SHIFT, _WRONG_SHIFT = 0.03, 0.06
"""Metres by which points have to move where a view is doubtful, and plainly wrong. Stereo matching
alone moves surfaces of plain clothes by up to 5 cm."""

_MOST_NAMED = 2
"""Views that are told where it is not clear which is wrong."""

Surfaces: TypeAlias = Sequence[Mapping[str, Surface]]
"""What the views measured as surfaces in the world, instant by instant, by view name."""

Places: TypeAlias = Mapping[str, RigidTransform]
"""Where the rectified cameras are, by view name."""

Explanation: TypeAlias = tuple[float, str, str]
"""Metres by which the points of a view move, what is wrong about it, what to do."""


def check_displacements(
    recording: Recording, surfaces: Surfaces, places: Places
) -> Iterator[Finding]:
    """The view whose points lie beside those of the others, and how."""
    fits = {name: one for name in places if (one := _best_fit(surfaces, places, name)) is not None}
    accurate = len(places) > 2 and all(recording.view(name).kind == "depth" for name in places)
    least = _LEAST_SHIFT if accurate else _WRONG_SHIFT
    off = [name for name, one in fits.items() if _is_off(one) and one.shift > least]
    if not off:
        return
    off.sort(key=lambda name: -fits[name].gain)
    first = off[0]
    clear = len(places) > 2 and all(
        fits[first].gain > _CLEAR_GAIN * one.gain for name, one in fits.items() if name != first
    )
    named = [first] if clear else off[:_MOST_NAMED]
    told = {name: _explanation(recording, surfaces, places, name, fits[name]) for name in named}
    what = told[first][1] if clear else _either({name: one[1] for name, one in told.items()})
    shift = max(one[0] for one in told.values())
    if clear and shift < least:
        return
    severity: Severity = "error" if shift > _WRONG_SHIFT else "warning"
    where = named if len(places) > 2 else list(places)  # either of two may be wrong
    where.sort(key=list(places).index)
    yield Finding(
        severity,
        f"view{'s' if len(where) > 1 else ''} {', '.join(where)}",
        f"{what}: {100 * fits[first].before:.0f} % of the points lie within 2 cm of the other "
        f"views' surfaces, {100 * fits[first].after:.0f} % with this corrected",
        " ".join(one[2] for one in told.values()),
    )


def _either(told: Mapping[str, str]) -> str:
    """One sentence of what may be wrong about several views."""
    each = " or ".join(f"of view {name} {what}" for name, what in told.items())
    return f"their depths do not fit, and it cannot be told which view is wrong: {each}"


def _is_off(fit: CloudFit) -> bool:
    return fit.gain > _LEAST_GAIN and fit.shift > _LEAST_SHIFT


def _best_fit(surfaces: Surfaces, places: Places, view: str) -> CloudFit | None:
    """The better of a free movement and a factor, which is found from farther away."""
    free = fit_view(surfaces, places, view)
    if free is not None and free.before > _FITS and free.gain < _LEAST_GAIN:
        return free  # what lies there already need not be searched for
    factor = fit_view(surfaces, places, view, "range")
    known = [one for one in (free, factor) if one is not None]
    return max(known, key=lambda one: one.gain, default=None)


def fit_view(surfaces: Surfaces, places: Places, view: str, way: Way = "any") -> CloudFit | None:
    """How a view's points would have to be moved to lie on those of the other views."""
    seen = [one for one in surfaces if view in one]
    own = [Surface(one[view].points[::2], one[view].normals[::2]) for one in seen]
    rest = [joined([s for name, s in one.items() if name != view]) for one in seen]
    return fit_clouds(own, rest, places[view].translation, way)


def _explanation(
    recording: Recording, surfaces: Surfaces, places: Places, view: str, fit: CloudFit
) -> Explanation:
    """What may be wrong about a view whose points lie beside those of the others."""
    factor = fit_view(surfaces, places, view, "range")
    if factor is None or factor.after < fit.after - _WORTH * fit.gain:
        return (
            fit.shift,
            f"the camera is turned, or displaced by {100 * fit.shift:.0f} cm",
            f"Calibrate the place of view {view} again, and check that it is synchronised.",
        )
    stereo = recording.view(view).kind == "stereo"
    part = "focal length or base line" if stereo else "depth_unit or focal length"
    size = "large" if factor.amount < 1 else "small"
    return (
        factor.shift,
        f"the distances are too {size} by {abs(100 * (1 / factor.amount - 1)):.0f} %",
        f"The {part} of view {view} is probably wrong by this factor: multiply it by "
        f"{factor.amount:.3f}.",
    )

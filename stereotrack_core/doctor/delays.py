"""Which view shows the person later than the others? By where the limbs that move are in space.

The points of one view that move are compared with what the other views measure some frames before
and after. Motion in the images tells less: from different sides it looks different.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy

from stereotrack_core.arrays import FloatArray
from stereotrack_core.doctor.clocks import span
from stereotrack_core.doctor.displacements import Places
from stereotrack_core.doctor.views import Instants
from stereotrack_core.errors import Correction, Finding

STRETCH, STEP = 44, 2
"""Frames in a row that are looked at, and the step in which they are measured."""

_LONGEST = 12
"""Frames by which a view may be late."""

_FARTHEST = 0.25
"""Metres as which larger distances count."""

_APART, _LEAST_MOTION = 6, 0.1
"""Frames within which points move by so many metres."""

_FEWEST, _MOST_POINTS = 40, 150
"""Points without which nothing is said, and those of a frame that are asked."""

_LEAST, _WRONG = 0.75, 2.0
"""Frames from which a view is late, and plainly late."""

_MENDED, _LEAST_WORTH = 0.68, 0.01
"""Share of the distance that is left in step at most, and metres by which it falls."""


@dataclass(frozen=True)
class Delay:
    """How much later a view shows what the others show."""

    frames: float
    before: float
    """Metres from its moving points to what the others measure at the same frame; root mean
    square."""
    after: float
    """The same with the delay taken away."""

    @property
    def clear(self) -> bool:
        """Whether it fits clearly better so."""
        return self.after < _MENDED * self.before and self.before - self.after > _LEAST_WORTH

    @property
    def worth_telling(self) -> bool:
        """Whether it is more than the measurement's own error."""
        return abs(self.frames) >= _LEAST


def delay_of(instants: Instants, places: Places, view: str, step: int = 1) -> Delay | None:
    """Delay of a view against the others; None where little moves.

    The instants are `step` frames apart.
    """
    longest = _LONGEST // step
    clouds = [{n: o.placed(places[n]) for n, o in seen.items() if n in places} for seen in instants]
    own = [one.get(view) for one in clouds]
    rest = [_rest(one, view) for one in clouds]
    squares = np.zeros(2 * longest + 1)
    count = 0
    for k in range(longest, len(clouds) - longest):
        near = rest[k - longest : k + longest + 1]
        trees = [tree for tree in near if tree is not None]
        moving = _moving(own, k, _APART // step)
        if moving is None or len(trees) < len(near):
            continue
        far = [np.minimum(tree.query(moving)[0], _FARTHEST) for tree in trees]
        squares += [float(np.sum(one**2)) for one in far]
        count += len(moving)
    if count < _FEWEST:
        return None
    distance = np.sqrt(squares / count)
    at = int(np.argmin(distance))
    frames = step * (longest - at - _beside(distance, at))
    return Delay(frames, float(distance[longest]), float(distance[at]))


def _beside(values: FloatArray, at: int) -> float:
    """Where between its neighbours the parabola through the least value (N,) has its bottom."""
    if not 0 < at < len(values) - 1:
        return 0.0
    before, least, after = values[at - 1 : at + 2]
    bend = before - 2 * least + after
    return float(0.5 * (before - after) / bend) if bend > 0 else 0.0


def _rest(cloud: Mapping[str, FloatArray], view: str) -> scipy.spatial.cKDTree | None:
    others = [points for name, points in cloud.items() if name != view]
    return scipy.spatial.cKDTree(np.concatenate(others)) if others else None


def _moving(own: Sequence[FloatArray | None], k: int, apart: int) -> FloatArray | None:
    """Points of frame k that were, or will be, elsewhere; None where there are none."""
    now, before, after = own[k], own[k - apart], own[k + apart]
    if now is None or before is None or after is None:
        return None
    points = now[:: max(1, len(now) // (4 * _MOST_POINTS))]
    away = [scipy.spatial.cKDTree(one).query(points)[0] for one in (before, after)]
    some = points[np.minimum(*away) > _LEAST_MOTION]
    return some[:: max(1, len(some) // _MOST_POINTS)] if len(some) else None


def check_delays(
    instants: Instants, places: Places, fps: float, step: int = 1
) -> Iterator[Finding]:
    """The view that shows everything earlier or later than the others.

    The instants are `step` frames apart.
    """
    known = {name: delay_of(instants, places, name, step) for name in places}
    found = {name: one for name, one in known.items() if one is not None}
    late = {name: one for name, one in found.items() if one.clear and one.worth_telling}
    if not late:
        return
    name = max(late, key=lambda one: late[one].before / max(late[one].after, 1e-6))
    delay = late[name]
    alone = len(places) > 2
    other = next(one for one in places if one != name)
    if delay.frames < 0 and not alone:  # of two views, one is as late as the other is early
        name, other, delay = other, name, replace(delay, frames=-delay.frames)
    others = "the other views" if alone else f"view {other}"
    streams = others if delay.frames < 0 else f"view {name}"
    yield Finding(
        "error" if abs(delay.frames) > _WRONG else "warning",
        f"view {name}" if alone else f"views {', '.join(places)}",
        f"view {name} shows everything {span(delay.frames, fps)} than {others}: limbs that move "
        f"lie {100 * delay.before:.0f} cm from what {others} measured",
        f"Make first_frame of the streams of {streams} larger by "
        f"{max(1, round(abs(delay.frames)))}, or synchronise the cameras (tested: then they lie "
        f"{100 * delay.after:.0f} cm from it).",
        Correction("shift_frames", (name,), float(round(delay.frames) or np.sign(delay.frames))),
    )


def stretch_of(signals: Sequence[FloatArray], frame_count: int) -> range:
    """The frames in a row in which most moves, by the motion (F,) of several streams."""
    count = min(STRETCH, frame_count)
    whole = [one / max(float(one.max()), 1e-9) for one in signals if len(one) >= count]
    if not whole or frame_count <= count:
        return range(count)
    shortest = min(map(len, whole))
    motion = np.sum([one[:shortest] for one in whole], axis=0)
    within = np.convolve(motion, np.ones(count), "valid")
    first = min(int(np.argmax(within)), frame_count - count)
    return range(first, first + count)

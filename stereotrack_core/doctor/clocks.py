"""Do the streams of a recording show the same instants?

By the motion that all of them see; where that tells nothing and views measure depth, by the points
of limbs that move. A lag is believed where the signals agree clearly better than anywhere else. Of
delays of 2 to 8 frames of one of four views, motion finds all on two meshes, within 0.1 frames, and
none on the demo, where arms cross; depth finds four of five there.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, permutations
from typing import TypeAlias

import numpy as np
import scipy

from stereotrack_core.arrays import FloatArray
from stereotrack_core.doctor.views import Instants, Places
from stereotrack_core.errors import Correction, CorrectionKind, Finding, Severity
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.importing import synchronise
from stereotrack_core.recording.reader import FrameReader

_MOST_FRAMES = 600
_FEWEST_FRAMES = 20
_CERTAIN, _ELSEWHERE = 0.6, 0.8  # least correlation, and share of it that the second best may have
_PAIR_CERTAIN = 0.9
_LEAST_PAIR_LAG = 0.5  # frames; those of good pairs differ by up to 0.04
_LEAST_LAG, _WRONG_LAG = 1.5, 3.0
"""Frames from which a view is late, and plainly late. From different sides motion looks different:
views that are synchronised seem to differ by up to a frame."""

_ALONE_CERTAIN, _ALONE_ELSEWHERE, _ALONE_FRAMES = 0.75, 0.6, 100
"""The same of two views that no third one confirms, and frames without which nothing is said. Of 44
pairs of views in step that fulfil this (meshes, simulated and real people), none seems late; of
shorter stretches with other people in view, three of 113 do."""

_SAME = 1.0  # frames by which lags may differ and be taken as one


@dataclass(frozen=True)
class Lag:
    """By how many frames one stream shows everything later than another one."""

    frames: float
    correlation: float
    elsewhere: float

    @property
    def certain(self) -> bool:
        """Whether the signals agree there, and clearly less anywhere else."""
        return self.correlation > _CERTAIN and self.elsewhere < _ELSEWHERE * self.correlation


Signals: TypeAlias = Mapping[tuple[str, str], FloatArray]  # (F,), by view and ``left`` or ``image``


def check_clocks(recording: Recording, signals: Signals) -> Iterator[Finding]:
    """Findings about streams that show the scene earlier or later, by the motion in them."""
    wrong = []
    for view in recording.views:
        pair = signals.get((view.name, "left")), signals.get((view.name, "image"))
        if pair[0] is None or pair[1] is None:
            continue
        lag = lag_of(pair[1], pair[0])
        if abs(lag.frames) >= _LEAST_PAIR_LAG and lag.certain and lag.correlation >= _PAIR_CERTAIN:
            wrong.append(view.name)
            late = f"it shows everything {span(lag.frames, recording.fps)} than the right image"
            what = f"{late} of its pair (correlation of the motion {lag.correlation:.2f})"
            correction = _correction("shift_left", view.name, lag.frames)
            where = f"view {view.name}, left"
            yield Finding("error", where, what, _remedy(lag.frames), correction)
    views = {v: s for (v, key), s in signals.items() if key == "image" and v not in wrong}
    yield from check_lags(views, recording.fps)


def motion_signals(reader: FrameReader) -> Signals:
    """Motion in the first frames of every stream; none where there are too few."""
    if reader.frame_count < _FEWEST_FRAMES:
        return {}
    pictures: dict[tuple[str, str], list[FloatArray]] = {}
    for k in range(min(reader.frame_count, _MOST_FRAMES)):
        for name, images in reader.frame_set(k).views.items():
            pictures.setdefault((name, "image"), []).append(synchronise.reduced(images.image))
            if images.left is not None:
                pictures.setdefault((name, "left"), []).append(synchronise.reduced(images.left))
    whole = max(map(len, pictures.values()), default=0)
    # a stream with frames that cannot be read would seem to run ahead
    return {key: synchronise.motion_of(one) for key, one in pictures.items() if len(one) == whole}


def lag_of(one: FloatArray, other: FloatArray) -> Lag:
    """How much later `other` (F,) shows what `one` (F,) shows."""
    if min(one.std(), other.std()) <= 0:
        return Lag(0.0, 0.0, 0.0)
    return Lag(*synchronise.best_lag(one, other))


def check_lags(signals: Mapping[str, FloatArray], fps: float) -> Iterator[Finding]:
    """The view that is earlier or later than all others, by motion (F,) of every view."""
    names = list(signals)
    if len(names) == 2:
        yield from _check_two(signals, fps)
    lags = {(a, b): lag_of(signals[a], signals[b]) for a, b in permutations(names, 2)}
    for name in names:
        others = [other for other in names if other != name]
        own = [lags[other, name] for other in others if lags[other, name].certain]
        rest = [lags[pair] for pair in combinations(others, 2) if lags[pair].certain]
        if len(own) < 2 or not rest:
            continue
        late = float(np.median([lag.frames for lag in own]))
        agree = all(abs(lag.frames - late) <= _SAME for lag in own)
        together = all(abs(lag.frames) <= _SAME for lag in rest)
        if abs(late) >= _LEAST_LAG and agree and together:
            agreed = f"correlation of the motion {np.median([lag.correlation for lag in own]):.2f}"
            what = f"it shows everything {span(late, fps)} than the other views ({agreed})"
            severity: Severity = "error" if abs(late) >= _WRONG_LAG else "warning"
            correction = _correction("shift_frames", name, late)
            yield Finding(severity, f"view {name}", what, _remedy(late), correction)


def _check_two(signals: Mapping[str, FloatArray], fps: float) -> Iterator[Finding]:
    """Two views that show different instants; nobody knows which is right."""
    (first, one), (second, other) = signals.items()
    lag = lag_of(one, other)
    agree = lag.correlation > _ALONE_CERTAIN
    alone = lag.elsewhere < _ALONE_ELSEWHERE * lag.correlation and len(one) >= _ALONE_FRAMES
    if agree and alone and abs(lag.frames) >= _LEAST_LAG:
        late = second if lag.frames > 0 else first
        said = f"view {second} shows everything {span(lag.frames, fps)} than view {first}"
        what = f"{said} (correlation of the motion {lag.correlation:.2f})"
        change = f"first_frame of the streams of view {late} larger by {abs(round(lag.frames))}"
        remedy = f"Make {change}, or synchronise the cameras."
        yield Finding("warning", f"views {first}, {second}", what, remedy)


def span(frames: float, fps: float) -> str:
    """``2.0 frames (67 ms) later``, for frames by which a stream is late."""
    size = f"{abs(frames):.1f} frames ({1000 * abs(frames) / fps:.0f} ms)"
    return f"{size} {'later' if frames > 0 else 'earlier'}"


def _correction(kind: CorrectionKind, view: str, frames: float) -> Correction | None:
    whole = round(frames)
    return Correction(kind, (view,), float(whole)) if whole else None


def _remedy(frames: float) -> str:
    whole = round(abs(frames))
    if whole == 0:
        return "Set time_offset of its stream, or synchronise the cameras."
    change = f"larger by {whole}" if frames > 0 else f"smaller by {whole}"
    return f"Make first_frame of its streams {change}, or synchronise the cameras."


STRETCH, STEP = 44, 2  # frames in a row that are looked at, and the step in which they are measured
_LONGEST = 12  # frames by which a view may be late
_FARTHEST = 0.25  # metres as which larger distances count
_APART, _LEAST_MOTION = 6, 0.1  # frames within which points move by so many metres
_FEWEST, _MOST_POINTS = 40, 150  # points without which nothing is said, and those asked in a frame
_LEAST, _WRONG = 0.75, 2.0  # frames from which a view is late, and plainly late
_MENDED, _LEAST_WORTH = 0.68, 0.01  # most share of the distance left in step, least fall in m


Delay: TypeAlias = tuple[float, float, float]
"""Frames by which a view is late, and metres (rms) from its moving points to those of the others,
at the same frame, and with the delay taken away."""


def delay_of(instants: Instants, places: Places, view: str, step: int = 1) -> Delay | None:
    """Delay of a view against the others, by instants `step` frames apart; None in stillness."""
    longest = _LONGEST // step
    clouds = [{n: o.placed(places[n]) for n, o in seen.items() if n in places} for seen in instants]
    own = [one.get(view) for one in clouds]
    others = [[points for name, points in one.items() if name != view] for one in clouds]
    rest = [scipy.spatial.cKDTree(np.concatenate(one)) if one else None for one in others]
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
    frames = step * (longest - at - synchronise.beside_least(distance, at))
    return frames, float(distance[longest]), float(distance[at])


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
    """The view that shows everything earlier or later, by instants `step` frames apart."""
    late: dict[str, Delay] = {}
    for name in places:
        if (delay := delay_of(instants, places, name, step)) is not None:
            frames, before, after = delay
            clear = after < _MENDED * before and before - after > _LEAST_WORTH
            if clear and abs(frames) >= _LEAST:
                late[name] = delay
    if not late:
        return
    name = max(late, key=lambda one: late[one][1] / max(late[one][2], 1e-6))
    frames, before, after = late[name]
    alone = len(places) > 2
    other = next(one for one in places if one != name)
    if frames < 0 and not alone:  # of two views, one is as late as the other is early
        name, other, frames = other, name, -frames
    others = "the other views" if alone else f"view {other}"
    streams = others if frames < 0 else f"view {name}"
    yield Finding(
        "error" if abs(frames) > _WRONG else "warning",
        f"view {name}" if alone else f"views {', '.join(places)}",
        f"view {name} shows everything {span(frames, fps)} than {others}: limbs that move lie "
        f"{100 * before:.0f} cm from what {others} measured",
        f"Make first_frame of the streams of {streams} larger by {max(1, round(abs(frames)))}, or "
        f"synchronise the cameras (tested: then they lie {100 * after:.0f} cm from it).",
        Correction("shift_frames", (name,), float(round(frames) or np.sign(frames))),
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

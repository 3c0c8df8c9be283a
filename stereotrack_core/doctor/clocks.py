"""Do the streams of a recording show the same instants?

By the motion that all of them see: the images of a pair see the same motion, and views from
different sides see similar phases of rest and motion. A lag is believed where the signals agree
there clearly better than anywhere else.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import combinations, permutations
from typing import TypeAlias

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.errors import Correction, CorrectionKind, Finding
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.importing.signals import motion_of, reduced
from stereotrack_core.recording.importing.synchronise import best_lag
from stereotrack_core.recording.reader import FrameReader

_MOST_FRAMES = 600
_FEWEST_FRAMES = 20
_CERTAIN, _ELSEWHERE = 0.6, 0.8
"""Correlation from which signals agree, and the share of it that the second best place may have."""

_PAIR_CERTAIN = 0.9
_LEAST_PAIR_LAG = 0.5
"""Frames; those of good pairs differ by up to 0.04."""

_LEAST_LAG, _WRONG_LAG = 1.5, 3.0
"""Frames from which a view is late, and plainly late. From different sides motion looks different:
views that are synchronised seem to differ by up to a frame."""

_SAME = 1.0
"""Frames by which lags may differ and be taken as one."""


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


Signals: TypeAlias = Mapping[tuple[str, str], FloatArray]
"""Motion (F,) in streams, by view and ``left`` or ``image``."""


def check_clocks(recording: Recording, signals: Signals) -> Iterator[Finding]:
    """Findings about streams that show the scene earlier or later, by the motion in them."""
    wrong = []
    for view in recording.views:
        pair = signals.get((view.name, "left")), signals.get((view.name, "image"))
        if pair[0] is not None and pair[1] is not None:
            found = list(_check_pair(view.name, lag_of(pair[1], pair[0]), recording.fps))
            wrong += [view.name] * len(found)
            yield from found
    views = {v: s for (v, key), s in signals.items() if key == "image" and v not in wrong}
    yield from check_lags(views, recording.fps)


def motion_signals(reader: FrameReader) -> Signals:
    """Motion in the first frames of every stream; none where there are too few."""
    if reader.frame_count < _FEWEST_FRAMES:
        return {}
    pictures: dict[tuple[str, str], list[FloatArray]] = {}
    for k in range(min(reader.frame_count, _MOST_FRAMES)):
        for name, images in reader.frame_set(k).views.items():
            pictures.setdefault((name, "image"), []).append(reduced(images.image))
            if images.left is not None:
                pictures.setdefault((name, "left"), []).append(reduced(images.left))
    whole = max(map(len, pictures.values()), default=0)
    # a stream with frames that cannot be read would seem to run ahead
    return {key: motion_of(one) for key, one in pictures.items() if len(one) == whole}


def lag_of(one: FloatArray, other: FloatArray) -> Lag:
    """How much later `other` (F,) shows what `one` (F,) shows."""
    if min(one.std(), other.std()) <= 0:
        return Lag(0.0, 0.0, 0.0)
    return Lag(*best_lag(one, other))


def _check_pair(view: str, lag: Lag, fps: float) -> Iterator[Finding]:
    if abs(lag.frames) < _LEAST_PAIR_LAG or not lag.certain or lag.correlation < _PAIR_CERTAIN:
        return
    yield Finding(
        "error",
        f"view {view}, left",
        f"it shows everything {span(lag.frames, fps)} than the right image of its pair "
        f"(correlation of the motion {lag.correlation:.2f})",
        _remedy(lag.frames),
        _correction("shift_left", view, lag.frames),
    )


def check_lags(signals: Mapping[str, FloatArray], fps: float) -> Iterator[Finding]:
    """The view that is earlier or later than all others, by motion (F,) of every view."""
    names = list(signals)
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
            yield Finding(
                "error" if abs(late) >= _WRONG_LAG else "warning",
                f"view {name}",
                f"it shows everything {span(late, fps)} than the other views (correlation of "
                f"the motion {np.median([lag.correlation for lag in own]):.2f})",
                _remedy(late),
                _correction("shift_frames", name, late),
            )


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

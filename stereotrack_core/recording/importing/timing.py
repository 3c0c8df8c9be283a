"""One rate for all sources: where frames were taken at others, they are picked by their times."""

from __future__ import annotations

from dataclasses import replace

from stereotrack_core.errors import InputError
from stereotrack_core.recording.importing.choices import Choices
from stereotrack_core.recording.importing.sources import MOST_UNEVEN, Source

_MOST_DRIFT = 0.5  # frames over the length of a source
_SAME_START = 0.25  # frames


def at_one_rate(choices: Choices) -> Choices:
    """Choices whose sources all have the frame rate of the recording, and begin together by stamps.

    Sources whose rate is uneven or differs from the recording's are resampled. Where all state the
    instant of each frame, they are resampled from the first instant that all of them show.
    A rate that is given for files that all state another one is taken as the right one.

    Raises InputError where stamped sources have no time in common.
    """
    used = choices.used()
    sources = [use.source for use in used]
    rates = [one.fps for one in sources if one.fps is not None]
    if choices.fps is None or not rates:
        return choices
    agree = all(_drift(one, rates[0]) <= _MOST_DRIFT for one in sources)
    corrected = agree and all(_drift(s, choices.fps) > _MOST_DRIFT for s in sources)
    rate = rates[0] if corrected else choices.fps
    begin = _common_begin(sources, rate)
    uses = []
    for use in choices.uses:
        source = replace(use.source, rate=None, begin=0.0)
        if choices.resample and use in used:
            source = _resampled(source, rate, begin)
        uses.append(replace(use, source=source))
    return replace(choices, uses=tuple(uses))


def _resampled(source: Source, rate: float, begin: float | None) -> Source:
    if begin is not None:
        return replace(source, rate=rate, begin=begin - source.times[0])
    if source.fps is None:
        return source
    needed = source.uneven > MOST_UNEVEN or _drift(source, rate) > _MOST_DRIFT
    return replace(source, rate=rate) if needed else source


def _drift(source: Source, rate: float) -> float:
    """Frames that a source is off at its end when it is shown at a rate."""
    return 0.0 if source.fps is None else source.frames * abs(source.fps / rate - 1.0)


def _common_begin(sources: list[Source], rate: float) -> float | None:
    """The instant at which stamped sources begin; None where they need not be resampled."""
    if not all(one.times for one in sources):
        return None
    begins = [one.times[0] for one in sources]
    even = all(one.uneven <= MOST_UNEVEN and _drift(one, rate) <= _MOST_DRIFT for one in sources)
    if even and (max(begins) - min(begins)) * rate <= _SAME_START:
        return None
    last = min(sources, key=lambda one: one.times[-1])
    latest = max(sources, key=lambda one: one.times[0])
    if last.times[-1] <= latest.times[0]:
        apart = latest.times[0] - last.times[-1]
        raise InputError(
            f"{last.name} ends {apart:.1f} s before {latest.name} begins",
            where=str(last.path),
            remedy="Use sources of the same time, or whose clocks agree.",
        )
    return latest.times[0]

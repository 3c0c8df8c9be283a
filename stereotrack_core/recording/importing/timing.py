"""One rate for all sources: where frames were taken at others, they are picked by their times."""

from __future__ import annotations

from dataclasses import replace

from stereotrack_core.errors import InputError
from stereotrack_core.recording.importing.choices import Choices
from stereotrack_core.recording.importing.source import Source
from stereotrack_core.recording.importing.video_sources import MOST_UNEVEN

_MOST_DRIFT = 0.5  # frames over the length of a source
_SAME_START = 0.25  # frames
_SAME_LENGTH = 0.1  # of the length, within which cameras that were started together stop


def at_one_rate(choices: Choices) -> Choices:
    """Choices whose sources all have the frame rate of the recording, and begin together by stamps.

    Sources whose rate is uneven or differs from the recording's are resampled. Where all state the
    instant of each frame, they are resampled from the first instant that all of them show.
    A rate that is given for files that all state another one is taken as the right one.

    Sources that state no rate are taken frame by frame.

    Raises InputError where stamped sources have no time in common, or a source that states no rate
    is longer or shorter than those that state one.
    """
    used = choices.used()
    sources = [use.source for use in used]
    stated = [one for one in sources if one.fps is not None]
    if choices.fps is None or not stated:
        return choices
    rates = [one.fps for one in stated if one.fps is not None]
    agree = all(_drift(one, rates[0]) <= _MOST_DRIFT for one in stated)
    corrected = agree and all(_drift(s, choices.fps) > _MOST_DRIFT for s in stated)
    rate = rates[0] if corrected else choices.fps
    if choices.resample:
        _check_length(sources, stated, choices.fps)
    begin = _common_begin(sources, rate)
    uses = []
    for use in choices.uses:
        source = replace(use.source, rate=None, begin=0.0)
        if choices.resample and use in used:
            source = _resampled(source, rate, begin)
        uses.append(replace(use, source=source))
    return replace(choices, uses=tuple(uses))


def _check_length(sources: list[Source], stated: list[Source], rate: float) -> None:
    """Refuse to guess the rate of a source whose frames do not fill the time of the others."""
    lengths = [one.frames / one.fps for one in stated if one.fps is not None]
    for one in sources:
        seconds = one.frames / rate
        if one.fps is None and not any(abs(seconds / s - 1) < _SAME_LENGTH for s in lengths if s):
            raise InputError(
                f"{one.name} does not state its frame rate: at {rate:.5g} frames per second, its "
                f"{one.frames} frames last {seconds:.1f} s, {stated[0].name} {lengths[0]:.1f} s",
                where=str(one.path),
                remedy=f"Give its frames per second, on the command line with --fps {one.name}=N.",
            )


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

"""Everything that the images and depths say about a recording.

Of its pictures, pairs, clocks, views and reference.

What an earlier check has found wrong is left out of the later ones: a pair that cannot be matched
has no depth, and a view that is late would seem to stand elsewhere.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

from stereotrack_core.arrays import FloatArray
from stereotrack_core.doctor.clocks import check_clocks, motion_signals
from stereotrack_core.doctor.clouds import check_clouds
from stereotrack_core.doctor.delays import check_delays, stretch_of
from stereotrack_core.doctor.pairs import check_pairs
from stereotrack_core.doctor.pictures import check_pictures
from stereotrack_core.doctor.reference import bodies, check_reference
from stereotrack_core.doctor.views import (
    Instants,
    Places,
    check_views,
    measurable,
    measured_frames,
    measured_views,
)
from stereotrack_core.errors import Finding, InputError
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.reader import FrameReader

_VIEW = re.compile(r"^views? (.+?)(?:, (?:left|right|background))?$")
_GLANCED = 2
"""Frames that a glance looks at."""

_CACHE_BYTES = 128 * 1024 * 1024


def diagnose(recording: Recording) -> tuple[Finding, ...]:
    """Findings by measuring a recording; none where its cameras are guessed.

    Reads up to 600 frames and measures depth in some of them. Raises InputError where a stream
    cannot be opened.
    """
    if recording.guessed:
        return ()
    with FrameReader(recording, colour=False, cache_bytes=_CACHE_BYTES) as reader:
        if not reader.frame_count:
            return ()
        found = [*check_pictures(recording, reader), *check_pairs(recording, reader)]
        signals = motion_signals(reader)
        found += check_clocks(recording, signals)
        found += _delays(recording, reader, found, list(signals.values()))
        found += _measured(recording, reader, found)
        found += check_clouds(recording, reader, _views_of(found))
    return tuple(found)


def glance(recording: Recording, views: Sequence[str] | None = None) -> tuple[Finding, ...]:
    """What a few frames say about the pictures and pairs of some views, or all.

    The short form of :func:`diagnose`: about a second. Raises as it does.
    """
    if recording.guessed:
        return ()
    chosen = tuple(v for v in recording.views if views is None or v.name in views)
    part = replace(recording, views=tuple(v for v in chosen if v.left is not None))
    if not part.views:
        return ()
    with FrameReader(part, colour=False, cache_bytes=_CACHE_BYTES, read_ahead=0) as reader:
        if not reader.frame_count:
            return ()
        return (
            *check_pictures(part, reader, frames=_GLANCED),
            *check_pairs(part, reader),
        )


def _delays(
    recording: Recording,
    reader: FrameReader,
    before: Sequence[Finding],
    motion: Sequence[FloatArray],
) -> Iterator[Finding]:
    """Findings by the points of the person in frames in a row."""
    views = measurable(recording, _views_of(before))
    if len(views) < 2 or not motion:
        return
    stretch = stretch_of(motion, reader.frame_count)
    try:
        instants, places = measured_views(recording, reader, views, frames=stretch)
    except InputError:
        return  # told by the next check
    yield from check_delays(instants, places, recording.fps)


def _measured(
    recording: Recording, reader: FrameReader, before: Sequence[Finding]
) -> Iterator[Finding]:
    """Findings by the points of the person, of views about which nothing was found before."""
    views = measurable(recording, _views_of(before))
    instants: Instants = []
    places: Places = {}
    if views and (len(views) > 1 or recording.reference is not None):
        try:
            instants, places = measured_views(recording, reader, views)
        except InputError as error:
            yield Finding.of(error)
            return
    found = list(check_views(recording, reader, instants, places))
    yield from found
    sound = {name: one for name, one in places.items() if name not in _views_of(found)}
    wholly = not any(one.where.startswith("views ") for one in found)
    measured = bodies(instants, sound, measured_frames(reader)) if sound and wholly else ()
    yield from check_reference(recording, measured)


def _views_of(findings: Iterable[Finding]) -> tuple[str, ...]:
    """Names of the views that findings blame."""
    matches = (_VIEW.match(one.where) for one in findings)
    return tuple(name for match in matches if match for name in match[1].split(", "))

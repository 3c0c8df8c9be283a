"""Everything that the images and depths say about a recording.

Of its pictures, pairs, clocks, views and reference.

What an earlier check has found wrong is left out of the later ones: a pair that cannot be matched
has no depth, and a view that is late would seem to stand elsewhere.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from stereotrack_core.doctor.clocks import Signals, check_clocks, motion_signals
from stereotrack_core.doctor.clouds import check_clouds
from stereotrack_core.doctor.delays import STEP, check_delays, stretch_of
from stereotrack_core.doctor.displacements import Places
from stereotrack_core.doctor.light import check_light
from stereotrack_core.doctor.pairs import check_pairs
from stereotrack_core.doctor.pictures import check_pictures
from stereotrack_core.doctor.reference import bodies, check_reference
from stereotrack_core.doctor.reference_clock import reference_delay
from stereotrack_core.doctor.silhouettes import check_silhouettes, silhouettes_of
from stereotrack_core.doctor.views import (
    Instants,
    check_views,
    measurable,
    measured_frames,
    measured_views,
)
from stereotrack_core.errors import Finding, InputError
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.worker_processes import Asker

_VIEW = re.compile(r"^views? (.+?)(?:, (?:left|right|image|background))?$")
_GLANCED = 2
"""Frames that a glance looks at."""

_CACHE_BYTES = 128 * 1024 * 1024


def diagnose(
    recording: Recording, tell: Callable[[str], None] = lambda _words: None
) -> tuple[Finding, ...]:
    """Findings by measuring a recording; none where its cameras are guessed.

    Reads up to 600 frames and measures depth in some of them; `tell` is told what is looked at.
    Raises InputError where a stream cannot be opened.
    """
    if recording.guessed:
        return ()
    with FrameReader(recording, colour=False, cache_bytes=_CACHE_BYTES) as reader:
        if not reader.frame_count:
            return ()
        tell("images and pairs")
        found = [*check_pictures(recording, reader), *check_pairs(recording, reader)]
        tell("light")
        found += check_light(recording, reader)
        tell("clocks")
        signals = motion_signals(reader)
        found += check_clocks(recording, signals)
        found += _by_silhouettes(recording, reader, _views_of(found))
        tell("depths of the views")
        stretch = stretch_of(list(signals.values()), reader.frame_count)
        found += _measured(recording, reader, found, stretch[::STEP], signals)
        found += check_clouds(recording, reader, _views_of(found))
    return tuple(found)


def diagnose_elsewhere(recording: Recording, asker: Asker) -> tuple[Finding, ...]:
    """The same in a process that works for a window."""
    return diagnose(recording, asker.tell)


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


def _by_silhouettes(
    recording: Recording, reader: FrameReader, doubtful: Sequence[str]
) -> Iterator[Finding]:
    """Findings by the silhouettes of views about which nothing was found before."""
    shown = silhouettes_of(recording, reader)
    yield from check_silhouettes({n: one for n, one in shown.items() if n not in doubtful})


def _measured(
    recording: Recording,
    reader: FrameReader,
    before: Sequence[Finding],
    stretch: range,
    signals: Signals,
) -> Iterator[Finding]:
    """Findings by the points of the person, of views about which nothing was found before."""
    views = measurable(recording, _views_of(before))
    frames = measured_frames(reader)
    every = np.union1d(frames, stretch) if len(views) > 1 else frames
    instants: Instants = []
    places: Places = {}
    if views and (len(views) > 1 or recording.reference is not None):
        try:
            instants, places = measured_views(recording, reader, views, frames=every)
        except InputError as error:
            yield Finding.of(error)
            return
    at = dict(zip(every.tolist(), instants, strict=False))
    late = []
    if len(places) > 1:
        in_a_row = [at[k] for k in stretch]
        late = list(check_delays(in_a_row, places, recording.fps, STEP))
    yield from late
    in_step = {name: one for name, one in places.items() if name not in _views_of(late)}
    spread = [at[k] for k in frames.tolist()] if in_step else []
    found = list(check_views(recording, reader, spread, in_step))
    yield from found
    sound = {name: one for name, one in in_step.items() if name not in _views_of(found)}
    doubtful = _views_of((*before, *late))
    delay = reference_delay(recording, {k: s for k, s in signals.items() if k[0] not in doubtful})
    yield from check_reference(recording, bodies(spread, sound, frames) if sound else (), delay)


def _views_of(findings: Iterable[Finding]) -> tuple[str, ...]:
    """Names of the views that findings blame."""
    matches = (_VIEW.match(one.where) for one in findings)
    return tuple(name for match in matches if match for name in match[1].split(", "))

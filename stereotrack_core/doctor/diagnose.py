"""Everything that the images and depths say about a recording, and whether it should be tracked.

What an earlier check has found wrong is left out of the later ones.
"""

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import closing
from dataclasses import replace

from stereotrack_core.counting import counted
from stereotrack_core.depth.chain import DepthChain
from stereotrack_core.depth.lost_points import LEAST_POINTS, LostPoints
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.volume import is_changed, reach_of, settled
from stereotrack_core.doctor import clocks
from stereotrack_core.doctor.light import check_light, check_pictures
from stereotrack_core.doctor.pairs import check_pairs
from stereotrack_core.doctor.reference import bodies, check_reference
from stereotrack_core.doctor.views import (
    MEASURED,
    Instants,
    Places,
    check_views,
    measurable,
    measured_views,
)
from stereotrack_core.errors import Finding, InputError
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.findings import by_severity, examine_described
from stereotrack_core.recording.images import spread
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.recording.selection import usable_views
from stereotrack_core.worker_processes import Asker

_FRAMES = 6


def check_clouds(
    recording: Recording, reader: FrameReader, doubtful: Sequence[str] = ()
) -> Iterator[Finding]:
    """Findings where no frame gives enough points; views that are `doubtful` are not asked."""
    try:
        views = [name for name in usable_views(recording, None) if name not in doubtful]
    except InputError:
        return  # nothing gives depth, which is no mistake
    if not views:
        return
    parameters, count = DepthParameters(subpixel="matcher", silhouettes=False), reader.frame_count
    try:
        depth = settled(recording, parameters, reader, views)
        chain = DepthChain(recording, depth, views=views)
    except InputError as error:
        yield Finding.of(error)
        return
    lost = LostPoints(recording, depth)
    with closing(chain):
        chain.learn_background(reader, range(count))
        for k in spread(count, _FRAMES):
            cloud = chain.process(reader.frame_set(k))
            if len(cloud.points) >= LEAST_POINTS:
                return
            lost.note(cloud)
    for cause in lost.causes("too few of all views together"):
        where = f"view {', '.join(cause.views)}" if cause.views else "recording.toml"
        yield Finding("error", where, f"there is nothing to track: {cause.what}", cause.remedy)


_VIEW = re.compile(r"^views? (.+?)(?:, (?:left|right|image|background))?$")
_GLANCED = 2  # frames that a glance looks at


def diagnose(
    recording: Recording, tell: Callable[[str], None] = lambda _words: None
) -> tuple[Finding, ...]:
    """Findings by up to 600 frames of a recording; none where its cameras are guessed.

    `tell` is told what is looked at. Raises InputError where a stream cannot be opened.
    """
    if recording.guessed:
        return ()
    with FrameReader(recording, colour=False) as reader:
        if not reader.frame_count:
            return ()
        tell("images and pairs")
        found = [*check_pictures(recording, reader), *check_pairs(recording, reader)]
        tell("light")
        found += check_light(recording, reader)
        tell("clocks")
        signals = clocks.motion_signals(reader)
        found += clocks.check_clocks(recording, signals)
        tell("depths of the views")
        stretch = clocks.stretch_of(list(signals.values()), reader.frame_count)
        found += _measured(recording, reader, found, stretch[:: clocks.STEP])
        found += check_clouds(recording, reader, _views_of(found))
    return tuple(found)


def diagnose_elsewhere(recording: Recording, asker: Asker) -> tuple[Finding, ...]:
    """The same in a process that works for a window."""
    return diagnose(recording, asker.tell)


def glance(recording: Recording, views: Sequence[str] | None = None) -> tuple[Finding, ...]:
    """Findings about the pictures and pairs of some views, or all, in about a second."""
    if recording.guessed:
        return ()
    chosen = tuple(v for v in recording.views if views is None or v.name in views)
    part = replace(recording, views=tuple(v for v in chosen if v.left is not None))
    if not part.views:
        return ()
    with FrameReader(part, colour=False, read_ahead=0) as reader:
        if not reader.frame_count:
            return ()
        return (*check_pictures(part, reader, frames=_GLANCED), *check_pairs(part, reader))


def _measured(
    recording: Recording, reader: FrameReader, before: Sequence[Finding], stretch: range
) -> Iterator[Finding]:
    """Findings by the points of the person, of views about which nothing was found before."""
    views = measurable(recording, _views_of(before))
    frames = spread(reader.frame_count, MEASURED)
    every = sorted({*frames, *stretch}) if len(views) > 1 else frames
    instants: Instants = []
    places: Places = {}
    if views and (len(views) > 1 or recording.reference is not None):
        try:
            instants, places = measured_views(recording, reader, views, frames=every)
        except InputError as error:
            yield Finding.of(error)
            return
    at = dict(zip(every, instants, strict=False))
    late = []
    if len(places) > 1:
        in_a_row = [at[k] for k in stretch]
        late = list(clocks.check_delays(in_a_row, places, recording.fps, clocks.STEP))
    yield from late
    in_step = {name: one for name, one in places.items() if name not in _views_of(late)}
    apart = [at[k] for k in frames] if in_step else []
    found = list(check_views(recording, apart, in_step))
    yield from found
    sound = {name: one for name, one in in_step.items() if name not in _views_of(found)}
    yield from check_reference(recording, bodies(apart, sound, frames) if sound else ())


def _views_of(findings: Iterable[Finding]) -> tuple[str, ...]:
    """Names of the views that findings blame."""
    matches = (_VIEW.match(one.where) for one in findings)
    return tuple(name for match in matches if match for name in match[1].split(", "))


_NOT_TRACKED = ("reference.csv", "segments.csv")  # files that the tracker does not read


def checks_before_tracking(
    recording: Recording, views: Sequence[str] | None = None, depth: DepthParameters | None = None
) -> tuple[Finding, ...]:
    """Findings of the files, a glance, and changed disparities. Raises InputError."""
    found = (*examine_described(recording), *glance(recording, views))
    return by_severity((*found, *changed_reach(recording, views, depth or DepthParameters())))


def changed_reach(
    recording: Recording, views: Sequence[str] | None, depth: DepthParameters
) -> tuple[Finding, ...]:
    """Findings about changed disparities that do not reach the person. Raises InputError."""
    chosen = [v.name for v in recording.views if v.kind != "mono"]
    chosen = [name for name in chosen if views is None or name in views]
    if recording.guessed or not chosen or not is_changed(depth):
        return ()
    with FrameReader(recording, views=chosen, colour=False, read_ahead=0) as reader:
        return reach_of(recording, depth, reader, chosen) if reader.frame_count else ()


def hindrances(
    findings: Iterable[Finding], recording: Recording, views: Sequence[str] | None = None
) -> tuple[Finding, ...]:
    """The errors of which a run with some views, or all, would suffer."""
    others = [v for v in recording.views if views is not None and v.name not in views]
    names = [v.name for v in others]
    names += [s.camera for v in others for s in v.streams().values() if s.camera]
    elsewhere = [re.compile(rf"\b(view|camera) {re.escape(name)}(,|$)") for name in names]
    errors = [one for one in findings if one.severity == "error"]
    tracked = [one for one in errors if not one.where.startswith(_NOT_TRACKED)]
    return tuple(one for one in tracked if not any(p.search(one.where) for p in elsewhere))


def refuse_plainly_wrong(found: Sequence[Finding], where: str, remedy: str) -> None:
    """Raise InputError where there are hindrances: the run would look right and be wrong."""
    if found:
        more = f", and {counted(len(found) - 1, 'more error')}" if len(found) > 1 else ""
        what = f"it would not be tracked correctly: {found[0].where}: {found[0].what}{more}"
        raise InputError(what, where, remedy)

"""What is asked of a recording before it is tracked, and whether it should be."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

from stereotrack_core.counting import counted
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.reach import is_changed, reach_of
from stereotrack_core.doctor.diagnose import glance
from stereotrack_core.errors import Finding, InputError
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.findings import by_severity, examine
from stereotrack_core.recording.reader import FrameReader

_NOT_TRACKED = ("reference.csv", "segments.csv")
"""Files that the tracker does not read."""


def checks_before_tracking(
    recording: Recording,
    views: Sequence[str] | None = None,
    depth: DepthParameters | None = None,
) -> tuple[Finding, ...]:
    """Findings of the files, and of a glance at the images of some views, the gravest first.

    And about disparities that somebody has changed, in the parameters that are to be used.

    Raises InputError where a stream cannot be opened.
    """
    found = (*examine(recording.folder), *glance(recording, views))
    return by_severity((*found, *changed_reach(recording, views, depth or DepthParameters())))


def changed_reach(
    recording: Recording, views: Sequence[str] | None, depth: DepthParameters
) -> tuple[Finding, ...]:
    """Findings about disparities that somebody has changed and that do not reach the person.

    Reads some frames where they were changed. Raises InputError where a stream cannot be opened.
    """
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
    return tuple(
        one
        for one in findings
        if one.severity == "error"
        and not one.where.startswith(_NOT_TRACKED)
        and not any(place.search(one.where) for place in elsewhere)
    )


def refuse_plainly_wrong(found: Sequence[Finding], where: str, remedy: str) -> None:
    """Raise InputError where there are hindrances: the run would look right and be wrong."""
    if found:
        more = f", and {counted(len(found) - 1, 'more error')}" if len(found) > 1 else ""
        raise InputError(
            f"it would not be tracked correctly: {found[0].where}: {found[0].what}{more}",
            where=where,
            remedy=remedy,
        )

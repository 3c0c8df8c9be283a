"""What is asked of a recording before it is tracked, and whether it should be."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

from stereotrack_core.counting import counted
from stereotrack_core.doctor.diagnose import glance
from stereotrack_core.errors import Finding, InputError
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.findings import by_severity, examine

_NOT_TRACKED = ("reference.csv", "segments.csv")
"""Files that the tracker does not read."""


def checks_before_tracking(
    recording: Recording, views: Sequence[str] | None = None
) -> tuple[Finding, ...]:
    """Findings of the files, and of a glance at the images of some views, the gravest first.

    Raises InputError where a stream cannot be opened.
    """
    return by_severity((*examine(recording.folder), *glance(recording, views)))


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

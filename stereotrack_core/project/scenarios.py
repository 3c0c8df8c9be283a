"""Named stretches that results are compared over: the recording's segments and the project's own.

A scenario such as ``crossing`` may have several stretches, which count together.
"""

from collections.abc import Iterable, Mapping
from typing import Any

from stereotrack_core.annotation.click import LAST_FRAME
from stereotrack_core.project.database import making_sense
from stereotrack_core.project.edit import Change, Edit, Stamp, State, facts_of
from stereotrack_core.project.entries import facts_as_json, save_entry
from stereotrack_core.project.project import Project
from stereotrack_core.project.schema import SCENARIO
from stereotrack_core.recording.description import Recording, Segment

_STRETCHES = "stretches"


def scenarios_of(project: Project) -> tuple[Segment, ...]:
    """Stretches of all scenarios, those of one scenario behind each other. ProjectDamaged."""
    with making_sense(project.path):
        every = ((entry.name, _stretches(entry.facts)) for entry in project.scenarios.all())
        return tuple(Segment(name, *stretch) for name, own in every for stretch in own)


def segments_of(project: Project | None, recording: Recording) -> tuple[Segment, ...]:
    """The recording's segments, then the project's scenarios."""
    return recording.segments + (() if project is None else scenarios_of(project))


def keep_scenario(name: str, frames: range) -> Edit:
    """Keep a stretch under a name, beside the stretches that have that name already."""
    name = name.strip()

    def changes(state: State, stamp: Stamp) -> Iterable[Change]:
        before = state.row(SCENARIO, (name,))
        known = () if before is None or before[-1] else _stretches(facts_of(str(before[0])))
        both = sorted({*known, (frames.start, frames.stop)})
        facts = facts_as_json({_STRETCHES: [list(stretch) for stretch in both]})
        return save_entry(SCENARIO, name, facts, replacing=True).changes(state, stamp)

    words = f"name frames {frames.start} to {frames.stop - 1} {name}"
    return Edit("name stretch", words, changes)


def _stretches(facts: Mapping[str, Any]) -> tuple[tuple[int, int], ...]:
    found = tuple((int(first), int(end)) for first, end in facts[_STRETCHES])
    if not all(0 <= first < end <= LAST_FRAME for first, end in found):
        raise ValueError("a scenario has a stretch without frames")
    return found

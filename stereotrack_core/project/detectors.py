"""Import of a detector's files into a project: planned and told first, then done."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from stereotrack_core.annotation.click import Prediction
from stereotrack_core.annotation.detected_body import landmark_predictions
from stereotrack_core.annotation.propose import PROPOSED
from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.interop.keypoints.reading import read_keypoints
from stereotrack_core.interop.keypoints.source import (
    FoundKeypoints,
    KeypointSource,
    joined,
    of_chosen_person,
)
from stereotrack_core.project.predictions import DetectorState
from stereotrack_core.project.prefilling import FIT
from stereotrack_core.project.project import Project
from stereotrack_core.project.selection import Selection, outside_gaps
from stereotrack_core.project.whereabouts import SUFFIX
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.keypoint_names import LANDMARK_OF, layout_named
from stereotrack_core.recording.keypoints import Keypoints, keypoints_of, of_one_person, rows_of

_TAKEN = (FIT, PROPOSED)  # names under which the program keeps predictions of its own


def keypoints_in(
    path: Path, recording: Recording, layout: str | None = None, person: str | None = None
) -> FoundKeypoints:
    """Keypoints of one person, the surest or `person`, of a project or a detector's files.

    `layout` names the order of points without names. Raises InputError where there are none.
    """
    if path.suffix.lower() != SUFFIX:
        named = None if layout is None else layout_named(layout)
        source = KeypointSource(path, recording, layout=named)
        return of_chosen_person(read_keypoints(source), person)
    if layout is not None:
        remedy = "Omit it, or import the file again with this layout."
        raise InputError("the keypoints of a project have names", "--layout", remedy)
    with Project.open(path, read_only=True) as project:
        keypoints = project.keypoints.all()
    if not len(keypoints):
        remedy = "Import them with `stereotrack import predictions`."
        raise InputError("the project has no keypoints", path, remedy)
    return of_chosen_person(FoundKeypoints(keypoints), person)


@dataclass(frozen=True, eq=False)
class DetectorImport:
    """Planned import of a detector's files into a project; nothing is written yet."""

    keypoints: Keypoints  # keypoints to keep
    left_out: Mapping[str, int]  # keypoints that are not, by the reason in words
    notes: tuple[str, ...]  # decisions about them: the order of points, which person
    people: tuple[str, ...]  # names or numbers of all people in the files
    replaced: int  # keypoints of the project that go, because these come in their place
    proposed: int  # landmarks that are proposed as clicks
    before: DetectorState
    after: DetectorState  # content of the project by the detectors, without and with the files

    def facts(self) -> dict[str, Any]:
        """Numbers and names, for a person or a program."""
        kept = self.keypoints
        return {
            "keypoints": len(kept),
            "of_landmarks": sum(name in LANDMARK_OF for name in kept.keypoint.tolist()),
            "frames": len(set(kept.frame.tolist())),
            "cameras": ", ".join(kept.cameras),
            "detectors": ", ".join(self.after.sources),
            "replaced": self.replaced,
            "left_out": dict(self.left_out),
            "notes": list(self.notes),
        }

    def left_out_words(self) -> str:
        """Keypoints left out and why, in a line; ``nothing`` if there are none."""
        told = [f"{counted(count, 'keypoint')} {why}" for why, count in self.left_out.items()]
        return "; ".join(told) or "nothing"


def plan_import(
    project: Project,
    sources: Sequence[KeypointSource],
    frames: int | None = None,
    *,
    all_people: bool = False,
    person: str | None = None,
    propose: bool = False,
) -> DetectorImport:
    """Read files of a detector and work out what they change; the project stays as it is.

    They replace what the project has of the same detector in the same cameras; unless landmarks are
    proposed, earlier proposals stay. One `person` is kept, or `all_people`; `frames` is the
    recording's number. Raises InputError.
    """
    every = joined([read_keypoints(source, frames) for source in sources])
    numbers = np.unique(every.keypoints.person).tolist()
    people = [every.people.get(number, str(number)) for number in numbers]
    found = every if all_people else of_chosen_person(every, person)
    kept = found.keypoints
    if all_people and len(people) > 1:
        named = ", ".join(f"{number} is {name}" for number, name in every.people.items())
        note = f"all {len(people)} people are kept" + (f" ({named})" if named else "")
        found = replace(found, notes=(*found.notes, note))
    names = tuple(sorted(set(kept.source.tolist())))
    for name in names:
        if name in _TAKEN:
            what = f"the detector cannot be called {name!r}"
            raise InputError(what, sources[0].path, "Give another name of the detector.")
    before = project.keypoints.state(names)
    new = landmark_predictions(of_one_person(kept), project.landmark_set().names)
    after = _joined(before, kept, new if propose else None)
    replaced = len(before.keypoints) - (len(after.keypoints) - len(kept))
    proposed = len(project.predictions.unclicked(new)) if propose else 0
    return DetectorImport(
        kept, found.left_out, found.notes, tuple(people), replaced, proposed, before, after
    )


def removal(project: Project, source: str) -> tuple[DetectorState, DetectorState]:
    """Content of the project by a detector, and the same without it."""
    before = project.keypoints.state((source,))
    return before, DetectorState((source,), keypoints_of(()), ())


class DetectorFill(NamedTuple):
    """Change of a project by a detection in some of its frames."""

    before: DetectorState
    after: DetectorState  # keypoints of the detector in the project before and after
    proposed: int  # landmarks of the selection that are proposed as clicks


def plan_fill(
    project: Project, keypoints: Keypoints, predictions: Iterable[Prediction], selection: Selection
) -> DetectorFill:
    """Work out what a detection in a selection changes; the project stays as it is.

    It replaces the same detector's in the selected frames; other landmarks keep their proposals.
    """
    before = project.keypoints.state(tuple(sorted(set(keypoints.source.tolist()))))
    new = outside_gaps(project, (one for one in predictions if selection.has(one.landmark)))
    after = _joined(before, keypoints, new, selection)
    return DetectorFill(before, after, len(project.predictions.unclicked(new)))


def _joined(
    before: DetectorState,
    new: Keypoints,
    proposed: Sequence[Prediction] | None,
    selection: Selection | None = None,
) -> DetectorState:
    """The detectors' rows with `new` for those of the same cameras, perhaps in a selection."""
    here = set(zip(new.source.tolist(), new.camera.tolist(), strict=True))
    here |= {(one.source, one.camera) for one in proposed or ()}

    def goes(source: str, camera: str, frame: int) -> bool:
        within = selection is None or frame in selection.frames
        return within and (source, camera) in here

    old = before.keypoints
    of = zip(old.source.tolist(), old.camera.tolist(), old.frame.tolist(), strict=True)
    stays = np.array([not goes(*place) for place in of], dtype=np.bool_)
    keypoints = keypoints_of([*rows_of(old[stays]), *rows_of(new)])
    if proposed is None:
        return DetectorState(before.sources, keypoints, before.proposed)
    kept = (
        one
        for one in before.proposed
        if not goes(one.source, one.camera, one.frame)
        or (selection is not None and not selection.has(one.landmark))
    )
    return DetectorState(before.sources, keypoints, (*kept, *proposed))

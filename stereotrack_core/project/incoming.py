"""Take in clicks from a file or from another project; what contradicts is decided, not overwritten.

Clicks that are new are taken. Where the project says something else, also where it says that a
click was deleted, nothing happens until somebody decides.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, TypeAlias

from stereotrack_core.annotation.agreement import Difference, differences
from stereotrack_core.annotation.click import Click, ClickKey
from stereotrack_core.errors import InputError
from stereotrack_core.project.click_edits import PlaceClicks
from stereotrack_core.project.database import resolved
from stereotrack_core.project.project import Project
from stereotrack_core.recording.finding import Finding

Side: TypeAlias = Literal["mine", "theirs"]


@dataclass(frozen=True)
class Incoming:
    """Clicks from elsewhere beside those of the project.

    Attributes
    ----------
    source : str
        Where they come from: a file or a project, as the person knows it.
    new : tuple of Click
        The project says nothing about them.
    same : tuple of Click
        The project says the same.
    conflicts : tuple of Difference
        ``first`` is the project's click, ``second`` the other; one of them may be deleted.
    """

    source: str
    new: tuple[Click, ...]
    same: tuple[Click, ...]
    conflicts: tuple[Difference, ...]

    def edit(self, decisions: Mapping[ClickKey, Side] | Side | None = None) -> PlaceClicks:
        """The one edit that takes in what is new, and the conflicts decided for the other side.

        Parameters
        ----------
        decisions : mapping from ClickKey to {"mine", "theirs"}, or one of them for all

        Raises
        ------
        InputError
            Where a conflict is not decided.
        """
        taken = list(self.new)
        for conflict in self.conflicts:
            if isinstance(decisions, str):
                decided: Side | None = decisions
            else:
                decided = (decisions or {}).get(conflict.key)
            if decided is None:
                raise self._undecided(conflict)
            if decided == "theirs" and conflict.second is not None:
                taken.append(conflict.second)
        number = f"{len(taken)} click{'' if len(taken) == 1 else 's'}"
        return PlaceClicks(tuple(taken), f"take {number} from {self.source}")

    def _undecided(self, conflict: Difference) -> InputError:
        frame, camera, landmark = conflict.key
        several = len(self.conflicts) > 1
        return InputError(
            f"{len(self.conflicts)} click{'s are' if several else ' is'} there already and"
            f" {'say' if several else 'says'} something else, such as"
            f" {landmark} in {camera}, frame {frame}",
            where=self.source,
            remedy="Decide whether the project's or the other ones stay.",
        )


def incoming(
    mine: Iterable[Click], theirs: Iterable[Click], source: str, *, complete: bool = True
) -> Incoming:
    """Compare clicks from elsewhere with those of the project.

    Parameters
    ----------
    mine : iterable of Click
        All clicks of the project, deleted ones too.
    theirs : iterable of Click
        Where a deleted click meets nothing, nothing comes of it.
    source : str
    complete : bool
        Whether the source can say flag and sigma; a clicks file cannot, and leaves them alone.
    """
    ours = {click.key: click for click in mine}
    others = list(theirs)
    if not complete:
        others = [_with_marks_of(ours.get(click.key), click) for click in others]
    new, same, conflicts = [], [], []
    for found in differences(ours.values(), others):
        if found.second is None:
            continue
        if found.first is None:
            if not found.second.deleted:
                new.append(found.second)
        elif found.first.says_the_same(found.second):
            same.append(found.second)
        else:
            conflicts.append(found)
    return Incoming(source, tuple(new), tuple(same), tuple(conflicts))


def clicks_of_project(
    path: Path, project: Project
) -> tuple[tuple[Click, ...], tuple[Finding, ...]]:
    """All clicks of another project of the same recording, deleted ones too.

    Returns
    -------
    clicks : tuple of Click
    notes : tuple of Finding
        What the person should know about that project.

    Raises
    ------
    InputError
        Where it is this project, is of another recording, or cannot be read.
    """
    if resolved(path) == project.path:
        raise InputError(
            "this is the project that is open", where=str(path), remedy="Choose another one."
        )
    with Project.open(path, read_only=True) as other:
        theirs, ours = other.recording_place(), project.recording_place()
        if theirs.fingerprint != ours.fingerprint:
            raise InputError(
                f"this is a project of another recording ({theirs.name})",
                where=str(path),
                remedy=f"Give a project of {ours.name}.",
            )
        return other.clicks.all(with_deleted=True), other.notes


def _with_marks_of(mine: Click | None, click: Click) -> Click:
    return click if mine is None else replace(click, flag=mine.flag, sigma=mine.sigma)

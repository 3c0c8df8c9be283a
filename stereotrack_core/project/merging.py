"""Clicks of a file or another project beside the own: new ones are taken, the others as decided."""

from collections.abc import Collection, Iterable
from dataclasses import dataclass, replace
from math import sqrt
from pathlib import Path
from typing import Any, Literal, TypeAlias

from stereotrack_core.annotation.agreement import Difference, differences
from stereotrack_core.annotation.click import Click
from stereotrack_core.counting import counted
from stereotrack_core.errors import Finding, InputError
from stereotrack_core.project.clicks import place_clicks
from stereotrack_core.project.edit import Edit
from stereotrack_core.project.project import Project

_MEAN = "merged"  # origin of a click between two others
Decision: TypeAlias = Literal["mine", "theirs", "mean"]


def _mean_click(conflict: Difference) -> Click | None:
    """The place between two clicks, as visible as the worse and surer; None without both places."""
    mine, theirs = conflict.first, conflict.second
    if conflict.apart is None or mine is None or theirs is None or mine.position is None:
        return None
    sigma = None
    if mine.sigma is not None and theirs.sigma is not None:
        sigma = 0.5 * sqrt(mine.sigma**2 + theirs.sigma**2)
    x, y = mine.position
    return Click(
        *conflict.key,
        position=(x + 0.5 * conflict.apart[0], y + 0.5 * conflict.apart[1]),
        visibility=min(mine.visibility, theirs.visibility),
        flag=mine.flag or theirs.flag,
        sigma=sigma,
        origin=_MEAN,
    )


@dataclass(frozen=True)
class Incoming:
    """Clicks from elsewhere beside those of the project; what contradicts is decided by a person.

    In conflicts, ``first`` is the project's click, ``second`` the other; one may be deleted.
    """

    source: str
    new: tuple[Click, ...]
    same: tuple[Click, ...]
    conflicts: tuple[Difference, ...]

    def taken(self, decision: Decision | None = None) -> list[Click]:
        """Clicks to take in: what is new, and for all conflicts what was decided.

        Where there is no mean, the project's click stays. Raises InputError without a decision.
        """
        if decision is None and self.conflicts:
            frame, camera, landmark = self.conflicts[0].key
            several = len(self.conflicts) > 1
            raise InputError(
                f"{len(self.conflicts)} click{'s' if several else ''} already in the project "
                f"differ{'' if several else 's'}, such as {landmark} in {camera}, frame {frame}",
                self.source,
                "Nothing was imported. Choose whether to keep the project's clicks or use "
                "the others: with --conflicts mine or theirs, or in the workbench.",
            )
        decided: list[Click | None] = []
        if decision == "theirs":
            decided = [one.second for one in self.conflicts]
        elif decision == "mean":
            decided = [_mean_click(one) for one in self.conflicts]
        return [*self.new, *(click for click in decided if click is not None)]

    def edit(self, decision: Decision | None = None) -> Edit:
        """The one edit that takes in :meth:`taken`."""
        taken = self.taken(decision)
        means = sum(click.origin == _MEAN for click in taken)
        between = f", {means} of them mean positions," if decision == "mean" and means else ""
        words = f"merge {counted(len(taken), 'click')}{between} from {self.source}"
        return place_clicks(taken, words)


def incoming(
    mine: Iterable[Click], theirs: Iterable[Click], source: str, *, unstated: Collection[str] = ()
) -> Incoming:
    """Compare clicks from elsewhere with those of the project, both with the deleted ones.

    Fields of :class:`Click` that are `unstated` the source cannot say, and leaves alone.
    """
    ours = {click.key: click for click in mine}
    others = list(theirs)
    if unstated:
        others = [_completed(click, ours.get(click.key, click), unstated) for click in others]
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


def _completed(theirs: Click, mine: Click, unstated: Collection[str]) -> Click:
    """A click with what its source cannot say from mine, as far as that goes with its place."""
    fields = set(unstated)
    if theirs.position is None or mine.position is None:
        fields.discard("visibility")
    kept: dict[str, Any] = {name: getattr(mine, name) for name in fields}
    return replace(theirs, **kept)


def clicks_of_project(
    path: Path, project: Project
) -> tuple[tuple[Click, ...], tuple[Finding, ...]]:
    """All clicks of another project of the recording, and notes about it. Raises InputError."""
    if path.resolve() == project.path:
        raise InputError("this project is already open", path, "Choose another project.")
    with Project.open(path, read_only=True) as other:
        theirs, ours = other.recording_place(), project.recording_place()
        if theirs.fingerprint != ours.fingerprint:
            what = f"this project is of a different recording ({theirs.name})"
            raise InputError(what, path, f"Choose a project of {ours.name}.")
        return other.clicks.all(with_deleted=True), other.notes

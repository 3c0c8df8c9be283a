"""Clicks from a file or another project beside the project's, and what becomes of each."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass

from stereotrack_core.annotation.agreement import Difference, farthest_first
from stereotrack_core.annotation.click import ClickKey
from stereotrack_core.errors import InputError
from stereotrack_core.project.clicks import PlaceClicks
from stereotrack_core.project.merging import Decision, Incoming, has_mean

from ....session.counting import counted

_SHOWN_PROBLEMS = 50


@dataclass(frozen=True)
class Kinds:
    """How many clicks there are of each kind.

    Attributes
    ----------
    new, same : int
        The project says nothing about them; it says the same.
    moved : int
        Both have a place, but not the same one, or another flag or sigma.
    seen_differently : int
        One says that the landmark is outside the image.
    deleted : int
        One side has taken the click away.
    """

    new: int
    same: int
    moved: int
    seen_differently: int
    deleted: int

    @property
    def conflicts(self) -> int:
        """Clicks that contradict each other."""
        return self.moved + self.seen_differently + self.deleted


class TakeIn:
    """What would be taken in, decided click by click; nothing is written before :meth:`edit`.

    Parameters
    ----------
    incoming : Incoming
    problems : iterable of InputError
        What could not be read at all.
    """

    def __init__(self, incoming: Incoming, problems: Iterable[InputError] = ()) -> None:
        self.incoming = incoming
        self.problems = tuple(problems)
        self._rows = _in_order(incoming.conflicts)
        self._decisions: dict[ClickKey, Decision] = {}
        self.with_new = True

    @property
    def conflicts(self) -> tuple[Difference, ...]:
        """What contradicts, the worst first."""
        return self._rows

    def kinds(self) -> Kinds:
        """Clicks counted."""
        found = Counter(_kind(one) for one in self._rows)
        return Kinds(
            len(self.incoming.new),
            len(self.incoming.same),
            found["moved"],
            found["seen"],
            found["deleted"],
        )

    def decision(self, row: int) -> Decision:
        """What becomes of a conflict; the project's click stays until something else is said."""
        return self._decisions.get(self._rows[row].key, "mine")

    def decide(self, rows: Iterable[int], decision: Decision) -> None:
        """Decide conflicts; where there is no mean, the decision stays as it was."""
        for row in rows:
            conflict = self._rows[row]
            if decision != "mean" or has_mean(conflict):
                self._decisions[conflict.key] = decision

    def with_decisions_of(self, other: TakeIn) -> TakeIn:
        """The comparison itself, with what was decided in another one of the same clicks."""
        known = {one.key for one in self._rows}
        self._decisions = {key: d for key, d in other._decisions.items() if key in known}
        self.with_new = other.with_new
        return self

    def edit(self) -> PlaceClicks:
        """The one edit that does what was decided.

        Raises
        ------
        InputError
            Where nothing would change.
        """
        edit = self.incoming.edit(self._decisions, with_new=self.with_new)
        if not edit.clicks:
            raise InputError(
                "nothing to merge",
                where=self.incoming.source,
                remedy="All clicks are already in the project, or yours were kept.",
            )
        return edit

    def taken(self) -> int:
        """Number of clicks that :meth:`edit` would write."""
        return len(self.incoming.edit(self._decisions, with_new=self.with_new).clicks)

    def summary(self) -> str:
        """``412 new, 1208 equal, 5 differ: 3 moved, 1 seen differently, 1 deleted``."""
        kinds = self.kinds()
        parts = [f"{kinds.new} new", f"{kinds.same} equal"]
        if kinds.conflicts:
            names = ("moved", "different visibility", "deleted on one side")
            numbers = (kinds.moved, kinds.seen_differently, kinds.deleted)
            said = [f"{n} {name}" for n, name in zip(numbers, names, strict=True) if n]
            parts.append(f"{kinds.conflicts} differ ({', '.join(said)})")
        return f"{self.incoming.source}: {', '.join(parts)}."

    def what_happens(self) -> str:
        """What taking in would do, in words."""
        taken = self.taken()
        kept = len(self._rows) - (taken - len(self.incoming.new) * self.with_new)
        words = f"{counted(taken, 'click')} will be written"
        left = f", {counted(kept, 'conflict')} keep the project's click" if kept else ""
        return f"{words}{left}."

    def problem_words(self) -> tuple[str, ...]:
        """What could not be read, line by line."""
        shown = self.problems[:_SHOWN_PROBLEMS]
        words = [f"{problem.what}. {problem.remedy}".strip() for problem in shown]
        if (more := len(self.problems) - len(words)) > 0:
            words.append(f"and {more} more")
        return tuple(words)


def _in_order(conflicts: Iterable[Difference]) -> tuple[Difference, ...]:
    conflicts = tuple(conflicts)
    worst = farthest_first(conflicts)
    known = {one.key for one in worst}
    return (*worst, *(one for one in conflicts if one.key not in known))


def _kind(conflict: Difference) -> str:
    if conflict.kind in ("only first", "only second"):
        return "deleted"
    return "seen" if conflict.kind == "seen differently" else "moved"

"""Clicks from a file or another project beside the project's, and what becomes of each."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

from stereotrack_core.annotation.agreement import Difference, farthest_first
from stereotrack_core.annotation.click import ClickKey
from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.project.clicks import PlaceClicks
from stereotrack_core.project.merging import Decision, Incoming, has_mean

_SHOWN_PROBLEMS = 50
_KINDS = {
    "only first": "deleted on one side",
    "only second": "deleted on one side",
    "seen differently": "different visibility",
}


class TakeIn:
    """What would be merged, decided click by click; nothing is written before :meth:`edit`.

    Attributes
    ----------
    problems : tuple of InputError
        What could not be read at all.
    conflicts : tuple of Difference
        What contradicts, the worst first.
    with_new : bool
        Whether clicks that the project says nothing about are taken.
    """

    def __init__(self, incoming: Incoming, problems: Iterable[InputError] = ()) -> None:
        self.incoming, self.problems = incoming, tuple(problems)
        worst = farthest_first(incoming.conflicts)
        known = {one.key for one in worst}
        others = (one for one in incoming.conflicts if one.key not in known)
        self.conflicts: tuple[Difference, ...] = (*worst, *others)
        self._decisions: dict[ClickKey, Decision] = {}
        self.with_new = True

    def decision(self, row: int) -> Decision:
        """What becomes of a conflict; the project's click stays until something else is said."""
        return self._decisions.get(self.conflicts[row].key, "mine")

    def decide(self, rows: Iterable[int], decision: Decision) -> None:
        """Decide conflicts; where there is no mean, the decision stays as it was."""
        for row in rows:
            conflict = self.conflicts[row]
            if decision != "mean" or has_mean(conflict):
                self._decisions[conflict.key] = decision

    def with_decisions_of(self, other: TakeIn) -> TakeIn:
        """The comparison itself, with what was decided in another one of the same clicks."""
        known = {one.key for one in self.conflicts}
        self._decisions = {key: d for key, d in other._decisions.items() if key in known}
        self.with_new = other.with_new
        return self

    def edit(self) -> PlaceClicks:
        """The one edit that does what was decided; of no click where nothing would change."""
        return self.incoming.edit(self._decisions, with_new=self.with_new)

    def summary(self) -> str:
        """``412 new, 1208 equal, 4 differ (3 moved, 1 different visibility)``."""
        parts = [f"{len(self.incoming.new)} new", f"{len(self.incoming.same)} equal"]
        if self.conflicts:
            found = Counter(_KINDS.get(one.kind, "moved") for one in self.conflicts)
            names = ("moved", "different visibility", "deleted on one side")
            said = ", ".join(f"{found[name]} {name}" for name in names if found[name])
            parts.append(f"{len(self.conflicts)} differ ({said})")
        return f"{self.incoming.source}: {', '.join(parts)}."

    def what_happens(self) -> str:
        """What :meth:`edit` would do, in words; empty for nothing."""
        taken = len(self.edit().clicks)
        kept = len(self.conflicts) - (taken - len(self.incoming.new) * self.with_new)
        words = f"{counted(taken, 'click')} will be written"
        left = f", {counted(kept, 'conflict')} keep the project's click" if kept else ""
        return f"{words}{left}." if taken else ""

    def problem_words(self) -> tuple[str, ...]:
        """What could not be read, line by line."""
        shown = self.problems[:_SHOWN_PROBLEMS]
        words = [f"{problem.what}. {problem.remedy}".strip() for problem in shown]
        if (more := len(self.problems) - len(words)) > 0:
            words.append(f"and {more} more")
        return tuple(words)

"""Two readings become one: for each click the project's, the other one, or their mean."""

from __future__ import annotations

from collections.abc import Mapping
from math import sqrt
from typing import Literal, TypeAlias

from stereotrack_core.annotation.agreement import Difference
from stereotrack_core.annotation.click import Click, ClickKey
from stereotrack_core.errors import InputError
from stereotrack_core.project.click_edits import PlaceClicks
from stereotrack_core.project.incoming import Incoming

Decision: TypeAlias = Literal["mine", "theirs", "mean"]

MERGED = "merged"
"""Origin of a click that is the mean of two."""


def has_mean(conflict: Difference) -> bool:
    """Whether both sides give a position, so that there is a place between them."""
    return conflict.apart is not None


def mean_click(conflict: Difference) -> Click:
    """The place between two clicks.

    It is as visible and as sure as the worse of both says; where both state how sure they are,
    the mean of two independent clicks is surer.

    Raises
    ------
    InputError
        Where one of them has no place.
    """
    mine, theirs = conflict.first, conflict.second
    if conflict.apart is None or mine is None or theirs is None or mine.position is None:
        frame, camera, landmark = conflict.key
        raise InputError(
            f"{landmark} in {camera}, frame {frame}, has a place in one reading only",
            remedy="Take the project's or the other one; there is no mean.",
        )
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
        origin=MERGED,
    )


def merging_edit(
    incoming: Incoming, decisions: Mapping[ClickKey, Decision], *, with_new: bool = True
) -> PlaceClicks:
    """The one edit that takes in what is new and what was decided; the rest stays as it is.

    Parameters
    ----------
    incoming : Incoming
    decisions : mapping from ClickKey
        Conflicts without a decision stay the project's.
    with_new : bool
        Whether clicks that the project says nothing about are taken in.

    Raises
    ------
    InputError
        Where a mean was asked for that there is not.
    """
    taken = list(incoming.new) if with_new else []
    means = 0
    for conflict in incoming.conflicts:
        decision = decisions.get(conflict.key, "mine")
        if decision == "mean":
            taken.append(mean_click(conflict))
            means += 1
        elif decision == "theirs" and conflict.second is not None:
            taken.append(conflict.second)
    number = f"{len(taken)} click{'' if len(taken) == 1 else 's'}"
    between = f", {means} of them means," if means else ""
    return PlaceClicks(tuple(taken), f"take {number}{between} from {incoming.source}")

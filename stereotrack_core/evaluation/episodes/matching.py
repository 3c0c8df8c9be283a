"""How many of the episodes found without truth are right, and how many of the right ones found."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import maximum_bipartite_matching

from stereotrack_core.evaluation.episodes.episode import Episode


@dataclass(frozen=True)
class Agreement:
    """Counts of episodes.

    Attributes
    ----------
    true : int
        Found with truth.
    found : int
        Those of them that one found without truth overlaps, on the same limb.
    called : int
        Found without truth.
    right : int
        Those of them that overlap one found with truth, on the same limb.
    pairs : int
        Most of either that can be matched when each belongs to one other only: a long one that
        is called and overlaps several true ones finds all of them, but makes one pair.
    """

    true: int = 0
    found: int = 0
    called: int = 0
    right: int = 0
    pairs: int = 0

    @property
    def precision(self) -> float:
        """Share of those found without truth that are right; NaN where there are none."""
        return self.right / self.called if self.called else float("nan")

    @property
    def recall(self) -> float:
        """Share of those found with truth that are found without; NaN where there are none."""
        return self.found / self.true if self.true else float("nan")


def agreement(
    truth: Sequence[Episode], called: Sequence[Episode], right: Sequence[Episode] | None = None
) -> Agreement:
    """Match episodes: two belong together where they share a frame and a limb.

    Parameters
    ----------
    truth : sequence of Episode
        What shall be found.
    called : sequence of Episode
        What was found without truth.
    right : sequence of Episode, optional
        What may be found, where that is more than what shall be: episodes by a lower threshold.
    """
    allowed = truth if right is None else right
    overlap = np.array([[one.overlaps(other) for other in called] for one in truth], dtype=np.bool_)
    overlap = overlap.reshape(len(truth), len(called))
    matched = maximum_bipartite_matching(csr_array(overlap))
    return Agreement(
        true=len(truth),
        found=int(overlap.any(axis=1).sum()),
        called=len(called),
        right=sum(any(one.overlaps(other) for other in allowed) for one in called),
        pairs=int((matched >= 0).sum()),
    )


def pooled(parts: Iterable[Agreement]) -> Agreement:
    """Counts of several runs together."""
    every = list(parts)
    return Agreement(
        sum(part.true for part in every),
        sum(part.found for part in every),
        sum(part.called for part in every),
        sum(part.right for part in every),
        sum(part.pairs for part in every),
    )

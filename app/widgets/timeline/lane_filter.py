"""Which lanes of an annotation are shown."""

from __future__ import annotations

from dataclasses import dataclass

KINDS = ("landmarks", "uncertainty", "residual")
"""Kinds of lanes that can be shown or hidden together."""

KIND_WORDS = {
    "landmarks": "Clicks of each landmark",
    "uncertainty": "Uncertainty of each limb [°]",
    "residual": "Residual of each limb [px]",
}


@dataclass(frozen=True)
class LaneFilter:
    """Which lanes are shown.

    Attributes
    ----------
    kinds : frozenset of str
        Of :data:`KINDS`.
    hidden : frozenset of str
        What lanes are called (``Lane.id``) that are left out.
    only_flagged : bool
        Leave out the landmarks without a flagged frame, and all limbs.
    """

    kinds: frozenset[str] = frozenset({"landmarks", "uncertainty"})
    hidden: frozenset[str] = frozenset()
    only_flagged: bool = False

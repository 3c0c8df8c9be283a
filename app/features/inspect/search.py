"""The search for the arms in tables and words."""

from __future__ import annotations

import numpy as np

from stereotrack_core.tracking.trace import Pair, Proposals, Search

from ...widgets.plots.inside_content import Table

_SHOWN = 6
_TIPS = {
    "data": "Measured points that neither torso nor arms explain",
    "sight": "Arm positions that a view sees through, or that no view supports",
    "anatomy": "Elbows bent too far, arms inside the torso, implausible arm positions",
    "change": "Change from the predicted arms",
    "crossing": "Arms that intersect each other",
    "pictures": "Parts of the pose that views should see and do not",
}

_SHORT = {
    "data": "Data",
    "sight": "Visib.",
    "anatomy": "Anat.",
    "change": "Change",
    "crossing": "Cross",
    "pictures": "Views",
}


def search_words(search: Search) -> str:
    """What was tried, and what came of it."""
    tried = [len(one.cost) for one in search.proposals]
    places = " and ".join(str(count) for count in tried) or "no"
    best = min(search.pairs, key=lambda pair: pair.cost, default=None)
    said = f"{places} candidates for the left and the right arm were scored."
    if search.followed.chosen or best is None:
        return f"{said} The tracked arms were kept."
    less = search.followed.cost - best.cost
    return f"{said} Other arms were chosen, at a cost lower by {less:.1f}."


def pairs_table(search: Search) -> Table:
    """Pairs of places that were refined, with what speaks against them."""
    names = tuple(search.followed.terms)
    pairs: list[tuple[str, Pair]] = [("followed", search.followed)]
    pairs += [(f"pair {i}", pair) for i, pair in enumerate(search.pairs, start=1)]
    rows = tuple(
        (
            f"{name}, chosen" if pair.chosen else name,
            f"{pair.cost:.1f}",
            *(f"{pair.terms[each]:.1f}" for each in names),
        )
        for name, pair in pairs
    )
    strong = tuple(i for i, (_, pair) in enumerate(pairs) if pair.chosen)
    title = f"Cost of pairs of arms. A new pair must cost {search.gain:g} less."
    headings = ("Arms", "Total", *(_SHORT.get(name, name) for name in names))
    tips = ("", "Sum of all terms", *(_TIPS.get(name, "") for name in names))
    return Table(title, headings, rows, strong=strong, tips=tips)


def proposals_table(proposals: Proposals) -> Table:
    """The best places for one arm."""
    side = "left" if proposals.side == 0 else "right"
    names = tuple(proposals.terms)
    order = np.argsort(proposals.cost, kind="stable")[:_SHOWN].tolist()
    rows = tuple(
        (
            f"{_direction(proposals.upper[k])}, then {_direction(proposals.fore[k])}",
            f"{proposals.cost[k]:.1f}",
            *(f"{proposals.terms[name][k]:.1f}" for name in names),
        )
        for k in order
    )
    kept = int(np.count_nonzero(proposals.kept))
    title = (
        f"Best candidates for the {side} arm, of {len(proposals.cost)}; pairs were formed from "
        f"{kept}"
    )
    headings = ("Upper arm, forearm", "Total", *(_SHORT.get(name, name) for name in names))
    tips = ("", "Sum of all terms", *(_TIPS.get(name, "") for name in names))
    limb = f"{side}_upper_arm"
    return Table(title, headings, rows, (limb,) * len(rows), tips=tips)


def _direction(along: np.ndarray[tuple[int], np.dtype[np.float64]]) -> str:
    """Where a limb points as the person sees it: ``forward down``."""
    x, y, z = along.tolist()
    names = [
        ("forward" if y > 0 else "backward", abs(y)),
        ("up" if z > 0 else "down", abs(z)),
        ("right" if x > 0 else "left", abs(x)),
    ]
    strong = [name for name, share in sorted(names, key=lambda each: -each[1]) if share > 0.4]
    return " ".join(strong)

"""Why a search chose wrong arms: true ones were missed, cost more, or were shown by no data."""

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal, TypeAlias

import numpy as np

from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.geometry.rotation import angle_between
from stereotrack_core.tracking.trace import Search, TrueArms

Why: TypeAlias = Literal["search", "cost", "data", "right"]

WHY_WORDS: Mapping[Why, str] = MappingProxyType(
    {
        "search": "search missed it",
        "cost": "cost wrong",
        "data": "data missing",
        "right": "arms correct",
    }
)
TERM_WORDS: Mapping[str, str] = MappingProxyType(
    {
        "data": "measured points that nothing explains",
        "pictures": "views that do not show the pose",
        "keypoints": "keypoints elsewhere",
        "anatomy": "implausible arms",
        "change": "change from the predicted arms",
        "crossing": "arms that intersect",
        "gain": "the gain that other arms need",
    }
)
"""Terms of the arm search's cost, and what else may keep the true arms out, in words."""

_POINTS_TO: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "search": ("search_proposals", "search_refined", "second_look", "search_iterations"),
        "data": ("background_threshold", "speckle_size", "outlier_distance", "second_look"),
        "cost": ("picture_cost", "keypoint_cost", "arms_apart", "loss_scale", "second_look"),
    }
)
"""Parameters that a reason points to."""

_OF_TERM: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "data": ("max_correspondence_distance", "outlier_distance"),
        "pictures": ("background_threshold", "halo_trim"),
        "keypoints": ("keypoint_sigma",),
        "change": ("sigma_joint", "prior_inflation_above"),
    }
)
"""Further parameters if the cost is wrong, by the named term."""

_NEAR = np.radians(25.0)  # angle of both limbs from which a candidate is near the true arm
_WRONG = np.radians(30.0)  # angle of a limb from the true one from which it is called wrong
# Share of the points around the shoulders that lie on a limb, below which they do not show it: in
# planted failures limbs that are seen have 3 to 15 %, those whose view is covered 0 to 2 %.
_FEW = 0.03
_CLEARLY = 15.0  # cost by which what is measured must speak for unseen arms to count as seen
_MEASURED = ("data", "pictures", "keypoints")


@dataclass(frozen=True)
class Reason:
    """Why the arms of a frame were chosen, from the cost of the true ones."""

    why: Why
    term: str  # that speaks most against the true arms, if the cost is wrong; else empty
    words: str

    @property
    def brief(self) -> str:
        """``search``, or ``cost: change``."""
        return f"{self.why}: {self.term}" if self.term else self.why

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of parameters that may help, the likeliest first."""
        return (*_POINTS_TO.get(self.why, ()), *_OF_TERM.get(self.term, ()))


def reason_of(search: Search) -> Reason | None:
    """The reason of a recorded search; None where the true arms are not known."""
    truth = search.truth
    if truth is None:
        return None
    chosen = next(pair for pair in (search.followed, *search.pairs) if pair.chosen)
    off = np.degrees(np.nanmax(truth.off))
    if not np.any(truth.off > _WRONG):
        return Reason("right", "", f"The chosen arms are within {off:.0f}° of the true ones.")
    true = truth.refined
    more = true.cost - chosen.cost
    extra = {name: value - chosen.terms[name] for name, value in true.terms.items()}
    costs = f"the true arms cost {true.cost:.1f}, the chosen ones {chosen.cost:.1f}"
    needed = search.gain if search.followed.chosen else 0.0
    unseen = _unseen(truth)
    if unseen and sum(extra[name] for name in _MEASURED) > -_CLEARLY:
        return Reason("data", "", f"Hardly any data show the true {unseen}; {costs}.")
    dropped = _dropped(search, truth)
    if more < 0.0 and dropped is not None:
        return dropped
    if more < -needed:
        return Reason("search", "", f"The search missed the true arms by {-more:.1f}: {costs}.")
    if more < 0.0:
        words = f"other arms are chosen only if they cost {search.gain:g} less"
        return Reason("cost", "gain", f"The cost is wrong: {costs}, and {words}.")
    term = max(extra, key=lambda name: extra[name])
    words = f"most by {TERM_WORDS[term]} ({extra[term]:+.1f})"
    return Reason("cost", term, f"The cost is wrong: {costs}, {words}.")


def _dropped(search: Search, truth: TrueArms) -> Reason | None:
    """The cost dropped all candidates near a true arm before it made pairs; None if it did not."""
    for one in search.proposals:
        if max(truth.off[one.side], truth.off[2 + one.side]) <= _WRONG:
            continue
        away = np.maximum(
            angle_between(one.upper, truth.upper[one.side]),
            angle_between(one.fore, truth.fore[one.side]),
        )
        near = np.flatnonzero(away < _NEAR)
        if len(near) and not one.kept[near].any():
            best = near[np.argmin(one.cost[near])]
            kept = np.flatnonzero(one.kept)[np.argmin(one.cost[one.kept])]
            extra = {name: float(cost[best] - cost[kept]) for name, cost in one.terms.items()}
            term = max(extra, key=lambda name: extra[name])
            words = (
                f"The cost is wrong: a candidate {np.degrees(away[best]):.0f}° from the true "
                f"{('left', 'right')[one.side]} arm was scored and left out, as it costs "
                f"{one.cost[best] - one.cost[kept]:.1f} more than the best, most by "
                f"{TERM_WORDS[term]} ({extra[term]:+.1f})."
            )
            return Reason("cost", term, words)
    return None


def _unseen(truth: TrueArms) -> str:
    """Limbs of wrong arms that hardly any point was measured on, in words."""
    wrong = (truth.off > _WRONG).reshape(2, 2).any(axis=0)  # left and right
    few = np.tile(wrong, 2) & (truth.points < max(_FEW * truth.measured, 1.0))
    return ", ".join(LIMBS[2 + k].replace("_", " ") for k in np.flatnonzero(few))


def reasons_words(reasons: Iterable[Reason | None]) -> str:
    """``cost wrong 5 (change 3, data 2), search missed it 3``."""
    known = [one for one in reasons if one is not None]
    said = []
    for why, count in Counter(one.why for one in known).most_common():
        terms = Counter(one.term for one in known if one.why == why and one.term)
        inside = ", ".join(f"{term} {n}" for term, n in terms.most_common())
        said.append(f"{WHY_WORDS[why]} {count}{f' ({inside})' if inside else ''}")
    return ", ".join(said)

"""The search for the arms, taken apart after it was made."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import Pose
from stereotrack_core.tracking.inside.corrections import is_among
from stereotrack_core.tracking.inside.events import Proposed, Refined, Refining, Searched, Searching
from stereotrack_core.tracking.inside.trace import Pair, Proposals, Search
from stereotrack_core.tracking.parameters import TrackingParameters
from stereotrack_core.tracking.search.arms import Arms
from stereotrack_core.tracking.search.search import ArmSearch


def search_of(
    body: BodyModel,
    parameters: TrackingParameters,
    told: Searching,
    proposed: Sequence[Proposed],
    tried: Sequence[tuple[Refining, Refined]],
    done: Searched,
    seconds: float,
) -> Search:
    """Split the scores of everything that was tried into their terms.

    Parameters
    ----------
    body : BodyModel
    parameters : TrackingParameters
    told, proposed, tried, done
        What the tracker has said.
    seconds : float
        From the beginning of the search to its end.
    """
    search = ArmSearch(body, parameters.search, parameters.arms_apart)

    def pair(before: Pose, pose: Pose) -> Pair:
        terms = search.terms(told.evidence, told.predicted, pose)
        return Pair(before, pose, terms, sum(terms.values()), pose is done.pose)

    return Search(
        followed=pair(told.present, told.present),
        pairs=tuple(pair(begun.proposed, refined.pose) for begun, refined in tried),
        proposals=tuple(_proposals(search, told, one) for one in proposed),
        gain=parameters.search.search_gain,
        seconds=seconds,
    )


def _proposals(search: ArmSearch, told: Searching, one: Proposed) -> Proposals:
    terms = search.arm_terms(told.evidence, one.side, one.arms, one.expected, one.other)
    kept = is_among(_keys(one.arms), _keys(one.kept))
    return Proposals(one.side, one.arms.upper, one.arms.fore, terms, kept)


def _keys(arms: Arms) -> FloatArray:
    return np.hstack([arms.upper, arms.fore])

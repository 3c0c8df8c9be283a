"""Proposals: where the landmarks of the next frame are, before anybody has clicked there.

What the clicked frames around let expect is corrected by points that were followed in the images,
and by the clicks of the frame itself. A question may ask for clicks: uncertain landmarks are left
out in the one image where a click tells most, as an accepted error is accepted in all.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from stereotrack_core.annotation.accepting import NearestClicks
from stereotrack_core.annotation.click import (
    ACCEPTED,
    USUAL_SIGMA,
    ClickKey,
    Prediction,
    Visibility,
)
from stereotrack_core.annotation.follow_body import told_by
from stereotrack_core.annotation.landmark_filter import (
    STEADY,
    Gaussian,
    LandmarkFilter,
    ProposalQuestion,
    Rig,
    updated,
)
from stereotrack_core.annotation.predict import in_image

PROPOSED = "proposed"  # source of proposals
_FARTHEST = 120.0  # pixels at 480 lines; what is less certain than that is no proposal
_WELL = 0.5  # share of a click's standard deviation to which a landmark is known well


@dataclass(frozen=True, eq=False)
class Proposals:
    """The answer: a prediction for every landmark and image that has no click."""

    question: ProposalQuestion
    predictions: tuple[Prediction, ...]


class Proposer:
    """Proposes; keeps what is the same from click to click. Called in one thread at a time."""

    def __init__(self) -> None:
        self._kept: tuple[ProposalQuestion, Gaussian | None] | None = None

    def __call__(self, question: ProposalQuestion) -> Proposals:
        """Propose what the clicks of the frame leave open."""
        if self._kept is None or not _same_around(self._kept[0], question):
            self._kept = (question, LandmarkFilter(question).predicted())
        prior, rig = self._kept[1], Rig(question)
        near = NearestClicks(question.around)
        told = told_by(question.steps, question.frame)  # with the motion, so not once more
        followed = [one for one in question.followed if one.landmark not in told]
        found: list[Prediction] = []
        if prior is not None:
            posterior = updated(prior, rig, rig.measured(question.clicks, followed))
            left = _to_be_clicked(posterior, rig, question) if question.asks else set()
            found += (one for one in _open_places(posterior, rig, question) if one.key not in left)
        # what is clicked in one image alone has no place in the world
        said = {one.key for one in question.clicks} | {one.key for one in found}
        alone = {one.key: one for one in question.followed if one.key not in said}
        found += (replace(one, source=PROPOSED) for one in alone.values())
        made = []
        for one in found:
            visibility, camera = near.visibility(one.key), question.cameras.get(one.camera)
            inside = camera is None or in_image(camera, np.array(one.position))
            if visibility is not None and (visibility == Visibility.OUTSIDE or inside):
                made.append(replace(one, visibility=visibility))
        return Proposals(question, tuple(made))


def _same_around(one: ProposalQuestion, two: ProposalQuestion) -> bool:
    """Whether all is the same but what is known of the frame itself."""
    same = all(getattr(one, name) is getattr(two, name) for name in ("cameras", "motion"))
    equal = ("frame", "around", "names", "fps", "sigmas", "steps")
    return same and all(getattr(one, name) == getattr(two, name) for name in equal)


def _to_be_clicked(state: Gaussian, rig: Rig, question: ProposalQuestion) -> set[ClickKey]:
    """Where a click tells most of each uncertain landmark that nobody has clicked by hand."""
    said = {one.key for one in question.clicks}
    by_hand = {one.landmark for one in question.clicks if one.origin != ACCEPTED}
    found, views = set(), np.arange(len(rig.cameras))
    for place, name in enumerate(rig.names):
        keys = [ClickKey(question.frame, camera.name, name) for camera in rig.cameras]
        free = [view for view, key in enumerate(keys) if key not in said]
        if name in by_hand or not free:
            continue
        own = slice(place * rig.size, (place + 1) * rig.size)
        H = rig.jacobian(state.mean, views, np.full(len(views), place))[:, :, own]
        H = H.reshape(2 * len(views), -1)
        P = H @ state.covariance[own, own] @ H.T
        sigma = STEADY * rig.sigmas.get(name, USUAL_SIGMA)
        if np.trace(P) > len(P) * (_WELL * sigma) ** 2:
            gains = []  # by how much a click in each makes the variances of all pixels smaller
            for view in free:
                at = slice(2 * view, 2 * view + 2)
                less = P[:, at] @ np.linalg.solve(P[at, at] + sigma**2 * np.eye(2), P[at])
                gains.append(float(np.trace(less)))
            found.add(keys[free[int(np.argmax(gains))]])
    return found


def _open_places(state: Gaussian, rig: Rig, question: ProposalQuestion) -> Sequence[Prediction]:
    """Predictions of unclicked landmarks that are certain enough, in cameras that face them."""
    said = {click.key for click in question.clicks}
    count = len(rig.names)
    camera = np.repeat(np.arange(len(rig.cameras)), count)
    landmark = np.tile(np.arange(count), len(rig.cameras))
    H = rig.jacobian(state.mean, camera, landmark)
    spread = 0.5 * np.trace(H @ state.covariance @ np.swapaxes(H, 1, 2), axis1=1, axis2=2)
    pixels = rig.pixels(state.mean)
    found = []
    for place in range(len(camera)):
        own, name = rig.cameras[camera[place]], rig.names[landmark[place]]
        sigma = float(np.sqrt(spread[place]))
        x, y = pixels[camera[place], landmark[place]].tolist()
        one = Prediction(question.frame, own.name, name, PROPOSED, (x, y), sigma)
        certain = sigma <= _FARTHEST * rig.scale[camera[place]]
        if one.key not in said and certain and np.isfinite((x, y)).all():
            found.append(one)
    return found

"""Proposals: where the landmarks of the next frame are, before anybody has clicked there.

What the clicked frames around let expect is corrected by points that were followed in the images,
and by the clicks of the frame itself. Clicks are asked for until the landmarks are known to the
wanted accuracy, each where it tells most: an accepted error is accepted in all images.

A prediction is accepted if its standard deviation is within a limit. It is seen as the landmark's
nearest clicks before and after it in the same camera; without any, what the body hides is guessed.
"""

from bisect import bisect_left
from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from math import inf, isfinite, nan

import numpy as np

from stereotrack_core.annotation.click import USUAL_SIGMA, Click, ClickKey, Prediction, Visibility
from stereotrack_core.annotation.follow import FOLLOWING
from stereotrack_core.annotation.follow_body import told_by
from stereotrack_core.annotation.landmark_filter import (
    STEADY,
    Gaussian,
    LandmarkFilter,
    ProposalQuestion,
    Rig,
    updated,
)
from stereotrack_core.annotation.predict import hidden_landmarks, in_image, pixel_scale
from stereotrack_core.arrays import FloatArray
from stereotrack_core.counting import counted
from stereotrack_core.geometry.camera import variance_by_cameras
from stereotrack_core.recording.description import Cameras
from stereotrack_core.recording.landmarks import LANDMARKS

ACCEPTED_SIGMA = 5.0
"""Largest standard deviation of an accepted prediction, pixels per axis at 480 lines.

A click has 3 px. Landmarks followed from one frame to the next are known to 1.5 to 2 px, landmarks
clicked in two other views to 3 px if these do not face each other. Hands of arms that were raised
within half a second are stated to 5 to 30 px, and are 6 to 50 px off.
"""

PROPOSED = "proposed"  # source of proposals
_UNKNOWN_MM = 300.0  # error from which on no number is stated
_TELLS = 0.01  # share of the variances that a click takes away, if it is to be asked for
_FARTHEST = 120.0  # pixels at 480 lines; what is less certain than that is no proposal


class NearestClicks:
    """The clicks of each landmark in each camera, to look up those around a frame."""

    def __init__(self, clicks: Iterable[Click]) -> None:
        self._clicks: dict[tuple[str, str], list[tuple[int, Visibility]]] = defaultdict(list)
        for click in sorted(clicks, key=lambda one: one.frame):
            if not click.deleted:
                own = click.frame, click.visibility
                self._clicks[click.camera, click.landmark].append(own)

    def visibility(
        self, key: ClickKey, otherwise: Visibility = Visibility.SEEN
    ) -> Visibility | None:
        """The less visible of the clicks around a frame; None if just one is outside the image."""
        own = self._clicks.get((key.camera, key.landmark), [])
        first = bisect_left(own, (key.frame, Visibility.OUTSIDE))
        end = bisect_left(own, (key.frame + 1, Visibility.OUTSIDE))
        near = {seen for _, seen in (*own[max(first - 1, 0) : first], *own[end : end + 1])}
        if Visibility.OUTSIDE in near and len(near) > 1:
            return None
        return min(near, default=otherwise)


@dataclass(frozen=True)
class Acceptance:
    """Predictions that become clicks, and how many stay open."""

    predictions: tuple[Prediction, ...]  # with their visibilities
    left_open: int
    limit: float  # pixels per axis at 480 lines

    def words(self) -> str:
        """Sentence on the points that stay open, and why; empty if there are none."""
        if not self.left_open:
            return ""
        points, verb = counted(self.left_open, "point"), "stays" if self.left_open == 1 else "stay"
        limit = f"{self.limit:.3g} px at 480 lines"
        return f"{points} less certain than {limit} {verb} open. Click or drag them."


def is_certain(prediction: Prediction, cameras: Cameras, limit: float) -> bool:
    """Whether a prediction is within a limit of sigma, pixels per axis at 480 lines."""
    camera = cameras.get(prediction.camera)
    scale = 1.0 if camera is None else pixel_scale(camera)
    return prediction.sigma is not None and prediction.sigma <= limit * scale


def acceptable(
    predictions: Sequence[Prediction],
    clicks: Iterable[Click],
    cameras: Cameras,
    limit: float = ACCEPTED_SIGMA,
) -> Acceptance:
    """Predictions within a limit of sigma, seen as in the nearest of the clicks around.

    Left open is also what is outside the image in one of the nearest clicked frames alone.
    """
    near, taken = NearestClicks(clicks), []
    for one in predictions:
        visibility = near.visibility(one.key, one.visibility)
        if visibility is not None and is_certain(one, cameras, limit):
            taken.append(replace(one, visibility=visibility))
    return Acceptance(tuple(taken), len(predictions) - len(taken), limit)


@dataclass(frozen=True, eq=False)
class Proposals:
    """The answer: a prediction for every landmark and image that has no click."""

    question: ProposalQuestion
    predictions: tuple[Prediction, ...]
    accuracy_mm: float = nan  # root mean square error of the landmarks in space; NaN if unknown
    asked: tuple[ClickKey, ...] = ()  # clicks for the wanted accuracy, most telling first
    then_mm: float = nan  # accuracy after these clicks

    def words(self, body_mm: float = 0.0) -> str:
        """``Accuracy now 12 mm; about 4 more clicks for 8 mm``; empty if it is unknown.

        A fitted body that is `body_mm` off the clicks, more than wanted, is no more accurate.
        """
        if not isfinite(self.accuracy_mm):
            return ""
        if self.accuracy_mm > _UNKNOWN_MM:
            return "Accuracy unknown: too far from a clicked frame. Click what is not predicted."
        now, wanted = f"Accuracy now {self.accuracy_mm:.0f} mm", self.question.wanted_mm
        if body_mm > max(wanted, self.accuracy_mm):
            return f"Accuracy now {body_mm:.0f} mm, by which the fitted body is off the clicks."
        if self.accuracy_mm <= wanted:
            return f"{now}: good enough for {wanted:g} mm."
        if not self.asked:
            return f"{now}: more clicks in this frame change little."
        more = counted(len(self.asked), "more click")
        return f"{now}; about {more} for {max(self.then_mm, wanted):.0f} mm."

    def doubtful(self, cameras: Cameras, limit: float = ACCEPTED_SIGMA) -> tuple[Prediction, ...]:
        """Proposals to be looked at one by one, the most telling first.

        They are those that are asked for, and then those that are less certain than the limit.
        """
        rank = {key: place for place, key in enumerate(self.asked)}
        seen = [one for one in self.predictions if one.visibility != Visibility.OUTSIDE]
        found = [one for one in seen if one.key in rank or not is_certain(one, cameras, limit)]
        return tuple(sorted(found, key=lambda one: (rank.get(one.key, inf), -(one.sigma or 0.0))))


class Proposer:
    """Proposes; keeps what is the same from click to click. Called in one thread at a time."""

    def __init__(self) -> None:
        self._kept: tuple[ProposalQuestion, Gaussian | None] | None = None

    def __call__(self, question: ProposalQuestion) -> Proposals:
        """Propose what the clicks of the frame leave open."""
        if self._kept is None or not _same_around(self._kept[0], question):
            self._kept = (question, LandmarkFilter(question).predicted())
        prior, rig = self._kept[1] or LandmarkFilter(question).detected(), Rig(question)
        near, hidden = NearestClicks(question.around), set[ClickKey]()
        accurate: tuple[float, tuple[ClickKey, ...], float] = (nan, (), nan)
        told = told_by(question.steps, question.frame)  # with the motion, so not once more
        others = [one for one in question.followed if one.source != FOLLOWING]
        alone = [one for one in question.followed if one.source == FOLLOWING]
        followed = [*others, *(one for one in alone if one.landmark not in told)]
        found: list[Prediction] = []
        if prior is not None:
            posterior = updated(prior, rig, rig.measured(question.clicks, followed))
            found += _open_places(posterior, rig, question)
            hidden = _behind_body(posterior, rig, question)
            seen = [one.key for one in found if one.key not in hidden]
            accurate = _to_be_clicked(posterior, rig, question, seen)
        # what is clicked in one image alone has no place in the world
        said = {one.key for one in question.clicks} | {one.key for one in found}
        by_key = {one.key: one for one in alone if one.key not in said}
        found += (replace(one, source=PROPOSED) for one in by_key.values())
        made = []
        for one in found:
            usual = Visibility.GUESSED if one.key in hidden else Visibility.SEEN
            visibility, camera = near.visibility(one.key, usual), question.cameras.get(one.camera)
            inside = camera is None or in_image(camera, np.array(one.position))
            if visibility is not None and (visibility == Visibility.OUTSIDE or inside):
                made.append(replace(one, visibility=visibility))
        return Proposals(question, tuple(made), *accurate)


def _same_around(one: ProposalQuestion, two: ProposalQuestion) -> bool:
    """Whether all is the same but what is known of the frame itself."""
    equal = ("frame", "around", "names", "fps", "sigmas", "steps")
    same = all(getattr(one, name) == getattr(two, name) for name in equal)
    return same and one.cameras is two.cameras


def _behind_body(state: Gaussian, rig: Rig, question: ProposalQuestion) -> set[ClickKey]:
    """Landmarks that the body itself hides, where all nine of them are known."""
    places = {name: place for place, name in enumerate(rig.names)}
    if not all(name in places for name in LANDMARKS) or not rig.cameras:
        return set()
    nine = state.mean[[places[name] for name in LANDMARKS], :3]
    origins = np.array([camera.position_world for camera in rig.cameras])
    behind = hidden_landmarks(nine[None], rig.names, state.mean[None, :, :3], origins)[0]
    places_behind = ((rig.cameras[v].name, rig.names[k]) for v, k in np.argwhere(behind))
    return {ClickKey(question.frame, *place) for place in places_behind}


def _to_be_clicked(
    state: Gaussian, rig: Rig, question: ProposalQuestion, free: Sequence[ClickKey]
) -> tuple[float, tuple[ClickKey, ...], float]:
    """Accuracy in mm, the clicks at `free` places that bring it to the wanted one, and that then.

    Each is the one after which the variances of all landmarks' places are smallest (greedily).
    """
    views = {camera.name: view for view, camera in enumerate(rig.cameras)}
    camera = np.array([views[key.camera] for key in free], dtype=np.int64)
    landmark = np.array([rig.names.index(key.landmark) for key in free], dtype=np.int64)
    sigma = [STEADY * rig.sigmas.get(key.landmark, USUAL_SIGMA) for key in free]
    R = np.square(sigma)[:, None, None] * np.eye(2)
    H = rig.jacobian(state.mean, camera, landmark)
    P, asked, M = state.covariance, list[ClickKey](), _triangulation(state, rig)
    wanted = len(rig.names) * (question.wanted_mm / 1000.0) ** 2
    by_cameras = len(M) * variance_by_cameras(rig.cameras)  # which no click takes away

    def variance() -> float:
        return float(np.einsum("ij,jk,ik->", M, P, M)) + by_cameras

    before = variance()
    while (now := variance()) > wanted and len(asked) < len(free):
        HP = H @ P
        S, seen = HP @ np.swapaxes(H, 1, 2) + R, HP @ M.T
        less = np.einsum("mik,mik->m", seen, np.linalg.solve(S, seen))
        less[[free.index(key) for key in asked]] = 0.0
        best = int(np.argmax(less))
        if less[best] < _TELLS * now:
            break
        asked.append(free[best])
        P = P - HP[best].T @ np.linalg.solve(S[best], HP[best])
    now_mm, then_mm = (1000.0 * np.sqrt(v / len(rig.names)) for v in (before, variance()))
    return float(now_mm), tuple(asked), float(then_mm)


def _triangulation(state: Gaussian, rig: Rig) -> FloatArray:
    """Derivative (3 n, n S) of the places that all images together give, by the state.

    The place in the state itself is not known apart from the offsets of the clicks, which stay the
    same in a reference that is clicked.
    """
    views, found = np.arange(len(rig.cameras)), []
    for place in range(len(rig.names)):
        H = rig.jacobian(state.mean, views, np.full(len(views), place)).reshape(2 * len(views), -1)
        found.append(np.linalg.pinv(H[:, rig.size * place : rig.size * place + 3]) @ H)
    return np.concatenate(found)


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

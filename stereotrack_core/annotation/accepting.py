"""Acceptance of predictions as clicks, and their visibility.

A prediction is accepted if its standard deviation is within a limit. It is seen as the landmark's
nearest clicks before and after it in the same camera; without any, what the body hides is guessed.
"""

from bisect import bisect_left
from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stereotrack_core.annotation.click import Click, ClickKey, Prediction, Visibility
from stereotrack_core.annotation.click_gains import hidden_landmarks
from stereotrack_core.counting import counted
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.triangulation import nearest_to_rays
from stereotrack_core.recording.description import Cameras
from stereotrack_core.recording.landmarks import LANDMARKS

ACCEPTED_SIGMA = 5.0
"""Largest standard deviation of an accepted prediction, pixels per axis at 480 lines.

A click has 3 px. Landmarks followed from one frame to the next are known to 1.5 to 2 px, landmarks
clicked in two other views to 3 px if these do not face each other. Hands of arms that were raised
within half a second are stated to 5 to 30 px, and are 6 to 50 px off.
"""

_LINES = 480.0


def pixel_scale(camera: Camera) -> float:
    """Factor from pixels at 480 lines to those of a camera; at least 1."""
    return max(1.0, min(camera.width, camera.height) / _LINES)


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


def guessed_if_hidden(
    predictions: Sequence[Prediction], cameras: Cameras
) -> tuple[Prediction, ...]:
    """The predictions; those of landmarks behind the body, seen from their camera, are guessed.

    Only where one source predicts all nine landmarks of a frame in two images or more.
    """
    by_body: dict[tuple[int, str], list[Prediction]] = defaultdict(list)
    for one in predictions:
        if one.camera in cameras and one.landmark in LANDMARKS:
            by_body[one.frame, one.source].append(one)
    names, hidden = list(cameras), set[tuple[ClickKey, str]]()
    origins = np.array([camera.position_world for camera in cameras.values()]).reshape(-1, 3)
    for (_, source), own in by_body.items():
        directions = np.full((len(LANDMARKS), len(names), 3), np.nan)
        for one in own:
            ray = cameras[one.camera].rays_world(np.array(one.position))
            directions[LANDMARKS.index(one.landmark), names.index(one.camera)] = ray
        nine = nearest_to_rays(origins, directions)
        if np.isfinite(nine).all():
            behind = hidden_landmarks(nine[None], LANDMARKS, nine[None], origins)[0]
            there = ((names.index(one.camera), LANDMARKS.index(one.landmark)) for one in own)
            hidden |= {(one.key, source) for one, at in zip(own, there, strict=True) if behind[at]}
    return tuple(
        replace(one, visibility=Visibility.GUESSED) if (one.key, one.source) in hidden else one
        for one in predictions
    )

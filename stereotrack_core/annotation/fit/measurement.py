"""Clicks as the fit takes them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from stereotrack_core.annotation.click import UNCERTAIN, Click, ClickKey, Visibility
from stereotrack_core.annotation.landmark_set import LandmarkSet
from stereotrack_core.arrays import FloatArray

GUESSED_FACTOR = 3.0
"""Factor on the standard deviation of clicks that were guessed behind something."""

DOUBTED_FACTOR = 2.0
"""Factor on the standard deviation of clicks that their author doubts."""

USUAL_SIGMA = 3.0
"""Pixels per axis of a seen landmark where nobody has measured better."""


@dataclass(frozen=True, eq=False)
class ClickMeasurement:
    """A landmark in the picture of a camera.

    Attributes
    ----------
    camera, landmark : str
    pixel : (2,) float64
        Raw-image pixels.
    sigma : float
        Standard deviation in pixels per axis; larger where the place was guessed.
    visibility : Visibility
    """

    camera: str
    landmark: str
    pixel: FloatArray
    sigma: float
    visibility: Visibility = Visibility.SEEN

    def key(self, frame: int) -> ClickKey:
        """What the click is found by."""
        return ClickKey(frame, self.camera, self.landmark)


def measurements(
    clicks: Iterable[Click],
    landmark_set: LandmarkSet,
    default_sigma: Mapping[str, float] | float = USUAL_SIGMA,
) -> tuple[ClickMeasurement, ...]:
    """Clicks of one frame as measurements; deleted ones and those outside give none.

    Parameters
    ----------
    landmark_set : LandmarkSet
        Clicks of landmarks that are not in it give none either.
    default_sigma : float or mapping from landmark to float
        Pixels per axis, for seen landmarks whose click does not state its own.
    """
    found = []
    for click in clicks:
        if click.deleted or click.position is None or click.landmark not in landmark_set.names:
            continue
        found.append(
            ClickMeasurement(
                click.camera,
                click.landmark,
                np.array(click.position, dtype=np.float64),
                sigma_of(click, default_sigma),
                click.visibility,
            )
        )
    return tuple(found)


def sigma_of(click: Click, default: Mapping[str, float] | float = USUAL_SIGMA) -> float:
    """Standard deviation of a click in pixels per axis: its own, or from its landmark's usual one.

    Guessed and doubted clicks without a sigma of their own count less.
    """
    if click.sigma is not None:
        return click.sigma
    usual = default if isinstance(default, float | int) else default.get(click.landmark)
    sigma = USUAL_SIGMA if usual is None else float(usual)
    if click.visibility == Visibility.GUESSED:
        sigma *= GUESSED_FACTOR
    return DOUBTED_FACTOR * sigma if click.flag == UNCERTAIN else sigma

"""Where two readings of the same images differ, and how far: two people, or one person twice."""

from collections.abc import Iterable
from dataclasses import dataclass
from math import hypot, nan, sqrt
from typing import Literal, TypeAlias

import numpy as np

from stereotrack_core.annotation.click import Click, ClickKey, Visibility
from stereotrack_core.annotation.click_points import click_pixels
from stereotrack_core.annotation.landmark_set import LandmarkSet
from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.limbs import LIMB_ENDS
from stereotrack_core.geometry.rotation import angle_between
from stereotrack_core.recording.description import Cameras

Kind: TypeAlias = Literal["same", "apart", "seen differently", "only first", "only second"]
_RAYLEIGH_MEDIAN = sqrt(2.0 * np.log(2.0))  # median length of a plane vector of unit deviations


@dataclass(frozen=True)
class Difference:
    """Two readings of one landmark in one image; None where a reading says nothing."""

    key: ClickKey
    first: Click | None
    second: Click | None

    @property
    def kind(self) -> Kind:
        """Whether they agree, and if not, in what; flags and sigmas do not count."""
        first, second = self._there
        if first is None or second is None:
            return "only first" if first else "only second" if second else "same"
        outside = Visibility.OUTSIDE
        if (first.visibility == outside) != (second.visibility == outside):
            return "seen differently"
        return "same" if first.position == second.position else "apart"

    @property
    def _there(self) -> tuple[Click | None, Click | None]:
        """Both, but for those that were deleted."""
        first, second = (c if c and not c.deleted else None for c in (self.first, self.second))
        return first, second

    @property
    def apart(self) -> tuple[float, float] | None:
        """Second less first position in pixels; None where one of them has none."""
        places = [click.position for click in self._there if click and click.position]
        if len(places) < 2:
            return None
        (x, y), (u, v) = places
        return u - x, v - y

    @property
    def distance(self) -> float | None:
        """Pixels between both; None where one of them has no position."""
        return None if self.apart is None else hypot(*self.apart)


def differences(first: Iterable[Click], second: Iterable[Click]) -> tuple[Difference, ...]:
    """Both readings side by side, by frame, camera and landmark; also where they agree."""
    ours = {click.key: click for click in first}
    theirs = {click.key: click for click in second}
    every = sorted(ours.keys() | theirs)
    return tuple(Difference(key, ours.get(key), theirs.get(key)) for key in every)


@dataclass(frozen=True)
class Agreement:
    """Agreement of two readings on a landmark: their distances in pixels."""

    landmark: str  # empty: all landmarks together
    count: int = 0  # images in which both gave a position; all numbers are NaN without any
    sigma: float = nan  # of a single click per axis, both being equally good
    robust_sigma: float = nan  # the same from the median, which single outliers do not change
    median: float = nan
    p95: float = nan
    largest: float = nan
    bias: tuple[float, float] = (nan, nan)
    """Mean of second less first: both understand the landmark differently."""
    disputed: int = 0  # images in which one says outside, or in which one of them says nothing


def agreement(found: Iterable[Difference], landmark: str = "") -> Agreement:
    """Summary of the differences of one landmark, or of all of them."""
    chosen = [one for one in found if not landmark or one.key.landmark == landmark]
    apart = np.array([one.apart for one in chosen if one.apart is not None]).reshape(-1, 2)
    disputed = sum(one.kind in ("seen differently", "only first", "only second") for one in chosen)
    count, median, p95 = _statistics(distances := np.linalg.norm(apart, axis=1))
    if not count:
        return Agreement(landmark, disputed=disputed)
    return Agreement(
        landmark=landmark,
        count=count,
        sigma=float(np.sqrt(np.mean(distances**2) / 4)),
        robust_sigma=median / (sqrt(2.0) * _RAYLEIGH_MEDIAN),
        median=median,
        p95=p95,
        largest=float(distances.max()),
        bias=(float(apart[:, 0].mean()), float(apart[:, 1].mean())),
        disputed=disputed,
    )


def agreement_by_landmark(found: Iterable[Difference]) -> dict[str, Agreement]:
    """Summary for each landmark that occurs."""
    every = tuple(found)
    return {name: agreement(every, name) for name in dict.fromkeys(d.key.landmark for d in every)}


_ENOUGH = 20  # pairs that weigh as much as what is known without them


def click_sigmas(
    found: Iterable[Difference], landmarks: Iterable[str], usual: float
) -> dict[str, float]:
    """Standard deviation of a click in pixels per axis, by landmark, measured by annotating again.

    It is told by the median distance of both readings. Landmarks without many readings have that of
    all together, and without those the `usual` one.
    """
    all_of_them = tuple(found)

    def drawn(own: Agreement, prior: float) -> float:
        if not own.count:
            return prior
        weight = own.count / (own.count + _ENOUGH)
        return sqrt(weight * own.robust_sigma**2 + (1.0 - weight) * prior**2)

    together = drawn(agreement(all_of_them), usual)
    return {name: drawn(agreement(all_of_them, name), together) for name in landmarks}


@dataclass(frozen=True)
class AgreementInSpace:
    """Distances of a landmark (mm), and angles of its limb (deg), between readings, over frames."""

    count: int
    median_mm: float
    p95_mm: float
    median_deg: float
    p95_deg: float


def agreement_in_space(
    found: Iterable[Difference], cameras: Cameras, landmarks: LandmarkSet
) -> dict[str, AgreementInSpace]:
    """Summary for each landmark, by the images in which both readings give a position."""
    pairs = [one for one in found if one.apart is not None]
    first, second = (
        click_pixels([click for click in clicks if click is not None], cameras, landmarks.names)
        for clicks in ([one.first for one in pairs], [one.second for one in pairs])
    )
    one, two = first.points(), second.points()
    distance = 1000.0 * np.linalg.norm(two - one, axis=-1)
    axes = {
        limb: np.degrees(angle_between(first.between(one, *ends), second.between(two, *ends)))
        for limb, ends in LIMB_ENDS.items()
    }
    return {
        one.name: AgreementInSpace(*_statistics(own), *_statistics(axes[one.limb])[1:])
        for one, own in zip(landmarks.landmarks, distance.T, strict=True)
    }


def _statistics(values: FloatArray) -> tuple[int, float, float]:
    known = values[np.isfinite(values)]
    if not len(known):
        return 0, nan, nan
    median, p95 = (float(value) for value in np.percentile(known, (50, 95)))
    return len(known), median, p95


def common_frames(found: Iterable[Difference]) -> tuple[Difference, ...]:
    """The differences at frames that both readings have annotated; others say nothing."""
    all_of_them = tuple(found)

    def frames(side: str) -> set[int]:
        clicks = ((one.key.frame, getattr(one, side)) for one in all_of_them)
        return {frame for frame, click in clicks if click is not None and not click.deleted}

    both = frames("first") & frames("second")
    return tuple(one for one in all_of_them if one.key.frame in both)

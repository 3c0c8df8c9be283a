"""Cameras that contradict the others, and clicks and frames that somebody should look at again.

Two clicks of one landmark in two images lie on each other's epipolar lines: of all ways to exchange
left and right in some of the views the best is looked for.

What is around a click is followed through the images to the next clicked frame, from both sides. A
click is doubted if both come to the same other place, unless the other views say that it is right.

A click that is an outlier with the probability p gives nothing to the fit: to click right there
would gain p times what a new click gains. As far as the fit has believed it, it has pulled the
limb, by at most the angle of its residual.
"""

import math
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise, product
from typing import Literal, TypeAlias

import numpy as np

from stereotrack_core.annotation.click import USUAL_SIGMA, Click, ClickKey
from stereotrack_core.annotation.click_points import ClickPixels, click_pixels
from stereotrack_core.annotation.fit.results import PROBABLE, TrajectoryFit
from stereotrack_core.annotation.follow import MOST_FRAMES, follow_points, pictures_of
from stereotrack_core.annotation.landmark_set import LandmarkSet
from stereotrack_core.annotation.predict import PredictedPoint, pixel_scale, predicted_point
from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.body.limbs import LIMB_ENDS, LIMBS
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.camera_agreement import (
    LEAST_RATIO,
    CameraResidual,
    Disagreement,
    camera_residuals,
    disagreeing_camera,
)
from stereotrack_core.geometry.rotation import angle_between
from stereotrack_core.geometry.triangulation import epipolar_distance
from stereotrack_core.recording.description import Cameras, Recording
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.work import NO_WORK, Work

MOST_VIEWS = 8  # of more views the first ones are looked at; exchanges grow as their power of two
LEAST_GAIN = 8.0  # log likelihood that an exchange has to gain
_GROSS = 12.0  # distances of more than so many sigma count as this: one outlier shall not decide


@dataclass(frozen=True)
class Swap:
    """Two landmarks mixed up in some images of a frame; rms distances to epipolar lines, px."""

    frame: int
    first: str
    second: str
    cameras: tuple[str, ...]  # where they should be exchanged
    certain: bool  # False where to exchange them in all other views instead fits as well
    distance: float
    distance_after: float


def find_swaps(
    clicks: Iterable[Click], cameras: Cameras, pairs: Sequence[tuple[str, str]], sigma: float = 2.0
) -> tuple[Swap, ...]:
    """Pairs of landmarks that were mixed up, by frame; `sigma` of clicks is in pixels.

    The distance of two good clicks has the variance 2 sigma^2, so exchanging gains the log
    likelihood (S - S') / (4 sigma^2), with the sums S of squared distances. It is told where that
    is at least :data:`LEAST_GAIN` and S is halved; landmarks in one epipolar plane cannot be told
    apart.
    """
    at_frame: dict[int, dict[str, dict[str, tuple[float, float]]]] = {}
    for click in clicks:
        if click.position is not None and not click.deleted and click.camera in cameras:
            views = at_frame.setdefault(click.frame, {})
            views.setdefault(click.camera, {})[click.landmark] = click.position
    places = product(sorted(at_frame), pairs)
    swaps = (_swap(frame, pair, at_frame[frame], cameras, sigma) for frame, pair in places)
    return tuple(swap for swap in swaps if swap is not None)


def _swap(
    frame: int,
    pair: tuple[str, str],
    positions: Mapping[str, Mapping[str, tuple[float, float]]],
    cameras: Cameras,
    sigma: float,
) -> Swap | None:
    views = [name for name, places in positions.items() if pair[0] in places or pair[1] in places]
    views = sorted(views, key=lambda name: -sum(one in positions[name] for one in pair))
    views = views[:MOST_VIEWS]
    missing = (np.nan, np.nan)
    points = {name: np.array([positions[name].get(one, missing) for one in pair]) for name in views}
    costs, terms = _costs(points, cameras, _GROSS * sigma)
    if not terms:
        return None

    def squares(exchanged: Sequence[bool]) -> float:
        return sum(own[exchanged[i] != exchanged[j]] for (i, j), own in costs.items())

    as_they_are = (False,) * len(views)
    others = [(False, *rest) for rest in product((False, True), repeat=len(views) - 1)]
    best = min(others, key=squares)
    gain = (squares(as_they_are) - squares(best)) / (2.0 * sigma) ** 2
    now, after = (math.sqrt(squares(one) / terms) for one in (as_they_are, best))
    if gain < LEAST_GAIN or after > now / math.sqrt(2.0):
        return None
    exchanged = [name for name, changes in zip(views, best, strict=True) if changes]
    kept = [name for name in views if name not in exchanged]
    fewer = min(exchanged, kept, key=len)
    return Swap(frame, *pair, tuple(sorted(fewer)), len(exchanged) != len(kept), now, after)


def _costs(
    points: Mapping[str, FloatArray], cameras: Cameras, largest: float
) -> tuple[dict[tuple[int, int], tuple[float, float]], int]:
    """Squares of each two views' distances, as they are and exchanged (px^2), and their number."""
    costs, terms = {}, 0
    for (i, one), (j, two) in combinations(enumerate(points), 2):
        if np.isnan(points[one]).any() and np.isnan(points[two]).any():
            continue  # one click each: to exchange them would leave nothing to compare
        distances = epipolar_distance(
            *(cameras[one], points[one][:, None]), *(cameras[two], points[two][None])
        )
        both_ways = np.stack([distances.diagonal(), distances[::-1].diagonal()])
        squared = np.minimum(both_ways, largest) ** 2
        if np.isfinite(squared).any(axis=1).all():
            straight, crossed = np.nansum(squared, axis=1)
            costs[i, j] = float(straight), float(crossed)
            terms += int(np.isfinite(squared[0]).sum())
    return costs, terms


_BLOCKS, _BLOCK = 60, 5  # stretches of clicked frames, and frames in each: neighbours show movement
_FAR = 4.0  # usual sigmas from which a click lies far from what other cameras say
_NUMBERS = ("no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine")


def doubtful_camera(
    clicks: Iterable[Click], cameras: Cameras, landmark_set: LandmarkSet
) -> Disagreement | None:
    """The camera that contradicts the others over all clicks; accepted ones say nothing."""
    names = landmark_set.names
    found = _compared(clicks, cameras, names)
    other = {name: landmark_set[name].mirror or name for name in names}
    mirror = [names.index(other[name]) for name in names]
    return disagreeing_camera(found.cameras, found.frame, np.moveaxis(found.pixel, 2, 0), mirror)


def residuals_by_camera(
    clicks: Iterable[Click], cameras: Cameras, landmark_set: LandmarkSet, found: Disagreement | None
) -> tuple[CameraResidual, ...]:
    """Distances of each camera's clicks from the points that the sound cameras agree on."""
    compared = _compared(clicks, cameras, landmark_set.names)
    doubtful = () if found is None else found.doubtful
    return camera_residuals(compared.cameras, np.moveaxis(compared.pixel, 2, 0), doubtful)


def _compared(clicks: Iterable[Click], cameras: Cameras, names: Sequence[str]) -> ClickPixels:
    own = [click for click in clicks if not click.accepted]
    asked = frames_asked(np.unique([click.frame for click in own]).astype(np.int64))
    return click_pixels([click for click in own if click.frame in asked], cameras, names)


def frames_asked(clicked: IntArray) -> frozenset[int]:
    """The clicked frames that are compared: all, or so many that they are spread over all."""
    blocks = -(-len(clicked) // _BLOCK)
    chosen = np.linspace(0, blocks - 1, min(blocks, _BLOCKS)).round().astype(np.int64)
    rows = (chosen[:, None] * _BLOCK + np.arange(_BLOCK)).ravel()
    return frozenset(int(frame) for frame in clicked[rows[rows < len(clicked)]])


def what_disagrees(found: Disagreement, names: Mapping[str, str] | None = None) -> str:
    """Sentence on the camera that disagrees, and by how much; `names` say how people call them."""
    called = names or {}
    if not found.camera:
        both = " and ".join(called.get(name, name) for name in found.others)
        unknown = "it cannot be told which of them is wrong"
        return f"{both} disagree by {found.off_px:.0f} px, and {unknown}"
    camera, count = called.get(found.camera, found.camera), len(found.others)
    others = f"the other {_NUMBERS[count] if count < len(_NUMBERS) else count}"
    if np.isfinite(found.late_frames):
        way = "later" if found.late_frames > 0 else "earlier"
        when = f"{abs(found.late_frames):.1f} frames {way}"
        return f"{camera} is {when} than {others}, with {found.off_px:.0f} px of disagreement"
    return f"{camera} disagrees with {others} by {found.off_px:.0f} px"


def what_to_do(found: Disagreement) -> str:
    """Remedy to try before clicks are blamed."""
    if not found.camera:
        check = "Check calibration and synchronisation of both."
        return f"{check} Click the same landmarks in a third view to find out which is wrong."
    if np.isfinite(found.late_frames):
        return "Check its synchronisation and set its time offset. Its clicks may be correct."
    return "Check its calibration and synchronisation. Its clicks may be correct."


def own_outliers(
    flagged: Iterable[ClickKey],
    found: Disagreement | None,
    clicks: Iterable[Click],
    cameras: Cameras,
) -> tuple[ClickKey, ...]:
    """Those of the clicks far from a fit that look wrong without the doubtful camera, too."""
    keys = tuple(flagged)
    if found is None or not keys:
        return keys
    sound = {name: camera for name, camera in cameras.items() if name not in found.doubtful}
    limit = max(_FAR * USUAL_SIGMA, LEAST_RATIO * float(np.nan_to_num(found.agreement_px)))
    together = {(key.frame, key.landmark): list[Click]() for key in keys}
    for click in clicks:
        if (click.frame, click.landmark) in together:
            together[click.frame, click.landmark].append(click)
    wrong = {
        ClickKey(frame, camera, landmark)
        for (frame, landmark), own in together.items()
        for camera in _wrong_ones(predicted_point(sound, own), limit)
    }
    return tuple(key for key in keys if key in wrong)


def _wrong_ones(point: PredictedPoint | None, limit: float) -> tuple[str, ...]:
    """Cameras whose click fits none of the others, or else lies farthest off."""
    if point is None or point.outliers or not point.error_px:
        return () if point is None else point.outliers
    worst = max(point.error_px.values())
    if not worst > limit:
        return ()
    # two clicks miss each other by the same, and nobody can say which is wrong
    both = len(point.error_px) == 2
    return tuple(name for name, error in point.error_px.items() if both or error == worst)


_HIGH_RESIDUAL = 4.0  # usual sigmas from which a residual is worth a look
_LIMB_LENGTH = 0.3  # metres; what a place that is off does to a direction
_USUAL_DISTANCE = 3.0  # metres from a camera to the person


DoubtKind: TypeAlias = Literal["place", "appearance", "swapped", "camera"]
"""Ways in which a click can be wrong: far from the fit, by its image, by its side, by its camera.
"""


@dataclass(frozen=True)
class Doubt:
    """Something about a click that is there."""

    outlier_probability: float
    angle_deg: float  # what its residual would do to a limb, degrees
    words: str
    kind: DoubtKind = "place"


def angle_of_residual(pixels: float, camera: Camera, distance: float = _USUAL_DISTANCE) -> float:
    """Degrees by which a residual turns a limb at this distance from the camera, metres."""
    return math.degrees(math.atan2(pixels * distance / camera.focal, _LIMB_LENGTH))


def doubts_of(fit: TrajectoryFit, cameras: Cameras, sigma: float) -> dict[ClickKey, Doubt]:
    """Clicks that are probably outliers, or lie far from the fit."""
    rows = {int(frame): row for row, frame in enumerate(fit.frame)}
    found = {}
    for key, residual in fit.residual_px.items():
        outlier = float(fit.outlier_probability.get(key, 0.0))
        length = float(np.linalg.norm(residual))
        camera = cameras.get(key.camera)
        if camera is None or not (outlier > PROBABLE or length > _HIGH_RESIDUAL * sigma):
            continue
        if key.frame not in rows or key.landmark not in fit.names:
            continue
        point = fit.landmarks[rows[key.frame], fit.names.index(key.landmark)]
        away = float(np.linalg.norm(point - camera.position_world))
        angle = float(np.nan_to_num(angle_of_residual(length, camera, away)))
        what = "probable outlier" if outlier > PROBABLE else "far from the fit"
        found[key] = Doubt(outlier, angle, f"{what}, {length:.0f} px")
    return found


def swaps_of(
    clicks: Iterable[Click],
    cameras: Cameras,
    landmark_set: LandmarkSet,
    frames: Iterable[int],
    sigma: float,
) -> dict[ClickKey, Doubt]:
    """Clicks of left and right that seem mixed up in some of the frames."""
    chosen = set(frames)
    there = [click for click in clicks if click.frame in chosen]
    found = {}
    for swap in find_swaps(there, cameras, landmark_set.pairs(), sigma=sigma):
        names = f"{swap.first} and {swap.second}".replace("_", " ")
        where = "" if swap.certain else " here or in the other views"
        doubt = Doubt(1.0, 0.0, f"{names} seem to be swapped{where}", "swapped")
        for camera in swap.cameras:
            for name in (swap.first, swap.second):
                found[ClickKey(swap.frame, camera, name)] = doubt
    return found


def disagreement_deg(fit: TrajectoryFit, run: LandmarkTrajectory) -> FloatArray:
    """Angles (F, 6) in degrees between a tracker's arms and the fit's; NaN where not known."""
    result: FloatArray = np.full((len(fit.frame), len(LIMBS)), np.nan)
    _, ours, theirs = np.intersect1d(fit.frame, run.frame, return_indices=True)
    for i, limb in enumerate(LIMBS):
        if limb.endswith("arm"):
            start, end = (LANDMARKS.index(names[0]) for names in LIMB_ENDS[limb])
            own = fit.nine[ours, end] - fit.nine[ours, start]
            other = run.points[theirs, end] - run.points[theirs, start]
            result[ours, i] = np.degrees(angle_between(own, other))
    return result


_OFF = 10.0  # pixels at 480 lines by which a click has to miss what was followed
_SURE = 4.0  # standard deviations, likewise
_AGREES = 2.5  # usual sigmas within which the other views say that a click is right
_OUTLIER = 0.7  # how probably a doubted click is wrong: mesh-P2, two views besides, 6 % wrong
_Ends = dict[ClickKey, list[FloatArray | None]]
"""Where clicks before and after were followed to, (2,) pixels; None where the click is right."""


def unlike_the_others(
    recording: Recording, clicks: Iterable[Click], work: Work = NO_WORK
) -> dict[ClickKey, Doubt]:
    """Clicks in the views' reference images that show something else than those around them.

    Raises Cancelled; InputError for a recording that cannot be read.
    """
    placed = [click for click in clicks if click.position is not None and not click.deleted]
    ends: _Ends = defaultdict(list)
    for count, view in enumerate(recording.views):
        here = [click for click in placed if click.camera == view.image.camera]
        with FrameReader(recording, views=[view.name], colour=False) as reader:
            part = work.part(count / len(recording.views), (count + 1) / len(recording.views))
            _follow(reader, view.image.camera, here, ends, part)
    near: dict[tuple[int, str], list[Click]] = defaultdict(list)
    for click in placed:
        near[click.frame, click.landmark].append(click)
    doubts = {}
    for key, both in ends.items():
        places = [place for place in both if place is not None]
        same, camera = near[key.frame, key.landmark], recording.cameras[key.camera]
        (click,) = (one for one in same if one.camera == key.camera)
        others = [one for one in same if one is not click]
        if len(places) < 2 or _fits(click, others, recording.cameras):
            continue
        off = float(np.linalg.norm(np.mean(places, axis=0) - np.array(click.position)))
        apart = float(np.linalg.norm(places[1] - places[0]))
        if apart < min(_OFF * pixel_scale(camera), 0.5 * off):
            words = f"the clicks before and after lead to another place, {off:.0f} px away"
            doubts[key] = Doubt(_OUTLIER, angle_of_residual(off, camera), words, "appearance")
    return doubts


def _follow(
    reader: FrameReader, camera: str, clicks: Sequence[Click], ends: _Ends, work: Work
) -> None:
    """Note for each click where what is followed from its neighbours comes to."""
    by_frame: dict[int, dict[str, Click]] = defaultdict(dict)
    for click in clicks:
        by_frame[click.frame][click.landmark] = click
    scale = pixel_scale(reader.recording.cameras[camera])
    frames = sorted(by_frame)
    for place, (first, last) in enumerate(pairwise(frames)):
        work.step(place / len(frames), f"frame {first}")
        names = [name for name in by_frame[first] if name in by_frame[last]]
        if not names or last - first > MOST_FRAMES:
            continue
        pictures = list(pictures_of(reader, camera, range(first, last + 1)))
        if any(picture is None for picture in pictures):
            continue
        for start, end, way in ((first, last, pictures), (last, first, pictures[::-1])):
            begun = np.array([by_frame[start][name].position for name in names])
            *_, (pixels, spreads) = follow_points(way, begun, cancelled=work.stopped)
            for name, pixel, spread in zip(names, pixels, spreads, strict=True):
                click = by_frame[end][name]
                if np.isfinite(spread):
                    off = float(np.linalg.norm(pixel - np.array(click.position)))
                    far = off > max(_OFF * scale, _SURE * spread)
                    ends[click.key].append(pixel if far else None)


def _fits(click: Click, others: Sequence[Click], cameras: Cameras) -> bool:
    """Whether a click lies where two other views or more say that the landmark is."""
    point = predicted_point(cameras, others)
    if point is None or point.outliers or click.camera not in point.pixel:
        return False
    off = float(np.linalg.norm(point.pixel[click.camera] - np.array(click.position)))
    return off < _AGREES * USUAL_SIGMA * pixel_scale(cameras[click.camera])

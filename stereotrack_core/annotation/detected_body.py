"""Landmarks that the keypoints of a 2-D detector show: in an image, or by a fitted body."""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise, product
from math import sqrt

import numpy as np

from stereotrack_core.annotation.click import Click, Prediction, sigma_of
from stereotrack_core.annotation.fit.fit import ClickFit
from stereotrack_core.annotation.fit.state import FitSettings
from stereotrack_core.annotation.landmark_set import NINE, Landmark, LandmarkSet
from stereotrack_core.annotation.predict import projected_landmarks
from stereotrack_core.arrays import BoolArray, FloatArray
from stereotrack_core.body.keypoint_places import keypoint_places
from stereotrack_core.body.model import body_model
from stereotrack_core.body.parameters import BodyShape
from stereotrack_core.body.proportions import AVERAGE, Proportions
from stereotrack_core.body.skeleton import PARTS, limb_of_part
from stereotrack_core.pose_model.detect import DETECTOR_NAME, detect_keypoints
from stereotrack_core.pose_model.detector import required_detector
from stereotrack_core.recording.description import Cameras, Recording
from stereotrack_core.recording.keypoint_names import exchanged
from stereotrack_core.recording.keypoints import Keypoints, Row, keypoints_of, rows_of
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.recording.person_boxes import person_boxes
from stereotrack_core.recording.reader import FrameReader, reference_pictures
from stereotrack_core.recording.sighted_keypoints import MeetingPoints, SightedKeypoints, sighted
from stereotrack_core.tracking.detecting import KEYPOINT_OFFSETS
from stereotrack_core.tracking.residuals.reprojection import MEETING_GATE
from stereotrack_core.work import Work
from stereotrack_core.worker_processes import Asker

_HAND = AVERAGE.elbow_to_hand / AVERAGE.forearm_length  # over that of the wrist
_SIGMA = 0.02  # standard deviation of a sure keypoint over the person's size in the picture
_UNSURE, _MOST_UNSURE = 20.0, 3.0
"""Growth of that deviation by what the installed detector's confidence lacks of 1, and its largest
factor: elbows below 0.95 are off by two to three times as much as those above."""

_LEAST_SURE = 0.1  # confidence of other detectors below which a keypoint is as uncertain as with it
_EXTENDED = 2.0  # factor on the standard deviation of what is extended from other keypoints


def landmark_predictions(keypoints: Keypoints, landmarks: Sequence[str]) -> tuple[Prediction, ...]:
    """Predictions in every picture; hands are extended, a head lies between the ears."""
    found: list[Prediction] = []
    rows = keypoints[np.lexsort((keypoints.source, keypoints.camera, keypoints.frame))]
    key = np.stack([rows.frame.astype(np.str_), rows.camera, rows.source], axis=1)
    changes = np.flatnonzero((key[1:] != key[:-1]).any(axis=1)) + 1
    for first, end in pairwise([0, *changes.tolist(), len(key)] if len(key) else []):
        found += _of_picture(rows[slice(first, end)], landmarks)
    return tuple(found)


def _of_picture(rows: Keypoints, landmarks: Sequence[str]) -> list[Prediction]:
    places = dict(zip(rows.keypoint.tolist(), rows.place, strict=True))
    sure = dict(zip(rows.keypoint.tolist(), rows.confidence.tolist(), strict=True))
    size = float(np.ptp(rows.place, axis=0).max())
    made = []
    for landmark in landmarks:
        place, told = _place_of(landmark, places)
        if place is not None:
            x, y = place.tolist()
            frame, camera, source = int(rows.frame[0]), str(rows.camera[0]), str(rows.source[0])
            sigma = max(1.0, _SIGMA * size) * doubt(min(sure[name] for name in told), source)
            sigma *= 1.0 if told == (landmark,) else _EXTENDED
            made.append(Prediction(frame, camera, landmark, source, (x, y), sigma))
    return made


def doubt(confidence: float, detector: str) -> float:
    """Factor on the standard deviation of a sure keypoint."""
    if detector == DETECTOR_NAME:
        return min(1.0 + _UNSURE * (1.0 - confidence), _MOST_UNSURE)
    return float(max(confidence, _LEAST_SURE) ** -0.5)


def _place_of(
    landmark: str, places: Mapping[str, FloatArray]
) -> tuple[FloatArray | None, tuple[str, ...]]:
    """Pixel (2,) of a landmark and the keypoints that tell it; None where none do."""
    if landmark in places:
        return places[landmark], (landmark,)
    side, _, name = landmark.partition("_")
    arm = (f"{side}_elbow", f"{side}_wrist")
    if name == "hand" and all(one in places for one in arm):
        elbow, wrist = (places[one] for one in arm)
        return elbow + _HAND * (wrist - elbow), arm
    ears = ("left_ear", "right_ear")
    if landmark == "head" and all(one in places for one in ears):
        return (places[ears[0]] + places[ears[1]]) / 2.0, ears
    return None, ()


@dataclass(frozen=True, eq=False)
class DetectLandmarks:
    """Has the installed detector look at a frame, in a process that keeps it for the next one."""

    recording: Recording
    frame: int
    landmarks: tuple[str, ...]
    proportions: Proportions

    def __call__(self, asker: Asker) -> tuple[Prediction, ...]:
        """Predictions in all views, by the fitted body unless the cameras are guessed.

        Raises InputError where the detector is missing, sees nobody or images cannot be read.
        """
        own, (folder, detector, boxes, reader) = self.recording, asker.kept.get(_KEPT, [None] * 4)
        if folder != own.folder:
            boxes = person_boxes(own, Work(stopped=asker.cancelled))
            detector = required_detector()
            if reader is not None:
                reader.close()
            reader = FrameReader(reference_pictures(own), cache_bytes=_CACHE, read_ahead=0)
            asker.kept[_KEPT] = own.folder, detector, boxes, reader
        seen = detect_keypoints(reader, detector, [self.frame], boxes=boxes)
        names = [view.image.camera for view in own.views if not own.guessed]
        cameras = {name: own.cameras[name] for name in names}
        return tuple(body_predictions(seen, self.landmarks, cameras, self.proportions))


def told_once(seen: Iterable[Prediction]) -> tuple[Prediction, ...]:
    """Predictions with larger sigmas: off alike in all images, they tell only once."""
    known = [one for one in seen if one.sigma]
    alike = Counter((one.frame, one.source, one.landmark) for one in known)
    return tuple(
        replace(one, sigma=(one.sigma or 0.0) * sqrt(alike[one.frame, one.source, one.landmark]))
        for one in known
    )


_KEPT = "detector"
_CACHE = 64 * 1024 * 1024  # bytes of pictures, which are seldom looked at twice
_SPREAD = {"elbow": 0.05, "wrist": 0.07, "hand": 0.09, "ear": 0.025, "head": 0.025}
"""Metres at the person's distance; standard deviation of a sure keypoint in one image."""

_OF_OTHERS = 0.03  # the same for the other keypoints
_OFF = {"shoulder": 0.02, "elbow": 0.025, "hand": 0.05, "head": 0.012, "hip": 0.025}
"""Metres along each axis by which a landmark is off alike in all images: the detector's points are
not quite where the offsets put them, and people differ."""

_MOST_OFF = 3.0  # standard deviations as which larger distances of a keypoint from the fit count
_ALONE = 2.0  # factor on sigma if fewer than two images show it: bones may bend two ways
_ARMS = ("elbow", "wrist", "hand")  # keypoints whose sides may be exchanged alone
_MARGIN = 0.5  # by how many keypoints rays must meet better for each image with its sides exchanged
_MOST_CAMERAS = 8  # beyond which exchanged sides are not looked for: too many combinations
_FEWEST = 4  # Keypoints in which rays have to meet. With fewer, the body could face any way.
_USED = ("shoulder", "elbow", "wrist", "hand", "hip", "head", "ear")
"""Keypoints that are fitted. The nose is not: the body's head does not turn about its own axis."""

_ALSO_TELLING = {"hand": ("wrist",), "head": ("ear",)}  # other keypoints that show a landmark
_JOINT = "joint of "  # before a landmark's name: without it, that is the keypoint beside it
_SETTINGS = FitSettings(use_depth=False, outlier_share=0.1, sigma_joint_shift=0.012)


def body_predictions(
    keypoints: Keypoints, landmarks: Sequence[str], cameras: Cameras, proportions: Proportions
) -> Iterator[Prediction]:
    """Predictions in all cameras by the body that several images show, or of single images."""
    in_sight = np.isin(keypoints.camera, list(cameras))
    yield from landmark_predictions(keypoints[~in_sight], landmarks)
    keypoints = keypoints[in_sight]
    names = [name for name in LANDMARKS if name in landmarks]
    others = [name for name in landmarks if name not in names]
    chosen = np.isin(LANDMARKS, names)
    for source in sorted(set(keypoints.source.tolist())):
        of_source = keypoints[keypoints.source == source]
        shape = BodyShape()
        if source == DETECTOR_NAME:  # it is known how its points lie beside the landmarks
            shape = shape.replaced(**KEYPOINT_OFFSETS)
        fit = ClickFit(cameras, _landmark_set(proportions, shape), proportions, _SETTINGS)
        for frame in sorted(set(of_source.frame.tolist())):
            rows = of_source[of_source.frame == frame]
            found = _landmarks_shown(rows, fit)
            yield from landmark_predictions(rows, landmarks if found is None else others)
            if found is not None:
                points, covariance = (array[chosen] for array in found)
                yield from projected_landmarks(
                    [frame], names, points[None], covariance[None], cameras, source
                )


def _landmarks_shown(keypoints: Keypoints, fit: ClickFit) -> tuple[FloatArray, FloatArray] | None:
    """The nine (9, 3), world, that a frame's keypoints show, and their covariances (9, 3, 3).

    None if too few rays meet.
    """
    rows = [row for row in _with_hands(keypoints) if _place(row[2]) in _USED]
    if not rows:
        return None
    seen = sighted(keypoints_of(rows), fit.cameras)
    wrong = _exchanged_sides(seen)
    meeting = seen.with_sides_exchanged(wrong).meeting(MEETING_GATE)
    if np.isfinite(meeting.world).all(axis=1).sum() < _FEWEST:
        return None
    clicks = _clicks(rows, seen, wrong, meeting)
    found = fit.frame(clicks)
    off = np.array([_OFF[_place(name)] for name in LANDMARKS])
    covariance = found.landmark_covariance[-9:] + off[:, None, None] ** 2 * np.eye(3)
    factors = _contradictions(clicks, found.residual_px)
    return found.landmarks_world[-9:], covariance * factors[:, None, None]


def _clicks(
    rows: list[Row], seen: SightedKeypoints, wrong: BoolArray, meeting: MeetingPoints
) -> list[Click]:
    """The keypoints as clicks with standard deviations, sides as they fit together."""
    middle = np.nanmedian(meeting.world, axis=0)
    clicks = []
    for frame, camera, name, x, y, sure, source, _person in rows:
        k, v = seen.names.index(name), seen.cameras.index(camera)
        own = exchanged(name) if wrong[k, v] else name
        depth = float(seen.rotation[v, 2] @ middle + seen.translation[v, 2])
        metre = float(seen.focal[v]) / max(depth, 0.1)
        sigma = _SPREAD.get(_place(name), _OF_OTHERS) * metre * doubt(sure, source)
        clicks.append(Click(frame, camera, own, (x, y), sigma=sigma))
    return clicks


def _place(name: str) -> str:
    """The name without its side."""
    return name.split("_")[-1]


def _contradictions(clicks: Sequence[Click], residual: FloatArray) -> FloatArray:
    """Factors (9,) on variances: how far images contradict the fit at each landmark, at least 1."""
    sigma = np.array([sigma_of(one) for one in clicks])
    squared = np.minimum((residual**2).sum(axis=1) / sigma**2, _MOST_OFF**2)
    factors = np.ones(len(LANDMARKS))
    for i, landmark in enumerate(LANDMARKS):
        place = _place(landmark)
        side, told = landmark.removesuffix(place), (place, *_ALSO_TELLING.get(place, ()))
        shown = [one.landmark for one in clicks]
        own = [k for k, n in enumerate(shown) if n.startswith(side) and _place(n) in told]
        cameras = len({clicks[k].camera for k in own})
        if cameras < 2:
            factors[i] = _ALONE**2
            continue
        names = len({clicks[k].landmark for k in own})
        freedom = names * (2 * cameras - 3)  # a point in space has three numbers
        factors[i] = max(1.0, float(squared[own].sum()) / freedom)
    return factors


def _landmark_set(proportions: Proportions, shape: BodyShape) -> LandmarkSet:
    """Keypoints where they are on the body, then the nine landmarks."""
    places = keypoint_places(body_model(proportions, shape))
    points = [
        Landmark(
            name, "#000000", limb_of_part(place.part), PARTS[place.part],
            offset=(place.point[0], place.point[1], place.point[2]),
        )
        for name, place in places.items() if _place(name) in _USED
    ]  # fmt: skip
    joints = [
        Landmark(_JOINT + one.name, one.colour, one.limb, one.part, one.along, one.across)
        for one in NINE.landmarks
    ]
    return LandmarkSet("keypoints", (*points, *joints))


def _with_hands(keypoints: Keypoints) -> Iterator[Row]:
    """Rows of one frame, and a hand between the knuckles of index and little finger."""
    rows = list(rows_of(keypoints))
    yield from rows
    by_name = {(row[1], row[2], row[6]): row for row in rows}
    for (camera, name, source), row in by_name.items():
        side = name.removesuffix("_index")
        other = by_name.get((camera, f"{side}_pinky", source))
        if side == name or other is None or (camera, f"{side}_hand", source) in by_name:
            continue
        x, y, sure = 0.5 * (row[3] + other[3]), 0.5 * (row[4] + other[4]), min(row[5], other[5])
        yield (row[0], camera, f"{side}_hand", x, y, sure, source, row[7])


def _exchanged_sides(seen: SightedKeypoints) -> BoolArray:
    """Where (K, V) left and right are exchanged in whole images or arms, so that rays meet best."""
    result = np.zeros(seen.confidence.shape, dtype=np.bool_)
    views = np.flatnonzero(seen.confidence.any(axis=0))
    if not 2 <= len(views) <= _MOST_CAMERAS:
        return result
    two_sided = seen.other_side != np.arange(len(seen.names))
    arm = np.array([_place(name) in _ARMS for name in seen.names], dtype=np.bool_)
    for group in (two_sided, two_sided & arm):
        best, least = result, np.inf
        for ways in product((False, True), repeat=len(views)):
            if 2 * sum(ways) > len(views):
                continue
            there = result.copy()
            there[:, views] ^= group[:, None] & np.array(ways)
            cost = _cost(seen.with_sides_exchanged(there), two_sided) + _MARGIN * sum(ways)
            if cost < least:
                best, least = there, cost
        result = best
    return result


def _cost(seen: SightedKeypoints, counted: BoolArray) -> float:
    """Number of keypoints that no other image agrees with; partly counted if they nearly agree."""
    meeting = seen.meeting(MEETING_GATE)
    centres, directions = seen.rays
    away = meeting.world[:, None] - centres
    along = np.einsum("kvi,kvi->kv", away, directions)
    off = np.linalg.norm(away - along[..., None] * directions, axis=2)
    cost = np.nan_to_num(np.minimum(off / MEETING_GATE, 1.0) ** 2, nan=1.0)
    return float(cost[(seen.confidence > 0.0) & counted[:, None]].sum())

"""Follow the body's surface through the images, from a clicked frame to another.

A landmark is a joint inside the body; what can be followed is skin and clothes around it. So points
of the surface where the clicks put it are followed in every image, and trunk, head and each segment
of the arms move as rigid bodies to where most of their points went. Joints hold them together. Only
how they move is told.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from stereotrack_core.annotation.click import Click
from stereotrack_core.annotation.fit.context import CLICKED_SHAPE, pose_at, standing, watched_place
from stereotrack_core.annotation.follow import MOST_FRAMES, flow, pictures_of
from stereotrack_core.annotation.landmark_set import NINE, LandmarkSet
from stereotrack_core.annotation.predict import predicted_points
from stereotrack_core.arrays import BoolArray, FloatArray, ImageArray, IntArray
from stereotrack_core.body.model import body_model, placed_cones
from stereotrack_core.body.proportions import Proportions
from stereotrack_core.body.sampling import inside_other_cone, regular_points, segment_blocked
from stereotrack_core.body.skeleton import FOREARMS, HEAD, PARTS, TORSO, UPPER_ARMS
from stereotrack_core.geometry.camera import Camera, pixel_jacobian
from stereotrack_core.geometry.rotation import rotation_from_vector, skew, vector_from_rotation
from stereotrack_core.recording.description import Cameras
from stereotrack_core.recording.reader import FrameReader

_POINTS = 700  # on the whole surface, of which about a third is seen by a camera
_FACING = 0.25  # cosine of the angle at which surface is still followed
_SKIN = 1e-3  # metres over the surface, free of it
_MOVED = (TORSO, HEAD, *UPPER_ARMS, *FOREARMS)
_NAMES = NINE.names
_ARMS = {  # the landmarks at the ends of their parts
    UPPER_ARMS[0]: ("left_shoulder", "left_elbow"),
    UPPER_ARMS[1]: ("right_shoulder", "right_elbow"),
    FOREARMS[0]: ("left_elbow", "left_hand"),
    FOREARMS[1]: ("right_elbow", "right_hand"),
}
_FEWEST = 3  # landmarks of the trunk, without which nobody knows how it stands


@dataclass(frozen=True, eq=False)
class ClickedSurface:
    """Points (N,) on the body where the clicks of a frame put it."""

    cameras: Cameras
    landmarks: FloatArray  # (9, 3), world, NaN where they are not known
    own: Mapping[str, FloatArray]  # (3,) of all that is clicked, world
    part: IntArray  # (N,)
    points: FloatArray  # (N, 3), world
    visible: Mapping[str, BoolArray]  # mapping from camera to (N,)
    offset: Mapping[str, FloatArray]  # by camera (P, 2), pixels: clicks lie beside a part

    @classmethod
    def of(
        cls,
        clicks: Sequence[Click],
        frame: int,
        found: Mapping[str, FloatArray],
        cameras: Cameras,
        proportions: Proportions,
    ) -> ClickedSurface | None:
        """The surface; None where too little of the trunk is known."""
        here = [one for one in clicks if one.frame == frame and one.position is not None]
        if sum(name in found for name in _landmarks_of(TORSO)) < _FEWEST:
            return None
        known = np.array([found.get(name, np.full(3, np.nan)) for name in _NAMES])
        body = body_model(proportions, CLICKED_SHAPE)
        pose = pose_at(known, body, NINE, standing(body, watched_place(cameras)))
        frames = body.frames(pose)
        placed, surface = placed_cones(body, frames), regular_points(body.cones, _POINTS)
        points = frames.apply(surface.part, surface.points)
        told = [p for p in _MOVED if p == TORSO or all(n in found for n in _landmarks_of(p))]
        keep = np.isin(surface.part, told) & ~inside_other_cone(points, surface.cone, placed)
        normals = np.einsum("nij,nj->ni", frames.rotations[surface.part], surface.normals)
        part, points, normals = surface.part[keep], points[keep], normals[keep]
        visible = {}
        for name, camera in cameras.items():
            sight = camera.position_world - points
            sight /= np.linalg.norm(sight, axis=1, keepdims=True)
            visible[name] = np.einsum("ni,ni->n", normals, sight) > _FACING
            at = np.flatnonzero(visible[name])
            free = points[at] + _SKIN * normals[at]
            visible[name][at] = ~segment_blocked(free, camera.position_world, placed)
        points = _to_clicked(points, part, known, NINE.places(body, frames))
        offset = {name: _offsets(camera, here, found, told) for name, camera in cameras.items()}
        return cls(cameras, known, found, part, points, visible, offset)

    def guessed(self, expected: Mapping[str, FloatArray]) -> FloatArray:
        """Where the points (N, 3) are expected."""
        shift = np.zeros((len(PARTS), 3))
        for part in _MOVED:
            ends = [expected[n] for n in _landmarks_of(part) if n in expected]
            ends = [end for end in ends if np.isfinite(end).all()]
            if ends:
                shift[part] = np.mean(ends, axis=0)
        return self.points + shift[self.part]

    def seen_by(self, name: str, guess: FloatArray) -> tuple[IntArray, FloatArray, FloatArray]:
        """Points (M,) that a camera sees, their pixels (M, 2), and the expected ones (M, 2)."""
        camera, shown = self.cameras[name], np.flatnonzero(self.visible[name])
        offset = self.offset[name][self.part[shown]]
        starts = camera.project(self.points[shown]) + offset
        ends = camera.project(guess[shown]) + offset
        inside = ((starts > 0) & (starts < (camera.width - 1, camera.height - 1))).all(axis=1)
        inside &= np.isfinite(ends).all(axis=1)
        return shown[inside], starts[inside], ends[inside]


def _landmarks_of(part: int) -> tuple[str, ...]:
    if part == HEAD:
        return ("head",)
    return _ARMS.get(part, ("left_shoulder", "right_shoulder", "left_hip", "right_hip"))


def _to_clicked(
    points: FloatArray, part: IntArray, known: FloatArray, placed: FloatArray
) -> FloatArray:
    """Points on the arms shifted with their ends, which the body's lengths put beside the clicks"""
    moved = points.copy()
    for one, (near, far) in _ARMS.items():
        own, a, b = part == one, _NAMES.index(near), _NAMES.index(far)
        along = placed[b] - placed[a]
        share = np.clip((points[own] - placed[a]) @ along / (along @ along), 0.0, 1.0)[:, None]
        moved[own] += (1.0 - share) * (known[a] - placed[a]) + share * (known[b] - placed[b])
    return moved


def _offsets(
    camera: Camera, clicks: Sequence[Click], found: Mapping[str, FloatArray], parts: Iterable[int]
) -> FloatArray:
    """How far clicks on every part (P, 2) lie beside its landmarks in an image."""
    result = np.zeros((len(PARTS), 2))
    for part in parts:
        names = found.keys() & set(_landmarks_of(part))
        own = [one for one in clicks if one.landmark in names and one.camera == camera.name]
        off = [np.array(one.position) - camera.project(found[one.landmark]) for one in own]
        if off:
            result[part] = np.mean(off, axis=0)
    return result


_LINES = 480
_WINDOW = 9  # side of the patch in pixels at 480 lines
_BACK = 0.7  # pixels at 480 lines by which a step forward and back may miss the start
_BORDER = 60  # pixels at 480 lines around the person in which is looked
_JOINTS = (
    (TORSO, UPPER_ARMS[0], "left_shoulder", 0.010),
    (TORSO, UPPER_ARMS[1], "right_shoulder", 0.010),
    (UPPER_ARMS[0], FOREARMS[0], "left_elbow", 0.003),
    (UPPER_ARMS[1], FOREARMS[1], "right_elbow", 0.003),
)
"""Parts, the landmark between them, and metres by which they part in a step."""

_GOING_ON = 0.85  # share of a motion that goes on
_TURN, _WAY = 0.6, 0.3  # radians and metres that a part moves where nothing was followed
_SIGMA, _FREEDOM = 0.8, 2.0  # pixels at 480 lines, and of the t distribution of followed points
_TOGETHER = 8.0  # followed points that tell no more than one
_LOST = 0.5
"""Standard deviation of a part's place as a multiple of how far its followed points lie beside it
(median), divided by the share of its points that were followed.

Without it the hand of an arm that was raised between two frames was stated to 3 px and was 32 px
off: what was followed to the end is skin that did not move, or the background beside the arm. In
the demo (steps of 1 to 10 frames) the multiple 1 overstates errors about twofold.
"""
_WIDER = (4.0, 4.0, 2.0, 2.0, 1.0, 1.0, 1.0)  # than `_SIGMA`, round by round


@dataclass(frozen=True, eq=False)
class BodyStep:
    """How landmarks have moved from one frame to another, as the images show it."""

    start: int
    end: int
    names: tuple[str, ...]  # of the landmarks
    shift: FloatArray  # (n, 3), world, metres; NaN where it is not known
    covariance: FloatArray  # (n, 3, 3), square metres


def told_by(steps: Iterable[BodyStep], frame: int) -> frozenset[str]:
    """Landmarks whose way to a frame is known: nothing need follow them one by one."""
    ways = (zip(step.names, step.shift, strict=True) for step in steps if step.end == frame)
    return frozenset(name for way in ways for name, shift in way if np.isfinite(shift).all())


@dataclass(frozen=True, eq=False)
class FollowedBody:
    """Cameras in which a person's body is followed, and the landmarks that are asked for."""

    cameras: Cameras
    proportions: Proportions
    landmarks: LandmarkSet = NINE


def follow_body(
    reader: FrameReader,
    clicks: Sequence[Click],
    start: int,
    frame: int,
    body: FollowedBody,
    *,
    cancelled: Callable[[], bool] = lambda: False,
) -> BodyStep | None:
    """Follow the body from a clicked frame to another; other clicks tell how it is moving.

    None where that is too far or too little is clicked or seen, or when it was cancelled.
    """
    if not 0 < abs(frame - start) <= MOST_FRAMES:
        return None
    cameras = body.cameras
    places = _places_at(start, clicks, cameras)
    surface = ClickedSurface.of(clicks, start, places, cameras, body.proportions)
    if surface is None:
        return None
    guess = surface.guessed(_going_on(clicks, start, frame, places, cameras))
    shown = {stream.camera for view in reader.views for stream in view.streams().values()}
    step = 1 if frame > start else -1
    seen = []
    for name in (name for name in cameras if name in shown):
        pictures = pictures_of(reader, name, range(start, frame + step, step))
        points, starts, ends = surface.seen_by(name, guess)
        found = _followed(pictures, starts, ends, abs(frame - start), cancelled)
        if found is None:
            return None
        known = np.isfinite(found).all(axis=1)
        seen.append(_Seen(name, points[known], found[known], points))
    if not seen:
        return None
    parts = _moved(surface, seen, guess)
    return _step(parts, _doubt(parts, surface, seen), surface, (start, frame), body.landmarks)


def _places_at(frame: int, clicks: Iterable[Click], cameras: Cameras) -> dict[str, FloatArray]:
    points = predicted_points(cameras, (one for one in clicks if one.frame == frame))
    return {name: point.world for name, point in points.items()}


def _going_on(
    clicks: Sequence[Click], start: int, end: int, known: Mapping[str, FloatArray], cameras: Cameras
) -> dict[str, FloatArray]:
    """How landmarks (3,) move if they go on as they did from the clicked frame before."""
    step = 1 if end > start else -1
    earlier = [one.frame for one in clicks if (one.frame - start) * step < 0]
    before = min(earlier, key=lambda one: abs(one - start), default=start)
    if not 0 < abs(before - start) <= MOST_FRAMES:
        return {}
    there = _places_at(before, clicks, cameras)
    share = _GOING_ON * abs(end - start) / abs(start - before)
    return {n: share * (known[n] - there[n]) for n in known.keys() & there.keys()}


def _followed(
    pictures: Iterable[ImageArray | None],
    starts: FloatArray,
    guess: FloatArray,
    steps: int,
    cancelled: Callable[[], bool],
) -> FloatArray | None:
    """Where pixels (M, 2) of the first picture are in the last, NaN if lost; None if cancelled."""
    found, move = starts, (guess - starts) / steps
    lost = np.zeros(len(starts), dtype=np.bool_)
    before, half, scale = None, 1, 1.0
    for picture in pictures:
        if cancelled():
            return None
        if picture is None or not len(starts):
            return np.full(starts.shape, np.nan)
        if before is None:
            half = max(min(picture.shape) // _LINES, 1)
            scale = max(1.0, min(picture.shape) / _LINES) / half
            both = np.concatenate([starts, guess]) / half  # the part of the picture around them
            low, high = both.min(axis=0) - _BORDER * scale, both.max(axis=0) + _BORDER * scale
            corner = np.maximum(np.floor(low), 0).astype(np.int64)
            size = (np.ceil(high) - corner).astype(np.int64)
            found, move = (found - 0.5 * (half - 1)) / half - corner, move / half
        small = _cut(picture, half, corner, size)
        if before is not None:
            there = flow(before, small, found, scale, window=_WINDOW, move=move)
            back = flow(small, before, there, scale, window=_WINDOW, move=-move)
            lost |= ~(np.linalg.norm(back - found, axis=1) <= _BACK * scale)
            found = there
        before = small
    return np.where(lost[:, None], np.nan, half * (found + corner) + 0.5 * (half - 1))


def _cut(picture: ImageArray, half: int, corner: IntArray, size: IntArray) -> ImageArray:
    (x, y), (right, bottom) = half * corner, half * (corner + size)
    cut = picture[y:bottom, x:right]
    if half == 1:
        return np.ascontiguousarray(cut)
    smooth = cv2.blur(cut, (half, half), anchor=((half - 1) // 2, (half - 1) // 2))
    return np.ascontiguousarray(smooth[::half, ::half])


@dataclass(frozen=True, eq=False)
class _Seen:
    """Points (M,) of the surface and their pixels (M, 2) in a camera's image of the other frame."""

    camera: str
    points: IntArray
    pixels: FloatArray
    started: IntArray  # points that the following began with


@dataclass(frozen=True, eq=False)
class _Parts:
    """How the P parts move: x becomes turn (x - centre) + centre + way."""

    turn: FloatArray  # (P, 3, 3)
    way: FloatArray  # (P, 3)
    centre: FloatArray  # (P, 3)
    covariance: FloatArray  # (6 P, 6 P) of turn and way

    def move(self, part: int | IntArray, points: FloatArray) -> FloatArray:
        """Points (..., 3) of one part, or of a part each."""
        arm = (self.turn[part] @ (points - self.centre[part])[..., None])[..., 0]
        return arm + self.centre[part] + self.way[part]

    def jacobian(self, part: int, point: FloatArray) -> FloatArray:
        """Derivative (3, 6 P) of a moved point by turn and way of all parts."""
        found = np.zeros((3, 6 * len(PARTS)))
        found[:, 6 * part : 6 * part + 3] = -skew(self.turn[part] @ (point - self.centre[part]))
        found[:, 6 * part + 3 : 6 * part + 6] = np.eye(3)
        return found


def _moved(surface: ClickedSurface, seen: Sequence[_Seen], guess: FloatArray) -> _Parts:
    """Gauss-Newton steps; points that are far off weigh less (t distribution)."""
    count = len(PARTS)
    centre, first = np.zeros((count, 3)), np.zeros((count, 3))
    for part in np.unique(surface.part).tolist():
        own = surface.part == part
        centre[part] = surface.points[own].mean(axis=0)
        first[part] = (guess[own] - surface.points[own]).mean(axis=0)
    nothing = np.zeros((6 * count, 6 * count))
    parts = _Parts(np.tile(np.eye(3), (count, 1, 1)), first, centre, nothing)
    expected = np.repeat(1.0 / np.square((_TURN, _WAY)), 3)  # its information
    for wider in _WIDER:
        away = np.hstack([vector_from_rotation(parts.turn), parts.way - first])
        H, g = np.diag(np.tile(expected, count)), -(expected * away).ravel()
        for one in seen:
            _add_pixels(H, g, surface, parts, one, wider)
        for one_part, other, name, sigma in _JOINTS:  # parts do not come apart
            if np.isin([one_part, other], surface.part).all():
                joint = surface.landmarks[NINE.names.index(name)]
                apart = parts.move(other, joint) - parts.move(one_part, joint)
                J = parts.jacobian(one_part, joint) - parts.jacobian(other, joint)
                H += J.T @ J / sigma**2
                g += J.T @ apart / sigma**2
        covariance = np.asarray(np.linalg.inv(H), dtype=np.float64)
        delta = (covariance @ g).reshape(-1, 6)
        turn: FloatArray = rotation_from_vector(delta[:, :3]) @ parts.turn
        way: FloatArray = parts.way + delta[:, 3:]
        parts = _Parts(turn, way, parts.centre, covariance)
    return parts


def _add_pixels(
    H: FloatArray, g: FloatArray, surface: ClickedSurface, parts: _Parts, seen: _Seen, wider: float
) -> None:
    """Add what the followed points of an image tell."""
    camera, part = surface.cameras[seen.camera], surface.part[seen.points]
    if not len(part):
        return
    points = parts.move(part, surface.points[seen.points])
    off = seen.pixels - camera.project(points) - surface.offset[seen.camera][part]
    by_place = pixel_jacobian(camera, points)
    arm = points - parts.centre[part] - parts.way[part]
    J = np.concatenate([-by_place @ skew(arm), by_place], axis=-1)
    fine = np.isfinite(off).all(axis=1) & np.isfinite(J).all(axis=(1, 2))
    sigma = wider * _SIGMA * max(1.0, min(camera.width, camera.height) / _LINES)
    distance = np.square(off).sum(axis=1) / sigma**2
    weight = (_FREEDOM + 2.0) / (_FREEDOM + distance) / (sigma**2 * _TOGETHER)
    for one in np.unique(part).tolist():
        own = fine & (part == one)
        at = slice(6 * one, 6 * one + 6)
        weighted = J[own] * weight[own, None, None]
        H[at, at] += np.einsum("nai,naj->ij", weighted, J[own])
        g[at] += np.einsum("nai,na->i", weighted, off[own])


def _doubt(parts: _Parts, surface: ClickedSurface, seen: Sequence[_Seen]) -> FloatArray:
    """Standard deviations (P,) in metres of the parts' places, as lost points tell."""
    of_part, metres, started = list[IntArray](), list[FloatArray](), np.zeros(len(PARTS))
    for one in seen:
        camera, part = surface.cameras[one.camera], surface.part[one.points]
        points = parts.move(part, surface.points[one.points])
        pixels = one.pixels - camera.project(points) - surface.offset[one.camera][part]
        away = np.linalg.norm(points - camera.position_world, axis=1) / camera.focal
        of_part.append(part)
        metres.append(away * np.linalg.norm(pixels, axis=1))
        started += np.bincount(surface.part[one.started], minlength=len(PARTS))
    every, off = np.concatenate(of_part), np.concatenate(metres)
    result: FloatArray = np.zeros(len(PARTS))
    for place in np.unique(every[np.isfinite(off)]):
        known = off[(every == place) & np.isfinite(off)]
        result[place] = _LOST * float(np.median(known)) * started[place] / len(known)
    return result


def _step(
    parts: _Parts,
    doubt: FloatArray,
    surface: ClickedSurface,
    frames: tuple[int, int],
    landmarks: LandmarkSet,
) -> BodyStep:
    """How the landmarks of a set move with their parts, whose places have standard deviations."""
    names, there = landmarks.names, set(surface.part.tolist())
    shift, covariance = np.full((len(names), 3), np.nan), np.full((len(names), 3, 3), np.nan)
    ends = {joint: (one, two) for one, two, joint, _ in _JOINTS}
    for place, name in enumerate(names):
        own = PARTS.index(landmarks[name].part)
        carried = [part for part in ends.get(name, (own,)) if part in there]
        if not carried or name not in surface.own:
            continue
        point = surface.own[name]
        shift[place] = np.mean([parts.move(part, point) - point for part in carried], axis=0)
        J = np.mean([parts.jacobian(part, point) for part in carried], axis=0)
        own_doubt = float(np.mean(np.square(doubt[carried])))
        covariance[place] = J @ parts.covariance @ J.T + own_doubt * np.eye(3)
    return BodyStep(*frames, names, shift, covariance)

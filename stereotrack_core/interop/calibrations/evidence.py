"""What a recording says about its cameras before they are known: points that several of them see.

Clicks and board corners that lie beside the recording, and details that both images of a stereo
camera show. Only which pixels belong together is used, so that every reading of a calibration can
be tried on it.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np

from stereotrack_core.arrays import FloatArray, ImageArray
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.recording.consistency import FILES, observations
from stereotrack_core.recording.description import Recording, View
from stereotrack_core.recording.folder import describe
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.recording.stream_files import picture_size

_FRAMES = 4  # frames in which details are looked for
_DETAILS = 1500  # details of an image
_CLEARLY = 0.8  # distance of the best match to the second best, of which it must be less
_INLIER_PX = 2.0
_LEAST_MATCHES = 30
_LEAST_SIGHTINGS = 8  # of a camera that points hold in its place
_MOST_POINTS = 3000
_MOST_FRAMES = 10_000_000


@dataclass(frozen=True, eq=False)
class SeenPoints:
    """The same N points in raw pixels of V cameras; NaN where one is not seen.

    `landmarks` (N,) names the points and `frame` (N,) is when, so that lengths of bones can be
    measured.
    """

    source: str
    cameras: tuple[str, ...]
    pixels: FloatArray  # (V, N, 2)
    landmarks: tuple[str, ...] = ()
    frame: tuple[int, ...] = ()


@dataclass(frozen=True, eq=False)
class Evidence:
    """All that there is; `pairs` are the left and right cameras of stereo views."""

    seen: tuple[SeenPoints, ...] = ()
    pairs: tuple[tuple[str, str], ...] = ()


def recording_without_calibration(folder: Path) -> Recording:
    """A recording whose calibration is not there yet, or is wrong.

    Its cameras have the names and image sizes of the streams and nothing else. Raises InputError
    where it has no views, or their images cannot be found.
    """
    complaints: list[InputError] = []
    recording = describe(folder, complaints)
    if recording is None or not recording.views:
        raise complaints[0]
    cameras: dict[str, Camera] = {}
    for view in recording.views:
        for key, stream in view.streams().items():
            name = stream.camera or view.image.camera
            where = f"{folder / 'recording.toml'}, view {view.name}, {key}.frames"
            width, height = picture_size(recording.folder, stream.frames, where)
            cameras[name] = Camera(
                name, width, height, np.eye(3), np.zeros(5), False, RigidTransform.identity()
            )
    return replace(recording, cameras=cameras)


def evidence_of(recording: Recording, clicks: Path | None = None) -> Evidence:
    """What is found beside a recording, whose cameras need to have names and sizes only.

    `clicks`: a clicks file from elsewhere. Raises InputError where it holds nothing.
    """
    pairs = tuple(
        (view.left.camera, view.image.camera)
        for view in recording.views
        if view.left is not None and {view.left.camera, view.image.camera} <= set(recording.cameras)
    )
    files = [(recording.folder / name, column) for name, column in FILES]
    if clicks is not None:
        files = [(clicks, "landmark"), *files]
    seen = [_of_file(recording, path, column) for path, column in files]
    if clicks is not None and seen[0] is None:
        raise InputError(
            "it contains no clicks in two cameras of the recording",
            where=str(clicks),
            remedy="Give a clicks file: frame,view,landmark,x,y,visibility.",
        )
    found = [one for one in seen if one is not None]
    for view in recording.views:
        if view.left is not None:
            both = {view.left.camera, view.image.camera}
            if not any(both <= set(one.cameras) for one in found):
                found += _of_images(recording, view)
    return Evidence(tuple(found), pairs)


def _of_file(recording: Recording, path: Path, column: str) -> SeenPoints | None:
    names = {name: name for name in recording.cameras}
    names |= {
        view.name: view.image.camera
        for view in recording.views
        if view.image.camera in recording.cameras
    }
    found = observations(path, column, names, _MOST_FRAMES)
    if found is None:
        return None
    cameras = tuple(dict.fromkeys(names[view] for view in found.views))
    pixels = np.full((len(cameras), *found.pixels.shape[1:]), np.nan)
    for view, own in zip(found.views, found.pixels, strict=True):
        at = cameras.index(names[view])
        pixels[at] = np.where(np.isfinite(pixels[at]), pixels[at], own)
    several = np.isfinite(pixels).all(axis=-1).sum(axis=0) >= 2
    at_frame, at_point = np.nonzero(several)
    if len(cameras) < 2 or not len(at_frame):
        return None
    if len(at_frame) > _MOST_POINTS:  # whole frames, so that bones keep both their ends
        step = int(np.ceil(len(at_frame) / _MOST_POINTS))
        kept = at_frame % step == 0
        at_frame, at_point = at_frame[kept], at_point[kept]
    return SeenPoints(
        path.name,
        cameras,
        pixels[:, at_frame, at_point],
        tuple(found.points[i] for i in at_point) if column == "landmark" else (),
        tuple(int(found.frame[i]) for i in at_frame),
    )


def _of_images(recording: Recording, view: View) -> list[SeenPoints]:
    """Details that both images of a stereo view show, of several frames as one."""
    assert view.left is not None  # noqa: S101 - the caller chose stereo views
    names = view.left.camera, view.image.camera
    if not set(names) <= set(recording.cameras):
        return []
    matches = []
    try:
        own = replace(recording, views=(view,))
        with FrameReader(own, colour=False, read_ahead=0) as reader:
            count = reader.frame_count
            for k in sorted({int(k) for k in np.linspace(0, max(count - 1, 0), _FRAMES)}):
                images = reader.frame_set(k).views.get(view.name) if count else None
                if images is not None and images.left is not None:
                    matches.append(matched_details(images.left, images.image))
    except InputError:
        return []  # said when the recording is opened
    if not matches or sum(len(one[0]) for one in matches) < _LEAST_MATCHES:
        return []
    both = np.stack([np.concatenate(side) for side in zip(*matches, strict=True)])
    return [SeenPoints(f"the images of {view.name}", names, both)]


def matched_details(left: ImageArray, right: ImageArray) -> tuple[FloatArray, FloatArray]:
    """Pixels (N, 2) of details in two images that show the same, by no calibration at all."""
    nothing = np.empty((0, 2)), np.empty((0, 2))
    orb = cv2.ORB_create(_DETAILS)  # type: ignore[attr-defined]
    found = [orb.detectAndCompute(image, None) for image in (left, right)]
    if any(one is None or len(one) < 2 for _, one in found):
        return nothing
    matcher = cv2.BFMatcher(cv2.NORM_HAMMING)
    pairs = matcher.knnMatch(found[0][1], found[1][1], k=2)
    clear = [
        one[0] for one in pairs if len(one) == 2 and one[0].distance < _CLEARLY * one[1].distance
    ]
    if len(clear) < _LEAST_MATCHES:
        return nothing
    at_left = np.array([found[0][0][one.queryIdx].pt for one in clear], dtype=np.float64)
    at_right = np.array([found[1][0][one.trainIdx].pt for one in clear], dtype=np.float64)
    _, kept = cv2.findFundamentalMat(at_left, at_right, cv2.FM_RANSAC, _INLIER_PX, 0.999)
    if kept is None:
        return nothing
    inlier = kept.ravel().astype(bool)
    return at_left[inlier], at_right[inlier]


def joins_all(evidence: Evidence, cameras: Collection[str]) -> bool:
    """Whether the points hold all cameras together, so that they alone tell where each stands."""
    groups: list[set[str]] = []
    for seen in evidence.seen:
        known = np.isfinite(seen.pixels).all(axis=-1).sum(axis=1) >= _LEAST_SIGHTINGS
        group = {name for name, enough in zip(seen.cameras, known, strict=True) if enough}
        groups = [one for one in groups if not one & group] + [
            group.union(*(one for one in groups if one & group))
        ]
    return any(set(cameras) <= group for group in groups)


def names_in(evidence: Evidence) -> Mapping[str, int]:
    """How many points there are by where they come from."""
    return {one.source: one.pixels.shape[1] for one in evidence.seen}


def bones_of(seen: SeenPoints, points: FloatArray) -> dict[str, float]:
    """Median lengths of a person's segments, in the unit of points (N, 3), by their name.

    Segments that are seen on both sides are the mean of both.
    """
    if not seen.landmarks:
        return {}
    at: dict[str, dict[int, FloatArray]] = {}
    for name, frame, point in zip(seen.landmarks, seen.frame, points, strict=True):
        at.setdefault(name, {})[frame] = point
    lengths: dict[str, list[float]] = {}
    for name, a, b in _BONES:
        common = at.get(a, {}).keys() & at.get(b, {}).keys()
        values = [float(np.linalg.norm(at[a][k] - at[b][k])) for k in common]
        lengths.setdefault(name, []).extend(value for value in values if np.isfinite(value))
    return {name: float(np.median(found)) for name, found in lengths.items() if found}


_BONES = (
    ("shoulder_width", "left_shoulder", "right_shoulder"),
    ("hip_width", "left_hip", "right_hip"),
    ("torso_length", "left_hip", "left_shoulder"),
    ("torso_length", "right_hip", "right_shoulder"),
    ("upper_arm_length", "left_shoulder", "left_elbow"),
    ("upper_arm_length", "right_shoulder", "right_elbow"),
    ("forearm_length", "left_elbow", "left_hand"),
    ("forearm_length", "right_elbow", "right_hand"),
)


def cameras_seen(seen: SeenPoints, cameras: Mapping[str, Camera]) -> list[Camera]:
    """The cameras of points in their order."""
    return [cameras[name] for name in seen.cameras]

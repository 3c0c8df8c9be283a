"""Cameras of a ROS bag: sensor_msgs/CameraInfo, placed by /tf_static or by the base line of a pair.

Frames of ROS are those of REP 103: a camera's optical frame has OpenCV's axes, and bodies, maps and
worlds have z up.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy

from stereotrack_core.arrays import FloatArray
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform

INFO = "sensor_msgs/msg/CameraInfo"
TRANSFORMS = "/tf_static"

_WORLDS = ("world", "map", "odom")
_FISHEYE = frozenset({"equidistant", "fisheye"})
_COUNTS = (4, 5, 8)
_RECTIFIED = ("image_rect", "image_rect_color", "image_rect_raw")


@dataclass(frozen=True, eq=False)
class Info:
    """A camera as a message states it."""

    frame: str
    size: tuple[int, int]
    matrix: FloatArray  # (3, 3)
    distortions: FloatArray
    fisheye: bool
    rectification: FloatArray  # (3, 3), rectified_from_camera
    projection: FloatArray  # (3, 4), of the rectified image

    @property
    def aside(self) -> FloatArray:
        """Translation (3,) from the rectified left camera to this one; 0 for the left one."""
        focal = self.projection[0, 0], self.projection[1, 1]
        if not all(focal):
            return np.zeros(3)
        return np.array([self.projection[0, 3] / focal[0], self.projection[1, 3] / focal[1], 0.0])


@dataclass(frozen=True, eq=False)
class Link:
    """A transform that never changes: child axes in the parent's frame."""

    parent: str
    child: str
    parent_from_child: RigidTransform


def info_of(message: Any) -> Info:
    """The camera that a message of ROS 1 or 2 states."""

    def values(name: str, shape: tuple[int, ...]) -> FloatArray:
        found = getattr(message, name, None)
        found = getattr(message, name.lower()) if found is None else found
        return np.asarray(found, dtype=np.float64).reshape(shape)

    distortions = values("D", (-1,))
    return Info(
        str(message.header.frame_id).lstrip("/"),
        (int(message.width), int(message.height)),
        values("K", (3, 3)),
        distortions if distortions.size else np.zeros(5),
        str(message.distortion_model).lower() in _FISHEYE,
        values("R", (3, 3)),
        values("P", (3, 4)),
    )


def links_of(message: Any) -> Iterable[Link]:
    """The transforms of a message of ``/tf_static``."""
    for one in message.transforms:
        q, t = one.transform.rotation, one.transform.translation
        rotation = scipy.spatial.transform.Rotation.from_quat([q.x, q.y, q.z, q.w]).as_matrix()
        yield Link(
            str(one.header.frame_id).lstrip("/"),
            str(one.child_frame_id).lstrip("/"),
            RigidTransform(rotation, np.array([t.x, t.y, t.z])),
        )


def cameras_of(
    topics: Mapping[str, str], infos: Mapping[str, Info], links: Sequence[Link]
) -> tuple[dict[str, Camera], tuple[str, ...]]:
    """Cameras by the topic of their images, all in one world, and what has to be known.

    `topics` are the frames that the images' headers name, by topic, `infos` the cameras by the
    topic of the message. Empty where a camera is not stated, or its place is not known: the notes
    say which.
    """
    known = {topic: one for topic in topics if (one := _info_for(topic, infos)) is not None}
    lacking = [topic for topic in topics if topic not in known]
    faulty = [topic for topic, one in known.items() if not _usable(one)]
    notes = [f"there is no camera_info of {', '.join(lacking)}"] if lacking else []
    if faulty:
        notes.append(f"the camera_info of {', '.join(faulty)} states no calibration")
    known = {topic: one for topic, one in known.items() if topic not in faulty}
    frames = {topic: topics[topic] or one.frame for topic, one in known.items()}
    tree, world = _tree(set(frames.values()), links)
    cameras: dict[str, Camera] = {}
    for topic, one in known.items():
        place = _place(topic, known, frames, tree)
        if place is None:
            notes.append(f"/tf_static does not say where {frames[topic] or topic} is")
            continue
        cameras[topic] = _camera(topic, one, place)
    if cameras:
        notes.append(
            f"the world is the frame {world or 'of the camera'} of the bag"
            + ("" if tree else ": run `stereotrack calibrate align` before tracking")
        )
    return cameras, tuple(notes)


def _info_for(topic: str, infos: Mapping[str, Info]) -> Info | None:
    """The message beside the images, in the same namespace."""
    parts = topic.split("/")
    above, beyond = parts[:-1], parts[:-2]
    for places in (above, beyond, [*beyond, "info"]):
        found = infos.get("/".join([*places, "camera_info"]))
        if found is not None:
            return found
    return None


def focal_of(topic: str, infos: Mapping[str, Info]) -> float | None:
    """Focal length in pixels of a topic's images; None where it is not stated."""
    found = _info_for(topic, infos)
    return None if found is None or not _usable(found) else float(found.matrix[0, 0])


def _usable(one: Info) -> bool:
    numbers = (one.matrix, one.distortions, one.rectification, one.projection)
    finite = all(np.isfinite(values).all() for values in numbers)
    counts = (4,) if one.fisheye else _COUNTS
    positive = one.matrix[0, 0] > 0 and one.matrix[1, 1] > 0
    return bool(finite and positive and one.distortions.size in counts)


def _tree(frames: set[str], links: Sequence[Link]) -> tuple[dict[str, RigidTransform], str]:
    """World from each frame that is linked to the first camera, and the world's name."""
    start = min((one for one in frames if any(one in (k.child, k.parent) for k in links)),
                default="")  # fmt: skip
    if not start:
        return {}, min(frames, default="")
    reached = {start: RigidTransform.identity()}
    waiting = [start]
    while waiting:
        here = waiting.pop()
        for link in links:
            for other, here_from_other in (
                (link.child, link.parent_from_child) if link.parent == here else ("", None),
                (link.parent, link.parent_from_child.inverse()) if link.child == here
                else ("", None),
            ):  # fmt: skip
                if here_from_other is not None and other not in reached:
                    reached[other] = reached[here] @ here_from_other
                    waiting.append(other)
    children = {link.child for link in links}
    roots = [one for one in reached if one not in children]
    world = next((one for one in _WORLDS if one in reached), roots[0] if roots else start)
    world_from_start = reached[world].inverse()
    return {name: world_from_start @ one for name, one in reached.items()}, world


def _place(
    topic: str,
    known: Mapping[str, Info],
    frames: Mapping[str, str],
    tree: Mapping[str, RigidTransform],
) -> RigidTransform | None:
    """camera_from_world of a topic's camera; None where it is not known.

    The right camera of a pair often names the frame of the left one; the base line then is in its
    projection.
    """
    own = known[topic]
    partner = _left_of(topic, known, frames)
    if partner is not None and (frames[topic] == frames[partner] or frames[topic] not in tree):
        left_from_world = _place(partner, known, frames, tree)
        if left_from_world is None:
            return None
        rectified = RigidTransform(own.rectification.T, own.rectification.T @ own.aside)
        left = known[partner].rectification
        return rectified @ RigidTransform(left, np.zeros(3)) @ left_from_world
    if frames[topic] in tree:
        return tree[frames[topic]].inverse()
    alone = all(frames[other] == frames[topic] or _left_of(other, known, frames) == topic
                for other in known)  # fmt: skip
    return RigidTransform.identity() if alone else None


def _left_of(topic: str, known: Mapping[str, Info], frames: Mapping[str, str]) -> str | None:
    """The left camera of the pair whose right one a topic shows."""
    if not known[topic].aside.any():
        return None
    others = [one for one in known if one != topic and not known[one].aside.any()]
    same = [one for one in others if frames[one] == frames[topic]]
    beside = [one for one in others if one.split("/")[1:-2] == topic.split("/")[1:-2]]
    return next(iter(same or beside or (others if len(known) == 2 else [])), None)


def _camera(topic: str, one: Info, camera_from_world: RigidTransform) -> Camera:
    width, height = one.size
    camera = Camera(
        topic, width, height, one.matrix, one.distortions, one.fisheye, camera_from_world
    )
    if not topic.rsplit("/", 1)[-1].startswith(_RECTIFIED) or not one.projection[0, 0]:
        return camera
    turned = RigidTransform(one.rectification, np.zeros(3))
    return replace(
        camera, matrix=one.projection[:, :3].copy(), distortions=np.zeros(5), fisheye=False,
        camera_from_world=turned @ camera_from_world,
    )  # fmt: skip

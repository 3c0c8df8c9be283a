"""Small ROS bags of every kind."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_typestore

from tests.recording.importing.clips import HEIGHT, WIDTH, numbered

BEGIN = 1_700_000_000_000_000_000
KINDS = ("rosbag1", "sqlite3", "mcap")


class Bag:
    """Writes messages of one bag; use as a context manager."""

    def __init__(self, path: Path, kind: str) -> None:
        path.parent.mkdir(exist_ok=True)
        self.one = kind == "rosbag1"
        self.store = get_typestore(Stores.ROS1_NOETIC if self.one else Stores.ROS2_HUMBLE)
        if self.one:
            self.writer: Any = Writer1(path)
        else:
            plugin = StoragePlugin.MCAP if kind == "mcap" else StoragePlugin.SQLITE3
            self.writer = Writer2(path, version=8, storage_plugin=plugin)
        self.connections: dict[str, Any] = {}

    def __enter__(self) -> Bag:
        self.writer.open()
        return self

    def __exit__(self, *_: object) -> None:
        self.writer.close()

    def new(self, name: str, *values: Any) -> Any:
        """A message of a type."""
        return self.store.types[name](*values)

    def header(self, at: int, frame: str) -> Any:
        stamp = self.new("builtin_interfaces/msg/Time", at // 10**9, at % 10**9)
        return self.new("std_msgs/msg/Header", *([0] if self.one else []), stamp, frame)

    def write(self, topic: str, message: Any, at: int) -> None:
        name = message.__msgtype__
        if topic not in self.connections:
            self.connections[topic] = self.writer.add_connection(topic, name, typestore=self.store)
        packed = self.store.serialize_ros1 if self.one else self.store.serialize_cdr
        self.writer.write(self.connections[topic], at, bytes(packed(message, name)))

    def image(self, topic: str, picture: np.ndarray, encoding: str, at: int, frame: str,
              late: int = 3_000_000) -> None:  # fmt: skip
        """A raw image that is recorded a little later than it was taken."""
        data = np.ascontiguousarray(picture).view(np.uint8).ravel()
        height, width = picture.shape[:2]
        message = self.new(
            "sensor_msgs/msg/Image", self.header(at, frame), height, width, encoding, 0,
            data.size // height, data,
        )  # fmt: skip
        self.write(topic, message, at + late)

    def compressed(self, topic: str, picture: np.ndarray, at: int, frame: str) -> None:
        content = cv2.imencode(".png", picture)[1].ravel()
        words = "16UC1; compressedDepth png" if topic.endswith("Depth") else "bgr8; png compressed"
        if topic.endswith("Depth"):
            content = np.concatenate([np.zeros(12, np.uint8), content])
        facts = (self.header(at, frame), words, content)
        self.write(topic, self.new("sensor_msgs/msg/CompressedImage", *facts), at)

    def info(self, topic: str, frame: str, focal: float = 60.0, aside: float = 0.0) -> None:
        """The camera of images, whose rectified image lies `aside` pixels from the left one."""
        matrix = np.array([[focal, 0, 31.5], [0, focal, 23.5], [0, 0, 1.0]])
        projection = np.hstack([matrix, [[aside], [0], [0]]])
        roi = self.new("sensor_msgs/msg/RegionOfInterest", 0, 0, 0, 0, False)
        message = self.new(
            "sensor_msgs/msg/CameraInfo", self.header(BEGIN, frame), HEIGHT, WIDTH, "plumb_bob",
            np.array([0.1, 0.0, 0.0, 0.0, 0.0]), matrix.ravel(), np.eye(3).ravel(),
            projection.ravel(), 0, 0, roi,
        )  # fmt: skip
        self.write(topic, message, BEGIN)


def stereo_bag(path: Path, kind: str = "rosbag1", frames: int = 10, fps: float = 20.0) -> Path:
    """A stereo camera whose images grow brighter."""
    with Bag(path, kind) as bag:
        bag.info("/stereo/left/camera_info", "left_optical")
        bag.info("/stereo/right/camera_info", "left_optical", aside=-60.0 * 0.12)
        for k in range(frames):
            at = BEGIN + round(1e9 * k / fps)
            bag.image("/stereo/left/image_raw", numbered(k), "mono8", at, "left_optical")
            colour = np.repeat((numbered(k) + 5)[..., None], 3, axis=2)
            bag.image("/stereo/right/image_raw", colour, "rgb8", at, "left_optical", 9_000_000)
    return path


def depth_bag(path: Path, kind: str = "mcap", metres: bool = False, frames: int = 10) -> Path:
    """A depth camera with its image, 2 m from a wall that comes 10 mm nearer with each frame."""
    with Bag(path, kind) as bag:
        bag.info("/camera/color/camera_info", "color_optical")
        bag.info("/camera/aligned_depth_to_color/camera_info", "color_optical")
        for k in range(frames):
            at = BEGIN + round(1e9 * k / 30)
            bag.compressed("/camera/color/image_raw/compressed", numbered(k), at, "color_optical")
            counts = np.full((HEIGHT, WIDTH), 2000 - 10 * k, np.uint16)
            counts[:, :8] = 0
            topic = "/camera/aligned_depth_to_color/image_raw"
            if metres:
                wall = np.where(counts > 0, counts * np.float32(0.001), np.nan).astype(np.float32)
                bag.image(topic, wall, "32FC1", at, "color_optical")
            else:
                bag.compressed(f"{topic}/compressedDepth", counts, at, "color_optical")
    return path

"""The files of a simulated recording."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from types import TracebackType
from typing import Any

import av
import cv2
import numpy as np
import tomli_w

from stereotrack_core.arrays import FloatArray, ImageArray
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.calibration import write_calibration
from stereotrack_core.recording.description import Segment, Subject
from stereotrack_core.recording.landmark_csv import write_landmarks
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.recording.segments_file import write_segments
from stereotrack_core.recording.subject_file import write_subject
from stereotrack_core.simulation.options import SceneOptions


class RecordingStore:
    """Writes pictures as they come, and the descriptions at the end.

    Parameters
    ----------
    folder : Path
        An empty folder.
    name : str
        Name of the recording.
    options : SceneOptions
    cameras : mapping from camera name (``N_left``, ``N_right`` ...) to Camera
    """

    def __init__(
        self, folder: Path, name: str, options: SceneOptions, cameras: Mapping[str, Camera]
    ) -> None:
        self._folder = folder
        self._name = name
        self._options = options
        self._cameras = dict(cameras)
        self._videos = {
            camera: _Video(folder / f"{camera}.mkv", options) for camera in self._cameras
        }

    def __enter__(self) -> RecordingStore:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        for video in self._videos.values():
            video.close()

    def add_backgrounds(self, pictures: Mapping[str, ImageArray]) -> None:
        """Write the pictures of the empty scene."""
        for camera, picture in pictures.items():
            cv2.imwrite(str(self._folder / f"{camera}_background.png"), picture)

    def add(self, pictures: Mapping[str, ImageArray]) -> None:
        """Append one frame of every camera."""
        for camera, video in self._videos.items():
            video.add(pictures[camera])

    def finish(self, subject: Subject, truth: FloatArray, segments: Sequence[Segment]) -> None:
        """Write what describes the pictures; `truth` is (F, 9, 3) metres, world."""
        folder = self._folder
        write_calibration(folder / "calibration.toml", self._cameras)
        write_subject(folder / "subject.toml", subject)
        frames = np.arange(len(truth), dtype=np.int64)
        write_landmarks(folder / "reference.csv", LandmarkTrajectory(frames, truth))
        write_segments(folder / "segments.csv", segments)
        (folder / "recording.toml").write_text(tomli_w.dumps(self._description()), "utf-8")

    def _description(self) -> dict[str, Any]:
        views = dict.fromkeys(camera.partition("_")[0] for camera in self._cameras)
        return {
            "format": 1,
            "name": self._name,
            "fps": self._options.fps,
            "calibration": "calibration.toml",
            "subject": "subject.toml",
            "reference": "reference.csv",
            "segments": "segments.csv",
            "views": [
                {
                    "name": view,
                    "kind": "stereo",
                    "left": self._stream(f"{view}_left"),
                    "right": self._stream(f"{view}_right"),
                }
                for view in views
            ],
        }

    def _stream(self, camera: str) -> dict[str, str]:
        stream = {"camera": camera, "frames": f"{camera}.mkv"}
        if self._options.background_images:
            stream["background"] = f"{camera}_background.png"
        return stream


class _Video:
    """Lossless video of one camera: the noise of the sensor is part of what is simulated."""

    def __init__(self, path: Path, options: SceneOptions) -> None:
        self._container = av.open(str(path), "w")
        rate = Fraction(options.fps).limit_denominator(1001)
        self._stream: Any = self._container.add_stream("ffv1", rate=rate)
        self._stream.width, self._stream.height = options.width, options.height
        self._stream.pix_fmt = "bgr0" if options.colour else "gray"
        self._format = "bgr24" if options.colour else "gray"

    def add(self, picture: ImageArray) -> None:
        frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), format=self._format)
        self._container.mux(self._stream.encode(frame))

    def close(self) -> None:
        self._container.mux(self._stream.encode(None))
        self._container.close()

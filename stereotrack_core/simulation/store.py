"""The files of a simulated recording."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType

import numpy as np

from stereotrack_core.arrays import FloatArray, ImageArray
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.description import Recording, Segment, Stream, Subject, View
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.recording.writing import (
    VideoWriter,
    write_png,
    write_recording_description,
)
from stereotrack_core.simulation.options import SceneOptions

_CRF = 16
"""Leaves the sensor's noise nearly as it is, at less than half the size of a lossless video."""


class RecordingStore:
    """Writes pictures as they come, and the descriptions at the end.

    Different cameras may be written to by different threads.

    Parameters
    ----------
    folder : Path
        An empty folder.
    options : SceneOptions
    cameras : mapping from camera name (``N_left``, ``N_right`` ...) to Camera
    """

    def __init__(self, folder: Path, options: SceneOptions, cameras: Mapping[str, Camera]) -> None:
        self._folder = folder
        self._options = options
        self._cameras = dict(cameras)
        self._open = ExitStack()
        self._videos: dict[str, VideoWriter] = {}

    def __enter__(self) -> RecordingStore:
        o = self._options
        for camera in self._cameras:
            video = VideoWriter(
                self._folder / f"{camera}.mp4", fps=o.fps, width=o.width, height=o.height,
                colour=o.colour, crf=0 if o.lossless else _CRF,
            )  # fmt: skip
            self._videos[camera] = self._open.enter_context(video)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._open.__exit__(kind, error, trace)

    def add_background(self, camera: str, picture: ImageArray) -> None:
        """Write a camera's picture of the empty scene."""
        write_png(self._folder / f"{camera}_background.png", picture)

    def add(self, camera: str, picture: ImageArray) -> None:
        """Append a camera's next frame."""
        self._videos[camera].write(picture)

    def finish(
        self, name: str, subject: Subject, truth: FloatArray, segments: Sequence[Segment]
    ) -> None:
        """Write what describes the pictures; `truth` is (F, 9, 3) metres, world."""
        views = dict.fromkeys(camera.partition("_")[0] for camera in self._cameras)
        write_recording_description(
            Recording(
                folder=self._folder,
                name=name,
                fps=self._options.fps,
                views=tuple(
                    View(
                        view,
                        "stereo",
                        image=self._stream(f"{view}_right"),
                        left=self._stream(f"{view}_left"),
                    )
                    for view in views
                ),
                cameras=self._cameras,
                subject=subject,
                reference=LandmarkTrajectory(np.arange(len(truth), dtype=np.int64), truth),
                segments=tuple(segments),
            )
        )

    def _stream(self, camera: str) -> Stream:
        shown = self._options.background_images
        background = f"{camera}_background.png" if shown else None
        return Stream(camera, f"{camera}.mp4", background)

"""Simulated recordings: a person moves in a room, cameras look, the truth is kept."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType

import numpy as np
from platformdirs import user_data_path

from stereotrack_core.arrays import FloatArray, ImageArray
from stereotrack_core.atomic import filling
from stereotrack_core.errors import Cancelled, InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.description import Recording, Segment, Stream, Subject, View
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.recording.writing import (
    VideoWriter,
    write_png,
    write_recording_description,
)
from stereotrack_core.simulation.motions import motion_names
from stereotrack_core.simulation.options import SceneOptions
from stereotrack_core.simulation.people import person_named
from stereotrack_core.simulation.rig import view_names
from stereotrack_core.simulation.scene import Scene, build_scene
from stereotrack_core.simulation.schedule import Part

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


Progress = Callable[[int, int], None]
_WORKERS = 2


def simulate(
    folder: Path,
    *,
    person: str = "P1",
    motion: str = "cross-arms",
    frames: int = 120,
    views: str = "NOSW",
    seed: int = 0,
    options: SceneOptions | None = None,
    parts: Sequence[Part] = (),
    on_progress: Progress | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> None:
    """Make a recording folder with rendered stereo images and truth.

    Parameters
    ----------
    folder : Path
        Must not exist yet, or be empty. It appears when everything is finished.
    person : str
        P1 to P4.
    motion : str
        A name of ``MOTIONS``, or several joined by ``+``; repeated until the frames are full.
    frames : int
    views : str
        Some of N, O, S, W.
    seed : int
        Same seed, same pictures and truth.
    options : SceneOptions, optional
    parts : sequence of Part
        What happens at which frames, instead of `motion`.
    on_progress : callable, optional
        Called with frames done and frames in all.
    cancelled : callable, optional
        Asked before every frame.

    Raises
    ------
    InputError
        For an unknown name, no frames, or a folder that holds something.
    Cancelled
        When stopped; nothing is left behind.

    Examples
    --------
    >>> simulate(Path("recording"), person="P2", motion="cross-arms", frames=40, views="NS")
    """
    chosen = options or SceneOptions()
    folder = Path(folder)
    _check(folder, frames, seed)
    who, names, where = person_named(person), motion_names(motion), view_names(views)
    with filling(folder) as workplace, ThreadPoolExecutor(_WORKERS) as workers:
        scene = build_scene(who, names, frames, where, seed, chosen, workers, parts)
        with RecordingStore(workplace, chosen, scene.cameras) as store:
            if chosen.background_images:
                for camera, renderer in scene.renderers.items():
                    store.add_background(camera, renderer.background())
            truth = []
            for frame in range(frames):
                if cancelled is not None and cancelled():
                    raise Cancelled
                truth.append(_make_frame(scene, frame, store, workers))
                if on_progress is not None:
                    on_progress(frame + 1, frames)
        store.finish(folder.name, who.subject(), np.array(truth), scene.chain.segments)


def _make_frame(scene: Scene, frame: int, store: RecordingStore, workers: Executor) -> FloatArray:
    """Draw and store all pictures of a frame; return its landmarks (9, 3)."""
    people, points = scene.people(frame)

    def draw(camera: str) -> None:
        store.add(camera, scene.picture(camera, people, frame))

    list(workers.map(draw, scene.cameras))
    return points


def _check(folder: Path, frames: int, seed: int) -> None:
    if frames < 1:
        raise InputError(
            f"{frames} frames cannot be simulated", where="--frames", remedy="Give 1 or more."
        )
    if seed < 0:
        raise InputError(f"the seed {seed} is negative", where="--seed", remedy="Give 0 or more.")
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise InputError(
            "the folder is not empty", where=str(folder), remedy="Use a new or empty folder."
        )


DEMO_FRAMES = 100
_MOTION, _PERSON, _SEED = "t-pose+cross-arms+point", "P2", 7


@dataclass(frozen=True)
class DemoPlaces:
    """Where the demo keeps its recording and its run."""

    recording: Path
    run: Path

    @property
    def made(self) -> bool:
        """Whether the recording is there."""
        return (self.recording / "recording.toml").is_file()


def demo_places(folder: Path | None) -> DemoPlaces:
    """Recording and run in `folder`, or in the program's own data folder.

    Raises
    ------
    InputError
        Where that is no folder.
    """
    if folder is None:
        folder = user_data_path("stereotrack", appauthor=False) / "demo"
    if folder.exists() and not folder.is_dir():
        raise InputError(
            "this is not a folder", where=str(folder), remedy="Give the name of a folder."
        )
    return DemoPlaces(folder / "recording", folder / "run.npz")


def make_demo(
    places: DemoPlaces,
    *,
    on_progress: Progress | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> None:
    """Render the demo recording: four views, T pose, crossed arms, pointing.

    Raises
    ------
    InputError
        Where its folder cannot be made.
    Cancelled
        Nothing is left behind.
    """
    try:
        places.recording.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"the folder cannot be created ({error.strerror})",
            where=str(places.recording.parent),
            remedy="Give a folder that you may write to: stereotrack demo DIR.",
        ) from error
    simulate(
        places.recording,
        person=_PERSON,
        motion=_MOTION,
        frames=DEMO_FRAMES,
        seed=_SEED,
        on_progress=on_progress,
        cancelled=cancelled,
    )

"""Simulated recordings: a person moves in a room, cameras look, the truth is kept."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from pathlib import Path

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.atomic import filling
from stereotrack_core.errors import Cancelled, InputError
from stereotrack_core.simulation.motions import motion_names
from stereotrack_core.simulation.options import SceneOptions
from stereotrack_core.simulation.people import person_named
from stereotrack_core.simulation.rig import view_names
from stereotrack_core.simulation.scene import Scene, build_scene
from stereotrack_core.simulation.schedule import Part
from stereotrack_core.simulation.store import RecordingStore

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

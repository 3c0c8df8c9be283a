"""Simulated recordings: a person moves in a room, cameras look, the truth is kept."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stereotrack_core.arrays import FloatArray, ImageArray
from stereotrack_core.errors import Cancelled, InputError
from stereotrack_core.simulation.actor import Actor, actor
from stereotrack_core.simulation.extras import Passer, passer_by
from stereotrack_core.simulation.motions import Chain, chain, motion_names
from stereotrack_core.simulation.options import SceneOptions
from stereotrack_core.simulation.people import person_named
from stereotrack_core.simulation.render import CameraRenderer, Posed
from stereotrack_core.simulation.rig import stereo_rig, view_names
from stereotrack_core.simulation.room import room
from stereotrack_core.simulation.sensor import sensor
from stereotrack_core.simulation.skeleton import landmarks, posed_bones
from stereotrack_core.simulation.store import RecordingStore
from stereotrack_core.simulation.textures import noise_lattice

Progress = Callable[[int, int], None]
_WORKERS = 2

DEMO_MOTION = "t-pose+cross-arms+point"
DEMO_FRAMES = 100


@dataclass(frozen=True, eq=False)
class Scene:
    """Who does what in front of which cameras.

    Attributes
    ----------
    actor : Actor
    chain : Chain
    passer : Passer or None
        Somebody in the background.
    renderers : mapping from camera name to CameraRenderer
    """

    actor: Actor
    chain: Chain
    passer: Passer | None
    renderers: dict[str, CameraRenderer]

    def people(self, frame: int) -> tuple[list[Posed], FloatArray]:
        """Everybody in a frame, posed, and the landmarks (9, 3) of the one who matters."""
        bones = posed_bones(self.actor.person, self.chain.states[frame])
        people = [Posed(self.actor, *self.actor.posed(bones))]
        if self.passer is not None and (state := self.passer.state(frame)) is not None:
            other = self.passer.actor
            people.append(Posed(other, *other.posed(posed_bones(other.person, state))))
        return people, landmarks(self.actor.person, bones)


def simulate(
    folder: Path,
    *,
    person: str = "P1",
    motion: str = "cross-arms",
    frames: int = 120,
    views: str = "NOSW",
    seed: int = 0,
    options: SceneOptions | None = None,
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
    """
    chosen = options or SceneOptions()
    folder = Path(folder)
    _check(folder, frames, seed)
    who, names, where = person_named(person), motion_names(motion), view_names(views)
    folder.parent.mkdir(parents=True, exist_ok=True)
    workplace = Path(tempfile.mkdtemp(prefix=f".{folder.name}-", dir=folder.parent))
    try:
        moves = chain(
            who, names, frames,
            fps=chosen.fps, pace=chosen.pace, t_pose_first=chosen.t_pose_first,
        )  # fmt: skip
        cameras = stereo_rig(where, chosen, seed)
        with ThreadPoolExecutor(_WORKERS) as workers:
            things, lattice = room(furnished=chosen.furnished), noise_lattice(seed)
            drawn = workers.map(
                lambda name: CameraRenderer(
                    cameras[name], sensor(chosen, seed, name), things, lattice
                ),
                cameras,
            )
            renderers = dict(zip(cameras, drawn, strict=True))
            other = passer_by(who, chosen, frames) if chosen.second_person else None
            scene = Scene(actor(who, chosen.clothes), moves, other, renderers)
            with RecordingStore(workplace, folder.name, chosen, cameras) as store:
                if chosen.background_images:
                    store.add_backgrounds({n: r.background() for n, r in renderers.items()})
                truth = []
                for k, (pictures, points) in enumerate(_pictures(scene, frames, workers)):
                    if cancelled is not None and cancelled():
                        raise Cancelled
                    store.add(pictures)
                    truth.append(points)
                    if on_progress is not None:
                        on_progress(k + 1, frames)
                store.finish(who.subject(), np.array(truth), moves.segments)
        if folder.exists():
            folder.rmdir()
        workplace.chmod(0o755)
        workplace.rename(folder)
    finally:
        shutil.rmtree(workplace, ignore_errors=True)


def demo_recording(
    folder: Path,
    *,
    on_progress: Progress | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> None:
    """Make the recording of ``stereotrack demo``: four views, about 8 s, arms that cross."""
    simulate(
        folder, person="P2", motion=DEMO_MOTION, frames=DEMO_FRAMES, seed=7,
        options=SceneOptions(), on_progress=on_progress, cancelled=cancelled,
    )  # fmt: skip


def _check(folder: Path, frames: int, seed: int) -> None:
    if frames < 1:
        raise InputError(
            f"{frames} frames cannot be made", where="--frames", remedy="Give 1 or more."
        )
    if seed < 0:
        raise InputError(f"the seed {seed} is negative", where="--seed", remedy="Give 0 or more.")
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise InputError(
            "there is something already", where=str(folder), remedy="Give a new or empty folder."
        )


def _pictures(
    scene: Scene, frames: int, workers: ThreadPoolExecutor
) -> Iterator[tuple[dict[str, ImageArray], FloatArray]]:
    """Pictures of all cameras by name, and landmarks (9, 3), frame by frame."""
    for frame in range(frames):
        people, points = scene.people(frame)
        drawn = workers.map(
            lambda renderer, seen=people, k=frame: renderer.picture(seen, k),
            scene.renderers.values(),
        )
        yield dict(zip(scene.renderers, drawn, strict=True)), points

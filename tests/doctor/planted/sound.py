"""Sound recordings of rigs, people and rooms that differ, rendered small, to plant faults into."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stereotrack_core.recording.description import Recording, Stream, View
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.recording.writing import counts_of, write_png, write_recording_description
from stereotrack_core.simulation.make import Simulation, build_scene
from stereotrack_core.simulation.people import PEOPLE
from stereotrack_core.simulation.rig import SceneOptions

FRAMES = 48
_UNIT = 0.001
_MOTIONS = (
    "cross-arms+point", "point+whip", "travolta+reach", "reach+shrug", "walk+point",
    "tie-shoes+reach", "whip+cross-arms", "shrug+travolta", "point+tie-shoes", "reach+walk",
)  # fmt: skip
_VIEWS = ("NOSW", "NOSW", "NOS", "NO", "NOSW", "OSW", "N", "NOSW", "NSW", "OS", "NOSW", "W")
_KINDS = ("stereo",) * 2 + ("depth",) + ("stereo",) * 4 + ("mono", "stereo", "depth") + ("stereo",)


@dataclass(frozen=True)
class Sound:
    """One rig, person, room and motion; `number` decides all of them."""

    number: int

    @property
    def name(self) -> str:
        """Of its folder."""
        return f"sound-{self.number:02d}"

    @property
    def kind(self) -> str:
        """Of its views."""
        return _KINDS[self.number % len(_KINDS)]

    @property
    def simulation(self) -> Simulation:
        """Somebody between 1.5 and 2.0 m tall, motions, rig, sensor and room."""
        rng = np.random.default_rng([self.number, 1])
        person = list(PEOPLE)[int(rng.integers(len(PEOPLE)))]
        motion = _MOTIONS[self.number % len(_MOTIONS)]
        views = "NOSW" if self.kind == "mono" else _VIEWS[self.number % len(_VIEWS)]
        options = self._options(float(rng.uniform(1.5, 2.0)))
        return Simulation(person, motion, FRAMES, "".join(views), self.number, options)

    def _options(self, stature: float) -> SceneOptions:
        rng = np.random.default_rng([self.number, 2])
        width = int(rng.choice([400, 480]))
        distance = float(rng.uniform(2.2, 3.6))
        # the person fills a like part of every image
        focal = float(rng.uniform(0.2, 0.28)) * width * distance
        return SceneOptions(
            fps=float(rng.choice([8.0, 10.0, 15.0])),
            pace=float(rng.uniform(0.6, 1.5)),
            stature=stature,
            clothes=str(rng.choice(["strong", "striped", "plain"], p=[0.5, 0.3, 0.2])),
            furnished=bool(rng.random() < 0.7),
            background_images=bool(rng.random() < 0.75),
            width=width,
            height=width * 3 // 4,
            focal=focal,
            baseline=float(rng.uniform(0.09, 0.2)),
            camera_distance=distance,
            camera_height=float(rng.uniform(1.2, 2.5)),
            distorted=bool(rng.random() < 0.4),
            askew=bool(rng.random() < 0.4),
            gain_difference=float(rng.uniform(-0.08, 0.08)),
            blur=float(rng.uniform(0.4, 1.0)),
            noise=float(rng.uniform(1.0, 4.0)),
        )


def make(sound: Sound, folder: Path) -> None:
    """Render it into a folder that does not exist yet."""
    simulation = sound.simulation
    options, person = simulation.options, simulation.who
    points = []
    with ThreadPoolExecutor(2) as workers:
        scene = build_scene(simulation, workers)
        chosen = [c for c in scene.cameras if sound.kind == "stereo" or c.endswith("right")]
        empty = options.background_images and sound.kind != "depth"
        for camera in chosen if empty else ():
            folder.mkdir(parents=True, exist_ok=True)
            write_png(folder / f"{camera}_background.png", scene.renderers[camera].background())
        for camera in chosen:
            (folder / camera).mkdir(parents=True, exist_ok=True)
            (folder / f"{camera}_depth").mkdir(exist_ok=True)
        for frame in range(FRAMES):
            people, truth = scene.people(frame)
            points.append(truth)

            def draw(camera: str, people=people, frame=frame) -> None:
                write_png(
                    folder / camera / f"{frame:03d}.png", scene.picture(camera, people, frame)
                )
                if sound.kind == "depth":
                    z = scene.renderers[camera].seen(people).depth
                    rng = np.random.default_rng([sound.number, frame, ord(camera[0])])
                    # the error of a structured-light camera grows with the square of the range
                    z = z + np.float32(0.0015) * z**2 * rng.standard_normal(z.shape, np.float32)
                    z[z > 6.0] = np.nan
                    write_png(folder / f"{camera}_depth" / f"{frame:03d}.png", counts_of(z, _UNIT))

            list(workers.map(draw, chosen))
    cameras = {name: scene.cameras[name] for name in chosen}
    views = tuple(_view(sound, name, empty=empty) for name in simulation.views)
    reference = LandmarkTrajectory(np.arange(FRAMES, dtype=np.int64), np.array(points))
    for stale in folder.glob("*_depth") if sound.kind != "depth" else ():
        stale.rmdir()
    write_recording_description(
        Recording(
            folder, sound.name, options.fps, views, cameras, person.subject(), reference
        )
    )  # fmt: skip


def _view(sound: Sound, name: str, *, empty: bool) -> View:
    def stream(side: str) -> Stream:
        camera = f"{name}_{side}"
        return Stream(camera, f"{camera}/%03d.png", f"{camera}_background.png" if empty else None)

    if sound.kind == "stereo":
        return View(name, "stereo", stream("right"), left=stream("left"))
    if sound.kind == "mono":
        return View(name, "mono", stream("right"))
    depth = Stream(f"{name}_right", f"{name}_right_depth/%03d.png")
    return View(name, "depth", stream("right"), depth=depth, depth_unit=_UNIT)

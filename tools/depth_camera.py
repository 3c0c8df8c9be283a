"""Simulated recordings of structured-light depth cameras, made of stereo ones."""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from pathlib import Path

import cv2
import numpy as np

from stereotrack_core.arrays import BoolArray, Float32Array
from stereotrack_core.recording.description import Stream, View
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.images import counts_of
from stereotrack_core.recording.writing import write_png, write_recording_description
from stereotrack_core.simulation.make import Simulation, build_scene, simulate
from stereotrack_core.simulation.render import CameraRenderer, Posed


def simulate_depth(folder: Path, made: Simulation) -> None:
    """Make a recording whose views have pictures, depth images and masks of the person."""
    simulate(folder, made)
    with ThreadPoolExecutor(2) as workers:
        scene = build_scene(made, workers)
    recording, views = open_recording(folder), []
    for view in recording.views:
        camera, name = view.image.camera, view.name
        stream = made.seed, ord(name)
        sensor = DepthCamera(scene.renderers[camera], made.options.focal, folder / name, stream)
        for frame in range(made.frames):
            sensor.write(scene.people(frame)[0], frame)
        picture = Stream(camera, view.image.frames)
        depth, mask = Stream(camera, f"{name}/{_DEPTH}"), Stream("", f"{name}/{_MASK}")
        views.append(View(name, "depth", picture, depth=depth, depth_unit=_UNIT, mask=mask))
    cameras = {view.image.camera: recording.cameras[view.image.camera] for view in views}
    write_recording_description(replace(recording, views=tuple(views), cameras=cameras))


_SCALE = 43.5  # focal length (580 px) times base line (75 mm) of the first Kinect
_STEP = 0.125  # pixels of disparity between two values that it distinguishes

_NOISE = 0.062
"""Pixels of disparity, standard deviation: 1.4 mm at 1 m, growing with the square of the range
(Khoshelham and Elberink 2012, doi:10.3390/s120201437)."""

_ALIKE = 1.0  # pixels over which errors are alike, standard deviation of the smoothing
_FRAYED = 0.4  # pixels by which edges are displaced, standard deviation

_BASELINE = 0.075
"""Metres from the projector to the camera: beside edges the camera sees what it does not light."""

_DEPTH, _MASK = "depth/%06d.png", "mask/%06d.png"
_UNIT = 0.001
_NEAREST, _FARTHEST = 0.3, 6.0
_BEFORE_ROOM = 0.08  # metres by which the person is in front of the empty room


@dataclass(frozen=True, eq=False)
class DepthCamera:
    """Measures the scene that a renderer draws; `stream` decides the noise, as of a sensor."""

    renderer: CameraRenderer
    focal: float  # pixels
    folder: Path  # of its images
    stream: tuple[int, int]
    empty: Float32Array = field(init=False)  # (H, W), metres. True ranges of the empty room.

    def __post_init__(self) -> None:
        object.__setattr__(self, "empty", self.renderer.depth(()))

        for images in (_DEPTH, _MASK):
            (self.folder / images).parent.mkdir(parents=True)

    def write(self, people: Sequence[Posed], frame: int) -> None:
        """Store depth image and mask of a frame."""
        ranges, person = self.measured(people, frame)
        write_png(self.folder / (_DEPTH % frame), counts_of(ranges, _UNIT))
        write_png(self.folder / (_MASK % frame), person)

    def measured(self, people: Sequence[Posed], frame: int) -> tuple[Float32Array, BoolArray]:
        """Ranges (H, W) in metres, NaN without, and the mask of who is there, made of these."""
        rng = np.random.default_rng([*self.stream, 3, frame])
        true = self.renderer.depth(people)
        shift = self.focal * _BASELINE / np.maximum(true, _NEAREST)
        lit = ~_in_shadow(shift.astype(np.float32))
        z = _frayed(np.where(lit, true, np.nan).astype(np.float32), rng)
        z[z > _FARTHEST] = np.nan
        noise = cv2.GaussianBlur(rng.standard_normal(z.shape, np.float32), (0, 0), _ALIKE)
        disparity = _SCALE / z + _NOISE * (noise / noise.std()).astype(np.float32)
        ranges = _SCALE / (np.round(disparity / _STEP) * _STEP)
        with np.errstate(invalid="ignore"):
            person = ranges < self.empty - _BEFORE_ROOM
        return ranges.astype(np.float32), person


def _in_shadow(disparity: Float32Array) -> BoolArray:
    """Pixels (H, W) that something nearer keeps from the projector's light."""
    height, width = disparity.shape
    lines = np.arange(height)[:, None]
    margin = int(np.ceil(disparity.max())) + 1
    column = np.rint(np.arange(width) + disparity).astype(np.int64)
    nearest = np.zeros((height, width + margin))
    np.maximum.at(nearest, (lines, column), disparity)
    return np.asarray(nearest[lines, column] > disparity + 1.0)


def _frayed(z: Float32Array, rng: np.random.Generator) -> Float32Array:
    """The ranges, each taken from a place beside it: edges are ragged."""
    height, width = z.shape
    x, y = np.meshgrid(np.arange(width), np.arange(height))
    off = _FRAYED * rng.standard_normal((2, height, width))
    column = np.clip(np.rint(x + off[0]), 0, width - 1).astype(np.int64)
    line = np.clip(np.rint(y + off[1]), 0, height - 1).astype(np.int64)
    return np.asarray(z[line, column])

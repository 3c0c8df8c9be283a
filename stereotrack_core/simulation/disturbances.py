"""Disturbances of simulated recordings: light, shadows, other people, cameras that move.

Shadows and shade are computed on the surfaces of the room and of the people, so that all cameras
see the same. The shadow is a perspective shadow map (Williams, "Casting curved shadows on curved
surfaces", 1978) whose edge widens with the distance from what casts it (Fernando,
"Percentage-closer soft shadows", 2005).
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np

from stereotrack_core.arrays import Float32Array, FloatArray, IntArray
from stereotrack_core.compiled import compiled
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.simulation.raster import SAMPLES, rasterise
from stereotrack_core.simulation.rig import Sensor, looking_at


@dataclass(frozen=True)
class Kind:
    """A kind of disturbance: default, least and greatest strength, and what the strength means."""

    default: float
    least: float
    most: float
    description: str
    whole: bool = False
    """Only whole numbers are possible."""


KINDS: dict[str, Kind] = {
    "gain": Kind(1.1, 0.05, 5.0, "factor of the light against the picture of the empty scene"),
    "exposure": Kind(0.15, 0.0, 0.9, "swing of each camera's exposure within ten seconds"),
    "gamma": Kind(0.8, 0.2, 5.0, "exponent of the brightness"),
    "noise": Kind(8.0, 0.0, 50.0, "grey levels of noise added in the video"),
    "flicker": Kind(0.08, 0.0, 0.9, "greatest random change of brightness from frame to frame"),
    "bands": Kind(0.08, 0.0, 0.9, "swing of mains light seen as bands by a rolling shutter"),
    "shadow": Kind(0.3, 0.0, 1.0, "share of the light that people keep from floor and walls"),
    "shade": Kind(0.25, 0.0, 1.0, "darkness of a shade with a soft edge that wanders"),
    "passer": Kind(3.6, 1.5, 4.0, "metres from the middle of the room where another walks past"),
    "shake": Kind(1.0, 0.0, 20.0, "pixels by which each stereo pair vibrates"),
    "bump": Kind(1.0, 0.0, 20.0, "degrees by which the first view is turned from half time on"),
    "rows": Kind(0.7, -20.0, 20.0, "pixels by which the left images are too low"),
    "blur": Kind(1.5, 0.0, 10.0, "pixels of blur added in the video"),
    "compress": Kind(35, 0, 51, "crf of the H.264 videos", whole=True),
    "late": Kind(1, 1, 10, "frames by which the last view is late", whole=True),
    "doubled": Kind(0.05, 0.0, 1.0, "share of the frames in which a view repeats the one before"),
    "dirt": Kind(0.7, 0.0, 1.0, "darkness of a spot on each lens, in the empty scene as well"),
    "glare": Kind(3.0, 1.0, 20.0, "factor of the light in a spot of each picture"),
}
"""All kinds by name, in the order in which messages list them."""


def kinds_text() -> str:
    """One clause per kind: name, default and meaning."""
    return "; ".join(
        f"{name}={kind.default:g} ({kind.description})" for name, kind in KINDS.items()
    )


@dataclass(frozen=True)
class Disturbance:
    """One disturbance; raises InputError for an unknown kind or an impossible strength."""

    kind: str
    strength: float

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise _refusal(f"there is no disturbance {self.kind!r}")
        kind = KINDS[self.kind]
        fits = kind.least <= self.strength <= kind.most  # false for NaN
        if not fits or (kind.whole and self.strength != round(self.strength)):
            raise _refusal(f"the strength {self.strength:g} of {self.kind!r} is not possible")


def _refusal(what: str) -> InputError:
    possible = ", ".join(
        f"{name} ({kind.least:g} to {kind.most:g}{', whole' if kind.whole else ''})"
        for name, kind in KINDS.items()
    )
    return InputError(what, where="--disturb", remedy=f"There are, with strengths: {possible}.")


def parsed_disturbances(text: str) -> tuple[Disturbance, ...]:
    """Read ``exposure=0.3,shadow``; without a strength the kind's default is meant.

    Raises InputError for an unknown kind, an impossible strength, or a kind given twice.
    """
    result = []
    for part in filter(None, (part.strip() for part in text.split(","))):
        name, equals, strength = (word.strip() for word in part.partition("="))
        try:
            value = float(strength) if equals else KINDS[name].default if name in KINDS else 0.0
        except ValueError:
            raise _refusal(f"{strength!r} is no strength of {name!r}") from None
        result.append(Disturbance(name, value))
    if len({one.kind for one in result}) < len(result):
        raise _refusal(f"{text!r} names a disturbance twice")
    return tuple(result)


_SWING_SECONDS = 10.0
_MAINS_HERTZ, _READOUT_SECONDS = 100.0, 1 / 30
"""Lamps pulse at twice the mains frequency; seconds from the first row of a picture to the last."""

_CLOCK_ERROR = 0.003
"""Relative error of the frame rate, by which the bands crawl."""


@dataclass(frozen=True, eq=False)
class Disturber:
    """The disturbances of one recording; pictures depend on nothing but them and the seed."""

    strengths: Mapping[str, float]
    """Strength by kind, of the chosen kinds."""
    seed: int
    fps: float
    frames: int

    def instant(self, camera: str, cameras: Iterable[str], frame: int) -> int:
        """Frame whose scene the camera shows; an earlier one if its view is late or repeats it."""
        view, behind = _view(camera), 0
        if view == _view(list(cameras)[-1]):
            behind = int(self.strengths.get("late", 0))
        if self.rng("doubled", view, frame).uniform() < self.strengths.get("doubled", 0.0):
            behind += 1
        return max(0, frame - behind)

    def turned(self, cameras: Mapping[str, Camera]) -> dict[str, Camera]:
        """Cameras of the view that is bumped, as they stand afterwards; the pair stays rigid."""
        if "bump" not in self.strengths:
            return {}
        view = _view(next(iter(cameras)))
        pair = {name: camera for name, camera in cameras.items() if _view(name) == view}
        base = pair[f"{view}_right"].camera_from_world
        angle = self.rng("bump").uniform(0, 2 * np.pi)
        axis = np.array([np.sin(angle), np.cos(angle), 0.0])
        turn = rotation_from_vector(np.radians(self.strengths["bump"]) * axis)
        moved = base.inverse() @ RigidTransform(turn, np.zeros(3)) @ base
        return {
            name: replace(camera, camera_from_world=camera.camera_from_world @ moved)
            for name, camera in pair.items()
        }

    def sensor(self, sensor: Sensor) -> Sensor:
        """The sensor as it takes the video; that of the empty scene's picture is undisturbed."""
        blur = float(np.hypot(sensor.blur, self.strengths.get("blur", 0.0)))
        noise = float(np.hypot(sensor.noise, self.strengths.get("noise", 0.0)))
        return replace(sensor, blur=blur, noise=noise)

    def on_sensor(self, camera: str, light: Float32Array, frame: int) -> Float32Array:
        """The light (H, W, c) that the sensor is to record; frame -1 is the empty scene."""
        light = self._shifted(camera, light, frame)
        if "dirt" in self.strengths:
            light = light * (1 - self.strengths["dirt"] * self._spot("dirt", camera, light))
        if frame < 0:
            return light
        light = light * self._brightness(camera, frame, light.shape[0])
        if "glare" in self.strengths:
            light = light * (1 + (self.strengths["glare"] - 1) * self._spot("glare", camera, light))
        if "gamma" in self.strengths:
            bent = 255 * (np.maximum(light, 0) / 255) ** self.strengths["gamma"]
            light = bent.astype(np.float32)
        return light

    def _brightness(self, camera: str, frame: int, rows: int) -> Float32Array:
        """Factors (rows, 1, 1) of the brightness of a frame."""
        given, seconds = self.strengths, frame / self.fps
        factor = given.get("gain", 1.0)
        if "exposure" in given:
            phase = self.rng("exposure", camera).uniform(0, 2 * np.pi)
            factor *= 1 + given["exposure"] * np.sin(2 * np.pi * seconds / _SWING_SECONDS + phase)
        if "flicker" in given:
            factor *= 1 + given["flicker"] * self.rng("flicker", _view(camera), frame).uniform(
                -1, 1
            )
        factors = np.full((rows, 1, 1), factor)
        if "bands" in given:
            phase = self.rng("bands", _view(camera)).uniform(0, 1)
            row = np.arange(rows).reshape(-1, 1, 1) / rows * _READOUT_SECONDS
            cycles = _MAINS_HERTZ * (seconds * (1 + _CLOCK_ERROR) + row) + phase
            factors *= 1 + given["bands"] * np.sin(2 * np.pi * cycles)
        return factors.astype(np.float32)

    def _spot(self, kind: str, camera: str, light: Float32Array) -> Float32Array:
        """A round spot (H, W, 1) with a soft edge, 1 in its middle, somewhere in the picture."""
        height, width = light.shape[:2]
        x, y = self.rng(kind, camera).uniform(0.3, 0.7, 2) * (width, height)
        rows, columns = np.mgrid[:height, :width].astype(np.float32)
        apart = np.hypot(columns - x, rows - y) / (0.12 * width)
        return np.asarray(np.exp(-(apart**4)), np.float32)[:, :, None]

    def _shifted(self, camera: str, light: Float32Array, frame: int) -> Float32Array:
        shift = np.zeros(2)
        if "shake" in self.strengths and frame >= 0:
            shift += self.strengths["shake"] * self.rng("shake", _view(camera), frame).normal(
                size=2
            )
        if camera.endswith("left"):
            shift[1] += self.strengths.get("rows", 0.0)
        if not shift.any():
            return light
        moved = cv2.warpAffine(
            light, np.column_stack([np.eye(2), shift]), light.shape[1::-1],
            flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE,
        )  # fmt: skip
        return np.asarray(moved, np.float32).reshape(light.shape)

    def rng(self, *key: object) -> np.random.Generator:
        """Random numbers for a purpose, the same in every program."""
        return np.random.default_rng([self.seed, zlib.crc32(repr(key).encode())])


def _view(camera: str) -> str:
    return camera.partition("_")[0]


UNDISTURBED = Disturber({}, 0, 1.0, 1)


Surface = tuple[IntArray, FloatArray, FloatArray]
"""Triangles (T, 3), and vertices and normals (V, 3), world."""

Drawn = tuple[IntArray, Float32Array, int]
"""Numbers of the triangles and their weights as :func:`rasterise` writes them; the first number."""

_LAMP_DISTANCE, _LAMP_HEIGHTS, _LAMP_RADIUS = 4.2, (1.9, 2.5), 0.05
"""Metres from the middle of the room, above the floor, and of the lamp itself."""

_MAP_SIZE, _MAP_FOCAL = 768, 307.0
"""Pixels of the shadow map; 1 cm at the person."""

_LOOK_AT_HEIGHT, _NEAREST = 0.9, 0.3
"""Metres: the height at which the lamp is aimed, and the least distance of what casts a shadow."""

_BIAS = 0.05
"""Metres by which what casts a shadow must be nearer to the lamp, so that nothing shades itself."""

_REACH = 21
"""Pixels (odd) of the map in which things may cast a soft edge on a point."""

_SHADE_SECONDS, _SHADE_WAY, _SHADE_EDGE = 12.0, 1.5, 0.8
"""Period, amplitude (m) and width (m) of the edge of the shade that wanders."""


@dataclass(frozen=True, eq=False)
class Shadows:
    """The light of a frame that people and shade take away from surfaces."""

    darkness: FloatArray
    """(2,): strengths of the shadow and of the shade."""
    lamp: FloatArray
    """(4, 3): rotation from world to lamp, whose z is its axis; place of the lamp."""
    nearness: Float32Array
    """(S, S): 1 / z of the nearest person seen by the lamp, 0 where nobody is."""
    reached: Float32Array
    """(S, S): greatest `nearness` around each pixel."""
    edge: FloatArray
    """(4,): direction into the shade, and the distance along it at which it begins."""

    @staticmethod
    def of(disturber: Disturber, people: Iterable[Surface], frame: int) -> Shadows | None:
        """Shadows of a frame; None if neither shadow nor shade is chosen."""
        given = disturber.strengths
        darkness = np.array([given.get("shadow", 0.0), given.get("shade", 0.0)])
        if not darkness.any():
            return None
        lamp, nearness = _lamp(disturber), np.zeros((_MAP_SIZE, _MAP_SIZE), np.float32)
        if darkness[0] > 0:
            for triangles, vertices, _ in people:
                _cast(lamp, triangles, vertices, nearness)
        reached = cv2.dilate(nearness, np.ones((_REACH, _REACH), np.uint8))
        return Shadows(
            darkness, lamp, nearness, np.asarray(reached, np.float32), _edge(disturber, frame)
        )

    def darken(self, drawn: Drawn, surface: Surface, is_person: bool, light: Float32Array) -> None:
        """Take the shadow from the light (h, w, c) of the samples that show the surface."""
        ids, weights, first = drawn
        _darken(
            light, ids, weights, first, *surface, is_person, self.darkness, self.lamp,
            self.nearness, self.reached, self.edge,
        )  # fmt: skip


def _lamp(disturber: Disturber) -> FloatArray:
    rng = disturber.rng("shadow")
    angle, height = rng.uniform(0, 2 * np.pi), rng.uniform(*_LAMP_HEIGHTS)
    place = np.array([*(_LAMP_DISTANCE * np.array([np.cos(angle), np.sin(angle)])), height])
    return np.vstack([looking_at(place, np.array([0.0, 0.0, _LOOK_AT_HEIGHT])), place])


def _cast(
    lamp: FloatArray, triangles: IntArray, vertices: FloatArray, out_nearness: Float32Array
) -> None:
    """Draw a person as the lamp sees it."""
    x, y, z = (lamp[:3] @ (vertices - lamp[3]).T).astype(np.float64)
    safe = np.maximum(z, _NEAREST)
    samples = np.column_stack([x, y]) / safe[:, None] * _MAP_FOCAL + (_MAP_SIZE - 1) / 2
    samples[z < _NEAREST] = np.nan
    pixels = (samples + 0.5) / SAMPLES - 0.5
    ids = np.empty(out_nearness.shape, np.int32)
    weights = np.empty((*ids.shape, 2), np.float32)
    rasterise(pixels, 1.0 / safe, triangles, 0, 0, 0, out_nearness, ids, weights)


def _edge(disturber: Disturber, frame: int) -> FloatArray:
    """Where the shade begins in a frame."""
    angle, phase = disturber.rng("shade").uniform(0, 2 * np.pi, 2)
    direction = np.array([np.cos(angle), np.sin(angle), 0.5]) / np.sqrt(1.25)
    turn = 2 * np.pi * frame / disturber.fps / _SHADE_SECONDS + phase
    return np.array([*direction, _SHADE_WAY * np.sin(turn) + 0.4])


@compiled()
def _darken(
    out_light: Any,
    ids: Any,
    weights: Any,
    first_id: int,
    triangles: Any,
    vertices: Any,
    normals: Any,
    is_person: bool,
    darkness: Any,
    lamp: Any,
    nearness: Any,
    reached: Any,
    edge: Any,
) -> None:
    """Multiply the light (h, w, c) of all samples that show these triangles."""
    for y in range(ids.shape[0]):
        for x in range(ids.shape[1]):
            t = ids[y, x] - first_id
            if t < 0 or t >= triangles.shape[0]:
                continue
            wb, wc = weights[y, x, 0], weights[y, x, 1]
            wa = 1.0 - wb - wc
            i, j, k = triangles[t, 0], triangles[t, 1], triangles[t, 2]
            px = wa * vertices[i, 0] + wb * vertices[j, 0] + wc * vertices[k, 0]
            py = wa * vertices[i, 1] + wb * vertices[j, 1] + wc * vertices[k, 1]
            pz = wa * vertices[i, 2] + wb * vertices[j, 2] + wc * vertices[k, 2]
            depth = (px * edge[0] + py * edge[1] + pz * edge[2] - edge[3]) / _SHADE_EDGE + 0.5
            depth = min(1.0, max(0.0, depth))
            factor = 1.0 - darkness[1] * depth * depth * (3.0 - 2.0 * depth)
            if darkness[0] > 0.0:
                dx, dy, dz = px - lamp[3, 0], py - lamp[3, 1], pz - lamp[3, 2]
                facing = -(normals[i, 0] * dx + normals[i, 1] * dy + normals[i, 2] * dz)
                facing = min(1.0, max(0.0, 5.0 * facing / math.sqrt(dx * dx + dy * dy + dz * dz)))
                hidden = _hidden(dx, dy, dz, lamp, nearness, reached) if facing > 0.0 else 0.0
                # The lamp shines in the empty scene as well, so that the room's sides that are
                # turned away from it lose nothing; those of a person have no light of the lamp.
                lost = 1.0 - facing * (1.0 - hidden) if is_person else facing * hidden
                factor *= 1.0 - darkness[0] * lost
            for c in range(out_light.shape[2]):
                out_light[y, x, c] *= factor


@compiled()
def _hidden(dx: float, dy: float, dz: float, lamp: Any, nearness: Any, reached: Any) -> float:
    """Share of the lamp that people hide from a point at this distance from it."""
    z = lamp[2, 0] * dx + lamp[2, 1] * dy + lamp[2, 2] * dz
    if z < _NEAREST:
        return 0.0
    size = nearness.shape[0]
    u = (lamp[0, 0] * dx + lamp[0, 1] * dy + lamp[0, 2] * dz) / z * _MAP_FOCAL + (size - 1) / 2
    v = (lamp[1, 0] * dx + lamp[1, 1] * dy + lamp[1, 2] * dz) / z * _MAP_FOCAL + (size - 1) / 2
    if not (0.0 <= u <= size - 1 and 0.0 <= v <= size - 1):
        return 0.0
    limit = 1.0 / (z - _BIAS)
    nearest = reached[int(v + 0.5), int(u + 0.5)]
    if nearest <= limit:
        return 0.0
    spread = max(0.7, _MAP_FOCAL * _LAMP_RADIUS * (nearest - 1.0 / z)) / 3
    count = 0
    for row in range(-3, 4):
        for column in range(-3, 4):
            r = min(size - 1, max(0, int(v + spread * row + 0.5)))
            c = min(size - 1, max(0, int(u + spread * column + 0.5)))
            count += nearness[r, c] > limit
    return count / 49.0

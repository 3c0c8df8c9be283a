"""Disturbances of simulated recordings: light, lenses, clocks, cameras that move."""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import cv2
import numpy as np

from stereotrack_core.arrays import Float32Array
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.simulation.rig import Sensor


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
    "shadow": Kind(0.3, 0.0, 1.0, "share of the light that people keep from floor and walls"),
    "shade": Kind(0.25, 0.0, 1.0, "darkness of a shade with a soft edge that wanders"),
    "passer": Kind(3.6, 1.5, 4.0, "metres from the middle of the room where another walks past"),
    "shake": Kind(1.0, 0.0, 20.0, "pixels by which each stereo pair vibrates"),
    "bump": Kind(1.0, 0.0, 20.0, "degrees by which the first view is turned from half time on"),
    "rows": Kind(0.7, -20.0, 20.0, "pixels by which the left images are too low"),
    "blur": Kind(1.5, 0.0, 10.0, "pixels of blur added in the video"),
    "compress": Kind(35, 0, 51, "crf of the H.264 videos", whole=True),
    "late": Kind(1, 1, 10, "frames by which the last view is late", whole=True),
}
"""All kinds by name, in the order in which messages list them."""


def kinds_text() -> str:
    """One clause per kind: name, default and meaning."""
    return "; ".join(
        f"{name}={kind.default:g} ({kind.description})" for name, kind in KINDS.items()
    )


def check_strengths(strengths: Mapping[str, float]) -> None:
    """Raise InputError for an unknown kind or an impossible strength."""
    for name, strength in strengths.items():
        if name not in KINDS:
            raise _refusal(f"there is no disturbance {name!r}")
        kind = KINDS[name]
        fits = kind.least <= strength <= kind.most  # false for NaN
        if not fits or (kind.whole and strength != round(strength)):
            raise _refusal(f"the strength {strength:g} of {name!r} is not possible")


def _refusal(what: str) -> InputError:
    possible = ", ".join(
        f"{name} ({kind.least:g} to {kind.most:g}{', whole' if kind.whole else ''})"
        for name, kind in KINDS.items()
    )
    return InputError(what, where="--disturb", remedy=f"There are, with strengths: {possible}.")


def parsed_disturbances(text: str) -> dict[str, float]:
    """Read ``exposure=0.3,shadow``; without a strength the kind's default is meant.

    Raises InputError for an unknown kind, an impossible strength, or a kind given twice.
    """
    result: dict[str, float] = {}
    for part in filter(None, (part.strip() for part in text.split(","))):
        name, equals, strength = (word.strip() for word in part.partition("="))
        if name in result:
            raise _refusal(f"{text!r} names a disturbance twice")
        try:
            result[name] = float(strength) if equals else KINDS[name].default
        except KeyError:
            raise _refusal(f"there is no disturbance {name!r}") from None
        except ValueError:
            raise _refusal(f"{strength!r} is no strength of {name!r}") from None
    check_strengths(result)
    return result


_SWING_SECONDS = 10.0


@dataclass(frozen=True, eq=False)
class Disturber:
    """The disturbances of one recording; pictures depend on nothing but them and the seed."""

    strengths: Mapping[str, float]
    """Strength by kind, of the chosen kinds."""
    seed: int
    fps: float
    frames: int

    def instant(self, camera: str, cameras: Iterable[str], frame: int) -> int:
        """Frame whose scene the camera shows; an earlier one if its view is late."""
        last = _view(camera) == _view(list(cameras)[-1])
        return max(0, frame - int(self.strengths.get("late", 0)) * last)

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
        if frame < 0:
            return light
        light = light * self._brightness(camera, frame)
        if "gamma" in self.strengths:
            bent = 255 * (np.maximum(light, 0) / 255) ** self.strengths["gamma"]
            light = bent.astype(np.float32)
        return light

    def _brightness(self, camera: str, frame: int) -> np.float32:
        """Factor of the brightness of a frame."""
        given, seconds = self.strengths, frame / self.fps
        factor = given.get("gain", 1.0)
        if "exposure" in given:
            phase = self.rng("exposure", camera).uniform(0, 2 * np.pi)
            factor *= 1 + given["exposure"] * np.sin(2 * np.pi * seconds / _SWING_SECONDS + phase)
        if "flicker" in given:
            factor *= 1 + given["flicker"] * self.rng("flicker", _view(camera), frame).uniform(
                -1, 1
            )
        return np.float32(factor)

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

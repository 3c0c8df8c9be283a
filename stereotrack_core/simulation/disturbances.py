"""Disturbances of simulated recordings: light, passers-by, cameras that move."""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from dataclasses import dataclass, replace

import cv2
import numpy as np

from stereotrack_core.arrays import Float32Array
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.geometry.transform import RigidTransform


@dataclass(frozen=True)
class Kind:
    """A kind of disturbance: default, least and greatest strength, and what the strength means."""

    default: float
    least: float
    most: float
    description: str


KINDS: dict[str, Kind] = {
    "gain": Kind(1.1, 0.05, 5.0, "factor of the light against the picture of the empty scene"),
    "exposure": Kind(0.15, 0.0, 0.9, "swing of each camera's exposure within ten seconds"),
    "flicker": Kind(0.08, 0.0, 0.9, "greatest random change of brightness from frame to frame"),
    "shadow": Kind(0.3, 0.0, 1.0, "share of the light that people keep from floor and walls"),
    "shade": Kind(0.25, 0.0, 1.0, "darkness of a shade with a soft edge that wanders"),
    "passer": Kind(3.6, 1.5, 4.0, "metres from the middle of the room where another walks past"),
    "shake": Kind(1.0, 0.0, 20.0, "pixels by which each stereo pair vibrates"),
    "bump": Kind(1.0, 0.0, 20.0, "degrees by which the first view is turned from half time on"),
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
        if not kind.least <= strength <= kind.most:  # NaN is refused too
            raise _refusal(f"the strength {strength:g} of {name!r} is not possible")


def _refusal(what: str) -> InputError:
    possible = ", ".join(
        f"{name} ({kind.least:g} to {kind.most:g})" for name, kind in KINDS.items()
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

    def on_sensor(self, camera: str, light: Float32Array, frame: int) -> Float32Array:
        """The light (H, W, c) that the sensor is to record in a frame of the video."""
        given, seconds, view = self.strengths, frame / self.fps, _view(camera)
        factor = given.get("gain", 1.0)
        if "exposure" in given:
            phase = self.rng("exposure", camera).uniform(0, 2 * np.pi)
            factor *= 1 + given["exposure"] * np.sin(2 * np.pi * seconds / _SWING_SECONDS + phase)
        if "flicker" in given:
            factor *= 1 + given["flicker"] * self.rng("flicker", view, frame).uniform(-1, 1)
        if "shake" in given:
            shift = given["shake"] * self.rng("shake", view, frame).normal(size=2)
            moved = cv2.warpAffine(
                light, np.column_stack([np.eye(2), shift]), light.shape[1::-1],
                flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE,
            )  # fmt: skip
            light = np.asarray(moved, np.float32).reshape(light.shape)
        return light * np.float32(factor)

    def rng(self, *key: object) -> np.random.Generator:
        """Random numbers for a purpose, the same in every program."""
        return np.random.default_rng([self.seed, zlib.crc32(repr(key).encode())])


def _view(camera: str) -> str:
    return camera.partition("_")[0]


UNDISTURBED = Disturber({}, 0, 1.0, 1)

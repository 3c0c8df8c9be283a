"""What a camera makes of the light: channels, blur, gain, noise, grey levels."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from stereotrack_core.arrays import Float32Array, FloatArray, ImageArray
from stereotrack_core.simulation.options import SceneOptions

_LUMINANCE = np.array([[0.299, 0.587, 0.114]])


@dataclass(frozen=True, eq=False)
class Sensor:
    """One camera's sensor.

    Attributes
    ----------
    response : (c, 3) float64
        Channels (grey, or blue, green, red) from red, green, blue of the light.
    gain : float
    blur, noise : float
        Standard deviations in pixels and grey levels.
    stream : (int, int)
        Seed and number of the camera: the noise of a frame depends on nothing else.
    """

    response: FloatArray
    gain: float
    blur: float
    noise: float
    stream: tuple[int, int]

    def exposed(self, light: Float32Array, frame: int) -> ImageArray:
        """Picture (H, W) or (H, W, 3) of light (H, W, c); frame -1 is the empty scene."""
        values: Float32Array = light * np.float32(self.gain)
        if self.blur > 0:
            blurred = cv2.GaussianBlur(values, (0, 0), self.blur)
            values = np.asarray(blurred, np.float32).reshape(light.shape)
        rng = np.random.default_rng([*self.stream, frame + 1])
        values = values + np.float32(self.noise) * rng.standard_normal(light.shape, np.float32)
        picture: ImageArray = np.clip(np.rint(values), 0, 255).astype(np.uint8)
        return picture[..., 0] if picture.shape[2] == 1 else picture


def sensor(options: SceneOptions, seed: int, camera: str) -> Sensor:
    """The sensor of the camera of that name; left ones are brighter."""
    number = int.from_bytes(camera.encode()[:1], "big") * 2 + camera.endswith("left")
    rng = np.random.default_rng([seed, 2, number])
    response = _LUMINANCE
    if options.colour:
        mixing = np.eye(3) * (1 + 0.06 * rng.normal(size=3)) + rng.uniform(0, 0.06, (3, 3))
        response = (mixing / mixing.sum(axis=1).mean())[::-1]
    gain = 1 + options.gain_difference if camera.endswith("left") else 1.0
    return Sensor(response, gain, options.blur, options.noise, (seed, number))

"""Numbers of the body that are free in a fit, and what is expected of them."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.model import BodyModel, body_model
from stereotrack_core.body.parameters import BodyParameters
from stereotrack_core.body.proportions import Proportions

SHAPE_SIGMAS: dict[str, float] = {
    "torso_radius_low": 0.02,
    "torso_radius_high": 0.02,
    "torso_flatness": 0.10,
    "torso_forward_low": 0.015,
    "torso_forward_high": 0.015,
    "shoulder_rise": 0.015,
    "shoulder_radius_factor": 0.15,
    "head_rise": 0.03,
    "head_forward": 0.01,
    "head_radius_factor": 0.12,
    "leg_forward": 0.008,
    "leg_radius_factor": 0.15,
}
"""What is fitted of the surface, and how much people differ from the default, in the parameters'
units.

Shifts to the front are held firmly: all of them together cannot be told from a body that leans.
"""

LENGTH_SIGMAS: dict[str, float] = {
    "shoulder_width": 0.05,
    "hip_width": 0.07,
    "torso_length": 0.04,
    "upper_arm_length": 0.04,
    "forearm_length": 0.04,
    "hand_length": 0.05,
    "shoulder_to_head": 0.06,
}
"""How much people of one height differ in their lengths, as parts of them."""

_HEIGHT_SIGMA = 0.06
"""How much people differ in height, as a part of it; it moves all lengths together."""


@dataclass(frozen=True, eq=False)
class FreeBody:
    """A body of which some numbers are free: lengths as logarithms of ratios, the surface's as
    they are.
    """

    proportions: Proportions
    """What lengths are expected to be."""
    shape: BodyParameters
    """What the surface is expected to be."""
    lengths: tuple[str, ...] = ()
    surface: tuple[str, ...] = tuple(SHAPE_SIGMAS)
    """`lengths` and `surface`: names of the free ones."""

    @property
    def start(self) -> FloatArray:
        """What is expected (k,)."""
        values = self.shape.values()
        lengths = np.zeros(len(self.lengths))
        return np.append(lengths, [float(values[name]) for name in self.surface])

    @property
    def information(self) -> FloatArray:
        """Inverse (k, k) of the covariance with which people differ from what is expected."""
        k = len(self.lengths)
        sigmas = [LENGTH_SIGMAS[name] for name in self.lengths]
        sigmas += [SHAPE_SIGMAS[name] for name in self.surface]
        covariance = np.diag(np.square(sigmas))
        covariance[:k, :k] += _HEIGHT_SIGMA**2
        return np.linalg.inv(covariance)

    def parts(self, theta: FloatArray) -> tuple[Proportions, BodyParameters]:
        """Lengths and surface for values (k,) of the free numbers."""
        k = len(self.lengths)
        ratios = dict(zip(self.lengths, np.exp(theta[:k]), strict=True))
        lengths = {name: float(r * getattr(self.proportions, name)) for name, r in ratios.items()}
        rows = {row.name: row for row in BodyParameters.rows()}
        values = {
            name: float(np.clip(value, rows[name].minimum, rows[name].maximum))
            for name, value in zip(self.surface, theta[k:], strict=True)
        }
        return dataclasses.replace(self.proportions, **lengths), self.shape.replaced(**values)

    def body(self, theta: FloatArray) -> BodyModel:
        """Body for values (k,) of the free numbers."""
        return body_model(*self.parts(theta))

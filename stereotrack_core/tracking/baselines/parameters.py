"""Parameters of the estimators that the tracker is measured against."""

from dataclasses import dataclass

from stereotrack_core.parameters import ParameterGroup, parameter

_GROUP = "Baselines"


@dataclass(frozen=True)
class BaselineParameters(ParameterGroup):
    """How much work each baseline may do in a frame, and how far it looks."""

    annealed_particles: int = parameter(
        200,
        "Number of particles of the annealed particle filter.",
        group=_GROUP,
        minimum=10,
        maximum=100000,
    )
    annealed_layers: int = parameter(
        10,
        "Number of layers of the annealed particle filter.",
        group=_GROUP,
        minimum=1,
        maximum=100,
    )
    annealed_survival: float = parameter(
        0.2,
        "Share of the particles that survives a layer.",
        group=_GROUP,
        minimum=0.05,
        maximum=0.95,
    )
    annealed_spread: float = parameter(
        1.0,
        "Diffusion before the first layer, in standard deviations of the expected movement.",
        group=_GROUP,
        minimum=0.1,
        maximum=20.0,
    )
    annealed_diffusion: float = parameter(
        0.3,
        "Diffusion between two layers, in standard deviations of the particles.",
        group=_GROUP,
        minimum=0.0,
        maximum=2.0,
    )
    annealed_data: int = parameter(
        300,
        "Measured points used to weight each particle.",
        group=_GROUP,
        minimum=20,
        maximum=20000,
    )
    limb_icp_rounds: int = parameter(
        4,
        "Number of rounds of assigning the data to limbs, registering the limbs, and joining them.",
        group=_GROUP,
        minimum=1,
        maximum=50,
    )
    limb_icp_iterations: int = parameter(
        5,
        "Closest-point iterations per limb.",
        group=_GROUP,
        minimum=1,
        maximum=100,
    )
    scalar_iterations: int = parameter(
        80,
        "Steps of stochastic gradient descent on the sum of distances.",
        group=_GROUP,
        minimum=1,
        maximum=10000,
    )
    scalar_data: int = parameter(
        300,
        "Measured points sampled for one step of stochastic gradient descent.",
        group=_GROUP,
        minimum=20,
        maximum=20000,
    )

"""Parameters of the tracker, and of a run; the thesis's values are those of section 4.2.1."""

import dataclasses
from dataclasses import dataclass

from stereotrack_core.body.parameters import BodyParameters
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.parameters import ParameterGroup, parameter
from stereotrack_core.tracking.arm_search.parameters import SearchParameters
from stereotrack_core.tracking.baselines.parameters import BaselineParameters
from stereotrack_core.tracking.residuals.parameters import (
    ColourParameters,
    DetectionParameters,
    SilhouetteParameters,
)

_METHOD, _NOISE, _DATA = "Method", "Noise", "Measurements"
_LIMITS = "Limits and collisions"


@dataclass(frozen=True)
class TrackingParameters(ParameterGroup):
    """How poses are estimated; the defaults are those of preset ``accurate``."""

    matching: str = parameter(
        "data_to_model",
        "Direction of the correspondences: measured points to the model, or sampled model points "
        "to the nearest measured points.",
        group=_METHOD,
        choices=("data_to_model", "model_to_data"),
        thesis="model_to_data",
    )
    estimator: str = parameter(
        "iterated",
        "Estimator for data-to-model correspondences: the tracker's own iterated correction, or "
        "one of the baselines.",
        group=_METHOD,
        choices=(
            "iterated",
            "extended_kalman",
            "annealed_particles",
            "limb_icp",
            "scalar_distance",
        ),
    )
    linearisation: str = parameter(
        "derivatives",
        "Linearisation of data-to-model correspondences: by derivatives, or by sigma points of "
        "the posterior, which is several times slower.",
        group=_METHOD,
        choices=("derivatives", "sigma_points"),
    )
    iterations: int = parameter(
        6, "Corrections per frame set.", group=_METHOD, minimum=1, maximum=50, thesis=4
    )
    ut_alpha: float = parameter(
        0.1,
        "Spread of the sigma points; small values keep them close to the mean.",
        group=_METHOD,
        minimum=1e-4,
        maximum=2.0,
    )
    ut_beta: float = parameter(
        2.0, "Second parameter of the scaled unscented transform.", group=_METHOD, minimum=0.0
    )
    ut_kappa: float = parameter(
        0.0, "Third parameter of the scaled unscented transform.", group=_METHOD, minimum=0.0
    )
    sigma_position: float = parameter(
        0.03,
        "Expected movement of the body between two frame sets at 10 Hz.",
        group=_NOISE,
        unit="m",
        minimum=0.001,
        maximum=2.0,
        thesis=0.1,
    )
    sigma_rotation: float = parameter(
        5.0,
        "Expected rotation of the torso between two frame sets at 10 Hz.",
        group=_NOISE,
        unit="deg",
        minimum=0.1,
        maximum=180.0,
        thesis=20.0,
    )
    sigma_joint: float = parameter(
        10.0,
        "Expected rotation of a joint between two frame sets at 10 Hz.",
        group=_NOISE,
        unit="deg",
        minimum=0.1,
        maximum=180.0,
        thesis=40.0,
    )
    sigma_girdle: float = parameter(
        3.0,
        "Expected rotation of a shoulder about its clavicle between two frame sets at 10 Hz.",
        group=_NOISE,
        unit="deg",
        minimum=0.1,
        maximum=180.0,
    )
    girdle_rest: float = parameter(
        2.5,
        "Angle of a clavicle from its rest position up to which it is held firmly. Beyond, it is "
        "held less and less, unless it is lowered.",
        group=_NOISE,
        unit="deg",
        minimum=0.1,
        maximum=180.0,
    )
    sigma_measurement: float = parameter(
        0.015,
        "Expected distance between corresponding points.",
        group=_NOISE,
        unit="m",
        minimum=0.001,
        maximum=1.0,
        thesis=0.02,
    )
    hurry: float = parameter(
        1.5,
        "Prior inflation: the prior is widened if the data move the body by more than this many "
        "of its standard deviations.",
        group=_NOISE,
        minimum=0.5,
        maximum=100.0,
    )
    velocity: float = parameter(
        0.0,
        "Share of the last frame's movement that is expected to continue.",
        group=_NOISE,
        minimum=0.0,
        maximum=1.0,
        thesis=0.0,
    )
    sampling: str = parameter(
        "random",
        "Method of sampling model points from the cones.",
        group=_DATA,
        choices=("random", "regular"),
        thesis="random",
    )
    model_points: int = parameter(
        64,
        "Number m of sampled model points in model-to-data correspondences.",
        group=_DATA,
        minimum=4,
        maximum=20000,
        thesis=64,
    )
    data_points: int = parameter(
        2000,
        "Number of measured points in data-to-model correspondences.",
        group=_DATA,
        minimum=50,
        maximum=20000,
    )
    effective_points: float = parameter(
        150.0,
        "Effective sample size of the data: neighbouring pixels of a block matcher are correlated.",
        group=_DATA,
        minimum=1.0,
        maximum=20000.0,
    )
    reach: float = parameter(
        0.25,
        "Measured points farther than this from the model are ignored (maximum correspondence "
        "distance).",
        group=_DATA,
        unit="m",
        minimum=0.02,
        maximum=2.0,
    )
    robust_wide: float = parameter(
        0.12,
        "Scale of the Geman-McClure loss in the first two iterations: the distance at which a "
        "point loses three quarters of its weight.",
        group=_DATA,
        unit="m",
        minimum=0.005,
        maximum=2.0,
    )
    robust_narrow: float = parameter(
        0.06,
        "Scale of the Geman-McClure loss from the third iteration on.",
        group=_DATA,
        unit="m",
        minimum=0.005,
        maximum=2.0,
    )
    least_points: int = parameter(
        150,
        "A cloud with fewer points than this is not tracked.",
        group=_DATA,
        minimum=1,
        maximum=100000,
    )
    max_unexplained_fraction: float = parameter(
        0.6,
        "A frame is not tracked if the unexplained fraction of its cloud is larger than this.",
        group=_DATA,
        minimum=0.0,
        maximum=1.0,
    )
    clearance: float = parameter(
        0.02,
        "Minimum distance of elbow and hand from the surface of the torso.",
        group=_LIMITS,
        unit="m",
        minimum=0.0,
        maximum=0.5,
        thesis=0.15,
    )
    arms_apart: float = parameter(
        0.045,
        "Minimum distance between the axes of the two forearms. An upper arm and the other "
        "forearm, which are thicker, keep twice this distance. 0 lets the arms pass through each "
        "other.",
        group=_LIMITS,
        unit="m",
        minimum=0.0,
        maximum=0.2,
        thesis=0.0,
    )
    least_elbow_angle: float = parameter(
        30.0,
        "Minimum angle between upper arm and forearm.",
        group=_LIMITS,
        unit="deg",
        minimum=0.0,
        maximum=170.0,
    )
    fit_shape: bool = parameter(
        True,
        "Fit torso, head and legs to the first frames before tracking starts.",
        group=_METHOD,
        thesis=False,
    )
    fit_frames: int = parameter(
        12, "Number of frames that the shape is fitted to.", group=_METHOD, minimum=4, maximum=200
    )
    longest_bridge: float = parameter(
        0.5,
        "Longest gap of untracked frames that smoothing bridges.",
        group="Smoothing",
        unit="s",
        minimum=0.0,
        maximum=10.0,
    )
    silhouette: SilhouetteParameters = dataclasses.field(default_factory=SilhouetteParameters)
    search: SearchParameters = dataclasses.field(default_factory=SearchParameters)
    colours: ColourParameters = dataclasses.field(default_factory=ColourParameters)
    detections: DetectionParameters = dataclasses.field(default_factory=DetectionParameters)
    baselines: BaselineParameters = dataclasses.field(default_factory=BaselineParameters)

    @property
    def wants_colour(self) -> bool:
        """Whether anything looks at colours, so that they have to be read."""
        return self.colours.colour_weight > 0.0 or self.detections.detect == "skin"


@dataclass(frozen=True)
class Settings(ParameterGroup):
    """Parameters from the images to the pose, in the order in which they act."""

    depth: DepthParameters = dataclasses.field(default_factory=DepthParameters)
    body: BodyParameters = dataclasses.field(default_factory=BodyParameters)
    tracking: TrackingParameters = dataclasses.field(default_factory=TrackingParameters)

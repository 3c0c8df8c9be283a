"""Parameters of the tracker, and of a run; the thesis's values are those of section 4.2.1."""

import dataclasses
from dataclasses import dataclass

from stereotrack_core.body.parameters import BodyParameters
from stereotrack_core.depth.lost_points import LEAST_POINTS
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.parameters import ParameterGroup, parameter

_METHOD, _NOISE, _DATA = "Method", "Noise", "Measurements"
_LIMITS, _SILHOUETTES, _SEARCH = "Limits and collisions", "Silhouettes", "Arm search"


@dataclass(frozen=True)
class TrackingParameters(ParameterGroup):
    """How poses are estimated; the defaults are those of preset ``accurate``."""

    matching: str = parameter(
        "data_to_model", _METHOD, choices=("data_to_model", "model_to_data"), thesis="model_to_data"
    )(
        "Direction of the correspondences: measured points to the model, or sampled model points "
        "to the nearest measured points."
    )
    estimator: str = parameter(
        "iterated",
        _METHOD,
        choices=(
            "iterated",
            "extended_kalman",
            "annealed_particles",
            "limb_icp",
            "scalar_distance",
        ),
    )(
        "Estimator for data-to-model correspondences: the tracker's own iterated correction, or "
        "one of the baselines."
    )
    iterations: int = parameter(6, _METHOD, (1, 50), thesis=4, fast=3)("Corrections per frame set.")
    ut_alpha: float = parameter(0.1, _METHOD, (1e-4, 2.0))(
        "Spread of the sigma points; small values keep them close to the mean."
    )
    sigma_position: float = parameter(0.03, _NOISE, (0.001, 2.0), unit="m", thesis=0.1)(
        "Expected movement of the body between two frame sets at 10 Hz."
    )
    sigma_rotation: float = parameter(5.0, _NOISE, (0.1, 180.0), unit="deg", thesis=20.0)(
        "Expected rotation of the torso between two frame sets at 10 Hz."
    )
    sigma_joint: float = parameter(10.0, _NOISE, (0.1, 180.0), unit="deg", thesis=40.0)(
        "Expected rotation of a joint between two frame sets at 10 Hz."
    )
    sigma_measurement: float = parameter(
        0.015, _NOISE, (0.001, 1.0), unit="m", thesis=0.02, fast=0.02
    )("Expected distance between corresponding points.")
    prior_inflation_above: float = parameter(1.5, _NOISE, (0.5, 100.0))(
        "Prior inflation: the prior is widened if the data move the body by more than this many "
        "of its standard deviations."
    )
    sampling: str = parameter("random", _DATA, choices=("random", "regular"), thesis="random")(
        "Method of sampling model points from the cones."
    )
    model_points: int = parameter(64, _DATA, (4, 20000), thesis=64)(
        "Number m of sampled model points in model-to-data correspondences."
    )
    data_points: int = parameter(2000, _DATA, (50, 20000), fast=800)(
        "Number of measured points in data-to-model correspondences."
    )
    effective_sample_size: float = parameter(150.0, _DATA, (1.0, 20000.0))(
        "Effective sample size of the data: neighbouring pixels of a block matcher are correlated."
    )
    max_correspondence_distance: float = parameter(0.25, _DATA, (0.02, 2.0), unit="m")(
        "Measured points farther than this from the model are ignored (maximum correspondence "
        "distance)."
    )
    loss_scale: float = parameter(0.06, _DATA, (0.005, 2.0), unit="m")(
        "Scale of the Geman-McClure loss: the distance at which a point loses three quarters of "
        "its weight; twice that in the first two iterations."
    )
    least_points: int = parameter(LEAST_POINTS, _DATA, (1, 100000))(
        "A cloud with fewer points than this is not tracked."
    )
    max_unexplained_fraction: float = parameter(0.6, _DATA, (0.0, 1.0))(
        "A frame is not tracked if the unexplained fraction of its cloud is larger than this."
    )
    clearance: float = parameter(0.02, _LIMITS, (0.0, 0.5), unit="m", thesis=0.15)(
        "Minimum distance of elbow and hand from the surface of the torso."
    )
    arms_apart: float = parameter(0.045, _LIMITS, (0.0, 0.2), unit="m", thesis=0.0)(
        "Minimum distance between the axes of the two forearms. An upper arm and the other "
        "forearm, which are thicker, keep twice this distance. 0 lets the arms pass through each "
        "other."
    )
    fit_shape: bool = parameter(True, _METHOD, thesis=False)(
        "Fit torso, head and legs to the first frames before tracking starts."
    )
    longest_bridge: float = parameter(0.5, "Smoothing", (0.0, 10.0), unit="s")(
        "Longest gap of untracked frames that smoothing bridges."
    )
    measure_silhouettes: bool = parameter(True, _SILHOUETTES, thesis=False)(
        "Fit the contours of the body to the silhouette edges."
    )
    silhouette_sigma: float = parameter(0.02, _SILHOUETTES, (0.001, 1.0), unit="m")(
        "Expected distance between a contour and its edge."
    )
    leave_out_views: bool = parameter(True, _SILHOUETTES, thesis=False)(
        "Leave out a view whose silhouette or points contradict those of the other views (three "
        "or more), for as long as they do."
    )
    search_arms: bool = parameter(True, _SEARCH, thesis=False)(
        "Search for better positions of both arms in every frame."
    )
    search_proposals: int = parameter(220, _SEARCH, (20, 5000), fast=120)(
        "Candidates per arm and frame."
    )
    search_refined: int = parameter(3, _SEARCH, (1, 20), fast=1)(
        "Best pairs that are refined by the filter."
    )
    search_iterations: int = parameter(3, _SEARCH, (1, 20), fast=2)(
        "Corrections used to refine a pair."
    )
    second_look: int = parameter(6, _SEARCH, (0, 50), thesis=0)(
        "How often at most a stretch with doubtful arms is tracked again with other random "
        "numbers; the best way through it is kept. With several depth views; 0: never."
    )
    picture_cost: float = parameter(1000.0, _SEARCH, (0.0, 100000.0), unit="1/m^2")(
        "Render-and-compare cost per square metre in which a view does not show the rendered pose."
    )
    keypoint_cost: float = parameter(10.0, _SEARCH, (0.0, 1000.0))(
        "Cost of an elbow or a wrist that is not where a view's keypoints show it."
    )
    colour_weight: float = parameter(0.06, "Colours", (0.0, 1.0), unit="m", thesis=0.0, fast=0.0)(
        "Distance added between a point and a part for each standard deviation by which its "
        "colour differs from the part's colours; 0 disables colours. No effect on grey images."
    )
    detector: str = parameter("auto", "Keypoints", choices=("auto", "off"), thesis="off")(
        "Keypoints of the installed pose detector: auto looks at pictures of views with depth "
        "where no other keypoints are given and the detector is installed."
    )
    detection_gate: float = parameter(0.3, "Keypoints", (0.01, 5.0), unit="m")(
        "A keypoint farther than this from every plausible position is rejected."
    )
    keypoint_sigma: float = parameter(0.04, "Keypoints", (0.001, 1.0), unit="m")(
        "Standard deviation of a sure keypoint of a 2-D detector, at the distance of the person; "
        "it is divided by the confidence."
    )

    @property
    def wants_colour(self) -> bool:
        """Whether anything looks at colours, so that they have to be read."""
        return self.colour_weight > 0.0


@dataclass(frozen=True)
class Settings(ParameterGroup):
    """Parameters from the images to the pose, in the order in which they act."""

    depth: DepthParameters = dataclasses.field(default_factory=DepthParameters)
    body: BodyParameters = dataclasses.field(default_factory=BodyParameters)
    tracking: TrackingParameters = dataclasses.field(default_factory=TrackingParameters)

    @property
    def follows_data(self) -> bool:
        """Whether what is measured looks for the model, keypoints and clicks as well."""
        return self.tracking.matching == "data_to_model"

    @property
    def uses_detector(self) -> bool:
        """Whether the pose detector is used where it is installed."""
        return self.tracking.detector == "auto" and self.follows_data

    @property
    def needs_depth(self) -> bool:
        """Whether the tracker is one that follows nothing but clouds."""
        return not self.follows_data or self.tracking.estimator != "iterated"

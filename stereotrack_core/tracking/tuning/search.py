"""Finding parameters by what a person calls the matter, which need not be in their names."""

from __future__ import annotations

from stereotrack_core.parameters import ParameterRow

_ARMS = (
    "arms_apart", "clearance", "search_arms", "search_proposals", "search_refined",
    "search_iterations", "picture_cost", "colour_weight", "girdle",
)  # fmt: skip
_LOSS = (
    "search_arms", "prior_inflation_above", "max_correspondence_distance",
    "max_unexplained_fraction", "least_points", "longest_bridge",
)  # fmt: skip
_MOTION = (
    "sigma_position", "sigma_rotation", "sigma_joint", "prior_inflation_above",
)  # fmt: skip
_WORK = (
    "matcher", "match_region", "disparity_count", "least_focal", "subpixel", "pixel_step",
    "estimator", "iterations", "data_points", "model_points", "search_arms", "search_proposals",
    "search_refined", "search_iterations", "picture_cost", "silhouettes", "measure_silhouettes",
    "fit_shape", "outlier_repeat",
)  # fmt: skip
_POINTS = (
    "speckle_size", "outlier_neighbours", "outlier_distance", "outlier_repeat", "match_uniqueness",
    "match_left_right", "low_pass", "halo_trim", "background_threshold",
)  # fmt: skip
_SIZE = (
    "proportions", "torso_radius_low", "torso_radius_high", "torso_flatness", "torso_forward_low",
    "torso_forward_high", "head_forward", "arm_radius_factor", "fit_shape",
)  # fmt: skip
_PERSON = (
    "background_mode", "background_empty_scene", "background_threshold",
    "silhouettes", "halo_trim", "volume_from_recording", "up_axis",
    "volume_centre_x", "volume_centre_y", "volume_bottom", "volume_x", "volume_y", "volume_z",
)  # fmt: skip

TOPICS: dict[tuple[str, ...], tuple[str, ...]] = {
    ("crossing", "crossed", "crosses", "folded", "overlap", "swapped", "touching"): _ARMS,
    ("occlusion", "occluded", "hidden", "invisible"): (*_ARMS, "measure_silhouettes"),
    ("lost", "loses", "losing", "failure", "fails", "recovery", "drift", "wrong", "stuck"): _LOSS,
    ("gaps", "missing", "holes", "dropouts"): (
        "longest_bridge", "least_points", "max_unexplained_fraction", "match_uniqueness",
        "match_left_right", "speckle_size", "outlier_neighbours", "outlier_distance",
    ),
    ("motion", "movement", "moving", "quick", "rapid", "agile", "lag", "delay", "hurry"): _MOTION,
    ("speed", "fast", "slow", "time", "performance", "cpu"): (*_MOTION, *_WORK),
    ("smooth", "smoothing", "jitter", "shaky", "jumps", "steady", "stable", "trembling"): (
        *_MOTION, "sigma_measurement", "effective_sample_size", "data_points", "longest_bridge",
    ),
    ("noise", "noisy"): (
        *_MOTION, "sigma_measurement", "silhouette_sigma", "effective_sample_size", *_POINTS,
    ),
    ("uncertainty", "confidence", "covariance", "variance", "deviation", "trust", "weight"): (
        *_MOTION, "sigma_measurement", "silhouette_sigma", "effective_sample_size",
        "colour_weight",
    ),
    ("outliers", "robust", "loss", "stray", "speckles", "clutter", "wild"): (
        *_POINTS, "max_correspondence_distance", "loss_scale",
        "detection_gate",
    ),
    ("person", "people", "foreground", "room", "furniture", "object", "space"): _PERSON,
    ("size", "shape", "length", "thickness", "clothes", "anatomy", "subject"): _SIZE,
    ("height", "tall"): ("volume_z", "volume_bottom", "proportions"),
    ("accuracy", "accurate", "precision", "precise", "quality"): (
        "subpixel", "least_focal", "match_window", "data_points", "iterations",
        "effective_sample_size", "silhouettes", "measure_silhouettes", "search_arms",
        "picture_cost", "colour_weight", "girdle", "fit_shape",
    ),
    ("resolution", "density", "dense", "sampling"): (
        "pixel_step", "least_focal", "data_points", "model_points", "match_window",
    ),
    ("stereo", "disparity", "depth"): (
        "matcher", "disparity_minimum", "disparity_count", "disparity_from_volume",
        "match_window", "least_focal", "low_pass", "edge_images", "match_uniqueness",
        "match_left_right", "match_region", "subpixel", "speckle_size",
    ),
    ("outline", "contour", "border", "edges", "halo"): (
        "silhouettes", "halo_trim", "measure_silhouettes", "silhouette_sigma", "edge_images",
    ),
    ("hands", "elbows", "wrists", "forearms"): (*_ARMS, "arm_radius_factor", "detection_gate"),
    ("shoulders", "shrug", "clavicle"): ("girdle", "torso_radius_high"),
    ("detector", "detections", "keypoints", "openpose"): ("detection_gate",),
    ("penetration", "collision", "inside", "through"): ("clearance", "arms_apart"),
    ("start", "beginning", "initial", "initialisation"): ("fit_shape",),
}  # fmt: skip
"""What a person may look for, and the parameters that concern it."""

_LEAST = 3
"""Letters from which the begin of a topic's word stands for the topic."""


def finds(row: ParameterRow, words: str) -> bool:
    """Whether a search for `words` finds a parameter.

    Every one of the words has to be in its name, group or description, or to begin a word of a
    topic of :data:`TOPICS` that the parameter belongs to; upper and lower case are the same.
    """
    text = f"{row.name} {row.name.replace('_', ' ')} {row.group} {row.help}".lower()
    return all(word in text or _concerns(row.name, word) for word in words.lower().split())


def _concerns(name: str, word: str) -> bool:
    if len(word) < _LEAST:
        return False
    return any(
        name in names and any(called.startswith(word) for called in topic)
        for topic, names in TOPICS.items()
    )

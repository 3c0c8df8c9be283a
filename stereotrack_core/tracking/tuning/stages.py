"""Which parameters each stage depends on, from the images to the pose."""

from collections.abc import Mapping, Sequence
from enum import IntEnum
from types import MappingProxyType
from typing import TypeAlias

from stereotrack_core.body.parameters import BodyParameters
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.parameters import Value
from stereotrack_core.tracking.parameters import Settings

StageKey: TypeAlias = tuple[tuple[str, Value], ...]  # of a stage and all before it


class Stage(IntEnum):
    """Stages in the order in which they work; each uses what those before it gave."""

    MATCHING = 0
    BACKGROUND = 1
    POINTS = 2
    FUSION = 3
    SHAPE = 4
    TRACKING = 5


_OF_DEPTH: Mapping[str, Stage] = MappingProxyType(
    dict.fromkeys(
        (
            "background_empty_scene",
            "background_mode",
            "background_rate",
            "background_validity_rate",
            "background_percentile",
        ),
        Stage.BACKGROUND,
    )
    | dict.fromkeys(
        (
            "subpixel",
            "speckle_size",
            "background_threshold",
            "silhouettes",
            "halo_trim",
            "pixel_step",
        ),
        Stage.POINTS,
    )
    | dict.fromkeys(("outlier_neighbours", "outlier_distance", "outlier_repeat"), Stage.FUSION)
)
"""Parameters of depth that act after matching; all others are taken to act on it, so that a new
parameter leads to too much work and never to a wrong cloud."""

_OF_SHAPE = frozenset({row.name for row in BodyParameters.rows()} | {"fit_shape", "matching"})
"""Parameters of body and tracking on which the body's shape depends."""

_DEPTH = frozenset(row.name for row in DepthParameters.rows())


_WITHOUT_DEPTH = frozenset({row.name for row in BodyParameters.rows()}) | {
    *("background_empty_scene", "silhouettes", "measure_silhouettes", "silhouette_sigma"),
    *("iterations", "sigma_position", "sigma_rotation", "sigma_joint"),
    *("clearance", "arms_apart", "fit_shape", "longest_bridge"),
    *("keypoint_sigma", "detection_gate"),
}
"""Parameters that act where keypoints and contours alone are tracked; all others act on a cloud."""


def acts_without_depth(name: str) -> bool:
    """Whether a parameter changes anything in mono views, which are tracked by keypoints."""
    return name in _WITHOUT_DEPTH


def stage_of(name: str) -> Stage:
    """The first stage on which a parameter acts."""
    if name in _DEPTH:
        return _OF_DEPTH.get(name, Stage.MATCHING)
    return Stage.SHAPE if name in _OF_SHAPE else Stage.TRACKING


def stage_key(parameters: DepthParameters | Settings, stage: Stage) -> StageKey:
    """Parameters on which the result of a stage depends; those of depth suffice up to fusion.

    How the frames of a shape's fit are followed acts on it by a hair, and does not count.
    """
    return tuple(item for item in parameters.values().items() if stage_of(item[0]) <= stage)


def changed_names(old: Settings, new: Settings) -> tuple[str, ...]:
    """Names of the parameters whose values differ, in order of declaration."""
    before = old.values()
    return tuple(name for name, value in new.values().items() if value != before[name])


def changes_in_words(old: Settings, new: Settings, first: Sequence[str] = ()) -> str:
    """``sigma joint 20 deg, iterations 8 and 3 more``: what differs, of which two are named.

    Parameters in `first` are named before others.
    """
    names, values = sorted(changed_names(old, new), key=lambda one: one not in first), new.values()
    rows = {row.name: row for row in new.rows()}
    said = ", ".join(rows[name].words(values[name]) for name in names[:2])
    return f"{said} and {len(names) - 2} more" if len(names) > 2 else said

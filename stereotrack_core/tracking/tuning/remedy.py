"""Changes of settings that may repair a failure, and the same without single parts."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

from stereotrack_core.parameters import ParameterRow, Value
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.tuning.stages import Stage, changes_in_words, stage_of

_FACTOR = 2.0  # by which a number is made larger and smaller

# What each part is switched off by. The motion prior is so wide that it says nothing.
_WITHOUT: Mapping[str, Mapping[str, Value]] = MappingProxyType(
    {
        "arm search": {"search_arms": False},
        "second look": {"second_look": 0},
        "silhouettes": {"measure_silhouettes": False},
        "views in the arm search": {"picture_cost": 0.0},
        "keypoints": {"detector": "off", "keypoint_cost": 0.0},
        "colours": {"colour_weight": 0.0},
        "arms apart": {"arms_apart": 0.0},
        "clearance of the torso": {"clearance": 0.0},
        "motion prior": {"sigma_joint": 90.0},
        "fitted shape": {"fit_shape": False},
    }
)


@dataclass(frozen=True)
class Change:
    """One thing to try instead of how a run was made."""

    words: str
    settings: Settings
    views: tuple[str, ...] | None = None  # that are used; None: those of the run


def changes(settings: Settings, names: Sequence[str]) -> tuple[Change, ...]:
    """Each of these parameters up and down, a switch the other way, every other choice.

    Those that need no other clouds come first, as they take a fraction of the time.
    """
    rows = {row.name: row for row in Settings.rows()}
    values, tried = settings.values(), list[Change]()
    for name in sorted(dict.fromkeys(names), key=lambda name: stage_of(name) < Stage.TRACKING):
        for value in _others(rows[name], values[name]):
            changed = settings.replaced(**{name: value})
            tried.append(Change(changes_in_words(settings, changed), changed))
    return tuple(tried)


def _others(row: ParameterRow, value: Value) -> list[Value]:
    """Other values of a parameter within its range; from 0 a default or nothing."""
    if isinstance(value, bool):
        return [not value]
    if isinstance(value, str):
        return [choice for choice in row.choices if choice != value]
    wanted = [value / _FACTOR, value * _FACTOR] if value else [row.default]
    low = -float("inf") if row.minimum is None else row.minimum
    high = float("inf") if row.maximum is None else row.maximum
    kept = [min(max(one, low), high) for one in wanted]
    whole = [round(one) if row.type is int else one for one in kept]
    return [one for one in dict.fromkeys(whole) if one != value]


def without_parts(settings: Settings, views: Sequence[str]) -> tuple[Change, ...]:
    """The settings without one part each, and all of several views but one."""
    tried = [Change(f"without {part}", settings.replaced(**off)) for part, off in _WITHOUT.items()]
    found = [change for change in tried if change.settings != settings]
    if len(views) > 1:
        found += [
            Change(f"without view {name}", settings, tuple(v for v in views if v != name))
            for name in views
        ]
    return tuple(found)

"""What an attempt takes from the run that it is compared with."""

from __future__ import annotations

from dataclasses import dataclass

from stereotrack_core.body.parameters import BodyParameters
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.proportions import Proportions
from stereotrack_core.errors import InputError
from stereotrack_core.parameters import ParametersT, Value
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.run_spec import FirstPose
from stereotrack_core.tracking.tuning.attempt import Attempt, Start
from stereotrack_core.tracking.tuning.stages import changed_names, shape_stands

from ...session.runs import RunEntry
from ...widgets.forms.parameter_editor import value_text

_NAMED = 2


@dataclass(frozen=True, eq=False)
class Base:
    """A run, as far as attempts begin where it has been.

    Attributes
    ----------
    entry : RunEntry
    settings : Settings or None
        None where a file of another version does not say.
    shape : BodyParameters or None
    seed : int
    learned_from : range
        Frames from which its background was learned and its shape fitted.
    first : Pose or None
        The first pose that it found.
    """

    entry: RunEntry
    settings: Settings | None
    shape: BodyParameters | None
    seed: int
    learned_from: range
    first: Pose | None

    def start(self, frame: int, settings: Settings) -> Start | None:
        """What the run knows before a frame; None where it was nowhere near."""
        before, here = self.entry.at(frame - 1), self.entry.at(frame)
        stands = self.settings is not None and shape_stands(self.settings, settings)
        shape = self.shape if stands else None
        lengths = self._lengths() if stands else None
        if before is not None and before.pose is not None:
            return Start(before.pose, before.P, shape, self.first, lengths)
        if here is not None and here.pose is not None:
            return Start(here.pose, None, shape, self.first, lengths)
        return None

    def _lengths(self) -> Proportions | None:
        """The body's lengths where the run has estimated them."""
        estimated = self.settings is not None and self.settings.body.proportions == "sequence"
        return self.entry.body.skeleton.proportions if estimated else None


def base_of(entry: RunEntry, made: Attempt | None = None) -> Base:
    """What is known of a run; `made` is the attempt that it was, if it was one."""
    first = next((f.pose for f in entry.ordered() if f.pose is not None), None)
    if made is not None and made.start is not None:
        first = made.start.first
    origin, stored = entry.origin, entry.stored
    settings, shape, seed = entry.settings, None, 0
    if origin is not None:
        shape, seed = origin.shape, origin.spec.seed
    elif stored is not None:
        settings = settings or _stored(Settings(), stored.meta.get("parameters"))
        shape = _stored(BodyParameters(), stored.meta.get("body"))
        seed = int(stored.meta.get("seed") or 0)
    learned = made.known if made is not None else entry.wanted
    return Base(entry, settings, shape, seed, learned, first)


def attempt_from(
    base: Base | None, settings: Settings, stretch: range, init: FirstPose, preset: str
) -> Attempt:
    """The attempt to track a stretch from where a run was, or from a first pose."""
    if base is None:
        return Attempt(settings, stretch, init=init, preset=preset)
    start = base.start(stretch.start, settings)
    return Attempt(settings, stretch, start, base.seed, base.learned_from, init, preset)


def changes_in_words(old: Settings | None, new: Settings, *, most: int = _NAMED) -> str:
    """``sigma joint 20 deg``; ``sigma joint 20 deg, iterations 8 and 3 more``."""
    if old is None:
        return "different settings"
    names = changed_names(old, new)
    if not names:
        return "settings of the run"
    rows = {row.name: row for row in new.rows()}
    values = new.values()
    said = [with_unit(name, values[name], rows[name].unit) for name in names[:most]]
    if len(names) > most:
        return f"{', '.join(said)} and {len(names) - most} more"
    return ", ".join(said)


def with_unit(name: str, value: Value, unit: str) -> str:
    """A parameter's value as a person reads it."""
    words = f"{name.replace('_', ' ')} {value_text(value).replace('_', ' ')}"
    return f"{words} {unit}".strip()


def _stored(group: ParametersT, values: object) -> ParametersT | None:
    """Parameters as a run states them; None where it does not state all of them."""
    if not isinstance(values, dict) or not values.keys() >= group.values().keys():
        return None
    try:
        return group.replaced(**{name: values[name] for name in group.values()})
    except InputError:
        return None

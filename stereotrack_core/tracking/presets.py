"""Named settings: ``thesis``, ``accurate``, ``fast``, baselines to compare with, a person's own."""

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType

import tomli_w

from stereotrack_core.atomic import write_file
from stereotrack_core.errors import InputError, did_you_mean
from stereotrack_core.parameters import Value, parsed_settings
from stereotrack_core.plain_data import check_kind
from stereotrack_core.recording.toml_table import load_toml
from stereotrack_core.tracking.parameters import Settings

_ESTIMATORS: Mapping[str, Value] = MappingProxyType(
    {
        "ekf": "extended_kalman",
        "annealed": "annealed_particles",
        "limb-icp": "limb_icp",
        "scalar": "scalar_distance",
    }
)

BASELINES: tuple[str, ...] = tuple(_ESTIMATORS)  # only their estimator is not ``accurate``

PRESETS: tuple[str, ...] = ("accurate", "thesis", "fast", *BASELINES)

_EXAMPLE = 'A preset file has name = "...", a base, and parameters below [values].'
SUFFIX = ".toml"  # a preset's name that ends so names a file that holds one


@dataclass(frozen=True)
class UserPreset:
    """Settings that somebody has named."""

    name: str
    base: str  # one of :data:`PRESETS`, from which all other values come
    values: Mapping[str, Value] = field(default_factory=dict)  # what differs from it, by name

    @property
    def settings(self) -> Settings:
        """All values; InputError for an unknown base or parameter, or a value outside its range."""
        return preset(self.base).replaced(**self.values)


def named(name: str, settings: Settings, base: str = "accurate") -> UserPreset:
    """Name settings, as they differ from a preset."""
    before = preset(base).values()
    changed = {key: value for key, value in settings.values().items() if value != before[key]}
    return UserPreset(name, base, changed)


def preset(name: str, changes: Sequence[str] = ()) -> Settings:
    """Settings of a preset, or of a file that holds one.

    Parameters
    ----------
    changes : sequence of str
        ``NAME=VALUE`` for each parameter that shall be otherwise.

    Raises
    ------
    InputError
        Where there is no preset of that name, the file does not hold one, or a change is none.

    Examples
    --------
    >>> preset("accurate", ["iterations=3"]).tracking.iterations
    3
    """
    changed = parsed_settings(changes)
    if name.lower().endswith(SUFFIX):
        return read_preset(Path(name)).settings.replaced(**changed)
    if name not in PRESETS:
        raise InputError(
            f"unknown preset {name!r}",
            where="--preset",
            remedy=f"Available: {', '.join(PRESETS)}. Give a preset of your own as a file "
            f"{SUFFIX}.",
        )
    values = {row.name: row.presets[name] for row in Settings.rows() if name in row.presets}
    if name in BASELINES:
        values["estimator"] = _ESTIMATORS[name]
    return Settings().replaced(**values).replaced(**changed)


def read_preset(path: Path) -> UserPreset:
    """The preset that a TOML file holds; one without a name gets the file's.

    Raises InputError for an unreadable file, an unknown base or parameter, or a value outside its
    range.
    """
    facts = load_toml(path)
    for key in facts:
        if key not in {"name", "base", "values"}:
            raise InputError(
                f"{key!r} is not a key of a preset file", where=str(path), remedy=_EXAMPLE
            )
    check_kind(facts, {"name": str, "base": str, "values": {}}, str(path), _EXAMPLE)
    name, base = facts.get("name", "").strip() or path.stem, facts.get("base", "accurate")
    if base not in PRESETS:
        raise InputError(
            f"unknown base preset {base!r}",
            where=f"{path}, base",
            remedy=f"Available: {', '.join(PRESETS)}.",
        )
    return UserPreset(name, base, _checked(facts.get("values", {}), path))


def write_preset(path: Path, preset: UserPreset) -> None:
    """Write a preset for :func:`read_preset`; InputError if the file cannot be written."""
    write_file(path, tomli_w.dumps(dataclasses.asdict(preset)))


def _checked(given: Mapping[str, Value], path: Path) -> dict[str, Value]:
    """Values below ``[values]`` in their parameters' types."""
    rows = {row.name: row for row in Settings.rows()}
    values: dict[str, Value] = {}
    for key, value in given.items():
        where = f"{path}, {key}"
        if key not in rows:
            raise InputError(
                "unknown parameter",
                where=where,
                remedy=did_you_mean(key, rows).rstrip() or "See docs/parameters.md.",
            )
        try:
            values[key] = rows[key].checked(value)
        except InputError as refusal:
            raise InputError(refusal.what, where=where, remedy=refusal.remedy) from None
    return values

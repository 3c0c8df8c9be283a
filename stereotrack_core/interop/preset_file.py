"""A person's own preset as a TOML file."""

from __future__ import annotations

from pathlib import Path

import tomli_w

from stereotrack_core.atomic import write_file
from stereotrack_core.tracking.presets import UserPreset, read_preset

__all__ = ["read_preset", "write_preset"]


def write_preset(path: Path, preset: UserPreset) -> None:
    """Write a preset so that :func:`read_preset` gives it again.

    Raises
    ------
    InputError
        Where the file cannot be written.
    """
    write_file(path, tomli_w.dumps(preset.facts()))

"""Of which kinds the values are that a run states about itself."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from types import MappingProxyType
from typing import Any

from stereotrack_core.errors import InputError
from stereotrack_core.plain_data import Kind, check_kind
from stereotrack_core.recording.description import Subject

_VALUES: Kind = {str: (bool, int, float, str)}
_LENGTHS = tuple(field.name for field in fields(Subject) if field.name != "name")

META_KINDS: Mapping[str, Kind] = MappingProxyType(
    {
        **dict.fromkeys(("program", "version", "preset", "init", "made", "way"), str),
        **dict.fromkeys(("recording", "recording_folder", "recording_folder_from_run"), str),
        **dict.fromkeys(("fingerprint", "calibration", "covariance_axes"), str),
        **dict.fromkeys(("smoothed", "colour", "incomplete"), bool),
        **dict.fromkeys(("fps", "wall_seconds"), float),
        "parameters": _VALUES,
        "body": _VALUES,
        **dict.fromkeys(("seed", "format"), int),
        "views": [str],
        "subject": {"name": str, **dict.fromkeys(_LENGTHS, float)},
        "bridged": [int],
        "first_pose": {"position": [float], "rotations": [[[float]]]},
        "frames": [int, int],
        "detections": {"source": str, "fingerprint": str, "count": int},
        "blind": [{"view": str, "first": int, "end": int, "reason": str}],
        "versions": {str: str},
        "resumed_at": [int],
        "started_at_reference": [int],
        "warnings": [str],
    }
)
"""What :meth:`Origin.meta` and whoever adds to it state; other keys may hold anything."""


def check_meta(meta: Any, where: str, remedy: str) -> None:
    """Refuse what cannot be the meta of a run.

    Raises
    ------
    InputError
        Where it is no table, or a value is of another kind; it names the key.
    """
    check_kind(meta, META_KINDS, where, remedy)
    for name, length in (meta.get("subject") or {}).items():
        if name in _LENGTHS and length is not None and length <= 0:
            raise InputError(
                f"a length of {length:g} m is not possible",
                where=f"{where}, subject.{name}",
                remedy=remedy,
            )

"""What is said about a run without reading its numbers, and how two runs differ in that."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from stereotrack_core.arrays import IntArray
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.repeating import changed_parameters

_META = (
    *("program", "version", "preset", "parameters", "seed", "views", "init", "smoothed"),
    *("recording", "fingerprint", "calibration", "versions", "wall_seconds", "made", "frames"),
)
_ASKED = "frames"


@dataclass(frozen=True)
class RunFacts:
    """A run in a list; what is not known is empty or None.

    Attributes
    ----------
    frames, tracked : int
        Frames that it has, and those of them with a pose.
    first, last : int or None
        The first and the last frame.
    asked : tuple of int or None
        Frames that were asked for, half-open.
    preset : str
    parameters : mapping
        All parameters.
    changed : mapping
        Parameters that are not the preset's, as they were when the run was kept: name to the
        preset's value and the run's.
    seed : int or None
    views : tuple of str
    init : str
        Where the first pose came from.
    smoothed : bool
    subject, recording : str
    fingerprint, calibration : str
        Of the recording and of its cameras.
    versions : mapping
        Of this program and of what it computes with.
    wall_seconds : float or None
    made : str
        When it was tracked, ISO 8601, UTC.
    note : str
        What a person has written about it.
    """

    frames: int
    tracked: int
    first: int | None = None
    last: int | None = None
    asked: tuple[int, int] | None = None
    preset: str = ""
    parameters: Mapping[str, Any] = field(default_factory=dict)
    changed: Mapping[str, tuple[Any, Any]] = field(default_factory=dict)
    seed: int | None = None
    views: tuple[str, ...] = ()
    init: str = ""
    smoothed: bool = False
    subject: str = ""
    recording: str = ""
    fingerprint: str = ""
    calibration: str = ""
    versions: Mapping[str, str] = field(default_factory=dict)
    wall_seconds: float | None = None
    made: str = ""
    note: str = ""

    @property
    def changed_words(self) -> str:
        """``iterations 2 instead of 6, data_points 400 instead of 800``; empty where none is."""
        told = (f"{name} {_said(b)} instead of {_said(a)}" for name, (a, b) in self.changed.items())
        return ", ".join(told)


@dataclass(frozen=True)
class Difference:
    """Something that two runs were made with, in words.

    Attributes
    ----------
    what : str
        A parameter's name, or a word such as ``seed``.
    first, second : str
    parameter : bool
        Whether it is a parameter.
    """

    what: str
    first: str
    second: str
    parameter: bool = False

    @property
    def differs(self) -> bool:
        """Whether it is not the same in both."""
        return self.first != self.second


def facts_to_keep(run: Run, note: str = "") -> dict[str, Any]:
    """Facts of a run, JSON-serialisable: what :func:`run_facts` reads."""
    facts = facts_of_meta(run.meta, run.frame, int(run.tracked.sum()))
    return facts | {"note": note} if note else facts


def facts_of_meta(meta: Mapping[str, Any], frame: IntArray, tracked: int) -> dict[str, Any]:
    """The same from a run's meta, its frame numbers (F,) and how many of them have a pose."""
    facts: dict[str, Any] = {
        "frames": len(frame),
        "tracked": tracked,
        **{key: meta[key] for key in _META if key in meta and key != _ASKED},
    }
    if len(frame):
        facts |= {"first": int(frame[0]), "last": int(frame[-1])}
    if meta.get(_ASKED) is not None:
        facts["asked"] = list(meta[_ASKED])
    subject = meta.get("subject")
    if isinstance(subject, dict) and subject.get("name"):
        facts["subject"] = subject["name"]
    if meta.get("parameters"):
        changed = changed_parameters(meta["parameters"], str(meta.get("preset", "")))
        facts["changed"] = {name: list(values) for name, values in changed.items()}
    return facts


def run_facts(stored: Mapping[str, Any]) -> RunFacts:
    """Read facts as they were kept; runs that others wrote have fewer.

    Raises
    ------
    ValueError, TypeError, OverflowError, LookupError
        Where they make no sense.
    """
    asked = stored.get("asked")
    versions = dict(stored.get("versions") or {})
    wall = stored.get("wall_seconds")
    return RunFacts(
        frames=int(stored.get("frames", 0)),
        tracked=int(stored.get("tracked", 0)),
        first=_integer(stored.get("first")),
        last=_integer(stored.get("last")),
        asked=None if asked is None else (int(asked[0]), int(asked[1])),
        preset=str(stored.get("preset", "")),
        parameters=dict(stored.get("parameters") or {}),
        changed={name: (a, b) for name, (a, b) in dict(stored.get("changed") or {}).items()},
        seed=_integer(stored.get("seed")),
        views=tuple(str(name) for name in stored.get("views") or ()),
        init=str(stored.get("init", "")),
        smoothed=bool(stored.get("smoothed", False)),
        subject=str(stored.get("subject") or ""),
        recording=str(stored.get("recording") or ""),
        fingerprint=str(stored.get("fingerprint") or ""),
        calibration=str(stored.get("calibration") or ""),
        versions={str(name): str(version) for name, version in versions.items()},
        wall_seconds=None if wall is None else float(wall),
        made=str(stored.get("made") or ""),
        note=str(stored.get("note") or ""),
    )


def _integer(value: Any) -> int | None:
    return None if value is None else int(value)


def beside(first: RunFacts, second: RunFacts) -> tuple[Difference, ...]:
    """All that two runs were made with, side by side: parameters first, then everything else."""
    names = dict.fromkeys((*first.parameters, *second.parameters))
    rows = [
        Difference(
            name,
            _said(first.parameters.get(name)),
            _said(second.parameters.get(name)),
            parameter=True,
        )
        for name in names
    ]
    others: tuple[tuple[str, Any, Any], ...] = (
        ("preset", first.preset, second.preset),
        ("seed", first.seed, second.seed),
        ("views", "+".join(first.views), "+".join(second.views)),
        ("frames", _frames(first), _frames(second)),
        ("initial pose", first.init, second.init),
        ("smoothed", first.smoothed, second.smoothed),
        ("subject", first.subject, second.subject),
        ("recording", first.recording, second.recording),
        ("recording's fingerprint", first.fingerprint[:8], second.fingerprint[:8]),
        ("fingerprint of the calibration", first.calibration[:8], second.calibration[:8]),
    )
    versions = dict.fromkeys((*first.versions, *second.versions))
    others += tuple(
        (f"version of {name}", first.versions.get(name), second.versions.get(name))
        for name in versions
    )
    return (*rows, *(Difference(what, _said(a), _said(b)) for what, a, b in others))


def differences(first: RunFacts, second: RunFacts) -> tuple[Difference, ...]:
    """What of that is different."""
    return tuple(row for row in beside(first, second) if row.differs)


def _frames(facts: RunFacts) -> str:
    return "" if facts.first is None else f"{facts.first} to {facts.last}"


def _said(value: Any) -> str:
    if value is None or value == "":
        return "unknown"
    if isinstance(value, bool):
        return "yes" if value else "no"
    short = f"{value:g}" if isinstance(value, float) else str(value)
    return short if not isinstance(value, float) or float(short) == value else repr(value)

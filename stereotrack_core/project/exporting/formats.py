"""The one list of formats that are written; command and window offer what stands here."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Literal, TypeAlias

from stereotrack_core.annotation.click import Click, Visibility
from stereotrack_core.annotation.reference import Reference
from stereotrack_core.errors import InputError

Kind: TypeAlias = Literal["run", "trajectory", "reference", "clicks", "keypoints"]
"""Kinds of data: a complete run, landmarks of any origin, a project's reference, its clicks, or
what a detector has predicted."""


@dataclass(frozen=True)
class ExportFormat:
    """A format of this or of another program."""

    name: str
    """As ``--format`` calls it."""
    label: str
    """As a dialog calls it."""
    suffixes: tuple[str, ...]
    """Of its files; the first one is usual."""
    kinds: tuple[Kind, ...]
    """Kinds of data that it can hold."""
    module: str = ""
    extra: str = ""
    """`module` and `extra`: library that it needs besides, and what installs that."""
    loses: frozenset[str] = frozenset()
    """Properties of clicks, by their names in :data:`_PROPERTIES`, that it has no place for."""
    lost_of_reference: str = ""
    """Parts of a fitted reference that it has no place for, in words."""

    @property
    def missing(self) -> str:
        """How what it needs is installed, as a sentence; empty where all is there."""
        if not self.module or find_spec(self.module) is not None:
            return ""
        return f"It needs `pip install 'stereotrack[{self.extra}]'`."

    def lost(self, reference: Reference) -> str:
        """Sentence on what it cannot store of a reference; empty if nothing."""
        if not self.lost_of_reference or reference.covariance is None:
            return ""
        return f"{self.label} cannot store: {self.lost_of_reference}."

    def named(self, path: Path) -> Path:
        """The path with a suffix, where it has none of this format."""
        if path.suffix.lower() in self.suffixes:
            return path
        return path.with_name(f"{path.name}{self.suffixes[0]}")


_MOTION: tuple[Kind, ...] = ("run", "trajectory", "reference")
_LABELS: tuple[Kind, ...] = ("clicks",)

_PROPERTIES: Mapping[str, tuple[str, Callable[[Click], bool]]] = {
    "guessed": ("which clicks are guessed", lambda one: one.visibility == Visibility.GUESSED),
    "outside": ("landmarks outside the image", lambda one: one.visibility == Visibility.OUTSIDE),
    "source": ("which clicks are accepted or imported", lambda one: one.origin != "hand"),
    "sigma": ("click uncertainties", lambda one: one.sigma is not None),
    "flag": ("flags", lambda one: bool(one.flag)),
    "annotator": ("annotators and times", lambda one: bool(one.who)),
}
"""Properties of clicks: in words, and whether a click has a value that is not the usual one."""

_NOTES = frozenset({"sigma", "flag", "annotator"})
_ALL_BUT_PLACES = frozenset(_PROPERTIES)
_SIGMA_AND_SOURCE = "standard deviations, and which frames are interpolated"

FORMATS: tuple[ExportFormat, ...] = (
    ExportFormat(
        "csv", "Table", (".csv",), (*_MOTION, "clicks", "keypoints"), loses=_NOTES,
        lost_of_reference="covariances between axes, and uncertainties of limbs",
    ),
    ExportFormat("trc", "TRC, OpenSim", (".trc",), _MOTION, lost_of_reference=_SIGMA_AND_SOURCE),
    ExportFormat(
        "c3d", "C3D", (".c3d",), _MOTION,
        lost_of_reference="standard deviations other than the largest one of each landmark (its "
        "residual), and which frames are interpolated",
    ),
    ExportFormat(
        "bvh", "BVH", (".bvh",), _MOTION,
        lost_of_reference=f"{_SIGMA_AND_SOURCE}, and gaps: unknown landmarks stay as they were "
        "last known",
    ),
    ExportFormat("npz", "Complete, with uncertainty", (".npz",), ("run", "reference")),
    ExportFormat("angles", "Joint angles", (".csv",), _MOTION),
    ExportFormat(
        "coco", "COCO keypoints", (".json",), ("clicks", "keypoints"), loses=_NOTES
    ),
    ExportFormat(
        "slp", "SLEAP", (".slp",), _LABELS, "sleap_io", "sleap",
        loses=_NOTES | {"outside", "source"},
    ),
    ExportFormat("dlc", "DeepLabCut", (".csv",), _LABELS, loses=_ALL_BUT_PLACES),
)  # fmt: skip


def lost_of_clicks(form: ExportFormat, clicks: Iterable[Click]) -> str:
    """Sentence on properties of these clicks that a format has no place for; empty if none."""
    lost = {name: 0 for name in _PROPERTIES if name in form.loses}
    for click in clicks:
        for name in lost:
            lost[name] += _PROPERTIES[name][1](click)
    words = [f"{_PROPERTIES[name][0]} ({count})" for name, count in lost.items() if count]
    return f"{form.label} cannot store: {', '.join(words)}." if words else ""


def formats_of(*kinds: Kind) -> tuple[ExportFormat, ...]:
    """Formats that any of these can be written as, in the order in which they are offered."""
    return tuple(one for one in FORMATS if set(kinds) & set(one.kinds))


def names_of(*kinds: Kind) -> tuple[str, ...]:
    """Their names."""
    return tuple(one.name for one in formats_of(*kinds))


def format_named(name: str) -> ExportFormat:
    """The format of that name; LookupError where there is none."""
    found = next((one for one in FORMATS if one.name == name), None)
    if found is None:
        raise LookupError(name)
    return found


def format_of_file(path: Path) -> ExportFormat:
    """The format that a file's name means, of several the first one; InputError for none."""
    suffix = path.suffix.lower()
    found = next((one for one in FORMATS if suffix in one.suffixes), None)
    if found is None:
        every = sorted({one for form in FORMATS for one in form.suffixes})
        raise InputError(
            f"the suffix {suffix!r} means no format",
            where=str(path),
            remedy=f"Give --format, or a name that ends in one of {', '.join(every)}.",
        )
    return found


def check_kind(form: ExportFormat, kind: Kind, kinds: Sequence[Kind] = ()) -> None:
    """Refuse a format that this cannot be written as; `kinds` are others that could be meant."""
    if kind not in form.kinds:
        raise InputError(
            f"this cannot be exported as {form.name}",
            where="--format",
            remedy=f"Use one of {', '.join(names_of(kind, *kinds))}.",
        )

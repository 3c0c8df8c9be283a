"""Probable roles of sources, by their names and sizes; a person's decisions replace them."""

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import TypeAlias

import numpy as np

from stereotrack_core.recording.importing.choices import Choices, Role, Source, Use
from stereotrack_core.recording.importing.readers import measured, open_source
from stereotrack_core.recording.importing.sources import Found

_SIDE_BY_SIDE = 2.5  # width over height from which an image is two; the widest films have 2.4
_SIDES: Mapping[str, Role] = {
    "left": "left", "l": "left", "links": "left", "right": "right", "r": "right", "rechts": "right",
    "infra1": "left", "infra2": "right",
}  # fmt: skip
_DEPTH_WORDS = frozenset({"depth", "d", "z", "tiefe"})
_IMAGE_WORDS = frozenset(
    {"image", "color", "colour", "rgb", "ir", "infrared", "grey", "gray", "img"}
)
_INFRARED = frozenset({"ir", "infrared"})  # 16 bits of brightness
_EMPTY = frozenset({"background", "backgrounds", "bg", "empty", "hintergrund", "leer"})
_MASK_WORDS = frozenset({"mask", "masks"})
_PAIR = re.compile(r"(.*?)(cam|camera)[_-]?([01])", re.IGNORECASE)

_UNITS = (0.001, 0.00025, 0.0002, 0.0001)
_ROOM = (0.3, 8.0)  # metres; the middle distance of what a depth camera sees indoors


def propose(found: Found) -> Choices:
    """Propose the roles of sources by their names and sizes."""
    uses = [_by_itself(measured(source)) for source in found.sources]
    _pair_by_number(uses)
    uses = [_without_partner(use, uses) for use in uses]
    folder = found.folder
    calibration = None if folder is None else folder / "calibration.toml"
    uses = list(_renamed(uses))
    return Choices(
        name=folder.resolve().name if folder is not None else "recording",
        uses=tuple(with_background(use, uses, found) for use in uses),
        fps=found.fps,
        calibration=calibration if calibration is not None and calibration.is_file() else None,
    )


Views: TypeAlias = Mapping[str, tuple[str, ...]]  # names of one or two sources by view


def viewed(uses: Sequence[Use], views: Views) -> tuple[Use, ...]:
    """Uses by views that a person names; two sources are left and right, unless one is depth."""
    by_name = {use.source.name: use for use in uses}
    roles: dict[str, tuple[Role, str]] = {}
    for view, names in views.items():
        kinds = [by_name[name].source.kind for name in names]
        if len(names) == 1:
            own = _by_itself(by_name[names[0]].source).role
            whole: Role = "depth" if kinds == ["depth"] else "mono"
            roles[names[0]] = (own if own.startswith("side") else whole, view)
        elif kinds.count("depth") == 1:
            for name, kind in zip(names, kinds, strict=True):
                roles[name] = ("depth" if kind == "depth" else "image", view)
        else:
            roles[names[0]], roles[names[1]] = ("left", view), ("right", view)
    unused: tuple[Role, str] = ("unused", "")
    told = [(use, *roles.get(use.source.name, unused)) for use in uses]
    return tuple(replace(use, role=role, view=view or use.view) for use, role, view in told)


def possible_units(source: Source) -> tuple[tuple[float, float], ...]:
    """Usual metres per count, and the middle of the scene with each; of a room's distance first."""
    with closing(open_source(source, "depth")) as reader:
        counts = reader.read(0, lambda _number, _picture: None)
    known = counts[counts > 0]
    if not known.size:
        return ((_UNITS[0], float("nan")),)
    middle = float(np.median(known))
    fitting = [(unit, middle * unit) for unit in _UNITS if _ROOM[0] <= middle * unit <= _ROOM[1]]
    return tuple(fitting) or ((_UNITS[0], middle * _UNITS[0]),)


def _by_itself(source: Source) -> Use:
    words = [word for word in re.split(r"[_\-. ]+", source.name) if word]
    for place, word in enumerate(words):
        rest = "_".join(words[:place] + words[place + 1 :])
        side = _SIDES.get(word.lower())
        at_end = place in (0, len(words) - 1)
        if side is not None and at_end and (len(word) > 1 or rest):
            return Use(source, side, rest or "stereo")
        if word.lower() in _EMPTY:
            return Use(source, "unused", source.name)
        if word.lower() in _MASK_WORDS:
            return Use(source, "mask", rest or "depth")
        if word.lower() in _DEPTH_WORDS and source.kind == "depth":
            return Use(source, "depth", rest or "depth")
        grey = word.lower() in _INFRARED or source.kind != "depth"
        if word.lower() in _IMAGE_WORDS and grey:
            return Use(source, "image", rest or "depth")
    if source.kind == "depth":
        return Use(source, "depth", source.name)
    wide = source.width >= _SIDE_BY_SIDE * source.height and source.width % 2 == 0
    return Use(source, "side by side" if wide else "mono", source.name)


def _pair_by_number(uses: list[Use]) -> None:
    """Take ``cam0`` and ``cam1`` for a stereo camera where there is no third."""
    mono = {i: use.source.name for i, use in enumerate(uses) if use.role == "mono"}
    matches = {i: match for i, name in mono.items() if (match := _PAIR.fullmatch(name))}
    stems = [match.group(1) for match in matches.values()]
    for index, match in matches.items():
        stem = match.group(1)
        sizes = {uses[other].source.size for other, m in matches.items() if m.group(1) == stem}
        alone = sum(use.source.name.startswith(stem) for use in uses) == 2
        if stems.count(stem) == 2 and len(sizes) == 1 and alone:
            side: Role = "left" if match.group(3) == "0" else "right"
            uses[index] = replace(uses[index], role=side, view=stem.strip("_-. ") or "stereo")


def _without_partner(use: Use, uses: Sequence[Use]) -> Use:
    """A single camera where what its name promises has no partner of the same size."""
    partner: Mapping[Role, Role] = {
        "left": "right", "right": "left", "image": "depth", "mask": "depth",
    }  # fmt: skip
    wanted = partner.get(use.role)
    if wanted is None:
        return use
    for other in uses:
        if other.role == wanted and other.view == use.view and other.source.size == use.source.size:
            return use
    role: Role = "unused" if use.role == "mask" else "mono"
    return replace(use, role=role, view=use.source.name)


def _renamed(uses: Sequence[Use]) -> Iterator[Use]:
    """The same with names of views that differ where the views do."""
    taken: dict[tuple[str, str], str] = {}
    for use in uses:
        kind = use.role if use.role in ("mono", "side by side") else "several"
        key = (use.view, use.source.name if kind != "several" else kind)
        if key not in taken:
            name, number = use.view, 2
            while name in taken.values():
                name, number = f"{use.view}_{number}", number + 1
            taken[key] = name
        yield replace(use, view=taken[key])


def with_background(use: Use, uses: Sequence[Use], found: Found) -> Use:
    """The use with the picture or video of the empty scene that its names belong to, if any."""
    if use.role in ("depth", "mask", "unused"):
        return use
    view = f"{use.view}_{use.role}" if use.role in ("left", "right") else use.view
    names = {use.source.name.casefold(), view.casefold()}
    if sum(one.role not in ("depth", "mask", "unused") for one in uses) == 1:
        names.add("")
    videos = [one.source.path for one in uses if one.role == "unused" and not one.source.images]
    for path in (*found.backgrounds, *videos):
        if _shown_empty(path) in names:
            return replace(use, background=path)
    return use


def _shown_empty(path: Path) -> str | None:
    """The stream whose empty scene a file shows, by its name or folder; None where it is none."""
    words = [word for word in re.split(r"[_\-. ]+", path.stem.casefold()) if word]
    rest = [word for word in words if word not in _EMPTY]
    if path.parent.name.casefold() in _EMPTY:
        return "_".join(words)
    return "_".join(rest) if len(rest) < len(words) else None

"""Order of the points in files that do not name them: stated, or told from a body's proportions.

Several detectors give equally many points in different orders (OpenPose's BODY_25 and BODY_25B).
In the right order, bones are as long in a picture as perspective leaves of a body's proportions; in
a wrong one, an eye may be as far from the nose as a knee. That tells them apart in any pose.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.errors import InputError
from stereotrack_core.recording.keypoint_names import LAYOUTS, layouts_of

_UNNAMED = re.compile(r"point (\d+) of (\d+)")

_MOST_PEOPLE = 600
"""People in single pictures that are looked at, spread over all frames."""

_FARTHEST = 1e6
"""Pixels beyond which a number is no place in an image."""

_FEWEST_BONES = 4
"""Bones without which a person tells nothing about the order."""

_MARGIN = 0.05
"""Misfit by which another order than the usual one must be better."""

_BODY_LIKE = 0.35
"""Misfit that another order than the usual one may have at most."""

_DOUBTFUL = 0.5
"""Misfit above which no known order looks like a body: right ones have 0.15 to 0.45, as of a person
seen from the side, wrong ones of the same number mostly 0.5 to 0.8."""

_MOST = 2.0
"""Largest deviation of one bone, as a logarithm, so that a gross error counts as one."""

_FORESHORTENED = 0.5
"""Weight of a bone that is too short, which perspective does, relative to one that is too long."""

_HIDDEN_SHOULDERS = 0.3
"""Misfit if no shoulder is ever seen: of a person behind a table, legs are missing and not they."""

_BONES: Mapping[tuple[str, str], float] = {
    **{("nose", f"{s}_eye"): 0.045 for s in ("left", "right")},
    **{(f"{s}_eye", f"{s}_ear"): 0.09 for s in ("left", "right")},
    **{("nose", f"{s}_ear"): 0.13 for s in ("left", "right")},
    **{(f"{s}_ear", f"{s}_shoulder"): 0.24 for s in ("left", "right")},
    **{("neck", f"{s}_shoulder"): 0.18 for s in ("left", "right")},
    **{("upper_neck", f"{s}_shoulder"): 0.21 for s in ("left", "right")},
    **{(f"{s}_shoulder", f"{s}_elbow"): 0.28 for s in ("left", "right")},
    **{(f"{s}_elbow", f"{s}_wrist"): 0.25 for s in ("left", "right")},
    **{(f"{s}_wrist", f"{s}_hand"): 0.08 for s in ("left", "right")},
    **{(f"{s}_wrist", f"{s}_index"): 0.10 for s in ("left", "right")},
    **{(f"{s}_shoulder", f"{s}_hip"): 0.50 for s in ("left", "right")},
    **{("mid_hip", f"{s}_hip"): 0.11 for s in ("left", "right")},
    **{(f"{s}_hip", f"{s}_knee"): 0.42 for s in ("left", "right")},
    **{(f"{s}_knee", f"{s}_ankle"): 0.41 for s in ("left", "right")},
    **{(f"{s}_ankle", f"{s}_heel"): 0.08 for s in ("left", "right")},
    **{(f"{s}_ankle", f"{s}_big_toe"): 0.17 for s in ("left", "right")},
    **{(f"{s}_big_toe", f"{s}_small_toe"): 0.07 for s in ("left", "right")},
    **{(f"{s}_ankle", f"{s}_foot"): 0.15 for s in ("left", "right")},
    ("left_shoulder", "right_shoulder"): 0.36,
    ("left_hip", "right_hip"): 0.22,
    ("nose", "head_top"): 0.20,
    ("neck", "nose"): 0.22,
    ("neck", "head_top"): 0.32,
    ("upper_neck", "head_top"): 0.25,
    ("upper_neck", "nose"): 0.14,
    ("neck", "head"): 0.22,
    ("upper_neck", "head"): 0.14,
    ("face", "head_top"): 0.15,
    ("neck", "face"): 0.18,
    ("neck", "mid_hip"): 0.52,
    ("spine", "mid_hip"): 0.24,
    ("spine", "neck"): 0.28,
    ("chest", "neck"): 0.25,
    ("neck", "upper_neck"): 0.08,
}
"""Lengths of an adult, metres; only their ratios count."""

AnyRow = TypeVar("AnyRow", bound=tuple[object, ...])


def unnamed(count: int, where: str, *, stated: str | None = None) -> Sequence[str]:
    """Names of so many points in a file that names none, as long as their order is not decided.

    Raises InputError if no usual layout has so many points, or fewer than the stated one.
    """
    if stated is not None and count < len(LAYOUTS[stated]):
        raise InputError(
            f"a person has {count} points, the layout {stated} {len(LAYOUTS[stated])}",
            where=where,
            remedy=f"State another layout with --layout: {', '.join(LAYOUTS)}.",
        )
    if stated is None and not layouts_of(count):
        raise InputError(
            f"a person has {count} points, which is none of the usual layouts",
            where=where,
            remedy=f"State the layout with --layout: {', '.join(LAYOUTS)}.",
        )
    return [f"point {i} of {count}" for i in range(count)]


@dataclass(frozen=True)
class LayoutChoice:
    """Order of the points of all people with equally many."""

    count: int
    layout: str
    stated: bool
    misfit: float
    """How far bones are from a body's proportions, as a logarithm; NaN if nothing tells it."""
    others: Mapping[str, float]
    """The same of the other layouts of that length."""

    def sentence(self) -> str:
        """What was chosen and why; empty if there was nothing to choose."""
        points = f"{self.count} points without names"
        if self.stated:
            better = min(self.others, key=lambda name: self.others[name], default="")
            if better and self.others[better] < self.misfit - _MARGIN:
                return (
                    f"{points}: in the order of {self.layout}, as stated, although a body's "
                    f"proportions speak for {better}"
                )
            return f"{points}: in the order of {self.layout}, as stated"
        doubt = (
            "; no known order looks like a body, so check it in the window"
            if self.misfit > _DOUBTFUL
            else ""
        )
        if not self.others:
            return f"{points}: in the order of {self.layout}{doubt}"
        best = min(self.others, key=lambda name: np.nan_to_num(self.others[name], nan=np.inf))
        if np.isnan(self.misfit):
            why = "the usual one; no person is seen well enough to tell"
        elif self.others[best] < self.misfit - _MARGIN:
            why = f"the usual one, although {best} looks more like a body"
        elif self.others[best] < self.misfit + _MARGIN:
            why = "a body's proportions hardly decide it"
        else:
            why = "told by a body's proportions"
        return (
            f"{points}: in the order of {self.layout} ({why}), not of {', '.join(self.others)}"
            f"{doubt}; another order can be stated (--layout)"
        )


def with_layouts(
    rows: Sequence[AnyRow], stated: str | None = None
) -> tuple[list[AnyRow], tuple[LayoutChoice, ...]]:
    """Rows whose points have names, and what was decided about those that had none.

    Parameters
    ----------
    rows : sequence of tuple
        Frame, camera, keypoint, column, row, confidence, source and person; points without names
        have those of :func:`unnamed`.
    stated : str, optional
        Name in ``LAYOUTS``; it goes before everything that the points tell.
    """
    matches = [_UNNAMED.fullmatch(str(row[2])) for row in rows]
    people: dict[int, dict[tuple[object, ...], list[tuple[int, float, float]]]] = {}
    for row, match in zip(rows, matches, strict=True):
        if match is not None:
            own = people.setdefault(int(match[2]), {}).setdefault((row[0], row[1], *row[6:]), [])
            x, y, sure = (float(str(value)) for value in row[3:6])
            if sure > 0.0 and max(abs(x), abs(y)) < _FARTHEST:
                own.append((int(match[1]), x, y))
    choices = {
        count: _choice(count, [one for one in own.values() if one], stated)
        for count, own in people.items()
    }
    named = [
        row if match is None else (*row[:2], _name(match, choices), *row[3:])
        for row, match in zip(rows, matches, strict=True)
    ]
    return named, tuple(choices.values())  # type: ignore[return-value]  # the same kind of tuples


def _name(match: re.Match[str], choices: Mapping[int, LayoutChoice]) -> str:
    place, names = int(match[1]), LAYOUTS[choices[int(match[2])].layout]
    return names[place] if place < len(names) else f"point_{place}"


def _choice(
    count: int, people: Sequence[Sequence[tuple[int, float, float]]], stated: str | None
) -> LayoutChoice:
    candidates = dict.fromkeys(([stated] if stated else []) + list(layouts_of(count)))
    step = max(1, len(people) // _MOST_PEOPLE)
    places = np.full((len(people[::step]), count, 2), np.nan)
    for own, points in zip(places, people[::step], strict=True):
        for place, x, y in points:
            own[place] = x, y
    misfits = {name: _misfit(places, LAYOUTS[name]) for name in candidates}
    usual = next(iter(candidates))
    best = min(candidates, key=lambda name: np.nan_to_num(misfits[name], nan=np.inf))
    better = misfits[best] < min(misfits[usual] - _MARGIN, _BODY_LIKE)
    chosen = usual if stated or not better else best
    others = {name: misfit for name, misfit in misfits.items() if name != chosen}
    return LayoutChoice(count, chosen, stated is not None, misfits[chosen], others)


def _misfit(places: FloatArray, names: Sequence[str]) -> float:
    """Mean deviation of the bones (P people) from proportions; NaN where too few are seen."""
    bones = [
        (names.index(a), names.index(b), length)
        for (a, b), length in _BONES.items()
        if a in names and b in names
    ]
    one, other, length = (np.array(column) for column in zip(*bones, strict=True))
    seen = np.linalg.norm(places[:, one] - places[:, other], axis=2)
    ratio = np.log(np.maximum(seen, 0.5) / length)
    ratio = ratio[np.isfinite(ratio).sum(axis=1) >= _FEWEST_BONES]
    if not len(ratio):
        return float("nan")
    off = ratio - np.nanmedian(ratio, axis=1, keepdims=True)
    off = np.where(off < 0.0, -_FORESHORTENED * off, off)
    shoulders = places[:, [names.index(f"{side}_shoulder") for side in ("left", "right")]]
    hidden = float(np.isnan(shoulders).mean())
    return float(np.nanmean(np.minimum(off, _MOST))) + _HIDDEN_SHOULDERS * hidden


def sentences(choices: Sequence[LayoutChoice]) -> Iterator[str]:
    """What was decided, without repetitions."""
    yield from dict.fromkeys(choice.sentence() for choice in choices)

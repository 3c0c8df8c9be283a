"""The thesis's own numbers, and four simulated recordings like its own (section 4.1).

Julius Ziegler, Tracking der artikularen Bewegung des Oberkörpers in Stereobildfolgen, Diplomarbeit,
Universität Karlsruhe (TH), 2005, chapter 4. Errors are means over all frames of real recordings
against a reference that it takes to be good to 10 degrees (page 49).

What the thesis says of its recordings is kept: four people, four stereo cameras of 640 x 480 and a
base line of 120 mm, 10 frame sets per second, 1200 to 2000 of them, furniture, a second person now
and then, a defined pose at the beginning, low contrast clothes for P3 and P4, P3 out of the sight
of most cameras early on. The motions that it shows pictures of stand at its very frame numbers and
take as long (figures 4.5, 4.7, 4.9 and 4.11). The rest is free movement at a similar pace. At the
end every person does the four motions once more, fast.

One thing differs: the focal length is 400 px, as in other simulated recordings, and not the 267 px
of the thesis's lenses. With those, the points of every second pixel that outlive the removal of
outliers are some 50 on a forearm, and preset ``thesis`` loses the arms of a person who stands
still. How many points the thesis had it does not say.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import cycle

from stereotrack_core.evaluation.summary import ERROR_MEASURES
from stereotrack_core.simulation.motions import Part
from stereotrack_core.simulation.rig import SceneOptions

ROWS = ERROR_MEASURES[:5]
"""Measure, name and unit of every row that all four tables have."""


@dataclass(frozen=True, eq=False)
class ThesisTable:
    """A table of the thesis."""

    number: str
    page: int
    title: str
    columns: tuple[str, ...]
    values: Mapping[str, tuple[float, ...]]
    """By measure."""
    remark: str
    """What the thesis itself says about it."""


def _values(*rows: tuple[float, ...]) -> Mapping[str, tuple[float, ...]]:
    return {name: row for (name, _, _), row in zip(ROWS, rows, strict=True)}


TABLE_4_1 = ThesisTable(
    "4.1",
    51,
    "Results with the reference parameters",
    ("P1", "P2", "P3", "P4", "together"),
    _values(
        (65, 53, 85, 67, 67),
        (9.1, 8.2, 11.2, 9.2, 9.4),
        (9.5, 13.6, 16.4, 16.1, 13.9),
        (22.0, 33.5, 40.3, 32.8, 32.1),
        (27.6, 25.6, 27.8, 42.3, 30.8),
    ),
    "P3 and P4 are slightly worse because of low-contrast clothes and more difficult motions.",
)

TABLE_4_2 = ThesisTable(
    "4.2",
    51,
    "Number of sampled model points m",
    ("m = 24", "m = 40", "m = 64", "m = 120"),
    _values(
        (89, 71, 67, 83),
        (10.8, 9.1, 9.4, 9.3),
        (18.5, 13.7, 13.9, 13.1),
        (41.4, 31.8, 32.1, 31.9),
        (41.9, 31.1, 30.8, 32.0),
    ),
    "The gain is smaller than expected, except from m = 24.",
)

TABLE_4_3 = ThesisTable(
    "4.3",
    52,
    "Two cameras instead of four",
    ("NS", "NOSW"),
    _values((64, 62), (7.6, 8.8), (12.1, 13.1), (34.1, 29.4), (39.8, 31.8)),
    "P3 is omitted: early on, only camera S saw it, and the arms were never found again.",
)

TABLE_4_4 = ThesisTable(
    "4.4",
    53,
    "Average proportions for everyone",
    ("averaged", "individual"),
    _values((75, 67), (9.4, 9.4), (14.2, 13.9), (43.9, 32.1), (35.9, 30.8)),
    "The arms are tracked significantly worse with average proportions.",
)

MOTIONS = ("whip", "travolta", "tie-shoes", "cross-arms")
"""Segments of the motions of section 4.3 (figures 4.5 to 4.12)."""

FAST = "-fast"
"""End of the names of segments that are done faster than the people of the thesis did."""

_HELD = "hold-arms-crossed"
_FILLERS = (
    ("walk", 110),
    ("arms-at-sides", 90),
    ("point", 90),
    ("walk", 110),
    ("travolta", 76),
    (_HELD, 130),
)
_FAST_FORMS = (("whip", 30), ("travolta", 20), ("tie-shoes", 50), ("cross-arms", 56))
_BLEND, _FAST_BLEND = 14, 8
_FAST_FRAMES = sum(frames + _FAST_BLEND for _, frames in _FAST_FORMS)
_T_POSE = Part("t-pose", "t-pose", 0, 12)


@dataclass(frozen=True)
class ThesisRecording:
    """One recording to be made, named like its person."""

    name: str
    frames: int
    parts: tuple[Part, ...]
    options: SceneOptions


def thesis_recordings(*, short: bool = False) -> tuple[ThesisRecording, ...]:
    """P1 to P4; `short` has every kind of segment in as few frames as can be."""
    return _short() if short else _full()


def _full() -> tuple[ThesisRecording, ...]:
    leaving = Part("leave-and-return", "leave-and-return", 16, 88)
    return (
        _recording("P1", 1200, (_T_POSE, _at("whip", 300, 274)), "strong"),
        _recording("P2", 1200, (_T_POSE, _at("travolta", 412, 38)), "striped", passer=True),
        _recording("P3", 1300, (_T_POSE, leaving, _at("tie-shoes", 113, 215)), "plain"),
        _recording(
            "P4",
            2000,
            (
                _T_POSE,
                Part("cross-arms", _HELD, 390, 130),
                _at("tie-shoes", 900, 215),
                _at("whip", 1479, 274),
            ),
            "plain",
        ),
    )


def _recording(
    name: str, frames: int, fixed: tuple[Part, ...], clothes: str, *, passer: bool = False
) -> ThesisRecording:
    slow = _filled(fixed, _FILLERS, frames - _FAST_FRAMES, _BLEND)
    slow = tuple(replace(part, name=part.name.replace(_HELD, "cross-arms")) for part in slow)
    options = SceneOptions(clothes=clothes, second_person=passer)
    return ThesisRecording(name, frames, (*slow, *_fast(frames - _FAST_FRAMES)), options)


def _fast(at: int) -> tuple[Part, ...]:
    parts = []
    for motion, frames in _FAST_FORMS:
        parts.append(Part(motion + FAST, motion, at + _FAST_BLEND, frames))
        at += _FAST_BLEND + frames
    return tuple(parts)


def _at(motion: str, first: int, frames: int) -> Part:
    return Part(motion, motion, first, frames)


def _short() -> tuple[ThesisRecording, ...]:
    options = SceneOptions(
        width=400, height=300, focal=250.0, furnished=False, noise=1.0, clothes="strong"
    )
    shown = {
        "P1": ("whip",),
        "P2": ("travolta",),
        "P3": ("tie-shoes",),
        "P4": ("cross-arms", "whip"),
    }
    made = []
    for name, motions in shown.items():
        parts, at = [Part("t-pose", "t-pose", 0, 4)], 4
        for motion, label in [*((m, m) for m in motions), (motions[0], motions[0] + FAST)]:
            parts.append(Part(label, motion, at + 2, 6))
            at += 8
        made.append(ThesisRecording(name, at, tuple(parts), options))
    return tuple(made)


def _filled(
    fixed: Sequence[Part], fillers: Sequence[tuple[str, int]], until: int, blend: int
) -> tuple[Part, ...]:
    """Put fillers into the gaps between fixed parts, which are in their order, up to frame `until`.

    Fillers (motion, frames) come in turn and take about so many frames: those of one gap are
    stretched alike until they fill it. Before every part are `blend` frames to go over to it.
    """
    turn = cycle(fillers)
    parts: list[Part] = []
    at = 0
    for part in (*fixed, None):
        end = until if part is None else part.first
        parts += _gap_filled(at, end - (0 if part is None else blend), turn, blend)
        if part is not None:
            parts.append(part)
            at = part.end
    return tuple(parts)


def _gap_filled(at: int, end: int, turn: Iterator[tuple[str, int]], blend: int) -> Iterator[Part]:
    chosen: list[tuple[str, int]] = []
    needed = 0
    while end - at - needed > 0:
        motion, frames = next(turn)
        if chosen and needed + blend + frames / 2 > end - at:
            break
        if not chosen and blend + frames / 2 > end - at:
            return
        chosen.append((motion, frames))
        needed += blend + frames
    moving = sum(frames for _, frames in chosen)
    scale = (end - at - blend * len(chosen)) / moving if moving else 1.0
    for motion, frames in chosen:
        length = max(2, int(frames * scale))
        yield Part(motion, motion, at + blend, length)
        at += blend + length

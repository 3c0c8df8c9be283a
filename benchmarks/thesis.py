"""The thesis's own numbers, and four simulated recordings like its own (section 4.1).

Julius Ziegler, Tracking der artikularen Bewegung des Oberkörpers in Stereobildfolgen, Diplomarbeit,
Universität Karlsruhe (TH), 2005, chapter 4. Errors are means over all frames of real recordings
against a reference that it takes to be good to 10 degrees (page 49).

What the thesis says of its recordings is kept, but for the focal length of the lenses
(docs/reproduce.md). The motions that it shows pictures of stand at its very frame numbers and take
as long (figures 4.5, 4.7, 4.9 and 4.11). The rest is free movement at a similar pace. At the end
every person does the four motions once more, fast.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import cycle

from stereotrack_core.evaluation.summary import ERROR_MEASURES
from stereotrack_core.simulation.motions import Part
from stereotrack_core.simulation.rig import SceneOptions

ROWS = ERROR_MEASURES[:5]  # measure, name and unit of every row that all four tables have


@dataclass(frozen=True, eq=False)
class ThesisTable:
    """A table of the thesis."""

    number: str
    page: int
    title: str
    columns: tuple[str, ...]
    values: tuple[tuple[float, ...], ...]  # of each of :data:`ROWS`
    remark: str  # what the thesis itself says about it


TABLES = (
    ThesisTable(
        "4.1", 51, "Results with the reference parameters", ("P1", "P2", "P3", "P4", "together"),
        ((65, 53, 85, 67, 67), (9.1, 8.2, 11.2, 9.2, 9.4), (9.5, 13.6, 16.4, 16.1, 13.9),
         (22.0, 33.5, 40.3, 32.8, 32.1), (27.6, 25.6, 27.8, 42.3, 30.8)),
        "P3 and P4 are slightly worse because of low-contrast clothes and more difficult motions.",
    ),
    ThesisTable(
        "4.2", 51, "Number of sampled model points m", ("m = 24", "m = 40", "m = 64", "m = 120"),
        ((89, 71, 67, 83), (10.8, 9.1, 9.4, 9.3), (18.5, 13.7, 13.9, 13.1),
         (41.4, 31.8, 32.1, 31.9), (41.9, 31.1, 30.8, 32.0)),
        "The gain is smaller than expected, except from m = 24.",
    ),
    ThesisTable(
        "4.3", 52, "Two cameras instead of four", ("NS", "NOSW"),
        ((64, 62), (7.6, 8.8), (12.1, 13.1), (34.1, 29.4), (39.8, 31.8)),
        "P3 is omitted: early on, only camera S saw it, and the arms were never found again.",
    ),
    ThesisTable(
        "4.4", 53, "Average proportions for everyone", ("averaged", "individual"),
        ((75, 67), (9.4, 9.4), (14.2, 13.9), (43.9, 32.1), (35.9, 30.8)),
        "The arms are tracked significantly worse with average proportions.",
    ),
)  # fmt: skip

# Segments of the motions of section 4.3 (figures 4.5 to 4.12).
MOTIONS = ("whip", "travolta", "tie-shoes", "cross-arms")
FAST = "-fast"  # end of the names of segments that are done faster than by the thesis's people
_HELD = "hold-arms-crossed"
_FILLERS = (
    *(("walk", 110), ("arms-at-sides", 90), ("point", 90)),
    *(("walk", 110), ("travolta", 76), (_HELD, 130)),
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
    if short:
        return _short()
    travolta, tie_shoes = _part("travolta", 412, 38), _part("tie-shoes", 113, 215)
    held = Part("cross-arms", _HELD, 390, 130)
    fourth = (held, _part("tie-shoes", 900, 215), _part("whip", 1479, 274))
    return (
        _recording("P1", 1200, (_part("whip", 300, 274),), "strong"),
        _recording("P2", 1200, (travolta,), "striped", passer=True),
        _recording("P3", 1300, (_part("leave-and-return", 16, 88), tie_shoes), "plain"),
        _recording("P4", 2000, fourth, "plain"),
    )


def _recording(
    name: str, frames: int, fixed: tuple[Part, ...], clothes: str, *, passer: bool = False
) -> ThesisRecording:
    at = frames - _FAST_FRAMES
    parts = [replace(part, name=part.name.replace(_HELD, "cross-arms"))
             for part in _filled((_T_POSE, *fixed), at)]  # fmt: skip
    for motion, length in _FAST_FORMS:
        parts.append(Part(motion + FAST, motion, at + _FAST_BLEND, length))
        at = parts[-1].end
    options = SceneOptions(clothes=clothes, second_person=passer)
    return ThesisRecording(name, frames, tuple(parts), options)


def _part(motion: str, first: int, frames: int) -> Part:
    return Part(motion, motion, first, frames)


def _short() -> tuple[ThesisRecording, ...]:
    options = SceneOptions(
        width=400, height=300, focal=250.0, furnished=False, noise=1.0, clothes="strong"
    )
    shown = {"P1": ["whip"], "P2": ["travolta"], "P3": ["tie-shoes"], "P4": ["cross-arms", "whip"]}
    made = []
    for name, motions in shown.items():
        labels = [*zip(motions, motions, strict=True), (motions[0] + FAST, motions[0])]
        parts = (Part(*names, 6 + 8 * k, 6) for k, names in enumerate(labels))
        whole = (_part("t-pose", 0, 4), *parts)
        made.append(ThesisRecording(name, whole[-1].end, whole, options))
    return tuple(made)


def _filled(fixed: Sequence[Part], until: int) -> Iterator[Part]:
    """Put fillers into the gaps between fixed parts, which are in their order, up to frame `until`.

    Fillers come in turn and take about their frames: those of one gap are stretched alike until
    they fill it. Before every part are :data:`_BLEND` frames to go over to it.
    """
    turn, at = cycle(_FILLERS), 0
    for part in fixed:
        yield from _gap_filled(at, part.first - _BLEND, turn)
        yield part
        at = part.end
    yield from _gap_filled(at, until, turn)


def _gap_filled(at: int, end: int, turn: Iterator[tuple[str, int]]) -> Iterator[Part]:
    chosen: list[tuple[str, int]] = []
    needed = 0
    while end - at - needed > 0:
        motion, frames = next(turn)
        if needed + _BLEND + frames / 2 > end - at:
            break
        chosen.append((motion, frames))
        needed += _BLEND + frames
    moving = sum(frames for _, frames in chosen)
    scale = (end - at - _BLEND * len(chosen)) / moving if moving else 1.0
    for motion, frames in chosen:
        length = max(2, int(frames * scale))
        yield _part(motion, at + _BLEND, length)
        at += _BLEND + length

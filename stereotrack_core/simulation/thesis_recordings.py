"""Four recordings like those of the thesis (section 4.1), simulated.

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

from dataclasses import dataclass, replace

from stereotrack_core.simulation.motions import Part, filled
from stereotrack_core.simulation.rig import SceneOptions

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
    slow = filled(fixed, _FILLERS, frames - _FAST_FRAMES, _BLEND)
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

"""Which frames of a reference are old."""

from dataclasses import replace

import numpy as np

from stereotrack_core.annotation.click import Click
from stereotrack_core.annotation.reference import (
    FITTED_TO,
    Reference,
    checksums,
    fitted_clicks,
    merged_reference,
)

CLICKS = tuple(
    Click(frame, camera, "head", (10.0 + frame, 20.0))
    for frame in (4, 8, 12)
    for camera in ("N_right", "S_right")
)


def meta(clicks=CLICKS):
    return {FITTED_TO: [list(row) for row in checksums(clicks).items()]}


def old(clicks, made_of=CLICKS):
    known = fitted_clicks(meta(made_of), clicks)
    return [frame for frame in range(16) if known.is_old(frame)]


def test_nothing_is_old_while_the_clicks_are_the_same_in_whatever_order():
    assert old(CLICKS) == []
    assert old(CLICKS[::-1]) == []
    assert old([replace(one, who="somebody", at="today") for one in CLICKS]) == []


def test_a_new_click_makes_old_what_lies_between_its_neighbours():
    assert old([*CLICKS, Click(6, "N_right", "head", (1.0, 1.0))]) == [5, 6, 7]
    assert old([*CLICKS, Click(14, "N_right", "head", (1.0, 1.0))]) == [13, 14, 15]
    assert old([*CLICKS, Click(1, "N_right", "head", (1.0, 1.0))]) == [0, 1, 2, 3]


def test_an_edit_and_its_undoing_are_followed():
    known = fitted_clicks(meta(), CLICKS)
    edited = known.after_edit([4], CLICKS[1:2])
    assert edited.is_old(4)
    assert not edited.is_old(8)
    assert edited.after_edit([4], CLICKS[:2]) == known


def reference(clicks):
    frames = np.arange(16)
    return Reference(
        frames, np.zeros((16, 1, 3)), np.zeros((16, 1, 3, 3)), np.zeros((16, 6)),
        np.zeros(16, bool), ("head",), meta(clicks) if clicks else {},
    )  # fmt: skip


def test_frames_that_were_fitted_again_are_new():
    now = [replace(one, position=(0.0, float(one.frame))) for one in CLICKS]
    merged = merged_reference(reference(CLICKS), reference(now), range(6, 10))
    known = fitted_clicks(merged.meta, now)
    assert [known.is_old(frame) for frame in (4, 8, 12)] == [True, False, True]
    merged = merged_reference(reference(None), reference(now), range(6, 10))
    assert fitted_clicks(merged.meta, now) is None

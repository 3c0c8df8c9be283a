"""A click states something that can be, or nothing."""

from __future__ import annotations

from dataclasses import replace

import pytest

from stereotrack_core.annotation.click import Click, Visibility

CLICK = Click(4, "N_right", "left_elbow", (12.5, 40.0))


@pytest.mark.parametrize(
    "wrong",
    [
        {"frame": -1},
        {"position": None},
        {"visibility": Visibility.OUTSIDE},
        {"position": (float("nan"), 1.0)},
        {"sigma": 0.0},
        {"sigma": float("inf")},
    ],
)
def test_what_cannot_be_is_refused(wrong: dict[str, object]):
    with pytest.raises(ValueError, match=r"."):
        replace(CLICK, **wrong)


def test_who_and_when_do_not_change_what_a_click_says():
    assert CLICK.says_the_same(replace(CLICK, who="A", at="2026-01-01T00:00:00", origin="merged"))
    assert not CLICK.says_the_same(replace(CLICK, position=(12.5, 40.1)))
    assert not CLICK.says_the_same(replace(CLICK, deleted=True))
    assert not CLICK.says_the_same(replace(CLICK, flag="uncertain"))

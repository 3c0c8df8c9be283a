"""Points without names: their order is told by the body's proportions, and said."""

import numpy as np
import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.recording.keypoint_names import LAYOUTS, layouts_of, unnamed, with_layouts

BY_SIDE = {
    "eye": (0.03, 0.09, 1.64), "ear": (0.07, 0.0, 1.62), "shoulder": (0.18, 0.0, 1.42),
    "hip": (0.1, 0.0, 0.93), "knee": (0.1, 0.02, 0.5), "ankle": (0.1, 0.0, 0.08),
    "heel": (0.1, -0.05, 0.02), "big_toe": (0.08, 0.16, 0.02),
    "small_toe": (0.14, 0.13, 0.02), "foot_index": (0.1, 0.16, 0.0),
}  # fmt: skip
IN_THE_MIDDLE = {
    "nose": (0.11, 1.6), "neck": (0.0, 1.43), "upper_neck": (0.02, 1.5), "head_top": (0.0, 1.78),
    "face": (0.08, 1.6), "mid_hip": (0.0, 0.95), "spine": (0.0, 1.18),
}  # fmt: skip


def body(rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Points of a standing person with arms anywhere, who faces anywhere: right, front, up."""
    found = {name: np.array([0.0, *place]) for name, place in IN_THE_MIDDLE.items()}
    for side, sign in (("left", -1.0), ("right", 1.0)):
        for name, place in BY_SIDE.items():
            found[f"{side}_{name}"] = np.array(place) * [sign, 1, 1]
        for start, end, length in (
            ("shoulder", "elbow", 0.29), ("elbow", "wrist", 0.25), ("wrist", "index", 0.1),
            ("wrist", "thumb", 0.07),
        ):  # fmt: skip
            way = rng.normal(size=3) + (0, 1, -1)
            found[f"{side}_{end}"] = found[f"{side}_{start}"] + length * way / np.linalg.norm(way)
    turn = rng.uniform(0, 2 * np.pi)
    ahead = np.array([np.cos(turn), np.sin(turn), 0.0])
    seen = {name: 300.0 * np.array([at @ ahead, 2.0 - at[2]]) for name, at in found.items()}
    return {name: place + rng.normal(size=2) for name, place in seen.items()}


def rows_of_layout(layout: str, people: int = 40, *, upper_body: bool = False):
    """Rows of points without names, in the order of a layout."""
    rng = np.random.default_rng(7)
    names = LAYOUTS[layout]
    rows = []
    for frame in range(people):
        found = body(rng)
        for own, name in zip(unnamed(len(names), ""), names, strict=True):
            below = any(part in name for part in ("knee", "ankle", "toe", "heel", "foot"))
            x, y = found.get(name, (0.0, 0.0))
            sure = 0.9 if name in found and not (upper_body and below) else 0.0
            rows.append((frame, "N", own, x, y, sure, "d", 0))
    return rows


@pytest.mark.parametrize("upper_body", [False, True])
@pytest.mark.parametrize("layout", LAYOUTS)
def test_layouts_of_equal_length_are_told_apart(layout, upper_body):
    named, (choice,) = with_layouts(rows_of_layout(layout, upper_body=upper_body))
    assert choice.layout == layout, choice
    assert [row[2] for row in named[: choice.count]] == list(LAYOUTS[layout])
    said = choice.sentence()
    assert f"in the order of {layout}" in said
    assert "no known order" not in said
    assert all(other in said for other in layouts_of(choice.count))


def test_a_stated_layout_is_never_overruled_but_contradicted():
    named, (choice,) = with_layouts(rows_of_layout("body25b"), "body25")
    assert [row[2] for row in named[:25]] == list(LAYOUTS["body25"])
    assert "body25, as stated, although a body's proportions speak for body25b" in choice.sentence()
    named, (choice,) = with_layouts(rows_of_layout("body25b"), "coco17")
    assert [row[2] for row in named[16:19]] == ["right_ankle", "point_17", "point_18"]
    with pytest.raises(InputError, match="17 points, the layout body25 25"):
        unnamed(17, "f", stated="body25")

"""What the real matcher makes of the pictures: nothing here is put in by the renderer."""

import dataclasses

import cv2
import numpy as np
import pytest

from stereotrack_core.simulation.materials import STRONG, Material, material_table
from stereotrack_core.simulation.shading import SHIRT, SLEEVE, TROUSERS
from tests.simulation.scenes import scene

FULL = {"width": 640, "height": 480, "focal": 400.0}
WINDOW = 11
FOCAL_TIMES_BASELINE = 400.0 * 0.12


def matched(left, right):
    matcher = cv2.StereoBM.create(64, WINDOW)
    matcher.setUniquenessRatio(10)
    matcher.setTextureThreshold(10)
    return matcher.compute(left, right) / 16.0


def cloth_away_from_edges(stuff):
    """Pixels whose window, with the matcher's own filters, sees one piece of clothing only."""
    kernel = np.ones((WINDOW + 8, WINDOW + 8), np.uint8)
    upper = np.isin(stuff, (SHIRT, SLEEVE)).astype(np.uint8)
    lower = (stuff == TROUSERS).astype(np.uint8)
    return (cv2.erode(upper, kernel) | cv2.erode(lower, kernel)) > 0


def measured(made, frames):
    """Per picture: disparity, true disparity, what is seen."""
    for frame in frames:
        people, _ = made.people(frame)
        for view in sorted({name[0] for name in made.cameras}):
            pictures = (made.picture(f"{view}_{side}", people, frame) for side in ("left", "right"))
            seen = made.renderers[f"{view}_left"].seen(people)
            yield matched(*pictures), FOCAL_TIMES_BASELINE / seen.depth, seen.stuff


def shares(clothes, person):
    made = scene(person, ("travolta",), 60, ("N", "O"), clothes=clothes, **FULL)
    whole, inner = [], []
    for found, _, stuff in measured(made, (5, 45)):
        cloth = np.isin(stuff, (SHIRT, SLEEVE, TROUSERS))
        whole.append((found[cloth] > 0).mean())
        inner.append((found[cloth_away_from_edges(stuff)] > 0).mean())
    return np.mean(whole), np.mean(inner)


@pytest.mark.parametrize("clothes", ["strong", "striped"])
def test_half_to_nine_tenths_of_textured_clothes_are_matched(clothes):
    _, inner = shares(clothes, "P2")
    assert 0.5 < inner < 0.9


def test_matches_lie_on_the_surface():
    """With cloth that leaves no doubt the disparity is that of the geometry, without bias."""
    made = scene("P4", ("t-pose",), 2, ("N", "S"), gain_difference=0.0, noise=0.5, **FULL)
    harlequin = Material(STRONG, (0.6, 0.6, 0.6), (0.1, 0.1, 0.1), 0.08, 0.1)
    dressed = dataclasses.replace(made.actor, materials=material_table((harlequin,) * 6))
    for found, truth, stuff in measured(dataclasses.replace(made, actor=dressed), (0,)):
        cloth = cloth_away_from_edges(stuff) & (found > 0)
        error = (found - truth)[cloth]
        assert abs(np.median(error)) < 0.06
        assert np.percentile(np.abs(error), 90) < 0.4

"""What the real matcher makes of the pictures: nothing here is put in by the renderer."""

import dataclasses

import cv2
import numpy as np
import pytest

from stereotrack_core.simulation.materials import STRONG, Material, material_table
from stereotrack_core.simulation.motions import T_POSE
from stereotrack_core.simulation.postures import Stand, state_of
from stereotrack_core.simulation.render import Posed
from stereotrack_core.simulation.shading import SHIRT, SLEEVE, TROUSERS
from stereotrack_core.simulation.skeleton import posed_bones
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


def test_less_than_three_tenths_of_plain_clothes_are_matched():
    whole, inner = shares("plain", "P2")
    assert inner < 0.3
    assert whole < shares("strong", "P2")[0] - 0.15


@pytest.mark.slow
@pytest.mark.parametrize("person", ["P1", "P3", "P4"])
def test_shares_hold_for_everybody(person):
    assert 0.5 < shares("strong", person)[1] < 0.93
    assert 0.5 < shares("striped", person)[1] < 0.93
    assert shares("plain", person)[1] < 0.3


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


def test_halo_is_about_half_a_window_wide():
    made = scene("P2", ("t-pose",), 2, ("N", "O"), **FULL)
    widths = []
    for found, truth, stuff in measured(made, (0,)):
        person = (stuff >= 0).astype(np.uint8)
        around = np.ones((31, 31), np.uint8)
        nearest = cv2.dilate(np.where(person, truth, 0).astype(np.float32), around)
        halo = (person == 0) & (np.abs(found - nearest) < 1.5) & (found > truth + 1.5)
        widths.append(cv2.distanceTransform(1 - person, cv2.DIST_L2, 5)[halo])
    widest = np.percentile(np.concatenate(widths), 95)
    assert WINDOW / 4 < widest < WINDOW


def range_noise(made, away):
    """Standard deviation in metres over pictures of the same scene that differ in noise.

    The print of the cloth grows with the distance, so that it looks the same in pixels.
    """
    person = made.actor.person
    camera = made.cameras["N_left"]
    forward = -camera.position_world[:2] / np.linalg.norm(camera.position_world[:2])
    state = state_of(person, T_POSE, Stand(camera.position_world[:2] + away * forward))
    materials = made.actor.materials.copy()
    materials[:, 7] *= away / 3.0
    dressed = dataclasses.replace(made.actor, materials=materials)
    people = [Posed(dressed, *dressed.posed(posed_bones(person, state)))]
    seen = made.renderers["N_left"].seen(people)
    found = [
        matched(*(made.picture(f"N_{side}", people, frame) for side in ("left", "right")))
        for frame in range(4)
    ]
    cloth = np.isin(seen.stuff, (SHIRT, SLEEVE, TROUSERS))
    for disparity in found:
        cloth &= np.abs(disparity - FOCAL_TIMES_BASELINE / seen.depth) < 1.0
    ranges = np.array([FOCAL_TIMES_BASELINE / disparity[cloth] for disparity in found])
    return ranges.std(axis=0, ddof=1).mean(), seen.depth[cloth].mean()


def test_noise_of_the_range_grows_with_the_square_of_the_distance():
    made = scene("P2", ("t-pose",), 2, ("N",), furnished=False, **FULL)
    noise, depth = np.array([range_noise(made, away) for away in (1.8, 2.6, 3.6, 5.0)]).T
    exponent = np.polyfit(np.log(depth), np.log(noise), 1)[0]
    assert 1.5 < exponent < 2.5

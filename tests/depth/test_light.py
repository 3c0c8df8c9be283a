"""The empty scene in the light of another picture."""

import cv2
import numpy as np
import pytest

from stereotrack_core.depth.light import (
    empty_scene,
    light_of,
    relit,
    shaded,
)
from stereotrack_core.depth.outline import difference_of, sharp_outline
from tests.depth.scenes import texture

EMPTY = (40 + 0.6 * texture(240, 320, seed=1)).clip(0, 255).astype(np.uint8)
PERSON = np.zeros(EMPTY.shape, dtype=bool)
PERSON[50:210, 130:190] = True
APART = cv2.dilate(PERSON.astype(np.uint8), np.ones((9, 9), np.uint8)) == 0
NOBODY = np.zeros(EMPTY.shape, dtype=bool)
ROWS, COLUMNS = np.mgrid[:240, :320]


def _picture(change, *, noise: float = 1.0):
    """The scene with a person in a uniform dress, in changed light, with noise."""
    scene = EMPTY.astype(np.float64)
    scene[PERSON] = 200.0
    scene = cv2.GaussianBlur(change(scene), (0, 0), 0.6)
    grain = np.random.default_rng(2).normal(0.0, noise, scene.shape)
    return (scene + grain).clip(0, 255).astype(np.uint8)


def _overlap(picture, background=APART):
    """Overlap of the outline found in a picture with the person's."""
    scene = empty_scene(EMPTY)
    empty = relit(picture, scene, light_of(picture, scene), background)
    found = sharp_outline(difference_of(picture, empty.picture), NOBODY, empty.noise)
    return (found & PERSON).sum() / (found | PERSON).sum()


def _shade(scene):
    return scene * (1.0 - 0.25 / (1.0 + np.exp(-(COLUMNS - 230) / 25.0)))


def _soft_shadow(scene):
    near = np.hypot((COLUMNS - 240) / 60.0, (ROWS - 190) / 30.0)
    return scene * (1.0 - 0.35 * np.clip(1.5 - near, 0.0, 1.0))


CHANGES = {
    "none": lambda scene: scene,
    "darker": lambda scene: 0.7 * scene,
    "brighter": lambda scene: 1.25 * scene,
    "offset": lambda scene: scene + 20.0,
    "gamma": lambda scene: 255.0 * (scene / 255.0) ** 0.7,
    "slope": lambda scene: scene * (0.85 + 0.3 * COLUMNS / 320.0),
    "shade": _shade,
    "soft shadow": _soft_shadow,
}


@pytest.mark.parametrize("name", CHANGES)
def test_a_change_of_light_is_no_difference(name):
    assert _overlap(_picture(CHANGES[name])) > 0.93


def test_a_shift_and_a_blur_of_the_picture_are_followed():
    moved = np.array([[1.0, 0.0, 0.8], [0.0, 1.0, -0.6]])

    def shaken(scene):
        return cv2.warpAffine(scene, moved, (320, 240), borderMode=cv2.BORDER_REPLICATE)

    assert _overlap(_picture(shaken)) > 0.9
    assert _overlap(_picture(lambda scene: cv2.GaussianBlur(scene, (0, 0), 1.5))) > 0.85


def test_a_shadow_keeps_the_structure_and_a_person_does_not():
    scene = empty_scene(EMPTY)
    dark = EMPTY.astype(np.float64)
    dark[100:200, 220:300] *= 0.6
    dark[PERSON] = texture(240, 320, seed=7)[PERSON]
    found = shaded(light_of(dark.clip(0, 255).astype(np.uint8), scene))
    assert found[28:47, 58:72].mean() > 0.8
    assert found[15:50, 35:45].mean() < 0.2

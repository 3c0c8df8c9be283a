"""Images that are partly black, and backgrounds of other views."""

import numpy as np
import pytest

from stereotrack_core.doctor.pictures import check_backgrounds, check_stripe
from tests.depth.scenes import texture


def scene(seed):
    return texture(60, 80, seed=seed)


def with_person(image):
    shown = image.copy()
    shown[20:50, 30:45] = 90
    return [shown, image]


def test_whole_images_have_no_findings():
    assert not list(check_stripe("view N, left", [scene(1).astype(np.uint8)] * 2))
    assert not list(check_stripe("view N, left", []))


@pytest.mark.parametrize(("columns", "severity"), [(40, "error"), (12, "warning")])
def test_a_stripe_that_is_always_black_is_told(columns, severity):
    image = scene(1).astype(np.uint8)
    image[:, :columns] = 0
    [finding] = check_stripe("view N, left", [image, image])
    assert finding.severity == severity
    assert f"{100 * columns / 80:.0f} % of the image is black" in finding.what


def test_a_depth_camera_may_show_nothing_where_it_measures_nothing():
    image = scene(1).astype(np.uint8)
    image[:, :40] = 0
    measured = np.ones(image.shape, dtype=bool)
    assert list(check_stripe("view O, image", [image], measured))
    measured[:, :40] = False
    assert not list(check_stripe("view O, image", [image], measured))


def test_own_backgrounds_have_no_findings():
    empty = {"N": scene(1), "O": scene(2)}
    assert not list(check_backgrounds({n: with_person(one) for n, one in empty.items()}, empty))


def test_backgrounds_of_other_views_are_named():
    shown = {"N": with_person(scene(1)), "O": with_person(scene(2)), "S": with_person(scene(3))}
    [copied] = check_backgrounds(shown, {"N": scene(1), "O": scene(1), "S": scene(3)})
    assert copied.where == "view O, background"
    assert "it is that of view N" in copied.what
    [exchanged] = check_backgrounds(shown, {"N": scene(2), "O": scene(1), "S": scene(3)})
    assert exchanged.where == "view N, background"
    assert "that of view O fits the images better" in exchanged.what

"""Backgrounds of other views."""

from stereotrack_core.doctor.light import check_backgrounds
from tests.depth.scenes import texture


def scene(seed):
    return texture(60, 80, seed=seed)


def with_person(image):
    shown = image.copy()
    shown[20:50, 30:45] = 90
    return [shown, image]


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

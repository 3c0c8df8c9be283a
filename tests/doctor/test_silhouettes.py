"""Silhouettes of views that are mirrored, exchanged or wrongly placed do not fill the others'."""

import dataclasses

import numpy as np
import pytest

from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.doctor.silhouettes import Silhouettes, check_silhouettes, filled
from stereotrack_core.doctor.slips import transposed
from stereotrack_core.errors import Correction
from tests.tracking.recordings import VIEWS, camera_towards_the_middle, rendered_depth
from tests.tracking.scenes import CAMERAS, pose_with_arms


@pytest.fixture(scope="module")
def shown():
    """Two frames of a person with one arm stretched out, beside the middle of the room."""
    body = body_model(AVERAGE)
    poses = [
        pose_with_arms([0, 1, 0], [0, 1, 0], [-1, 0, 0], [0, 0, 1], place=(0.3, 0.1, 0.95)),
        pose_with_arms([0, 0, 1], [0, 0, 1], [-1, 0, 0], [-1, 0, 0], place=(0.2, -0.2, 0.95)),
    ]
    result = {}
    for name, position in zip(VIEWS[:3], CAMERAS[:3], strict=True):
        camera = camera_towards_the_middle(name, position)
        masks = tuple(np.isfinite(rendered_depth(body, pose, camera)) for pose in poses)
        result[name] = Silhouettes(camera, (name,), masks)
    return result


def found(shown):
    [finding] = check_silhouettes(shown)
    return finding


def test_sound_silhouettes_have_no_findings(shown):
    assert filled(shown) > 0.98
    assert not list(check_silhouettes(shown))
    assert not list(check_silhouettes({name: shown[name] for name in "NO"}))


def test_a_mirrored_view_is_named(shown):
    finding = found({**shown, "O": shown["O"].mirrored})
    assert finding.where == "view O"
    assert "mirrored" in finding.what


def test_views_that_are_exchanged_are_named(shown):
    n, s = shown["N"], shown["S"]
    exchanged = {
        "N": dataclasses.replace(n, masks=s.masks),
        "S": dataclasses.replace(s, masks=n.masks),
    }
    finding = found({**shown, **exchanged})
    assert finding.where == "views N, S"
    assert "exchanged" in finding.what
    assert finding.correction == Correction("exchange_views", ("N", "S"))


def test_a_transposed_rotation_is_named(shown):
    wrong = dataclasses.replace(shown["O"], camera=transposed(shown["O"].camera))
    finding = found({**shown, "O": wrong})
    assert finding.where == "view O"
    assert "transposed" in finding.what


def test_views_without_silhouettes_have_no_findings(shown):
    nothing = {
        name: dataclasses.replace(one, masks=tuple(np.zeros_like(mask) for mask in one.masks))
        for name, one in shown.items()
    }
    assert not list(check_silhouettes(nothing))

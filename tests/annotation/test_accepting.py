"""Accepting takes what is certain, as visible as in the clicked frames around."""

from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.annotation.click import (
    ACCEPTED,
    Click,
    ClickKey,
    Prediction,
    Visibility,
    measurements,
)
from stereotrack_core.annotation.propose import NearestClicks, acceptable
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform

SEEN, GUESSED, OUTSIDE = Visibility.SEEN, Visibility.GUESSED, Visibility.OUTSIDE


def camera(name: str, lines: int) -> Camera:
    return Camera(name, 2 * lines, lines, np.eye(3), np.zeros(5), False, RigidTransform.identity())


CAMERAS = {"N": camera("N", 480), "S": camera("S", 960)}


def click(frame: int, seen: Visibility, landmark: str = "head", name: str = "N") -> Click:
    return Click(frame, name, landmark, None if seen == OUTSIDE else (1.0, 2.0), seen)


def predicted(sigma: float | None, name: str = "N", frame: int = 5) -> Prediction:
    return Prediction(frame, name, "head", "fit", (3.0, 4.0), sigma)


def test_the_limit_grows_with_the_image_and_an_unknown_sigma_is_beyond_it():
    given = (predicted(5.0), predicted(5.1), predicted(None), predicted(9.9, "S"))
    found = acceptable(given, (), CAMERAS)
    assert found.predictions == (given[0], given[3])
    assert found.words() == (
        "2 points less certain than 5 px at 480 lines stay open. Click or drag them."
    )
    assert acceptable(given[:1], (), CAMERAS).words() == ""
    assert acceptable(given, (), CAMERAS, limit=6.0).predictions == (*given[:2], given[3])


@pytest.mark.parametrize(
    ("before", "after", "expected"),
    [
        (SEEN, SEEN, SEEN),
        (GUESSED, None, GUESSED),
        (SEEN, GUESSED, GUESSED),
        (None, OUTSIDE, OUTSIDE),
        (OUTSIDE, OUTSIDE, OUTSIDE),
        (OUTSIDE, SEEN, None),
        (None, None, SEEN),
    ],
)
def test_visibility_is_that_of_the_nearest_clicks(before, after, expected):
    clicks = [click(0, SEEN), click(99, SEEN), click(4, OUTSIDE, "left_hand"), click(5, OUTSIDE)]
    clicks = clicks if before is not None and after is not None else clicks[2:]
    clicks += [click(2, before)] if before is not None else []
    clicks += [click(8, after)] if after is not None else []
    clicks.append(replace(click(4, GUESSED), deleted=True))
    assert NearestClicks(clicks).visibility(ClickKey(5, "N", "head")) == expected
    found = acceptable((predicted(1.0),), clicks, CAMERAS)
    assert [one.visibility for one in found.predictions] == [expected] * (expected is not None)


def test_what_was_accepted_in_several_images_tells_the_fit_once():
    by_hand = click(0, SEEN)
    taken = [replace(click(0, SEEN, name=name), origin=ACCEPTED) for name in ("S", "O", "W", "E")]
    other = replace(click(1, SEEN), origin=ACCEPTED)
    found = measurements([by_hand, *taken, other], ("head",), 3.0)
    assert [one.sigma for one in found] == [3.0, 6.0, 6.0, 6.0, 6.0, 3.0]

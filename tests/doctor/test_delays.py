"""Limbs that move in space tell which view shows them late."""

import dataclasses
import re

import numpy as np
import pytest

from stereotrack_core.doctor.clocks import check_delays, delay_of
from stereotrack_core.geometry.transform import RigidTransform


@dataclasses.dataclass(frozen=True)
class Points:
    """What a view measured, in the world already."""

    points: np.ndarray

    def placed(self, place):
        return self.points


SIDES = {"N": (0.0, 0.05), "O": (0.05, 0.0), "S": (0.0, -0.05)}


def seen(k, side):
    """A trunk and an arm that swings about the shoulder, from one side."""
    rng = np.random.default_rng(5)
    angle = 1.2 * np.sin(0.21 * k) + 0.5 * np.sin(0.083 * k + 1.0)
    along = rng.uniform(0.1, 0.7, (120, 1))
    arm = [0.2, 0.0, 1.4] + along * [np.cos(angle), 0.0, np.sin(angle)]
    trunk = rng.uniform([-0.2, 0.0, 0.8], [0.2, 0.0, 1.5], (200, 3))
    points = np.concatenate([arm, trunk])
    return Points(points + np.append(SIDES[side], 0.0) + 0.005 * rng.normal(size=points.shape))


def instants(late, views="NOS", length=40):
    return [{v: seen(k - late.get(v, 0), v) for v in views} for k in range(length)]


def places(views):
    return dict.fromkeys(views, RigidTransform.identity())


def test_views_in_step_have_no_findings():
    given = instants({})
    assert not list(check_delays(given, places("NOS"), 10.0))
    assert abs(delay_of(given, places("NOS"), "N")[0]) < 0.3


@pytest.mark.parametrize("late", [8, 1.4, -5])
def test_the_view_that_is_late_is_named_and_measured(late):
    [finding] = check_delays(instants({"O": late}), places("NOS"), 10.0)
    assert finding.where == "view O"
    assert finding.severity == ("error" if abs(late) > 2 else "warning")
    frames = float(re.search(r"([0-9.]+) frames", finding.what)[1])
    assert frames == pytest.approx(abs(late), abs=0.3)
    assert ("later" if late > 0 else "earlier") in finding.what
    assert "tested" in finding.remedy


def test_of_two_views_both_are_named():
    [finding] = check_delays(instants({"O": 6}, "NO"), places("NO"), 10.0)
    assert finding.where == "views N, O"
    assert "later than view N" in finding.what
    assert "streams of view O larger by 6" in finding.remedy


def test_stillness_proves_nothing():
    still = [{v: seen(3, v) for v in "NOS"}] * 40
    assert delay_of(still, places("NOS"), "N") is None

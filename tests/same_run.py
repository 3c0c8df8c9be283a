"""Whether two runs are the same to the last bit."""

import numpy as np

from stereotrack_core.tracking.estimate import Estimate
from stereotrack_core.tracking.frame import Run

_OF_ESTIMATE = (
    *("x", "P", "unexplained_fraction", "residual", "innovation"),
    *("limb_sigma_deg", "limb_lost"),
)


def assert_same_estimate(one: Estimate, other: Estimate) -> None:
    """Compare number by number, to the last bit."""
    for name in _OF_ESTIMATE:
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name), err_msg=name)
    np.testing.assert_array_equal(one.pose.rotations, other.pose.rotations)


def same_run(one: Run, other: Run) -> bool:
    """Compare number by number; how long the runs took is left out."""
    return all(
        np.array_equal(getattr(one, name), getattr(other, name), equal_nan=name != "tracked")
        for name in ("frame", "landmarks", "tracked", *_OF_ESTIMATE)
    )

"""Whether two runs are the same to the last bit."""

import numpy as np

from stereotrack_core.tracking.frame import Run

_NUMBERS = (
    *("frame", "landmarks", "x", "P", "unexplained_fraction", "residual", "innovation"),
    *("limb_sigma_deg", "limb_lost", "tracked"),
)


def same_run(one: Run, other: Run) -> bool:
    """Compare number by number; how long the runs took is left out."""
    return all(
        np.array_equal(getattr(one, name), getattr(other, name), equal_nan=name != "tracked")
        for name in _NUMBERS
    )

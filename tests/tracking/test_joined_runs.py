"""Runs that were packed in stretches."""

import numpy as np

from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.lockstep import joined


def stretch(first, count, stages):
    frames = np.arange(first, first + count)
    return Run(
        frame=frames,
        landmarks=np.full((count, 9, 3), 0.1 * first),
        x=np.zeros((count, 2)),
        P=np.zeros((count, 2, 2)),
        state_names=("a", "b"),
        tracked=np.ones(count, dtype=bool),
        unexplained_fraction=np.zeros(count),
        residual=np.zeros(count),
        innovation=np.zeros(count),
        limb_sigma_deg=np.zeros((count, 6)),
        limb_lost=np.zeros((count, 6)),
        seconds=np.full((count, len(stages)), 0.5),
        stage_names=stages,
        meta={"first": first},
    )


def test_stretches_become_one_run():
    whole = joined([stretch(0, 3, ("read", "track")), stretch(3, 2, ("track", "search"))])
    assert whole.frame.tolist() == [0, 1, 2, 3, 4]
    assert whole.landmarks[4, 0, 0] == np.float64(0.1 * 3)
    assert whole.stage_names == ("read", "track", "search")
    assert whole.seconds[0].tolist() == [0.5, 0.5, 0.0]
    assert whole.seconds[4].tolist() == [0.0, 0.5, 0.5]
    assert whole.meta == {"first": 3}

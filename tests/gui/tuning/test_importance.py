"""What the panel of trials says about the importance of parameters."""

import numpy as np

from app.features.tune.controller import effects_in_words
from app.session.judgement import MEASURED_LIMBS, Judgement
from stereotrack_core.tracking.presets import preset

FRAMES = np.arange(4)


class Entry:
    """As much of a run or trial as is asked for."""

    def __init__(self, **changes):
        self.settings = preset("fast").replaced(**changes)

    def made_with(self):
        return self.settings


def judged(degrees):
    limbs = {limb: np.full(4, degrees) for limb in MEASURED_LIMBS}
    return Judgement("error", FRAMES, limbs, np.ones(4, dtype=bool), np.zeros(4), None)


def test_the_parameter_that_matters_is_named_with_its_range():
    run = Entry()
    trials = [
        Entry(iterations=9),
        Entry(iterations=9, data_points=500),
        Entry(data_points=500),
        Entry(data_points=300),
    ]
    degrees = (8.0, 5.0, 5.2, 8.1, 8.0)
    judgements = {e: judged(d) for e, d in zip((run, *trials), degrees, strict=True)}
    words = effects_in_words(run, trials, judgements)
    first, *others = words.split(", ")
    assert first.startswith("iterations ")
    assert first.endswith("(-2.9 to 0.0 °)")
    assert others == ["data points none"]
    assert effects_in_words(run, trials[:2], judgements) == "", "too few trials"

"""Errors of a run in few words, always with how good the reference is that says so."""

from __future__ import annotations

import numpy as np

from ..widgets.style.limb_colours import limb_words
from .judgement import MEASURED_LIMBS, Judgement
from .truth import arms_good_to, measure_of, with_quality


def heading_words(judgement: Judgement) -> tuple[str, str, str]:
    """What the plot shows and how good that is: in full, briefly, and limb by limb."""
    if judgement.truth is None:
        return judgement.words, "", ""
    good = arms_good_to(judgement.quality)
    full = with_quality(judgement.words, good)
    if full == judgement.words:
        return full, "", f"Against {judgement.truth.words}, which does not say how good it is."
    limbs = ", ".join(
        f"{limb_words(limb)} {judgement.quality[measure_of(limb)]:.1f}°"
        for limb in MEASURED_LIMBS
        if measure_of(limb) in judgement.quality
    )
    tip = f"Against {judgement.truth.words}, which is good to: {limbs}."
    return f"{full}° (arms)", f"good to {good:.1f}°", tip


def score_words(judgement: Judgement | None, *, short: bool = False) -> str:
    """Median over frames and arm segments, or how uncertain the tracker is where no truth is."""
    if judgement is None:
        return ""
    arms = [values for limb, values in judgement.limbs.items() if "arm" in limb]
    values = np.concatenate(arms) if arms else np.empty(0)
    values = values[np.isfinite(values)]
    if not len(values):
        return ""
    sign = "" if judgement.measure == "error" else "± "
    stated = with_quality(f"{sign}{np.median(values):.1f}°", arms_good_to(judgement.quality))
    return stated.replace("reference good", "good") if short else stated

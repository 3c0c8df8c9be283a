"""What a comparison says, in plain words."""

from __future__ import annotations

from stereotrack_core.evaluation.comparison.compare import Comparison, MeasuredDifference

_UNITS = {"%": "percentage points"}
_DIGITS = 1


def verdict(measure: MeasuredDifference, first: str, second: str) -> str:
    """``B is better by 1.2 deg (0.8 to 1.6)``, or why nothing can be said."""
    found = measure.paired
    if not found.frames:
        return "not known of both"
    if found.better == 0.0 and found.worse == 0.0:
        return "the same in every frame"
    unit = _UNITS.get(measure.unit, measure.unit)
    winner = second if found.difference < 0 else first
    by = magnitude(abs(found.difference))
    if not found.enough:
        return f"{winner} is lower by {by} {unit}; too few independent frames to tell"
    if not found.differs:
        return "no difference that these frames can show"
    near, far = sorted((abs(found.low), abs(found.high)))
    return f"{winner} is better by {by} {unit} ({magnitude(near)} to {magnitude(far)})"


def magnitude(value: float) -> str:
    """A number with one digit after the point, or with more where it would read 0.0."""
    digits = _DIGITS
    while digits < 6 and 0.0 < abs(value) < 0.95 * 10.0**-digits:
        digits += 1
    return f"{value:.{digits}f}"


def how_it_is_made(comparison: Comparison) -> str:
    """What intervals and verdicts rest on."""
    count, (shortest, longest) = len(comparison.frames), comparison.blocks
    frames = f"{count} frame{'' if count == 1 else 's'}"
    if not longest:
        return f"Differences are paired over {frames}, too few to tell more."
    blocks = f"{shortest}" if shortest == longest else f"{shortest} to {longest}"
    return (
        f"Differences are paired over {frames} that all runs have. Intervals hold the true "
        f"difference in about 95 of 100 cases: they are made from blocks of {blocks} successive "
        "frames, because neighbouring frames are alike. Of twenty comparisons of equals one "
        "shows a difference by chance."
    )

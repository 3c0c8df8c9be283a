"""What is known about one tracked frame, as rows of a table."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.counting import spread_words
from stereotrack_core.tracking.frame import TrackedFrame

from ...session.judgement import UNCERTAIN_DEG, Judgement, doubts
from ...session.truth import TORSO_POSITION, measure_of, with_quality
from ...widgets.style.limb_colours import limb_words


def number_rows(
    tracked: TrackedFrame | None, judgement: Judgement | None
) -> list[tuple[str, str, str, str]]:
    """Rows of the numbers panel: limb, label, value, hint."""
    if tracked is None:
        return []
    rows = []
    place = _place(judgement, tracked.frame)
    quality = _quality(judgement, tracked.frame)
    unsure = {doubt.limb: doubt.words for doubt in doubts(tracked)}
    errors = judgement.errors_at(tracked.frame) if judgement is not None else {}
    for index, limb in enumerate(LIMBS):
        sigma = tracked.estimate.limb_sigma_deg[index]
        value = spread_words(sigma)
        value = f"± {value}" if value != "unknown" else value
        error = errors.get(limb)
        if error is not None:
            stated = with_quality(f"{error:.1f}°", quality.get(measure_of(limb)))
            value = f"{stated}  ({value})"
        chance = tracked.estimate.limb_lost[index]
        if chance == chance:
            value += f", failure probability {100.0 * chance:.0f} %"
        missed = "far off, not flagged" if error is not None and error > UNCERTAIN_DEG else ""
        hint = unsure.get(limb, missed)
        rows.append((limb, limb_words(limb), value, hint))
    rows += _frame_rows(tracked, judgement, place)
    return rows


def _frame_rows(
    tracked: TrackedFrame, judgement: Judgement | None, place: int | None
) -> list[tuple[str, str, str, str]]:
    rows = []
    if judgement is not None and judgement.errors is not None and place is not None:
        errors = judgement.errors
        at = {int(k): i for i, k in enumerate(errors.frame)}.get(tracked.frame)
        if at is not None:
            good = _quality(judgement, tracked.frame).get(TORSO_POSITION)
            value = with_quality(f"{1000.0 * errors.torso_position[at]:.0f} mm", good, digits=0)
            rows.append(
                (
                    "torso",
                    "torso position",
                    value,
                    "Distance of the hip midpoint from the reference.",
                )
            )
    if not tracked.tracked:
        return [*rows, ("", "not tracked", tracked.reason, "Why this frame has no pose.")]
    total = 1000.0 * sum(tracked.seconds.values())
    time = ("", "time", f"{total:.0f} ms", _stages(tracked))
    if not np.isfinite(tracked.estimate.unexplained_fraction):
        none = "Without depth there is no cloud. The pose is measured by keypoints and contours."
        return [*rows, ("", "points", "none", none), time]
    return [
        *rows,
        (
            "",
            "unexplained fraction",
            f"{100.0 * tracked.estimate.unexplained_fraction:.1f} %",
            "Fraction of the measured points that the model does not explain; 0 is ideal.",
        ),
        (
            "",
            "residual",
            f"{1000.0 * tracked.estimate.residual:.1f} mm",
            "Weighted root mean square distance between points and model.",
        ),
        (
            "",
            "normalised innovation",
            f"{tracked.estimate.innovation:.2f}",
            "Distance of the points from the prediction, relative to its predicted standard "
            "deviation; 1 is expected.",
        ),
        time,
    ]


def _stages(tracked: TrackedFrame) -> str:
    stages = [f"{name} {1000.0 * value:.0f} ms" for name, value in tracked.seconds.items()]
    return "Stages: " + ", ".join(stages) + ". Processing of consecutive frames overlaps."


def _quality(judgement: Judgement | None, frame: int) -> Mapping[str, float]:
    """How good the reference is in one frame."""
    return judgement.quality_over(np.array([frame])) if judgement is not None else {}


def _place(judgement: Judgement | None, frame: int) -> int | None:
    if judgement is None:
        return None
    found = (judgement.frame == frame).nonzero()[0]
    return int(found[0]) if len(found) else None

"""Runs beside each other in numbers, over the frames that all of them have."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from app.limb_colours import limb_words
from app.presenters.judgement import MEASURED_LIMBS, Judgement
from app.presenters.runs import RunEntry
from app.presenters.truth import measure_of, with_quality
from stereotrack_core.arrays import FloatArray, IntArray

LOST_DEG = 45.0
"""An arm segment farther off than this is lost."""


@dataclass(frozen=True)
class Comparison:
    """Numbers of several runs; the first is what the others are compared with.

    Attributes
    ----------
    words : str
        What is compared, over which frames.
    runs : tuple of str
    rows : tuple of (str, str, tuple of float)
        Limb (empty for none), label with its unit, and a value for each run; less is better.
    """

    words: str
    runs: tuple[str, ...]
    rows: tuple[tuple[str, str, tuple[float, ...]], ...]


def compared(
    entries: Sequence[RunEntry],
    active: RunEntry | None,
    judgements: Mapping[int, Judgement],
    selection: range | None,
) -> Comparison | None:
    """Compare the active run with all others that are shown; None where there is no run.

    Parameters
    ----------
    entries : sequence of RunEntry
    active : RunEntry or None
    judgements : mapping from the id of an entry to its judgement
    selection : range or None
        Frames to which the comparison is limited.
    """
    others = [entry for entry in entries if entry is not active and entry.visible]
    shown = [entry for entry in (active, *others) if entry is not None and id(entry) in judgements]
    if not shown or shown[0] is not active:
        return None
    known = [judgements[id(entry)] for entry in shown]
    frames = known[0].frame
    for judgement in known[1:]:
        frames = np.intersect1d(frames, judgement.frame)
    if selection is not None:
        frames = frames[(frames >= selection.start) & (frames < selection.stop)]
    return Comparison(
        words=_words(known[0], frames, selected=selection is not None, several=len(known) > 1),
        runs=tuple(entry.name for entry in shown),
        rows=_rows(known, frames),
    )


def _words(judgement: Judgement, frames: IntArray, *, selected: bool, several: bool) -> str:
    if not len(frames):
        return "These runs have no frame in common."
    where = "in the selection" if selected else "of the run"
    if several:
        where = f"that all runs have{' in the selection' if selected else ''}"
    count = f"{len(frames)} frame{'' if len(frames) == 1 else 's'}"
    against = f", against {judgement.truth.words}" if judgement.truth is not None else ""
    return f"Median {judgement.words} over {count} {where}{against}."


def _rows(
    judgements: Sequence[Judgement], frames: IntArray
) -> tuple[tuple[str, str, tuple[float, ...]], ...]:
    inside = [np.isin(judgement.frame, frames) for judgement in judgements]
    pairs = list(zip(judgements, inside, strict=True))
    quality = judgements[0].quality_over(frames)
    rows = [
        (
            limb,
            with_quality(f"{limb_words(limb)} [°]", quality.get(measure_of(limb))),
            tuple(_median(j.limbs[limb][k]) for j, k in pairs),
        )
        for limb in MEASURED_LIMBS
    ]
    if all(judgement.errors is not None for judgement in judgements):
        rows.append(("", "arms lost [%]", tuple(_lost(j, k) for j, k in pairs)))
    rows.append(("", "unexplained [%]", tuple(100 * _median(j.coverage[k]) for j, k in pairs)))
    missing = tuple(float(np.count_nonzero(~j.tracked[k])) for j, k in pairs)
    rows.append(("", "frames not tracked", missing))
    return tuple(rows)


def _median(values: FloatArray) -> float:
    known = values[np.isfinite(values)]
    return float(np.median(known)) if len(known) else float("nan")


def _lost(judgement: Judgement, inside: np.ndarray[tuple[int], np.dtype[np.bool_]]) -> float:
    arms = [values[inside] for limb, values in judgement.limbs.items() if "arm" in limb]
    known = np.concatenate(arms)
    known = known[np.isfinite(known)]
    return 100.0 * float(np.mean(known > LOST_DEG)) if len(known) else float("nan")

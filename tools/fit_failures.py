"""Fits the coefficients by which failures are found without truth, on simulated recordings alone.

``python tools/fit_failures.py FOLDER`` simulates the recordings below into the folder (those that
are there already are taken as they are), tracks each with several presets and choices of views, so
that limbs are really lost, and rewrites
``stereotrack_core/evaluation/failure_segments/coefficients.py``. Runs that are in the folder
already are taken as they are too. It takes about an hour. The recordings are others than those that
``tools/fit_lost_limbs.py`` fits on: what a tracker says of the recordings that it was fitted on is
better than it is.
"""

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeAlias

import numpy as np
from logistic import fitted

from stereotrack_core.arrays import BoolArray, FloatArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.evaluation.failure_segments.find import FailureSearch, stretches_of
from stereotrack_core.evaluation.failure_segments.segment import (
    ARM_HALVES,
    SIGNS,
    FailureSegment,
    failure_signs,
    failures_by_signs,
)
from stereotrack_core.interop.run_npz import read_npz, write_npz
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.simulation.make import Simulation, simulate
from stereotrack_core.simulation.rig import SceneOptions
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run import track
from stereotrack_core.tracking.run_spec import RunSpec

WRITTEN = Path(__file__).parents[1] / "stereotrack_core/evaluation/failure_segments/coefficients.py"
SHRINKAGE = 30.0  # examples that speak for slopes of 0 in units of the signs' own spread
# Preset, views and seed of the runs of a recording.
Tracked: TypeAlias = tuple[tuple[str, str, int], ...]
_MANY: Tracked = (
    ("fast", "NOSW", 0), ("fast", "NS", 0), ("fast", "O", 0), ("thesis", "NOSW", 0),
    ("thesis", "NS", 1), ("accurate", "OW", 0), ("accurate", "S", 0),
)  # fmt: skip
_QUICK: Tracked = (
    ("fast", "NOSW", 0), ("fast", "NS", 0), ("thesis", "NOSW", 0), ("accurate", "OW", 0),
)  # fmt: skip


def _each_by(views: str) -> Tracked:
    return tuple((used, views, 0) for used in ("fast", "thesis", "accurate"))


_FAST = SceneOptions(pace=3.0)

# What is simulated, and how it is tracked.
RECORDINGS: Mapping[str, tuple[Simulation, Tracked]] = {
    "hA": (Simulation("P1", "travolta+cross-arms+whip", 130, seed=101,
                      options=SceneOptions(pace=1.2)), _MANY),
    "hB": (Simulation("P3", "cross-arms+arms-at-sides+point", 120, seed=102,
                      options=SceneOptions(clothes="plain")), _MANY),
    "hC": (Simulation("P4", "tie-shoes+cross-arms+walk", 130, seed=103,
                      options=SceneOptions(clothes="striped")), _MANY),
    "hD": (Simulation("P2", "whip+cross-arms+travolta", 120, seed=104), _MANY),
    "iA": (Simulation("P1", "cross-arms", 78, "NS", 21), _each_by("NS")),
    "iB": (Simulation("P4", "cross-arms", 78, "NO", 22), _each_by("NO")),
    "iC": (Simulation("P3", "cross-arms", 78, "OW", 31), _each_by("OW")),
    "iD": (Simulation("P2", "cross-arms", 78, "NS", 121), _each_by("NS")),
    "iE": (Simulation("P4", "arms-at-sides", 60, "NO", 36), _each_by("NO")),
    "iF": (Simulation("P2", "whip", 50, seed=23, options=_FAST), _QUICK),
    "iG": (Simulation("P3", "travolta", 50, seed=24, options=_FAST), _QUICK),
    "iH": (Simulation("P4", "travolta", 50, seed=123, options=_FAST), _QUICK),
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class Example:
    """A run with what it is fitted to."""

    recording: str
    run: Run
    fps: float
    truth: tuple[FailureSegment, ...]
    signs: FloatArray  # (F, 6, S)
    failing: BoolArray  # (F, 6). Whether limbs are in failures by error.


def main(arguments: list[str]) -> int:
    """Simulate and track what is missing, fit, say how well it finds what was left out, write."""
    folder = Path(arguments[0])
    examples = []
    for name, (made, runs) in RECORDINGS.items():
        place = folder / "sims" / name
        if not place.exists():
            simulate(place, made)
        for used, views, seed in runs:
            print(name, used, views, seed, flush=True)
            examples.append(example(tracked(folder, place, used, views, seed), place))
    print("each recording classified with weights from the others:", left_out(examples))
    WRITTEN.write_text(written(fitted_by_limb(examples)))
    return 0


def tracked(folder: Path, place: Path, used: str, views: str, seed: int) -> Run:
    """A run that begins in the T pose."""
    file = folder / "runs" / f"{place.name}_{used}_{views}_{seed}.npz"
    if not file.exists():
        file.parent.mkdir(exist_ok=True)
        spec = RunSpec(preset(used), views=tuple(views), seed=seed, init="tpose", preset=used)
        write_npz(file, track(replace(open_recording(place), reference=None), spec))
    return read_npz(file)


def example(run: Run, place: Path) -> Example:
    """A run of a recording with its signs and failures by error."""
    recording = open_recording(place)
    search = FailureSearch(run, recording.fps, recording.reference)
    truth = tuple(one for one in stretches_of(search) if one.found == "truth")
    failing = np.zeros((len(run.frame), len(LIMBS)), dtype=np.bool_)
    for failure in truth:
        inside = (run.frame >= failure.first) & (run.frame <= failure.last)
        failing |= inside[:, None] & np.isin(LIMBS, failure.limbs)
    signs = failure_signs(run, recording.fps)
    return Example(place.name, run, recording.fps, truth, signs, failing)


def fitted_by_limb(examples: Sequence[Example]) -> dict[str, FloatArray]:
    """Coefficients (1 + S,) by their name."""
    failing = np.concatenate([each.failing for each in examples])
    result = {}
    signs = np.concatenate([each.signs for each in examples])
    for half, limbs in ARM_HALVES.items():
        rows = signs[:, list(limbs)].reshape(-1, signs.shape[-1])
        known = np.isfinite(rows).all(axis=1)
        fails = failing[:, list(limbs)].ravel()[known]
        result[half] = fitted(rows[known], fails, SHRINKAGE, rising=True)
    return result


def left_out(examples: Sequence[Example]) -> str:
    """How well failures of each recording are found by coefficients fitted on all others."""
    counts = np.zeros(4)  # true, true and found, found, found and true
    for name in sorted({each.recording for each in examples}):
        fit = fitted_by_limb([each for each in examples if each.recording != name])
        coefficients = {half: slopes.tolist() for half, slopes in fit.items()}
        for each in (one for one in examples if one.recording == name):
            called = failures_by_signs(each.run, each.fps, None, coefficients)
            for k, these, others in ((0, each.truth, called), (2, called, each.truth)):
                both = sum(any(one.overlaps(other) for other in others) for one in these)
                counts[k : k + 2] += len(these), both
    return f"precision {counts[3] / counts[2]:.2f}, recall {counts[1] / counts[0]:.2f}"


def written(coefficients: Mapping[str, FloatArray]) -> str:
    """Text of the module that holds them."""
    lines = ['"""Written by ``tools/fit_failures.py``: a constant, a slope per sign."""']
    for name, values in coefficients.items():
        names = ("constant", *SIGNS)
        rows = [
            f"    {value + 0.0:.4f},  # {sign}" for value, sign in zip(values, names, strict=True)
        ]
        lines += ["", f"{name} = (", *rows, ")"]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

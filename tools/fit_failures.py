"""Fits the coefficients by which failures are found without truth, on simulated recordings alone.

``python tools/fit_failures.py FOLDER`` simulates the recordings below into the folder (those that
are there already are taken as they are), tracks each with several presets and choices of views, so
that limbs are really lost, and rewrites
``stereotrack_core/evaluation/failure_segments/coefficients.py``. Runs that are in the folder
already are taken as they are too. It takes about an hour. The recordings are others than those that
``tools/fit_lost_limbs.py`` fits on: what a tracker says of the recordings that it was fitted on is
better than it is.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TypeAlias

import numpy as np
from logistic import fitted

from stereotrack_core.arrays import BoolArray, FloatArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.evaluation.failure_segments.find import FailureSearch, stretches_of
from stereotrack_core.evaluation.failure_segments.segment import FailureSegment
from stereotrack_core.evaluation.failure_segments.stretches import (
    ARM_HALVES,
    SIGNS,
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
SHRINKAGE = 30.0
"""Examples that speak for slopes of 0 in units of the signs' own spread."""


Tracked: TypeAlias = tuple[tuple[str, str, int], ...]
"""Preset, views and seed of the runs of a recording."""

_MANY: Tracked = (
    ("fast", "NOSW", 0), ("fast", "NS", 0), ("fast", "O", 0), ("thesis", "NOSW", 0),
    ("thesis", "NS", 1), ("accurate", "OW", 0), ("accurate", "S", 0),
)  # fmt: skip
_QUICK: Tracked = (
    ("fast", "NOSW", 0), ("fast", "NS", 0), ("thesis", "NOSW", 0), ("accurate", "OW", 0),
)  # fmt: skip


def _each_by(views: str) -> Tracked:
    return tuple((used, views, 0) for used in ("fast", "thesis", "accurate"))


@dataclass(frozen=True)
class Simulated:
    """A recording to simulate, and how it is tracked."""

    person: str
    motion: str
    frames: int
    seed: int
    options: Mapping[str, str | float] = field(default_factory=dict)
    views: str = "NOSW"
    tracked: Tracked = _MANY


RECORDINGS: Mapping[str, Simulated] = {
    "hA": Simulated("P1", "travolta+cross-arms+whip", 130, 101, {"pace": 1.2}),
    "hB": Simulated("P3", "cross-arms+arms-at-sides+point", 120, 102, {"clothes": "plain"}),
    "hC": Simulated("P4", "tie-shoes+cross-arms+walk", 130, 103, {"clothes": "striped"}),
    "hD": Simulated("P2", "whip+cross-arms+travolta", 120, 104),
    "iA": Simulated("P1", "cross-arms", 78, 21, views="NS", tracked=_each_by("NS")),
    "iB": Simulated("P4", "cross-arms", 78, 22, views="NO", tracked=_each_by("NO")),
    "iC": Simulated("P3", "cross-arms", 78, 31, views="OW", tracked=_each_by("OW")),
    "iD": Simulated("P2", "cross-arms", 78, 121, views="NS", tracked=_each_by("NS")),
    "iE": Simulated("P4", "arms-at-sides", 60, 36, views="NO", tracked=_each_by("NO")),
    "iF": Simulated("P2", "whip", 50, 23, {"pace": 3.0}, tracked=_QUICK),
    "iG": Simulated("P3", "travolta", 50, 24, {"pace": 3.0}, tracked=_QUICK),
    "iH": Simulated("P4", "travolta", 50, 123, {"pace": 3.0}, tracked=_QUICK),
}


@dataclass(frozen=True, eq=False)
class Example:
    """A run with what it is fitted to.

    Attributes
    ----------
    recording : str
    run : Run
    fps : float
    truth : tuple of FailureSegment
    signs : (F, 6, S) float64
    failing : (F, 6) bool
        Whether limbs are in failures by error.
    """

    recording: str
    run: Run
    fps: float
    truth: tuple[FailureSegment, ...]
    signs: FloatArray
    failing: BoolArray


def main(arguments: list[str]) -> int:
    """Simulate and track what is missing, fit, say how well it finds what was left out, write."""
    folder = Path(arguments[0])
    examples = []
    for name, made in RECORDINGS.items():
        place = folder / "sims" / name
        if not place.exists():
            options = SceneOptions().replaced(**made.options)
            simulate(
                place,
                Simulation(
                    person=made.person,
                    motion=made.motion,
                    frames=made.frames,
                    views=made.views,
                    seed=made.seed,
                    options=options,
                ),
            )
        for used, views, seed in made.tracked:
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
        recording = replace(open_recording(place), reference=None)
        run = track(
            recording,
            RunSpec(preset(used), views=tuple(views), seed=seed, init="tpose", preset=used),
        )
        write_npz(file, run)
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

"""Fits the coefficients by which episodes are found without truth, on simulated recordings alone.

``python tools/fit_episodes.py FOLDER`` simulates the recordings below into the folder (those that
are there already are taken as they are), tracks each with several presets and choices of views, so
that limbs are really lost, and rewrites ``stereotrack_core/evaluation/episodes/coefficients.py``.
Runs that are in the folder already are taken as they are too. It takes about half an hour. The
recordings are others than those that ``tools/fit_lost_limbs.py`` fits on: what a tracker says of
the recordings that it was fitted on is better than it is.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from logistic import fitted

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.skeleton import FOREARMS, UPPER_ARMS
from stereotrack_core.evaluation.episodes.rules import EpisodeRules
from stereotrack_core.evaluation.episodes.signs import EPISODE_SIGNS, episode_signs
from stereotrack_core.evaluation.errors import errors_against
from stereotrack_core.interop.run_npz import read_npz, write_npz
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.simulation.make import simulate
from stereotrack_core.simulation.options import SceneOptions
from stereotrack_core.tracking.pipeline import track
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run import Run

WRITTEN = Path(__file__).parents[1] / "stereotrack_core/evaluation/episodes/coefficients.py"
SAID = (
    "lost", "lost around", "lost most around", "lost of the neighbour", "sigma", "sigma around",
    "jerk most around",
)  # fmt: skip
"""Signs used where the run says how likely limbs are lost: that knows already what is near."""

UNSAID = tuple(sign for sign in EPISODE_SIGNS if not sign.startswith("lost"))
"""Signs used where it does not."""

SHRINKAGE = 30.0
"""Examples that speak for slopes of 0 in units of the signs' own spread."""


@dataclass(frozen=True)
class Simulated:
    """A recording to simulate."""

    person: str
    motion: str
    frames: int
    seed: int
    options: Mapping[str, str | float]


RECORDINGS: Mapping[str, Simulated] = {
    "hA": Simulated("P1", "travolta+cross-arms+whip", 130, 101, {"pace": 1.2}),
    "hB": Simulated("P3", "cross-arms+arms-at-sides+point", 120, 102, {"clothes": "plain"}),
    "hC": Simulated("P4", "tie-shoes+cross-arms+walk", 130, 103, {"clothes": "striped"}),
    "hD": Simulated("P2", "whip+cross-arms+travolta", 120, 104, {}),
}
TRACKED: tuple[tuple[str, str, int], ...] = (
    ("fast", "NOSW", 0), ("fast", "NS", 0), ("fast", "O", 0), ("thesis", "NOSW", 0),
    ("thesis", "NS", 1), ("accurate", "OW", 0), ("accurate", "S", 0),
)  # fmt: skip
"""Preset, views and seed of the runs of each recording."""


def main(arguments: list[str]) -> int:
    """Simulate and track what is missing, fit, write."""
    folder = Path(arguments[0])
    runs = []
    for name, made in RECORDINGS.items():
        place = folder / "sims" / name
        if not place.exists():
            options = SceneOptions().replaced(**made.options)
            simulate(
                place, person=made.person, motion=made.motion, frames=made.frames,
                seed=made.seed, options=options,
            )  # fmt: skip
        for used, views, seed in TRACKED:
            print(name, used, views, seed, flush=True)
            runs.append(tracked(folder, place, used, views, seed))
    WRITTEN.write_text(written(fitted_by_limb(runs)))
    return 0


def tracked(folder: Path, place: Path, used: str, views: str, seed: int) -> tuple[Run, Path]:
    """A run that begins in the T pose, and its recording's folder."""
    file = folder / "runs" / f"{place.name}_{used}_{views}_{seed}.npz"
    if not file.exists():
        file.parent.mkdir(exist_ok=True)
        recording = replace(open_recording(place), reference=None)
        run = track(
            recording, preset(used), views=tuple(views), seed=seed, init="tpose", preset=used
        )
        write_npz(file, run)
    return read_npz(file), place


def examples(run: Run, place: Path) -> tuple[FloatArray, FloatArray]:
    """Signs (F, 6, S) and errors (F, 6) in degrees of a run's frames."""
    recording = open_recording(place)
    if recording.reference is None:
        raise ValueError(f"{place} has no reference")
    errors = errors_against(run.trajectory(), recording.reference)
    degrees = np.full((len(run.frame), len(LIMBS)), np.nan)
    _, own, other = np.intersect1d(run.frame, errors.frame, return_indices=True)
    for i, limb in enumerate(LIMBS):
        degrees[own, i] = np.degrees(errors.of_limb(limb))[other]
    return episode_signs(run, recording.fps), degrees


def fitted_by_limb(runs: list[tuple[Run, Path]]) -> dict[str, FloatArray]:
    """Coefficients (1 + S,) by their name."""
    found = [examples(run, place) for run, place in runs]
    signs, degrees = (np.concatenate(part) for part in zip(*found, strict=True))
    result = {}
    for name, limbs in (("UPPER_ARM", UPPER_ARMS), ("FOREARM", FOREARMS)):
        rows = signs[:, list(limbs)].reshape(-1, signs.shape[-1])
        error = degrees[:, list(limbs)].ravel()
        known = np.isfinite(error) & np.isfinite(rows).all(axis=1)
        lost = error[known] > EpisodeRules().episode_error
        for used, ending in ((SAID, ""), (UNSAID, "_WITHOUT_LOST")):
            taken = np.where([sign in used for sign in EPISODE_SIGNS], rows[known], 0.0)
            result[f"{name}{ending}"] = fitted(taken, lost, SHRINKAGE)
    return result


def written(coefficients: Mapping[str, FloatArray]) -> str:
    """Text of the module that holds them."""
    lines = ['"""Written by ``tools/fit_episodes.py``: a constant, a slope per sign."""']
    names = ("constant", *EPISODE_SIGNS)
    for name, values in coefficients.items():
        rows = [
            f"    {value + 0.0:.4f},  # {sign}" for value, sign in zip(values, names, strict=True)
        ]
        lines += ["", f"{name} = (", *rows, ")"]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

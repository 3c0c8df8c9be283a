"""Fits the coefficients by which limbs are called lost, on simulated recordings alone.

``python tools/fit_lost_limbs.py FOLDER`` simulates the recordings below into the folder (those that
are there already are taken as they are), tracks each with several presets and choices of views, so
that limbs are really lost, and rewrites ``stereotrack_core/tracking/failure/coefficients.py``. It
takes about half an hour.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from logistic import fitted

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.skeleton import FOREARMS, UPPER_ARMS
from stereotrack_core.evaluation.errors import errors_against
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.simulation.make import simulate
from stereotrack_core.tracking.failure.features import FEATURES, LOST_DEG, with_neighbours
from stereotrack_core.tracking.frame import TrackedFrame
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run import track
from stereotrack_core.tracking.run_spec import RunSpec

PRESETS = ("accurate", "fast", "ekf", "thesis")
WRITTEN = Path(__file__).parents[1] / "stereotrack_core/tracking/failure/coefficients.py"

HEAD = '''"""Written by ``tools/fit_lost_limbs.py``: coefficients of upper arms and of forearms."""

CONSTANTS = ({first:.4f}, {second:.4f})

SLOPES = {{
'''
TAIL = '''
}
"""By feature: upper arm and forearm, by their own value and by their neighbour's."""
'''

SHRINKAGE = 3.0
"""Examples that speak for slopes of 0 in units of the signs' own spread."""


@dataclass(frozen=True)
class Simulated:
    """A recording to simulate, and the choices of its views that are tracked; all when empty."""

    person: str
    motion: str
    frames: int
    views: str
    seed: int
    chosen: tuple[str, ...]


RECORDINGS: Mapping[str, Simulated] = {
    "A": Simulated("P1", "whip+cross-arms+arms-at-sides", 140, "NOSW", 3, ("", "NO", "S")),
    "B": Simulated("P3", "tie-shoes+travolta+cross-arms", 140, "NOSW", 4, ("", "OW")),
    "C": Simulated("P2", "cross-arms+point+travolta", 60, "NOSW", 11, ("", "NS")),
    "D": Simulated("P4", "whip+tie-shoes+arms-at-sides", 80, "NO", 12, ("",)),
    "E": Simulated("P3", "cross-arms+whip+travolta", 80, "OW", 13, ("",)),
    "F": Simulated("P1", "walk+cross-arms+tie-shoes+point", 90, "NOSW", 14, ("", "NS", "W")),
}


def main(arguments: list[str]) -> int:
    """Simulate what is missing, track, fit, write."""
    folder = Path(arguments[0])
    signs, lost = [], []
    for name, made in RECORDINGS.items():
        place = folder / name
        if not place.exists():
            simulate(
                place, person=made.person, motion=made.motion, frames=made.frames,
                views=made.views, seed=made.seed,
            )  # fmt: skip
        for views in made.chosen:
            for used in PRESETS:
                print(name, views or made.views, used, flush=True)
                found = examples(place, used, views or made.views)
                signs.append(found[0])
                lost.append(found[1])
    WRITTEN.write_text(written(fitted_by_limb(np.concatenate(signs), np.concatenate(lost))))
    return 0


def examples(place: Path, used: str, views: str) -> tuple[FloatArray, FloatArray]:
    """Signs (F, 6, S) and errors (F, 6) in degrees of one run that begins in the T pose."""
    recording = open_recording(place)
    frames: list[TrackedFrame] = []
    run = track(
        recording,
        RunSpec(preset(used), views=tuple(views), init="tpose"),
        on_frame=lambda frame: frames.append(frame.without_cloud()),
    )
    if recording.reference is None:
        raise ValueError(f"{place} has no reference")
    errors = errors_against(run.trajectory(), recording.reference)
    judged = {
        f.frame: f.estimate.limb_features for f in frames if f.estimate.limb_features is not None
    }
    known = [k for k, frame in enumerate(errors.frame) if int(frame) in judged]
    degrees = np.full((len(known), 6), np.nan)
    degrees[:, list(UPPER_ARMS)] = np.degrees(errors.upper_arm[known])
    degrees[:, list(FOREARMS)] = np.degrees(errors.forearm[known])
    return np.array([judged[int(errors.frame[k])] for k in known]), degrees


def fitted_by_limb(signs: FloatArray, degrees: FloatArray) -> list[FloatArray]:
    """Coefficients (1 + 2 S,) of upper arms and of forearms."""
    result = []
    signs = with_neighbours(signs)
    for limbs in (UPPER_ARMS, FOREARMS):
        rows = signs[:, list(limbs)].reshape(-1, signs.shape[-1])
        error = degrees[:, list(limbs)].ravel()
        known = np.isfinite(error) & np.isfinite(rows).all(axis=1)
        result.append(fitted(rows[known], error[known] > LOST_DEG, SHRINKAGE))
    return result


def written(coefficients: Sequence[FloatArray]) -> str:
    """Text of the module that holds them."""
    (first, *upper), (second, *fore) = coefficients
    count, lines = len(FEATURES), []
    for k, name in enumerate(FEATURES):
        values = upper[k], fore[k], upper[count + k], fore[count + k]
        lines.append(f'    "{name}": ({", ".join(f"{value:.4f}" for value in values)}),')
    return HEAD.format(first=first, second=second) + "\n".join(lines) + TAIL


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

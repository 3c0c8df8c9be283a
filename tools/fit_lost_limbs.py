"""Fits the coefficients by which limbs are called lost, on simulated recordings alone.

``python tools/fit_lost_limbs.py FOLDER`` simulates the recordings of ``simulated_people.py`` into
the folder (those that are there already are taken as they are), tracks each with several presets
and choices of views, so that limbs are really lost, and rewrites
``stereotrack_core/tracking/failure/coefficients.py``. Examples that are in the folder already are
taken as they are too: delete them when features change. It says how well the limbs of each
recording are judged by coefficients that were fitted without it. ``one`` or ``several`` after the
folder fits the coefficients for one view or for several alone; the others stay. One view takes
about ten minutes, several half an hour.

While it tracks, no limb is called lost, so that the result does not depend on the coefficients
that are there already.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from unittest.mock import patch

import numpy as np
from logistic import fitted
from simulated_people import ONE, PLAIN, SEVERAL, Simulated

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.skeleton import FOREARMS, UPPER_ARMS
from stereotrack_core.evaluation.errors import errors_against
from stereotrack_core.evaluation.summary import CALLED
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.tracking.failure import features
from stereotrack_core.tracking.failure.coefficients import CONSTANTS, SLOPES
from stereotrack_core.tracking.failure.features import FEATURES, LOST_DEG, with_neighbours
from stereotrack_core.tracking.frame import TrackedFrame
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run import track
from stereotrack_core.tracking.run_spec import RunSpec

WRITTEN = Path(__file__).parents[1] / "stereotrack_core/tracking/failure/coefficients.py"

RECORDINGS = {"several": SEVERAL, "one": ONE}

SHRINKAGE = {"several": 3.0, "one": 10.0}
"""Examples that speak for slopes of 0 in units of the signs' own spread."""

WITHOUT_SEARCH = ("search_arms=false", "picture_cost=0")

ARMS = [*UPPER_ARMS, *FOREARMS]
KINDS = ("one depth view", "one stereo view", "two stereo views", "four stereo views")
CLEAR = (0.05, 0.2, 0.5, 0.8)
"""Probabilities between which the table of what is said and what happens is made."""


@dataclass(frozen=True, eq=False)
class Examples:
    """Limbs of one run that begins in the pose that the recording says."""

    recording: str
    kind: str
    """One of :data:`KINDS`."""
    signs: FloatArray
    """(F, 6, S)."""
    degrees: FloatArray
    """(F, 6). Errors; NaN where not known."""


def main(arguments: list[str]) -> int:
    """Simulate what is missing, track, fit, write, and say how good it is."""
    folder, *chosen = arguments
    constants = dict(CONSTANTS)
    slopes: dict[str, Mapping[str, Sequence[float]]] = dict(SLOPES)
    for views in chosen or RECORDINGS:
        runs = list(examples_of(Path(folder), RECORDINGS[views]))
        print(f"{views}: each recording judged with coefficients from the others")
        print(*tables(left_out(runs, SHRINKAGE[views])), sep="\n")
        upper, fore = fitted_by_limb(runs, SHRINKAGE[views])
        constants[views] = float(upper[0]), float(fore[0])
        values = np.stack([upper[1:], fore[1:]]).reshape(2, 2, len(FEATURES)).T.reshape(-1, 4)
        slopes[views] = {name: tuple(own) for name, own in zip(FEATURES, values, strict=True)}
    WRITTEN.write_text(written(constants, slopes))
    return 0


def examples_of(folder: Path, recordings: Mapping[str, Simulated]) -> Iterator[Examples]:
    """Those of all runs of recordings, which are made where they are not there yet."""
    for name, made in recordings.items():
        for views, used in product(made.chosen, made.presets):
            seen = views or made.views
            file = folder / "examples" / f"{name}_{seen}_{used}.npz"
            if not file.exists():
                print(file.stem, flush=True)
                made.make(folder / name)
                signs, degrees = judged_run(folder / name, used, seen, made.init)
                file.parent.mkdir(exist_ok=True)
                np.savez_compressed(file, signs=signs, degrees=degrees)
            with np.load(file) as stored:
                yield Examples(name, kind_of(made, seen), stored["signs"], stored["degrees"])


def kind_of(made: Simulated, views: str) -> str:
    """One of :data:`KINDS`."""
    if made.options.get("kind") == "depth":
        return "one depth view"
    return {1: "one stereo view", 2: "two stereo views", 4: "four stereo views"}[len(views)]


def judged_run(place: Path, used: str, views: str, init: str) -> tuple[FloatArray, FloatArray]:
    """Signs (F, 6, S) and errors (F, 6) in degrees of one run."""
    recording = open_recording(place)
    if recording.reference is None:
        raise ValueError(f"{place} has no reference")
    frames: list[TrackedFrame] = []
    settings = preset("accurate", WITHOUT_SEARCH) if used == PLAIN else preset(used)
    with patch.object(features, "failure_probability", nothing_lost):
        run = track(
            replace(recording, reference=None),
            RunSpec(settings, views=tuple(views), init=init),
            on_frame=lambda frame: frames.append(frame.without_cloud()),
        )
    errors = errors_against(run.trajectory(), recording.reference)
    judged = {
        f.frame: f.estimate.limb_features for f in frames if f.estimate.limb_features is not None
    }
    known = [k for k, frame in enumerate(errors.frame) if int(frame) in judged]
    degrees = np.full((len(known), 6), np.nan)
    degrees[:, list(UPPER_ARMS)] = np.degrees(errors.upper_arm[known])
    degrees[:, list(FOREARMS)] = np.degrees(errors.forearm[known])
    return np.array([judged[int(errors.frame[k])] for k in known]), degrees


def nothing_lost(_features: FloatArray | None, _views: str) -> FloatArray:
    """Probabilities (6,) in place of those that are to be fitted."""
    return np.zeros(6)


def fitted_by_limb(runs: Sequence[Examples], shrinkage: float) -> list[FloatArray]:
    """Coefficients (1 + 2 S,) of upper arms and of forearms."""
    result = []
    signs = np.concatenate([with_neighbours(run.signs) for run in runs])
    degrees = np.concatenate([run.degrees for run in runs])
    for limbs in (UPPER_ARMS, FOREARMS):
        rows = signs[:, list(limbs)].reshape(-1, signs.shape[-1])
        error = degrees[:, list(limbs)].ravel()
        known = np.isfinite(error) & np.isfinite(rows).all(axis=1)
        result.append(fitted(rows[known], error[known] > LOST_DEG, shrinkage))
    return result


def left_out(runs: Sequence[Examples], shrinkage: float) -> list[tuple[Examples, FloatArray]]:
    """Probabilities (F, 6) of each recording by coefficients that were fitted on all others."""
    result = []
    for name in dict.fromkeys(run.recording for run in runs):
        fit = fitted_by_limb([run for run in runs if run.recording != name], shrinkage)
        constants, slopes = [float(each[0]) for each in fit], np.stack([each[1:] for each in fit])
        for run in runs:
            if run.recording == name:
                free = features.probability_by(run.signs, constants, slopes)
                result.append((run, np.minimum(free, features.bound(run.signs))))
    return result


def tables(judged: Sequence[tuple[Examples, FloatArray]]) -> Iterator[str]:
    """Lines that say for each kind of views how well limbs were judged."""
    for kind in KINDS:
        rows = [(run, chance) for run, chance in judged if run.kind == kind]
        if not rows:
            continue
        degrees = np.concatenate([run.degrees[:, ARMS] for run, _ in rows]).ravel()
        chance = np.concatenate([chance[:, ARMS] for _, chance in rows]).ravel()
        known = np.isfinite(degrees) & np.isfinite(chance)
        lost, chance = degrees[known] > LOST_DEG, chance[known]
        called = chance > CALLED
        both = np.count_nonzero(lost & called)
        bins = np.digitize(chance, CLEAR)
        shares = ", ".join(
            f"{100 * chance[bins == k].mean():.0f} -> {100 * lost[bins == k].mean():.0f}"
            for k in np.unique(bins)
        )
        yield (
            f"{kind}: {len(lost)} segments, {lost.sum()} lost, {called.sum()} called, {both} both; "
            f"precision {both / max(called.sum(), 1):.2f}, recall {both / max(lost.sum(), 1):.2f}; "
            f"percent stated -> lost: {shares}"
        )


def written(
    constants: Mapping[str, tuple[float, float]],
    slopes: Mapping[str, Mapping[str, Sequence[float]]],
) -> str:
    """Text of the module that holds them."""
    lines = [
        '"""Written by ``tools/fit_lost_limbs.py``: coefficients of upper arms and of forearms."""',
        "",
        "CONSTANTS = {",
        *(f'    "{views}": ({_numbers(own)}),' for views, own in constants.items()),
        "}",
        '"""By the number of views that see the person."""',
        "",
        "SLOPES = {",
    ]
    for views, own in slopes.items():
        rows = [f'        "{name}": ({_numbers(values)}),' for name, values in own.items()]
        lines += [f'    "{views}": {{', *rows, "    },"]
    said = (
        "By views and feature: upper arm and forearm, by their own value and by their neighbour's."
    )
    return "\n".join([*lines, "}", f'"""{said}"""', ""])


def _numbers(values: Sequence[float]) -> str:
    return ", ".join(f"{value:.4f}" for value in values)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

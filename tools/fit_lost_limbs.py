"""Fits the coefficients by which limbs are called lost, on simulated recordings alone.

``python tools/fit_lost_limbs.py FOLDER`` simulates the recordings of ``simulated_people.py`` into
the folder (those that are there already are taken as they are), tracks each with several presets
and choices of views, so that limbs are really lost, and rewrites
``stereotrack_core/tracking/failure/coefficients.py``. The pose detector has to be installed. Every
example counts twice, with its keypoints and without, so that the probability holds in both cases.
Examples that are in the folder already are taken as they are too: delete them when features change.
The tool says how well the limbs of each recording are judged by coefficients that were fitted
without it, and how many errors of angles lie within the stated intervals. It takes about half an
hour.

While it tracks, no limb is called lost, so that the result does not depend on the coefficients
that are there already.
"""

import sys
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from unittest.mock import patch

import numpy as np
import scipy.stats
from logistic import fitted
from simulated_people import RECORDINGS, TRACKED

from stereotrack_core.arrays import BoolArray, FloatArray
from stereotrack_core.body.model import body_of_subject
from stereotrack_core.body.skeleton import FOREARMS, TORSO, UPPER_ARMS
from stereotrack_core.evaluation.summary import CALLED, errors_against
from stereotrack_core.pose_model.installation import is_installed
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.tracking.detecting import seen_keypoints
from stereotrack_core.tracking.estimate import views_named
from stereotrack_core.tracking.failure import features
from stereotrack_core.tracking.failure.features import (
    FEATURES,
    LOST_DEG,
    carried_on,
    coefficients_of,
    with_neighbours,
)
from stereotrack_core.tracking.frame import TrackedFrame
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run import track
from stereotrack_core.tracking.run_spec import RunSpec

WRITTEN = Path(__file__).parents[1] / "stereotrack_core/tracking/failure/coefficients.py"

SHRINKAGE = 3.0  # examples that speak for slopes of 0 in units of the signs' own spread
# Numbers of views, and runs with how many their coefficients are fitted on. Limbs of recordings
# that were left out, with two and with four views, are judged best by coefficients of all runs.
FITTED_ON = {"one": ("one",), "several": ("one", "two", "several")}
# Signs of a limb that is not lost; no slope may have the other sign than it should.
FALLING = [FEATURES.index(name) for name in ("visible", "detected")]

OF_DETECTOR = ("disagreement", "detected")
STORED = ("signs", "degrees", "sigma")
ARMS = [*UPPER_ARMS, *FOREARMS]
BINS = 10  # of the same width, in which what is stated is compared with what happens
# Standard deviations of a direction within which so many percent of errors lie: they have two
# normally distributed components, and the standard deviation is that of both together.
INTERVALS = {50: np.sqrt(np.log(2.0)), 90: np.sqrt(np.log(10.0))}


@dataclass(frozen=True, eq=False)
class Examples:
    """Limbs of one run that begins in the pose that the recording says."""

    recording: str
    views: str  # `one`, `two` or `several`
    used: str  # name in :data:`TRACKED`
    signs: FloatArray  # (F, 6, S)
    degrees: FloatArray  # (F, 6). Errors; NaN where not known.
    sigma: FloatArray  # (F, 6). Stated standard deviations, degrees.


def main(arguments: list[str]) -> int:
    """Simulate what is missing, track, fit, write, and say how good it is."""
    (folder,) = arguments
    if not is_installed():
        raise SystemExit("install the pose detector first: stereotrack detector install")
    runs = list(examples_of(Path(folder)))
    constants, slopes, rests_on = {}, {}, []
    for views in ("one", "two", "several"):
        chosen = [run for run in runs if run.views in FITTED_ON[coefficients_of(views)]]
        judged = [each for each in left_out(chosen) if each[0].views == views]
        print(*tables(views, judged), *coverage([run for run, *_ in judged]), sep="\n")
    for views, fitted_on in FITTED_ON.items():
        chosen = [run for run in runs if run.views in fitted_on]
        upper, fore = fitted_by_limb(chosen)
        constants[views] = float(upper[0]), float(fore[0])
        values = np.stack([upper[1:], fore[1:]]).reshape(2, 2, len(FEATURES)).T.reshape(-1, 4)
        slopes[views] = {name: tuple(own) for name, own in zip(FEATURES, values, strict=True)}
        rests_on.append(described(views, chosen))
    WRITTEN.write_text(written(constants, slopes, rests_on))
    return 0


def examples_of(folder: Path) -> Iterator[Examples]:
    """Those of all runs of recordings, which are made where they are not there yet."""
    for name, made in RECORDINGS.items():
        for views, used in product(made.chosen, made.presets):
            seen = views or made.simulation.views
            file = folder / "examples" / f"{name}_{seen}_{used}.npz"
            if not file.exists():
                print(file.stem, flush=True)
                if not (folder / name).exists():
                    made.make(folder / name, made.simulation)
                signs, degrees, sigma = judged_run(folder / name, used, seen, made.init)
                file.parent.mkdir(exist_ok=True)
                np.savez_compressed(file, signs=signs, degrees=degrees, sigma=sigma)
            with np.load(file) as stored:
                yield Examples(name, views_named(len(seen)), used, *(stored[k] for k in STORED))


def described(views: str, runs: Sequence[Examples]) -> str:
    """What the coefficients of a number of views rest on, as a line."""
    degrees = np.concatenate([run.degrees[:, ARMS].ravel() for run in runs])
    names = ", ".join(dict.fromkeys(run.recording for run in runs))
    return (
        f"{views}: {len(runs)} runs of {names}; "
        f"{np.isfinite(degrees).sum()} segments, {np.count_nonzero(degrees > LOST_DEG)} lost"
    )


def judged_run(place: Path, used: str, views: str, init: str) -> tuple[FloatArray, ...]:
    """Signs (F, 6, S), errors (F, 6) and their standard deviations (F, 6), degrees, of one run."""
    recording = open_recording(place)
    if recording.reference is None:
        raise ValueError(f"{place} has no reference")
    blind, frames = replace(recording, reference=None), dict[int, TrackedFrame]()
    settings = preset(*TRACKED[used])
    with patch.object(features, "failure_probability", lambda *_: np.zeros(6)):
        run = track(
            blind,
            RunSpec(settings, views=tuple(views), init=init),
            on_advance=lambda new: frames.update({one.frame: one for one in new.gained.frames}),
        )
    errors = errors_against(run.trajectory(), recording.reference)
    found = {k: one.estimate.limb_features for k, one in frames.items()}
    signs = {k: each for k, each in found.items() if each is not None}
    if not settings.follows_data:  # it does not look at pictures itself
        signs = with_keypoints(blind, views, frames, signs)
    known = [k for k, frame in enumerate(errors.frame) if int(frame) in signs]
    degrees = np.full((len(known), 6), np.nan)
    degrees[:, TORSO] = np.degrees(errors.torso_long[known])
    degrees[:, list(UPPER_ARMS)] = np.degrees(errors.upper_arm[known])
    degrees[:, list(FOREARMS)] = np.degrees(errors.forearm[known])
    chosen = [int(errors.frame[k]) for k in known]
    sigma = np.array([frames[k].estimate.limb_sigma_deg for k in chosen])
    return np.array([signs[k] for k in chosen]), degrees, sigma


def with_keypoints(
    recording: Recording,
    views: str,
    frames: Mapping[int, TrackedFrame],
    signs: Mapping[int, FloatArray],
) -> dict[int, FloatArray]:
    """Signs (6, S) by frame, with what the detector's keypoints say of the poses."""
    body = body_of_subject(recording.subject, preset("thesis").body)
    columns = [FEATURES.index(name) for name in OF_DETECTOR]
    said, result = np.zeros((6, len(columns))), {}
    with FrameReader(recording, views=list(views)) as reader:
        looks = seen_keypoints(recording, views, reader, preset("fast"))
        assert looks is not None
        body = looks.body(body)
        for k in sorted(signs):
            seen, pose = looks.of(frames[k].cloud, min(frames)), frames[k].estimate.pose
            said = carried_on(said, 1.0 / recording.fps, seen, body, pose)
            result[k] = signs[k].copy()
            result[k][:, columns] = said
    return result


def without_detector(signs: FloatArray) -> FloatArray:
    """The signs (..., S) as they are where no detector looks."""
    result = signs.copy()
    result[..., [FEATURES.index(name) for name in OF_DETECTOR]] = 0.0
    return result


def fitted_by_limb(runs: Sequence[Examples]) -> list[FloatArray]:
    """Coefficients (1 + 2 S,) of upper arms and of forearms."""
    result = []
    every = np.concatenate([run.signs for run in runs])
    signs = with_neighbours(np.concatenate([every, without_detector(every)]))
    degrees = np.tile(np.concatenate([run.degrees for run in runs]), (2, 1))
    rising = np.ones(2 * len(FEATURES))
    rising[[*FALLING, *np.add(FALLING, len(FEATURES))]] = -1.0
    for limbs in (UPPER_ARMS, FOREARMS):
        rows = signs[:, list(limbs)].reshape(-1, signs.shape[-1])
        error = degrees[:, list(limbs)].ravel()
        known = np.isfinite(error) & np.isfinite(rows).all(axis=1)
        found = fitted(rows[known] * rising, error[known] > LOST_DEG, SHRINKAGE, rising=True)
        result.append(np.append(found[0], found[1:] * rising))
    return result


def left_out(runs: Sequence[Examples]) -> list[tuple[Examples, FloatArray, FloatArray]]:
    """Probabilities (F, 6) of each recording by coefficients that were fitted on all others.

    With the detector's keypoints, and without.
    """
    result = []
    for name in dict.fromkeys(run.recording for run in runs):
        fit = fitted_by_limb([run for run in runs if run.recording != name])
        constants, slopes = [float(each[0]) for each in fit], np.stack([each[1:] for each in fit])
        for run in runs:
            if run.recording == name:
                both = (run.signs, without_detector(run.signs))
                seen, blind = (features.probability_by(x, constants, slopes) for x in both)
                result.append((run, seen, blind))
    return result


def tables(views: str, judged: Sequence[tuple[Examples, FloatArray, FloatArray]]) -> Iterator[str]:
    """Lines that say how well limbs were judged, with the detector and without."""
    degrees = np.concatenate([run.degrees[:, ARMS].ravel() for run, *_ in judged])
    seen = [chance[:, ARMS].ravel() for _, chance, _ in judged]
    blind = [chance[:, ARMS].ravel() for _, _, chance in judged]
    for chances, how in ((seen, "with detector"), (blind, "without detector")):
        chance = np.concatenate(chances)
        known = np.isfinite(degrees) & np.isfinite(chance)
        yield f"{views}, {how}: {agreement(chance[known], degrees[known] > LOST_DEG)}"


def agreement(chance: FloatArray, lost: BoolArray) -> str:
    """How probabilities (N,) fit what happened (N,): counts, calibration error, area, bins."""
    called = chance > CALLED
    both = np.count_nonzero(lost & called)
    place = np.minimum((chance * BINS).astype(int), BINS - 1)
    rows = [(place == k, 100 * chance[place == k].mean(), 100 * lost[place == k].mean())
            for k in np.unique(place)]  # fmt: skip
    error = sum(row.sum() * abs(said - true) for row, said, true in rows) / len(chance)
    bins = ", ".join(f"{said:.0f} -> {true:.0f} ({row.sum()})" for row, said, true in rows)
    return (
        f"{len(lost)} segments, {lost.sum()} lost, {called.sum()} called, {both} both; "
        f"calibration error {error / 100:.3f}, area {area_under_roc(chance, lost):.2f}; "
        f"percent stated -> lost (number): {bins}"
    )


def area_under_roc(chance: FloatArray, lost: BoolArray) -> float:
    """Probability that a lost limb has a higher probability (N,) than one that is not lost."""
    if lost.all() or not lost.any():
        return float("nan")
    pairs = np.count_nonzero(lost) * np.count_nonzero(~lost)
    return float(scipy.stats.mannwhitneyu(chance[lost], chance[~lost]).statistic / pairs)


def coverage(runs: Sequence[Examples]) -> Iterator[str]:
    """Lines that say how many errors of limbs that are not lost lie within stated intervals.

    The thesis is left out: its covariance is about something else.
    """
    chosen = [run for run in runs if run.used != "thesis"]
    for name, limbs in (("torso", [TORSO]), ("upper arms", UPPER_ARMS), ("forearms", FOREARMS)):
        degrees = np.concatenate([run.degrees[:, list(limbs)].ravel() for run in chosen])
        sigma = np.concatenate([run.sigma[:, list(limbs)].ravel() for run in chosen])
        kept = (degrees < LOST_DEG) & np.isfinite(sigma)
        ratio = degrees[kept] / sigma[kept]
        inside = (f"{100 * np.mean(ratio < k):.0f} % within {n} %" for n, k in INTERVALS.items())
        wider = [np.percentile(ratio, n) / k for n, k in INTERVALS.items()]
        yield (
            f"{runs[0].views}, {name}: {', '.join(inside)}; "
            f"intervals would have to be {wider[0]:.2f} and {wider[1]:.2f} times as wide"
        )


def written(
    constants: Mapping[str, tuple[float, float]],
    slopes: Mapping[str, Mapping[str, Sequence[float]]],
    rests_on: Sequence[str],
) -> str:
    """Text of the module that holds them."""
    lines = [
        '"""Written by ``tools/fit_lost_limbs.py``: coefficients of upper arms and of forearms."""',
        "",
        "RESTS_ON = (",
        *(f'    "{line}",' for text in rests_on for line in textwrap.wrap(text, 90)),
        ")",
        '"""Recordings and arm segments; each with the detector\'s keypoints and without."""',
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

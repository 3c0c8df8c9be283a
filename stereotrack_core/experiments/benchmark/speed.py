"""Time from encoded images to the pose, against bare block matching on the same images."""

from __future__ import annotations

import importlib
import importlib.util
import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from stereotrack_core.arrays import FloatArray, ImageArray
from stereotrack_core.errors import InputError
from stereotrack_core.filtering.correction import Correction, correct
from stereotrack_core.filtering.sigma_points import SigmaWeights, scaled_weights, sigma_deviations
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.keypoints import Keypoints
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.tracking.frame import TrackedFrame
from stereotrack_core.tracking.initialise.first_pose import FIT_FRAMES
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.pipeline import Pipeline
from stereotrack_core.tracking.run_spec import RunSpec, measured_keypoints

DISPARITIES, WINDOW = 64, 15
_WARM_UP = 3
_MOST_CALLS = 200

_Pairs = Sequence[tuple[ImageArray, ImageArray]]


@dataclass(frozen=True)
class ChainSpeed:
    """Time of the whole chain per frame set, and of block matching alone; medians over rounds."""

    preset: str
    frames: int
    """Frame sets in a round."""
    tracked: int
    """Of them, those that the last round tracked."""
    seconds: float
    """From encoded images to the last pose, over `frames`."""
    preparation_seconds: float
    """What is done once before the first frame."""
    matching_seconds: float
    """Bare StereoBM for all views just before the chain, over `frames`; NaN where not every view is
    a stereo one."""
    stage_ms: Mapping[str, float]
    """By stage, milliseconds: medians over the frames of the last round; stages
    overlap."""

    @property
    def ratio(self) -> float:
        """Time of the chain in units of bare block matching."""
        return self.seconds / self.matching_seconds


def chain_speed(
    recording: Recording,
    presets: Mapping[str, Settings],
    *,
    views: Sequence[str] | None = None,
    frames: int = 40,
    rounds: int = 5,
    on_progress: Callable[[int], None] = lambda _: None,
    keypoints: Keypoints | None = None,
) -> tuple[ChainSpeed, ...]:
    """Alternate bare block matching and the chain with every preset.

    A round has a new pipeline, so that nothing is in a cache. What is done once for a recording,
    learning the background and fitting the shape, is told by itself. Raises InputError where no
    views are given and the recording has no stereo view.

    Parameters
    ----------
    views : sequence of str, optional
        All stereo views when not given.
    frames, rounds : int
        Frame sets in a round, and rounds.
    on_progress : callable, optional
        Told how many passes are done, of ``rounds * len(presets)``.
    keypoints : Keypoints, optional
        That are measured as well, by presets that do so.
    """
    stereo = [view.name for view in recording.views if view.kind == "stereo"]
    views = stereo if views is None else views
    if not views:
        raise InputError(
            "the recording has no stereo view",
            where=str(recording.folder),
            remedy="Use a recording with stereo cameras.",
        )
    with FrameReader(recording, views=views, read_ahead=0) as reader:
        count = min(frames, reader.frame_count)
    pairs = _decoded(recording, views, count) if set(views) <= set(stereo) else ()
    matcher = cv2.StereoBM.create(DISPARITIES, WINDOW)

    def match() -> None:
        for left, right in pairs:
            matcher.compute(left, right)

    specs = {
        name: RunSpec(one, views=views, keypoints=measured_keypoints(recording, one, keypoints))
        for name, one in presets.items()
    }
    for spec in specs.values():
        _timed(recording, spec, min(_WARM_UP, count))
    matching: dict[str, list[float]] = {name: [] for name in presets}
    passes: dict[str, list[_Pass]] = {name: [] for name in presets}
    for turn in range(rounds):
        for k, (name, spec) in enumerate(specs.items(), start=1):
            matching[name].append(seconds_of(match) if pairs else math.nan)
            passes[name].append(_timed(recording, spec, count))
            on_progress(turn * len(presets) + k)
    return tuple(
        ChainSpeed(
            preset=name,
            frames=count,
            tracked=sum(frame.tracked for frame in own[-1].frames),
            seconds=median([one.seconds for one in own]) / count,
            preparation_seconds=median([one.preparation for one in own]),
            matching_seconds=median(matching[name]) / count,
            stage_ms=_stage_ms(own[-1].frames),
        )
        for name, own in passes.items()
    )


def _decoded(recording: Recording, views: Sequence[str], count: int) -> _Pairs:
    """Left and right grey images of the first frames, all views of a frame together."""
    pairs: list[tuple[ImageArray, ImageArray]] = []
    with FrameReader(recording, views=views, colour=False) as reader:
        for k in range(count):
            images = reader.frame_set(k).views
            for name in views:
                left = images[name].left if name in images else None
                if left is None:
                    raise InputError(
                        f"view {name} has no images at frame {k}",
                        where=str(recording.folder),
                        remedy="See `stereotrack info --deep`.",
                    )
                pairs.append((left, images[name].image))
    return pairs


@dataclass(frozen=True)
class _Pass:
    """One round of one preset."""

    seconds: float
    preparation: float
    frames: Sequence[TrackedFrame]


def _timed(recording: Recording, spec: RunSpec, frames: int) -> _Pass:
    """Track with a new pipeline; the clock for the frames starts when the track has settled.

    The shape is fitted to clouds that the first frames use again, so these are not timed.
    """
    found: list[TrackedFrame] = []
    with Pipeline(recording, spec) as pipeline:
        begun = min(FIT_FRAMES, pipeline.reader.frame_count - frames)
        timed = range(begun, begun + frames)
        preparation = seconds_of(lambda: pipeline.prepare(range(timed.stop)))
        for _ in pipeline.frames(range(begun)):
            pass
        seconds = seconds_of(lambda: found.extend(pipeline.frames(timed)))
    return _Pass(seconds, preparation, [frame.without_cloud() for frame in found])


def _stage_ms(frames: Sequence[TrackedFrame]) -> dict[str, float]:
    stages = dict.fromkeys(name for frame in frames for name in frame.seconds)
    return {
        name: 1000.0 * median([frame.seconds.get(name, 0.0) for frame in frames]) for name in stages
    }


def seconds_of(function: Callable[[], object]) -> float:
    """Wall time of one call."""
    begun = time.perf_counter()
    function()
    return time.perf_counter() - begun


def median_seconds(
    functions: Mapping[str, Callable[[], object]],
    *,
    budget: float = 1.0,
) -> dict[str, float]:
    """Median wall time of each function, called in turn so that all see the same machine.

    Parameters
    ----------
    functions : mapping from name to function
        Each is called once before, without being timed, unless that call alone takes longer
        than the budget: then it is the measurement.
    budget : float
        Seconds for each function; one that is slow is called at least once.
    """
    first = {name: seconds_of(function) for name, function in functions.items()}
    spent = dict.fromkeys(functions, 0.0)
    times: dict[str, list[float]] = {name: [] for name in functions}
    for _ in range(_MOST_CALLS):
        waiting = [name for name in functions if spent[name] + first[name] <= budget]
        if not waiting:
            break
        for name in waiting:
            needed = seconds_of(functions[name])
            spent[name] += needed
            times[name].append(needed)
    return {name: median(times[name] or [first[name]]) for name in functions}


def median(values: Sequence[float]) -> float:
    """Median as a plain number."""
    return float(np.median(values))


def exponent(sizes: Sequence[float], times: Sequence[float]) -> float:
    """Exponent e of time ~ size^e by least squares; at most 1 is linear. NaN for a single size."""
    if len(sizes) < 2:
        return math.nan
    return float(np.polyfit(np.log(sizes), np.log(times), 1)[0])


MEASUREMENTS = (64, 256, 1024, 4096)
STATES = 14
_ALPHA, _BETA, _KAPPA = 0.1, 2.0, 0.0


@dataclass(frozen=True)
class CorrectionSpeed:
    """Time of one correction with m measurements."""

    m: int
    seconds: float
    """Of the correction in O(m n^2)."""
    dense_seconds: float
    filterpy_seconds: float | None
    """None where filterpy is not installed."""
    difference: float
    """Largest difference of the corrected state and covariance from the dense form's, in units of
    the state's standard deviations."""


@dataclass(frozen=True, eq=False)
class Problem:
    """One correction to be done: see :func:`stereotrack_core.filtering.correction.correct`."""

    P: FloatArray
    dX: FloatArray
    Y: FloatArray
    z: FloatArray
    R: FloatArray
    weights: SigmaWeights

    @property
    def z_hat(self) -> FloatArray:
        """Weighted mean (m,) of the predicted measurements."""
        result: FloatArray = self.weights.mean @ self.Y
        return result


def make_problem(m: int, seed: int = 0) -> Problem:
    """A nearly linear measurement of a state like the body's."""
    random = np.random.default_rng(seed)
    root = random.normal(0.0, 0.1, (STATES, STATES))
    P = root @ root.T + 0.01 * np.eye(STATES)
    weights = scaled_weights(STATES, _ALPHA, _BETA, _KAPPA)
    dX = sigma_deviations(P, weights)
    H = random.normal(0.0, 1.0, (STATES, m))
    Y = dX @ H + 0.1 * (dX @ random.normal(0.0, 1.0, (STATES, m))) ** 2
    return Problem(P, dX, Y, random.normal(0.0, 0.05, m), np.full(m, 0.02**2), weights)


def fast_form(problem: Problem) -> Correction:
    """Run the program's own correction."""
    z_hat = problem.z_hat
    return correct(
        problem.P,
        problem.dX,
        problem.Y - z_hat,
        problem.weights.covariance,
        problem.z - z_hat,
        problem.R,
    )


def dense_form(problem: Problem) -> Correction:
    """K = P_xz P_zz^-1 as the textbook has it, with the m x m matrix (2.2.1)."""
    z_hat, Wc = problem.z_hat, problem.weights.covariance
    dY = problem.Y - z_hat
    P_zz = (dY.T * Wc) @ dY + np.diag(problem.R)
    P_xz = (problem.dX.T * Wc) @ dY
    K = np.linalg.solve(P_zz, P_xz.T).T
    return Correction(K @ (problem.z - z_hat), problem.P - K @ P_zz @ K.T)


def filterpy_form(problem: Problem) -> Callable[[], Correction] | None:
    """The same correction by filterpy's ``UnscentedKalmanFilter``; None without filterpy.

    The predicted measurements are looked up, so that only the correction is timed.
    """
    if importlib.util.find_spec("filterpy") is None:
        return None
    kalman = importlib.import_module("filterpy.kalman")
    m = len(problem.z)
    points = kalman.MerweScaledSigmaPoints(STATES, _ALPHA, _BETA, _KAPPA)
    rows: list[FloatArray] = list(problem.Y)
    order = iter(rows)
    ukf = kalman.UnscentedKalmanFilter(
        STATES, m, dt=1.0, hx=lambda _: next(order), fx=lambda x, _: x, points=points
    )
    ukf.R = np.diag(problem.R)

    def once() -> Correction:
        nonlocal order
        order = iter(rows)
        ukf.x, ukf.P = np.zeros(STATES), problem.P.copy()
        ukf.sigmas_f = problem.dX
        ukf.update(problem.z)
        return Correction(ukf.x, ukf.P)

    return once


def correction_speed(
    measurements: Sequence[int] = MEASUREMENTS,
    *,
    budget: float = 1.0,
    on_progress: Callable[[int], None] = lambda _: None,
) -> tuple[CorrectionSpeed, ...]:
    """Median times for each m, the forms called in turn with so many seconds for each.

    `on_progress` is told how many sizes are done.
    """
    results = []
    for done, m in enumerate(measurements, start=1):
        problem = make_problem(m)
        forms: dict[str, Callable[[], object]] = {
            "fast": lambda p=problem: fast_form(p),  # type: ignore[misc]
            "dense": lambda p=problem: dense_form(p),  # type: ignore[misc]
        }
        theirs = filterpy_form(problem)
        if theirs is not None:
            forms["filterpy"] = theirs
        times = median_seconds(forms, budget=budget)
        results.append(
            CorrectionSpeed(
                m=m,
                seconds=times["fast"],
                dense_seconds=times["dense"],
                filterpy_seconds=times.get("filterpy"),
                difference=difference(fast_form(problem), dense_form(problem), problem.P),
            )
        )
        on_progress(done)
    return tuple(results)


def difference(a: Correction, b: Correction, P: FloatArray) -> float:
    """Largest difference of two corrections in units of the deviations before, P (n, n)."""
    sigma = np.sqrt(np.diag(P))
    in_state = np.abs(a.dx - b.dx) / sigma
    in_covariance = np.abs(a.P - b.P) / np.outer(sigma, sigma)
    return float(max(in_state.max(), in_covariance.max()))


def growth(speeds: Sequence[CorrectionSpeed]) -> float:
    """Exponent e of time ~ m^e."""
    return exponent([speed.m for speed in speeds], [speed.seconds for speed in speeds])

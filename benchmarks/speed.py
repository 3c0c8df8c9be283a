"""Measure speed as ratios to well-known work on the same machine, in the same run.

- chain: from encoded images to the pose, against plain block matching of the same images
- correction: the correction step against the textbook's form and filterpy's
- growth: processor time of the tracker's step against the number of points (figure 4.4)

``python benchmarks/speed.py RECORDING --only chain``. Run nothing else meanwhile.
"""

from __future__ import annotations

import importlib
import importlib.util
import math
import os
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import cv2
import numpy as np

import stereotrack_core as stereotrack
from benchmarks.common import ended, parser_of, put_table, recordings_of, say
from stereotrack_core.arrays import FloatArray
from stereotrack_core.blas_threads import one_blas_thread
from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import proportions_of
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.errors import InputError
from stereotrack_core.filtering.correction import Correction, correct
from stereotrack_core.filtering.sigma_points import SigmaWeights, scaled_weights, sigma_deviations
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.recording.selection import usable_views
from stereotrack_core.tables import number
from stereotrack_core.tracking.initialise.first_pose import FIT_FRAMES
from stereotrack_core.tracking.initialise.seeds import t_pose_in_cloud
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.pipeline import Pipeline
from stereotrack_core.tracking.run_spec import RunSpec
from stereotrack_core.tracking.shared_clouds import read_cloud
from stereotrack_core.tracking.tracker import cameras_of, tracker_for

PARTS = ("chain", "correction", "growth")
DISPARITIES, WINDOW = 64, 15
MEASUREMENTS = (64, 256, 1024, 4096)
STATES = 14
MODEL_POINTS = (24, 40, 64, 120, 240, 480, 960)
DATA_POINTS = (500, 1000, 2000, 4000, 8000)
_SIGMA_POINTS = (0.1, 2.0, 0.0)  # alpha, beta, kappa
_MOST_CALLS = 200


def seconds_of(function: Callable[[], object]) -> float:
    """Wall time of one call."""
    begun = time.perf_counter()
    function()
    return time.perf_counter() - begun


def exponent(sizes: Sequence[float], times: Sequence[float]) -> float:
    """Exponent e of time ~ size^e by least squares; NaN for a single size."""
    if len(sizes) < 2:
        return math.nan
    return float(np.polyfit(np.log(sizes), np.log(times), 1)[0])


# The whole chain


def chain_table(recording: Recording, presets: Mapping[str, Settings], frames: int) -> None:
    """Time the chain of every preset, and block matching of the same images before it."""
    views = [view.name for view in recording.views if view.kind == "stereo"]
    with FrameReader(recording, read_ahead=0) as reader:
        frames = min(frames, reader.frame_count)
    rows = []
    for name, settings in presets.items():
        say(f"Timing {name} on {recording.name}.")
        spec = RunSpec(settings, name, views=views)
        _chain_seconds(recording, spec, 3)  # compile first
        matching = _matching_seconds(recording, views, frames)
        once, seconds, tracked = _chain_seconds(recording, spec, frames)
        values = (1000.0 * seconds, 1000.0 * matching, seconds / matching, 1.0 / seconds, once)
        rows.append((name, *(number(value) for value in values), f"{tracked} of {frames}"))
    put_table(
        f"{recording.name}: from encoded images to the pose, against StereoBM alone "
        f"({DISPARITIES} disparities, window {WINDOW})",
        ("preset", ">chain ms", ">StereoBM ms", ">ratio", ">frame sets/s", ">once s", ">tracked"),
        rows,
    )


def _matching_seconds(recording: Recording, views: Sequence[str], frames: int) -> float:
    """Seconds per frame set of bare block matching in all views."""
    matcher = cv2.StereoBM.create(DISPARITIES, WINDOW)
    spent = 0.0
    with FrameReader(recording, views=views, colour=False) as reader:
        for k in range(frames):
            found = reader.frame_set(k).views
            for name in views:
                images = found.get(name)
                if images is None or images.left is None:
                    raise InputError(
                        f"view {name} has no images at frame {k}", remedy="Use fewer --frames."
                    )
                begun = time.perf_counter()
                matcher.compute(images.left, images.image)
                spent += time.perf_counter() - begun
    return spent / frames


def _chain_seconds(recording: Recording, spec: RunSpec, frames: int) -> tuple[float, float, int]:
    """Seconds of preparing, seconds per frame set, and how many of these were tracked.

    The clouds that the shape was fitted to are used again for the first frames, so the clock
    starts after these.
    """
    with Pipeline(recording, spec) as pipeline:
        begun = max(0, min(FIT_FRAMES, pipeline.reader.frame_count - frames))
        once = seconds_of(lambda: pipeline.prepare(range(begun + frames)))
        for _ in pipeline.frames(range(begun)):
            pass
        found: list[bool] = []
        timed = pipeline.frames(range(begun, begun + frames))
        seconds = seconds_of(lambda: found.extend(frame.tracked for frame in timed))
    return once, seconds / frames, sum(found)


# The correction step


@dataclass(frozen=True, eq=False)
class Problem:
    """One correction to be done: see :func:`stereotrack_core.filtering.correction.correct`."""

    P: FloatArray
    dX: FloatArray
    Y: FloatArray
    z: FloatArray
    R: FloatArray
    weights: SigmaWeights


def make_problem(m: int, seed: int = 0) -> Problem:
    """Make a nearly linear measurement of a state like the body's."""
    random = np.random.default_rng(seed)
    root = random.normal(0.0, 0.1, (STATES, STATES))
    P = root @ root.T + 0.01 * np.eye(STATES)
    weights = scaled_weights(STATES, *_SIGMA_POINTS)
    dX = sigma_deviations(P, weights)
    H = random.normal(0.0, 1.0, (STATES, m))
    Y = dX @ H + 0.1 * (dX @ random.normal(0.0, 1.0, (STATES, m))) ** 2
    return Problem(P, dX, Y, random.normal(0.0, 0.05, m), np.full(m, 0.02**2), weights)


def fast_form(one: Problem) -> Correction:
    """Correct as the program does, in O(m n^2)."""
    z_hat = one.weights.mean @ one.Y
    return correct(one.P, one.dX, one.Y - z_hat, one.weights.covariance, one.z - z_hat, one.R)


def dense_form(one: Problem) -> Correction:
    """K = P_xz P_zz^-1 as the textbook has it, with the m x m matrix (2.2.1)."""
    z_hat, Wc = one.weights.mean @ one.Y, one.weights.covariance
    dY = one.Y - z_hat
    P_zz = (dY.T * Wc) @ dY + np.diag(one.R)
    P_xz = (one.dX.T * Wc) @ dY
    K = np.linalg.solve(P_zz, P_xz.T).T
    return Correction(K @ (one.z - z_hat), one.P - K @ P_zz @ K.T)


def filterpy_form(one: Problem) -> Correction:
    """Correct by filterpy, which is handed the predicted measurements in their order."""
    kalman = importlib.import_module("filterpy.kalman")
    points, rows = kalman.MerweScaledSigmaPoints(STATES, *_SIGMA_POINTS), iter(list(one.Y))
    ukf = kalman.UnscentedKalmanFilter(
        STATES, len(one.z), dt=1.0, hx=lambda _: next(rows), fx=lambda x, _: x, points=points
    )
    ukf.R, ukf.P, ukf.sigmas_f = np.diag(one.R), one.P.copy(), one.dX
    ukf.update(one.z)
    return Correction(ukf.x, ukf.P)


def difference(a: Correction, b: Correction, P: FloatArray) -> float:
    """Largest difference of two corrections in units of the deviations before, P (n, n)."""
    sigma = np.sqrt(np.diag(P))
    in_covariance = np.abs(a.P - b.P) / np.outer(sigma, sigma)
    return float(max((np.abs(a.dx - b.dx) / sigma).max(), in_covariance.max()))


def correction_table(sizes: Sequence[int], budget: float = 1.0) -> None:
    """Time the forms of the correction in turn, so that all see the same machine."""
    forms = [fast_form, dense_form]
    forms += [filterpy_form] if importlib.util.find_spec("filterpy") else []
    rows, fast = [], []
    for form in forms:
        form(make_problem(16))  # loads and compiles
    for m in sizes:
        problem = make_problem(m)
        spent: list[list[float]] = [[] for _ in forms]
        end = time.perf_counter() + budget * len(forms)
        for _ in range(_MOST_CALLS):
            for form, times in zip(forms, spent, strict=True):
                times.append(seconds_of(partial(form, problem)))
            if time.perf_counter() > end:
                break
        medians = [1000.0 * float(np.median(times)) for times in spent]
        fast.append(medians[0])
        off = difference(fast_form(problem), dense_form(problem), problem.P)
        slower = (f"{number(ms, 2)} ({ms / medians[0]:.0f} times)" for ms in medians[1:])
        rows.append((str(m), number(medians[0], 3), *slower, f"{off:.0e}"))
    names = (">dense ms", ">filterpy ms")[: len(forms) - 1]
    put_table(
        f"Correction with m measurements; time grows as m^{exponent(sizes, fast):.2f}",
        (">m", ">ms", *names, ">difference"),
        rows,
    )


# Growth


def growth_table(recording: Recording, name: str, settings: Settings) -> None:
    """Print how the tracker's step grows with the points."""
    say(f"Timing {name} on {recording.name}.")
    samples = settings.tracking.matching == "model_to_data"
    costs = dict(cost_of_points(recording, settings, MODEL_POINTS if samples else DATA_POINTS))
    power = number(exponent([*costs], [*costs.values()]), 2)
    put_table(
        f"{recording.name}, {name}: the tracker's step grows as points^{power} (processor time)",
        (">points", ">ms", ">ms for each"),
        [(str(n), number(ms), number(ms / n, 3)) for n, ms in costs.items()],
    )


def cost_of_points(
    recording: Recording, settings: Settings, sizes: Sequence[int], frames: int = 10
) -> Iterator[tuple[int, float]]:
    """Give sizes and milliseconds: model points if they are sampled, else measured points.

    Sizes beyond the smallest cloud are left out.
    """
    samples = settings.tracking.matching == "model_to_data"
    dense = settings.replaced(fit_shape=False, **({} if samples else {"pixel_step": 1}))
    with Pipeline(recording, RunSpec(dense, init="tpose")) as pipeline:
        count = min(frames, pipeline.reader.frame_count)
        pipeline.chain.learn_background(pipeline.reader, range(count))
        clouds = [read_cloud(pipeline.chain, pipeline.reader, k)[0] for k in range(count)]
    clouds = [cloud for cloud in clouds if len(cloud.points) >= settings.tracking.least_points]
    most = min((len(cloud.points) for cloud in clouds), default=0)
    for size in sizes:
        if clouds and (samples or size <= most):
            own = dense.replaced(**{"model_points" if samples else "data_points": size})
            yield size, _step_ms(recording, own, clouds)


def _step_ms(recording: Recording, settings: Settings, clouds: Sequence[Cloud]) -> float:
    """Median processor time of the tracker's step, without its failure probability."""
    positions = cameras_of(recording, usable_views(recording, None))
    body = body_model(proportions_of(recording.subject), settings.body)
    tracker = tracker_for(body, settings, positions, recording.fps, 0)
    tracker.start(t_pose_in_cloud(body, clouds[0].points))
    spent = []
    with one_blas_thread():
        tracker.step(clouds[0])
        for cloud in clouds:
            begun = time.process_time()
            estimate = tracker.step(cloud)
            seconds, whole = time.process_time() - begun, sum(estimate.seconds.values())
            spent.append(seconds * (estimate.seconds.get("track", whole) / whole if whole else 1.0))
    return 1000.0 * float(np.median(spent))


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure what is asked for and print the tables."""
    parser = parser_of(__doc__)
    parser.add_argument("--only", action="append", choices=PARTS, help="default: all parts")
    parser.add_argument("--presets", default="fast,accurate,thesis", help="comma-separated")
    parser.add_argument("--set", action="append", default=[], dest="changes", metavar="NAME=VALUE")
    parser.add_argument("--frames", type=int, default=40, help="frame sets of the chain")
    args = parser.parse_args(arguments)
    load = os.getloadavg()[0] / (os.cpu_count() or 1) if hasattr(os, "getloadavg") else 0.0
    if load > 0.7:
        say(f"The machine is busy (load {load:.1f} per core). The results will be inaccurate.")
    parts = args.only or PARTS
    presets = {n: stereotrack.preset(n, args.changes) for n in args.presets.split(",")}
    if "correction" in parts:
        correction_table(MEASUREMENTS)
    if {*parts} == {"correction"}:
        return
    for recording in recordings_of(args, with_reference=False):
        if "chain" in parts:
            chain_table(recording, presets, args.frames)
        for name, settings in presets.items() if "growth" in parts else ():
            growth_table(recording, name, settings)


if __name__ == "__main__":
    sys.exit(ended(main))

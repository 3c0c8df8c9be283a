"""Measure speed as ratios to well-known work on the same machine, in the same run.

- chain: from encoded images to the pose, against plain block matching of the same images
- growth: processor time of the tracker's step against the number of points (figure 4.4)

``python benchmarks/speed.py RECORDING --only chain``. Run nothing else meanwhile.
"""

import dataclasses
import os
import sys
import time
from collections.abc import Iterator, Mapping, Sequence

import cv2
import numpy as np

import stereotrack_core as stereotrack
from benchmarks.common import ended, parser_of, put_table, recordings_of, say
from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import proportions_of
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.errors import InputError
from stereotrack_core.one_thread import one_blas_thread
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.recording.selection import usable_views
from stereotrack_core.tables import number
from stereotrack_core.tracking.clouds import Clouds
from stereotrack_core.tracking.initialise.first_pose import FIT_FRAMES
from stereotrack_core.tracking.initialise.seeds import t_pose_in_cloud
from stereotrack_core.tracking.model import TrackState, cameras_of, model_for, step
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.prepare import prepare
from stereotrack_core.tracking.run import advances
from stereotrack_core.tracking.run_spec import Hooks, RunSpec

PARTS = ("chain", "growth")
DISPARITIES, WINDOW = 64, 15
MODEL_POINTS = (24, 40, 64, 120, 240, 480, 960)
DATA_POINTS = (500, 1000, 2000, 4000, 8000)


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
                    what = f"view {name} has no images at frame {k}"
                    raise InputError(what, remedy="Use fewer --frames.")
                begun = time.perf_counter()
                matcher.compute(images.left, images.image)
                spent += time.perf_counter() - begun
    return spent / frames


def _chain_seconds(recording: Recording, spec: RunSpec, frames: int) -> tuple[float, float, int]:
    """Seconds of preparing, seconds per frame set, and how many of these were tracked.

    The clouds that the shape was fitted to are used again for the first frames, so the clock
    starts after these.
    """
    with FrameReader(recording) as reader:
        begun = max(0, min(FIT_FRAMES, reader.frame_count - frames))
    spec = dataclasses.replace(spec, frames=range(begun + frames))
    with Clouds(recording, spec) as clouds:
        clock = time.perf_counter()
        run = prepare(clouds)
        once, tracked = time.perf_counter() - clock, list[bool]()
        for stretch in (range(begun), range(begun, begun + frames)):
            clock, tracked = time.perf_counter(), []
            for advance in advances(run, stretch):
                run = advance.run
                tracked += [frame.tracked for frame in advance.gained.frames]
        return once, (time.perf_counter() - clock) / frames, sum(tracked)


def growth_table(recording: Recording, name: str, settings: Settings) -> None:
    """Print how the tracker's step grows with the points."""
    say(f"Timing {name} on {recording.name}.")
    samples = settings.tracking.matching == "model_to_data"
    costs = dict(cost_of_points(recording, settings, MODEL_POINTS if samples else DATA_POINTS))
    sizes, times = np.log([*costs]), np.log([*costs.values()])
    power = float(np.polyfit(sizes, times, 1)[0]) if len(costs) > 1 else np.nan
    put_table(
        f"{recording.name}, {name}: the tracker's step grows as points^{number(power, 2)}"
        " (processor time)",
        (">points", ">ms", ">ms for each"),
        [(str(n), number(ms), number(ms / n, 3)) for n, ms in costs.items()],
    )


def cost_of_points(
    recording: Recording, settings: Settings, sizes: Sequence[int], frames: int = 10
) -> Iterator[tuple[int, float]]:
    """Give milliseconds for numbers of model points, else of data up to the smallest cloud's."""
    samples = settings.tracking.matching == "model_to_data"
    dense = settings.replaced(fit_shape=False, **({} if samples else {"pixel_step": 1}))
    with Clouds(recording, RunSpec(dense, init="tpose")) as chain:
        count = min(frames, chain.reader.frame_count)
        chain.learn(range(count), Hooks())
        clouds = [chain.take(k)[0] for k in range(count)]
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
    model = model_for(body, settings, positions, recording.fps, 0)
    state: TrackState = model.first(t_pose_in_cloud(body, clouds[0].points))
    spent = []
    with one_blas_thread():
        state, _ = step(model, state, clouds[0])
        for cloud in clouds:
            begun = time.process_time()
            state, estimate = step(model, state, cloud)
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
    for recording in recordings_of(args, with_reference=False):
        if "chain" in parts:
            chain_table(recording, presets, args.frames)
        for name, settings in presets.items() if "growth" in parts else ():
            growth_table(recording, name, settings)


if __name__ == "__main__":
    sys.exit(ended(main))

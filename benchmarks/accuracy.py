"""Compare presets and baselines, or what each part of ``accurate`` brings, on recordings.

Prints a Markdown table of errors against the reference, means and standard deviations over seeds.
A frame that is not tracked counts 90 degrees and 500 mm. Trackers never see the reference.

``python benchmarks/accuracy.py RECORDING ... --seeds 0,1,2 > table.md``
"""

import dataclasses
import sys
from argparse import Namespace
from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby
from operator import itemgetter
from pathlib import Path

import stereotrack_core as stereotrack
from benchmarks.common import (
    ended,
    parser_of,
    put_table,
    recordings_of,
    reference_within,
    say,
    worker_pool,
)
from stereotrack_core.evaluation.summary import Spread
from stereotrack_core.parameters import Value
from stereotrack_core.project.detectors import keypoints_in
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.recording.selection import frames_within, gives_depth, seeds_of, views_of
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.presets import PRESETS
from stereotrack_core.tracking.run_spec import RunSpec, measured_keypoints

ABLATIONS: Mapping[str, Mapping[str, Value]] = {
    "no arm search": {"search_arms": False},
    "no silhouettes": {"measure_silhouettes": False},
    "no render-and-compare": {"picture_cost": 0.0},
    "a third of the proposals": {"search_proposals": 73},
    "no fitted shape": {"fit_shape": False},
    "no legs": {"legs": False},
    "average proportions": {"proportions": "average"},
    "no colours": {"colour_weight": 0.0},
    "wide loss scale throughout": {"loss_scale": 0.12},
    "no robust loss": {"loss_scale": 2.0},
    "no prior inflation": {"prior_inflation_above": 100.0},
    "the thesis's process noise": {"sigma_rotation": 20.0, "sigma_joint": 40.0},
    "three iterations": {"iterations": 3},
    "300 data": {"data_points": 300},
    "no collisions": {"clearance": 0.0},
    "full-image matching": {"match_region": "whole"},
    "no left-right check": {"match_left_right": -1},
}  # by the table's name, the parameters that differ from those of ``accurate``

_COLUMNS = (
    *("recording", "preset", ">torso mm", ">long axis", ">cross axis"),
    *(">upper arms (95 %)", ">forearms (95 %)", ">lost %"),
)


def score(recording: Recording, spec: RunSpec) -> dict[str, float]:
    """Track a recording, without its reference, and measure the errors against it."""
    with FrameReader(recording, read_ahead=0) as reader:
        frames = spec.frames_of(reader.frame_count)
    reference = reference_within(recording, frames)
    run = stereotrack.track(dataclasses.replace(recording, reference=None), spec)
    summary = stereotrack.evaluate(run, reference)
    values = {"lost": 100.0 * summary.lost}
    for measure in summary.measures:
        values[measure.name] = measure.statistics.mean
        values[f"{measure.name}_p95"] = measure.statistics.p95
    return values


def row(recording: str, contestant: str, scores: Sequence[Mapping[str, float]]) -> tuple[str, ...]:
    """One line of the table: all seeds of one contestant on one recording."""

    def text(name: str, digits: int = 1) -> str:
        return Spread.of(one[name] for one in scores).text(digits)

    return (
        *(recording, contestant, text("torso_position", 0)),
        *(text("torso_long"), text("torso_cross")),
        f"{text('upper_arms')} ({text('upper_arms_p95')})",
        f"{text('forearms')} ({text('forearms_p95')})",
        text("lost"),
    )


def contestants(
    presets: str | None, changes: Sequence[str], *, ablation: bool = False
) -> dict[str, Settings]:
    """Settings by the name that the table gives them."""
    if ablation:
        base = stereotrack.preset("accurate", changes)
        return {"accurate": base} | {k: base.replaced(**v) for k, v in ABLATIONS.items()}
    names = presets.split(",") if presets else PRESETS
    return {name: stereotrack.preset(name, changes) for name in names}


def _specs(
    recording: Recording, settings: Mapping[str, Settings], path: Path | None, args: Namespace
) -> Iterator[RunSpec]:
    """Give the runs of one recording: every contestant that can track it, with every seed."""
    found = None if path is None else keypoints_in(path, recording).keypoints
    views = views_of(recording, args.views)
    with FrameReader(recording, read_ahead=0) as reader:
        frames = frames_within(args.frames, reader.frame_count)
    for name, own in settings.items():
        if own.needs_depth and not gives_depth(recording):
            say(f"{recording.name}: {name} is left out because no view provides depth.")
            continue
        keypoints = measured_keypoints(recording, own, found)
        plain = RunSpec(own, name, frames, views, init=args.init, keypoints=keypoints)
        yield from (dataclasses.replace(plain, seed=seed) for seed in seeds_of(args.seeds))


def main(arguments: Sequence[str] | None = None) -> None:
    """Track every recording with every contestant and seed, and print the table."""
    parser = parser_of(__doc__)
    parser.add_argument("--presets", help="comma-separated (default: all)")
    parser.add_argument("--ablation", action="store_true", help="leave out parts of accurate")
    parser.add_argument("--seeds", default="0,1,2,3,4", help="comma-separated")
    parser.add_argument("--frames", help="A:B, half-open (default: all)")
    parser.add_argument("--views", help="for example NS (default: all)")
    parser.add_argument("--init", choices=("auto", "tpose"), default="auto")
    parser.add_argument("--set", action="append", default=[], dest="changes", metavar="NAME=VALUE")
    parser.add_argument("--keypoints", action="append", type=Path, help="one per recording")
    parser.add_argument("--workers", type=int, default=1, help="processes")
    args = parser.parse_args(arguments)
    settings = contestants(args.presets, args.changes, ablation=args.ablation)
    recordings, rows = recordings_of(args), []
    given = args.keypoints or [None] * len(recordings)
    with worker_pool(args.workers) as pool:
        work = [
            (recording.name, spec.preset, pool.submit(score, recording, spec))
            for recording, path in zip(recordings, given, strict=True)
            for spec in _specs(recording, settings, path, args)
        ]
        for (recording, name), own in groupby(work, key=itemgetter(0, 1)):
            rows.append(row(recording, name, [future.result() for *_, future in own]))
            say(" ".join(rows[-1]))
    what = "Ablation" if args.ablation else "Presets and baselines"
    put_table(f"{what}; degrees, seeds {args.seeds}", _COLUMNS, rows)


if __name__ == "__main__":
    sys.exit(ended(main))

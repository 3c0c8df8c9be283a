"""``stereotrack benchmark``: presets and baselines on recordings, in one table."""

from __future__ import annotations

import itertools
from argparse import Namespace
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from stereotrack_core.atomic import write_file
from stereotrack_core.cli.arguments import (
    FRAMES,
    JSON,
    KEYPOINT_OPTIONS,
    VIEWS,
    changes,
    check_least,
    check_output,
    flag,
    option,
)
from stereotrack_core.cli.benchmark_annotation import annotation_benchmark
from stereotrack_core.cli.output import OK, put_json, put_result, put_table, say
from stereotrack_core.cli.progress import progress, stoppable
from stereotrack_core.cli.sources import keypoints_from
from stereotrack_core.counting import counted
from stereotrack_core.demo import copied_demo
from stereotrack_core.errors import InputError
from stereotrack_core.evaluation.errors import truth_of
from stereotrack_core.experiments.benchmark.accuracy import ABLATIONS, Row, Score, accuracy, pooled
from stereotrack_core.experiments.benchmark.growth import Cost, cost_of_points, cost_of_views
from stereotrack_core.experiments.benchmark.speed import chain_speed, exponent
from stereotrack_core.locks import writing
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.folder import open_recordings
from stereotrack_core.recording.keypoints import Keypoints
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.recording.selection import (
    frames_within,
    gives_depth,
    seeds_of,
    tracked_views,
    views_of,
)
from stereotrack_core.tables import (
    Table,
    csv_text,
    markdown_text,
    number,
    table_suffix,
)
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.presets import PRESETS, preset
from stereotrack_core.tracking.run_spec import RunSpec, measured_keypoints

DESCRIPTION = (
    "Track every recording with every preset and seed, and print one table: errors against "
    "the reference, their spread over seeds, and the speed of the whole chain. Trackers never "
    "see the reference. A frame that is not tracked counts 90 degrees and 500 mm. With "
    "--ablation: the contribution of each part of accurate. With --annotation: the accuracy "
    "of references fitted to clicks."
)

_BASE = "accurate"
"""The preset that the ablation takes parts away from."""

OPTIONS = (
    option(
        "recordings RECORDING",
        "recordings with a reference (default: the demo recording, which is copied if missing)",
        type=Path,
        nargs="*",
    ),
    option("--presets a,b,c", f"comma-separated presets (default: all; for growth {_BASE})"),
    option("--seeds 0,1,2", "comma-separated seeds (default: 0,1,2,3,4; for annotation 0)"),
    FRAMES,
    VIEWS,
    option(
        "--init",
        "initial pose: found automatically (auto), or the T pose facing north (tpose) "
        "(default: auto)",
        choices=("auto", "tpose"),
        default="auto",
    ),
    flag(
        "--ablation",
        f"compare {_BASE} with variants of {_BASE} that lack one part each, instead of presets",
    ),
    flag(
        "--growth",
        "measure how the cost of a frame grows with the number of points and views, instead "
        "of errors",
    ),
    flag(
        "--annotation", "fit the body to clicks simulated from the reference, instead of tracking"
    ),
    *KEYPOINT_OPTIONS,
    changes("change one parameter for all runs"),
    option(
        "--speed-frames N",
        "frame sets for timing (default: 20); 0 skips timing",
        type=int,
        default=20,
    ),
    option(
        "-o --output TABLE",
        "also write the table to a file: .md (as printed) or .csv (full precision)",
        type=Path,
    ),
    JSON,
)


def run(args: Namespace) -> int:
    """Track, measure, print."""
    if args.growth:
        _refuse_others(args, "--growth", ("ablation", "seeds", "frames", "output", "keypoints"))
    if args.annotation:
        return _annotation(args)
    seeds = seeds_of(args.seeds or "0,1,2,3,4")
    check_least(0, speed_frames=args.speed_frames)
    presets = _BASE if args.growth and args.presets is None else args.presets
    contestants = _contestants(presets, args.ablation, args.changes)
    if args.output is not None:
        table_suffix(check_output(args.output))
    recordings = _recordings(args.recordings)
    if args.growth:
        return _growth(recordings, contestants, args)
    with writing(args.output):
        return _accuracy(recordings, contestants, seeds, args)


def _accuracy(
    recordings: Sequence[Recording],
    contestants: Mapping[str, Settings],
    seeds: list[int],
    args: Namespace,
) -> int:
    scores: list[Score] = []
    speeds: dict[tuple[str, str], Mapping[str, float]] = {}
    for recording, seen in zip(recordings, _keypoints(args, recordings), strict=True):
        given = _that_follow(recording, contestants, asked=bool(args.presets))
        scores += _scores(recording, given, seeds, seen, args)
        speeds |= _speeds(recording, given, seen, args)
    rows = pooled(scores, speeds)
    what = "Ablation" if args.ablation else "Presets and baselines"
    table = readable(rows, seeds, what)
    if args.output is not None:
        _write(args.output, table, rows)
    facts = {"seeds": seeds, "rows": [_row_facts(row) for row in rows], "scores": scores}
    put_result(facts, table, as_json=args.json)
    return OK


def _annotation(args: Namespace) -> int:
    others = "growth", "ablation", "presets", "views", "output", "keypoints"
    _refuse_others(args, "--annotation", others)
    if args.changes:
        raise InputError("nothing is tracked", where="--set", remedy="Omit this option.")
    return annotation_benchmark(_recordings(args.recordings), seeds_of(args.seeds or "0"), args)


def _refuse_others(args: Namespace, kind: str, names: Sequence[str]) -> None:
    """Refuse options that a kind of table takes no notice of."""
    given = [f"--{name}" for name in names if getattr(args, name)]
    if given:
        raise InputError(
            f"{', '.join(given)} cannot be combined with it", where=kind, remedy="Omit this option."
        )


def _contestants(presets: str | None, ablation: bool, changes: list[str]) -> dict[str, Settings]:
    """Settings by the name that the table gives them."""
    if ablation:
        if presets is not None:
            raise InputError(
                "an ablation does not compare presets",
                where="--presets",
                remedy="Omit this option.",
            )
        base = preset(_BASE, changes)
        return {_BASE: base, **{row.name: base.replaced(**row.changes) for row in ABLATIONS}}
    names = PRESETS if presets is None else [name.strip() for name in presets.split(",")]
    return {name: preset(name, changes) for name in names}


def _recordings(folders: Sequence[Path]) -> list[Recording]:
    """Recordings with a reference; checked before anything long begins."""
    recordings = open_recordings(folders or [copied_demo().recording])
    for recording in recordings:
        truth_of(recording)  # refuses one without
    return recordings


def _keypoints(args: Namespace, recordings: Sequence[Recording]) -> list[Keypoints | None]:
    """Keypoints of each recording; of none, where none are given."""
    if not args.keypoints:
        return [None] * len(recordings)
    if len(args.keypoints) != len(recordings):
        raise InputError(
            f"keypoints are given {len(args.keypoints)} times for "
            f"{counted(len(recordings), 'recording')}",
            where="--keypoints",
            remedy="Give them once for each recording, in the order of the recordings.",
        )
    return [
        keypoints_from(path, recording, args)
        for path, recording in zip(args.keypoints, recordings, strict=True)
    ]


def _that_follow(
    recording: Recording, contestants: Mapping[str, Settings], *, asked: bool
) -> Mapping[str, Settings]:
    """Those that can track a recording; if asked for, those that need depth say so."""
    if asked or gives_depth(recording):
        return contestants
    found = {name: one for name, one in contestants.items() if not one.needs_depth}
    if left := [name for name in contestants if name not in found]:
        say(f"{recording.name}: left out because no view provides depth: {', '.join(left)}")
    return found


def _scores(
    recording: Recording,
    contestants: Mapping[str, Settings],
    seeds: list[int],
    keypoints: Keypoints | None,
    args: Namespace,
) -> Sequence[Score]:
    views = tracked_views(recording, views_of(recording, args.views), keypoints)
    with FrameReader(recording, views=views, read_ahead=0) as reader:
        frames = frames_within(args.frames, reader.frame_count)
    total = len(frames) * len(contestants) * len(seeds)
    say(
        f"Tracking {recording.name}: {len(frames)} frames, {counted(len(contestants), 'method')}, "
        f"{counted(len(seeds), 'seed')}."
    )
    specs = {
        name: RunSpec(
            settings, preset=name, frames=frames, views=views, init=args.init,
            keypoints=measured_keypoints(recording, settings, keypoints),
        )
        for name, settings in contestants.items()
    }  # fmt: skip
    done = itertools.count(1)
    with progress("Tracking", total) as show, stoppable() as stopped:
        return accuracy(
            recording, specs, seeds, on_frames=lambda _: show(next(done)), cancelled=stopped
        )


def _speeds(
    recording: Recording,
    contestants: Mapping[str, Settings],
    keypoints: Keypoints | None,
    args: Namespace,
) -> dict[tuple[str, str], Mapping[str, float]]:
    if not args.speed_frames:
        return {}
    say(f"Timing on {recording.name}. Do not run anything else meanwhile.")
    views = tracked_views(recording, views_of(recording, args.views), keypoints)
    with progress("Timing", len(contestants)) as show:
        timed = chain_speed(
            recording, contestants, views=views, frames=args.speed_frames, rounds=1,
            on_progress=show, keypoints=keypoints,
        )  # fmt: skip
    return {
        (recording.name, one.preset): {
            "frames_per_second": 1.0 / one.seconds,
            "ratio": one.ratio,
        }
        for one in timed
    }


def _growth(
    recordings: list[Recording], contestants: Mapping[str, Settings], args: Namespace
) -> int:
    found = []
    for recording in recordings:
        views = views_of(recording, args.views)
        for preset_name, settings in contestants.items():
            say(f"Timing {preset_name} on {recording.name}. Do not run anything else meanwhile.")
            points = cost_of_points(recording, settings, views=views)
            by_views = cost_of_views(recording, settings, views=views)
            where = {"recording": recording.name, "preset": preset_name}
            found.append({**where, "points": points, "views": by_views})
            name = f"{recording.name}, {preset_name}:"
            tables = (
                _growth_table(f"{name} the tracker's step", "points", points),
                _growth_table(f"{name} the whole chain", "views", by_views),
            )
            for table in () if args.json else tables:
                put_table(table)
    if args.json:
        put_json(found)
    return OK


def _write(path: Path, table: Table, rows: Sequence[Row]) -> None:
    if path.suffix.lower() == ".md":
        text = f"{markdown_text(table.columns, table.rows)}\n{table.title}.\n"
    else:
        text = csv_text(*in_full(rows))
    write_file(path, text)
    say(f"Table written to {path}.")


_HEADINGS = (
    *("recording", "preset", ">torso mm", ">long axis", ">cross axis"),
    *(">upper arms (95 %)", ">forearms (95 %)", ">lost %"),
)
_SPEED_HEADINGS = (">frames/s", ">times StereoBM")


def readable(rows: Sequence[Row], seeds: Sequence[int], what: str) -> Table:
    """Means, with their standard deviations over the seeds, one line per recording and preset."""
    spread = f" ± standard deviation over seeds {', '.join(map(str, seeds))}"
    title = f"{what}; degrees unless stated otherwise, means{spread if len(seeds) > 1 else ''}"
    headings = (*_HEADINGS, *(_SPEED_HEADINGS if rows and rows[0].speed else ()))
    return Table(title, headings, [_line(row) for row in rows])


def _line(row: Row) -> tuple[str, ...]:
    return (
        row.recording,
        row.contestant,
        _value(row, "torso_position", 0),
        _value(row, "torso_long"),
        _value(row, "torso_cross"),
        f"{_value(row, 'upper_arms')} ({_value(row, 'upper_arms_p95')})",
        f"{_value(row, 'forearms')} ({_value(row, 'forearms_p95')})",
        _value(row, "lost"),
        *map(number, row.speed.values()),
    )


def _value(row: Row, name: str, digits: int = 1) -> str:
    return row.values[name].text(digits)


def in_full(rows: Sequence[Row]) -> tuple[list[str], list[list[str | float | int]]]:
    """Columns and rows with every number in full."""
    names = list(rows[0].values) if rows else []
    columns = ["recording", "preset", "seeds", "frames"]
    columns += [f"{name}{end}" for name in names for end in ("", "_sd")]
    columns += ["frames_per_second", "ratio_to_stereobm"] if rows and rows[0].speed else []
    lines: list[list[str | float | int]] = []
    for row in rows:
        line: list[str | float | int] = [row.recording, row.contestant, row.seeds, row.frames]
        for name in names:
            line += [row.values[name].mean, row.values[name].deviation]
        lines.append([*line, *row.speed.values()])
    return columns, lines


def _row_facts(row: Row) -> dict[str, Any]:
    return {
        "recording": row.recording,
        "preset": row.contestant,
        "seeds": row.seeds,
        "frames": row.frames,
        "mean": {name: value.mean for name, value in row.values.items()},
        "standard_deviation": {name: one.deviation for name, one in row.values.items()},
        "speed": row.speed or None,
    }


def _growth_table(title: str, what: str, costs: Sequence[Cost]) -> Table:
    """Costs of a frame by size."""
    rows = [
        (str(cost.size), number(cost.milliseconds), number(cost.milliseconds / cost.size, 3))
        for cost in costs
    ]
    power = exponent([cost.size for cost in costs], [cost.milliseconds for cost in costs])
    grows = f"{title} grows as {what}^{number(power, 2)} (processor time)"
    return Table(grows, (f">{what}", ">ms", ">ms for each"), rows)

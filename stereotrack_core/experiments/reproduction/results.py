"""Everything that a reproduction writes, from the runs that are finished."""

from __future__ import annotations

import dataclasses
import json
import os
import platform
import shlex
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from stereotrack_core.atomic import write_file
from stereotrack_core.errors import InputError
from stereotrack_core.experiments.reproduction.curves import timing_curve
from stereotrack_core.experiments.reproduction.outcomes import Outcome, outcome_of
from stereotrack_core.experiments.reproduction.page import (
    Circumstances,
    RecordingFacts,
    Results,
    page,
)
from stereotrack_core.experiments.reproduction.pictures import motion_pictures
from stereotrack_core.experiments.reproduction.places import Places, kept_runs
from stereotrack_core.experiments.reproduction.plan import Group
from stereotrack_core.experiments.reproduction.tables import compared_tables
from stereotrack_core.experiments.reproduction.timing import StepCost, Timing, timing
from stereotrack_core.experiments.reproduction.words import columns_of, in_full, rows_of
from stereotrack_core.plain_data import check_kind, plain
from stereotrack_core.reading import decoding, read_json
from stereotrack_core.recording.csv_table import csv_text, markdown_text
from stereotrack_core.recording.description import Recording
from stereotrack_core.simulation.people import person_named
from stereotrack_core.simulation.thesis_recordings import FAST, thesis_recordings
from stereotrack_core.versions import versions


def write_results(
    places: Places,
    recordings: Sequence[Recording],
    groups: Sequence[Group],
    presets: Sequence[str],
    *,
    short: bool,
    on_timing: Callable[[str], None] | None = None,
) -> Results:
    """Write page, tables and numbers of what is finished.

    Times are measured only at the end, where `on_timing` is given; it is told the presets.
    """
    outcomes = read_outcomes(places, recordings, groups)
    tables = compared_tables(outcomes, [r.name for r in recordings], presets)
    timings = () if on_timing is None else _timings(places, recordings[0], presets, on_timing)
    results = Results(
        recordings=_facts(short=short),
        tables=tables,
        timings=timings,
        timing_picture=timing_curve(timings) if timings else None,
        motions=motion_pictures(places, recordings, outcomes),
        circumstances=_circumstances(places, outcomes, groups, presets, short=short),
    )
    _write_tables(places, results)
    write_file(places.page, page(results))
    return results


def read_outcomes(
    places: Places, recordings: Sequence[Recording], groups: Sequence[Group]
) -> list[Outcome]:
    """Measure every run that is there."""
    outcomes = []
    for _, kept in kept_runs(places, recordings, groups):
        for recording, entry, run in kept:
            if run is not None:
                outcomes.append(outcome_of(recording, entry, run))
    return outcomes


def _facts(*, short: bool) -> tuple[RecordingFacts, ...]:
    made = []
    for one in thesis_recordings(short=short):
        names = dict.fromkeys(part.name for part in one.parts if not part.name.endswith(FAST))
        fast = [part.name.removesuffix(FAST) for part in one.parts if part.name.endswith(FAST)]
        motions = f"{', '.join(names)}; fast: {', '.join(fast)}"
        stature = person_named(one.name).stature
        clothes = {"strong": "strong contrast", "plain": "low contrast"}.get(
            one.options.clothes, one.options.clothes
        )
        made.append(
            RecordingFacts(one.name, stature, one.frames, one.options.fps, clothes, motions)
        )
    return tuple(made)


def _timings(
    places: Places, recording: Recording, presets: Sequence[str], on_timing: Callable[[str], None]
) -> tuple[Timing, ...]:
    """Times of the presets, measured once and kept."""
    path = places.folder / "timing.json"
    kept = kept_timings(path)
    for name in presets:
        if name not in kept:
            on_timing(name)
            kept[name] = timing(recording, name)
            write_file(path, json.dumps(plain(kept), indent=2))
    return tuple(kept[name] for name in presets)


def kept_timings(path: Path) -> dict[str, Timing]:
    """Times by preset that were measured before; none where the file is damaged."""
    cost = dict.fromkeys(("points", "milliseconds"), float)
    stages = dict.fromkeys(("filter_ms", "stereo_ms_per_view", "segmentation_ms"), float)
    kind = {str: {"preset": str, "usual_points": int, **stages, "costs": [cost]}}
    try:
        kept = read_json(path)
        check_kind(kept, kind, str(path), "Omit the file.")
        with decoding(path, "timings are missing", "Omit the file."):
            return {
                name: Timing(**{**one, "costs": tuple(StepCost(**each) for each in one["costs"])})
                for name, one in kept.items()
            }
    except InputError:
        return {}


def _circumstances(
    places: Places,
    outcomes: Sequence[Outcome],
    groups: Sequence[Group],
    presets: Sequence[str],
    *,
    short: bool,
) -> Circumstances:
    seeds = 1 + max(entry.seed for group in groups for entry in group.entries)
    command = ["stereotrack", "reproduce", places.folder.name, *(["--short"] if short else [])]
    command += ["--presets", ",".join(presets), "--seeds", str(seeds)]
    used = versions()
    return Circumstances(
        command=shlex.join(command),
        versions={name: text for name, text in used.items() if name != "machine"},
        tracked_by=tuple(sorted({outcome.version for outcome in outcomes})),
        machine=f"{_processor()}, {os.cpu_count()} cores, {platform.system()}",
        seeds=seeds,
        presets=tuple(presets),
        runs=len(outcomes),
        wanted=sum(len(group.entries) for group in groups),
        short=short,
    )


def _processor() -> str:
    """Name of the processor, as far as the system tells."""
    facts: Mapping[str, str] = {}
    listed = Path("/proc/cpuinfo")
    if listed.is_file():
        lines = (line.partition(":") for line in listed.read_text("utf-8").splitlines())
        facts = {key.strip(): value.strip() for key, _, value in lines}
    return facts.get("model name") or platform.processor() or platform.machine()


def _write_tables(places: Places, results: Results) -> None:
    whole = []
    for compared in results.tables:
        columns, rows = in_full(compared)
        write_file(places.folder / f"table-{compared.key}.csv", csv_text(columns, rows))
        text = markdown_text(columns_of(compared), rows_of(compared))
        whole.append(f"## {compared.title}\n\n{text}\n{compared.remark}\n")
    write_file(places.folder / "tables.md", "\n".join(whole))
    if results.timings:
        columns = ["preset", "points", "milliseconds"]
        costs: list[list[str | float | int]] = [
            [timed.preset, cost.points, cost.milliseconds]
            for timed in results.timings
            for cost in timed.costs
        ]
        write_file(places.folder / "figure-4.4.csv", csv_text(columns, costs))
    facts = dataclasses.asdict(results.circumstances)
    write_file(places.folder / "made.json", json.dumps(plain(facts), indent=2))

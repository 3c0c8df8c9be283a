"""Everything that a reproduction writes, from the runs that are finished."""

from __future__ import annotations

import dataclasses
import json
import math
import os
import platform
import shlex
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from stereotrack_core.atomic import write_file
from stereotrack_core.errors import InputError
from stereotrack_core.experiments.benchmark.growth import Cost, Timing, timing
from stereotrack_core.experiments.reproduction.pictures import (
    MotionPictures,
    motion_pictures,
    timing_curve,
)
from stereotrack_core.experiments.reproduction.plan import THESIS, Group, Places, kept_runs
from stereotrack_core.experiments.reproduction.tables import (
    OF_THESIS,
    ComparedTable,
    Outcome,
    compared_tables,
    in_full,
    outcome_of,
    readable,
)
from stereotrack_core.experiments.reproduction.thesis import (
    FILTER_MS,
    REFERENCE_GOOD_TO_DEG,
    SEGMENTATION_MS,
    SOURCE,
    STEREO_MS_PER_VIEW,
)
from stereotrack_core.plain_data import check_kind, plain
from stereotrack_core.reading import decoding, read_json
from stereotrack_core.recording.description import Recording
from stereotrack_core.report.pages import code, embedded
from stereotrack_core.report.pages import page as drawn_page
from stereotrack_core.simulation.people import person_named
from stereotrack_core.simulation.thesis_recordings import FAST, thesis_recordings
from stereotrack_core.tables import Table, csv_text, markdown_text, number
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.presets import preset
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
    outcomes = [
        outcome_of(recording, planned, run)
        for _, kept in kept_runs(places, recordings, groups)
        for recording, planned, run in kept
        if run is not None
    ]
    tables = compared_tables(outcomes, [r.name for r in recordings], presets)
    timings = () if on_timing is None else _timings(places, recordings[0], presets, on_timing)
    results = Results(
        recordings=_recordings(short=short),
        tables=tables,
        timings=timings,
        timing_picture=timing_curve(timings) if timings else None,
        motions=motion_pictures(places, recordings, outcomes),
        circumstances=_circumstances(places, outcomes, groups, presets, short=short),
    )
    _write_tables(places, results)
    write_file(places.page, page(results))
    return results


def _recordings(*, short: bool) -> Table:
    """What the recordings are, in words."""
    rows = []
    for one in thesis_recordings(short=short):
        names = dict.fromkeys(part.name for part in one.parts if not part.name.endswith(FAST))
        fast = [part.name.removesuffix(FAST) for part in one.parts if part.name.endswith(FAST)]
        clothes = {"strong": "strong contrast", "plain": "low contrast"}
        options = one.options
        rows.append(
            (
                one.name,
                f"{person_named(one.name).stature:.2f}",
                str(one.frames),
                f"{one.frames / options.fps:.0f}",
                clothes.get(options.clothes, options.clothes),
                f"{', '.join(names)}; fast: {', '.join(fast)}",
            )
        )
    return Table("", ("", ">stature [m]", ">frames", ">seconds", "clothes", "motions"), rows)


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
    cost = dict.fromkeys(("size", "milliseconds"), float)
    stages = dict.fromkeys(("filter_ms", "stereo_ms_per_view", "segmentation_ms"), float)
    kind = {str: {"preset": str, "usual_points": int, **stages, "costs": [cost]}}
    try:
        kept = read_json(path)
        check_kind(kept, kind, str(path), "Omit the file.")
        with decoding(path, "timings are missing", "Omit the file."):
            return {
                name: Timing(**{**one, "costs": tuple(Cost(**each) for each in one["costs"])})
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
    seeds = 1 + max(one.seed for group in groups for one in group.runs)
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
        wanted=sum(len(group.runs) for group in groups),
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
        table = readable(compared)
        text = markdown_text(table.columns, table.rows)
        whole.append(f"## {compared.title}\n\n{text}\n{compared.remark}\n")
    write_file(places.folder / "tables.md", "\n".join(whole))
    if results.timings:
        columns = ["preset", "points", "milliseconds"]
        costs: list[list[str | float | int]] = [
            [timed.preset, cost.size, cost.milliseconds]
            for timed in results.timings
            for cost in timed.costs
        ]
        write_file(places.folder / "figure-4.4.csv", csv_text(columns, costs))
    facts = dataclasses.asdict(results.circumstances)
    write_file(places.folder / "made.json", json.dumps(plain(facts), indent=2))


@dataclass(frozen=True)
class Circumstances:
    """How the numbers came about."""

    command: str
    """That makes them again."""
    versions: Mapping[str, str]
    tracked_by: tuple[str, ...]
    """Versions of this program that made the runs."""
    machine: str
    seeds: int
    presets: tuple[str, ...]
    runs: int
    wanted: int
    """`runs` and `wanted`: runs that are finished, and all that belong to the tables."""
    short: bool


@dataclass(frozen=True)
class Results:
    """Everything that the page shows."""

    recordings: Table
    tables: tuple[ComparedTable, ...]
    timings: tuple[Timing, ...]
    timing_picture: bytes | None
    motions: tuple[MotionPictures, ...]
    circumstances: Circumstances


_TITLE = "Reproduction of the thesis's evaluation"
_ORDER = ("4.1", "4.2", "4.3", "4.4", "fast", "motions")


def page(results: Results) -> str:
    """The whole page as HTML."""
    by_key = {compared.key: compared for compared in results.tables}
    made = results.circumstances
    timed = bool(results.timings) and results.timing_picture is not None
    return drawn_page(
        "reproduction.html",
        _TITLE,
        lead=_lead(by_key["4.1"]),
        made=made,
        of_thesis=OF_THESIS,
        source=SOURCE,
        good_to=REFERENCE_GOOD_TO_DEG,
        recordings=results.recordings,
        compared_tables=[
            {"key": key, "title": one.title, "table": readable(one), "remark": one.remark}
            for key in _ORDER
            if (one := by_key.get(key)) is not None
        ],
        timings=_timings_table(results.timings),
        timing_picture=embedded(results.timing_picture or b"", "svg") if timed else "",
        motions=results.motions,
        embedded=embedded,
        circumstances=_circumstances_table(made),
        presets=[_parameters(name) for name in made.presets],
    )


def _lead(compared: ComparedTable) -> str:
    """The main result in words."""
    said = []
    for measure, label in (("upper_arms", "upper arms"), ("forearms", "forearms")):
        values = {
            line.source: line.figures[-1].mean for line in compared.lines if line.measure == measure
        }
        others = [
            f"{source} {number(value)}"
            for source, value in values.items()
            if source != OF_THESIS and math.isfinite(value)
        ]
        if others:
            said.append(f"{label}: {', '.join(others)}, in the thesis {values[OF_THESIS]:.1f}")
    if not said:
        return "No tracking results yet."
    return (
        f"Mean errors in degrees at the thesis's pace. {'; '.join(said).capitalize()}. The "
        "thesis's numbers come from real recordings, ours from simulated recordings with exact "
        "ground truth. Only the relations between numbers can be compared."
    )


def _timings_table(timings: Sequence[Timing]) -> Table:
    thesis = (number(FILTER_MS, 0), number(STEREO_MS_PER_VIEW, 0), number(SEGMENTATION_MS, 0))
    rows: list[tuple[str, ...]] = [(OF_THESIS, *thesis, "m³, as stated")]
    for timed in timings:
        values = (timed.filter_ms, timed.stereo_ms_per_view, timed.segmentation_ms)
        what = "m" if timed.preset == THESIS else "points"
        power = f"{what} to the power {number(timed.exponent(), 2)}"
        rows.append((timed.preset, *(number(value) for value in values), power))
    columns = (
        *("", ">tracking [ms]", ">stereo, each view [ms]", ">segmentation [ms]"),
        "growth of tracking time",
    )
    return Table("", columns, rows)


def _circumstances_table(made: Circumstances) -> Table:
    rows = [
        ("command", code(made.command)),
        ("machine", made.machine),
        *made.versions.items(),
        ("runs tracked by version", ", ".join(made.tracked_by) or "-"),
        ("seeds", f"0 to {made.seeds - 1} for {THESIS}, 0 for others"),
        ("recordings", "simulated with seed 0; the reference is the exact ground truth"),
    ]
    return Table("", ("", ""), rows)


def _parameters(name: str) -> dict[str, str | Table]:
    """Parameters of a preset that differ from the defaults, and the others."""
    columns, values = ("parameter", ">value", "unit", ">default"), preset(name).values()
    rows = [
        (row, (row.name, str(values[row.name]), row.unit, str(row.default)))
        for row in Settings.rows()
    ]
    changed = [line for row, line in rows if values[row.name] != row.default]
    same = [line for row, line in rows if values[row.name] == row.default]
    return {"name": name, "changed": Table("", columns, changed), "same": Table("", columns, same)}

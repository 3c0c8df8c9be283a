"""The page on which the thesis's results and ours stand beside each other."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from stereotrack_core.experiments.reproduction.plan import THESIS
from stereotrack_core.experiments.reproduction.tables import OF_THESIS, ComparedTable
from stereotrack_core.experiments.reproduction.thesis import (
    FILTER_MS,
    REFERENCE_GOOD_TO_DEG,
    SEGMENTATION_MS,
    SOURCE,
    STEREO_MS_PER_VIEW,
    ThesisMotion,
)
from stereotrack_core.experiments.reproduction.timing import Timing
from stereotrack_core.experiments.reproduction.words import html_table
from stereotrack_core.parameters import Value
from stereotrack_core.report.html import (
    Html,
    bullets,
    document,
    element,
    fold,
    heading,
    joined,
    link,
    paragraph,
    picture,
)
from stereotrack_core.report.tables import number, table
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.presets import preset


@dataclass(frozen=True)
class RecordingFacts:
    """What a recording is, in words."""

    name: str
    stature: float
    frames: int
    fps: float
    clothes: str
    motions: str


@dataclass(frozen=True)
class MotionPictures:
    """Pictures of one motion.

    Attributes
    ----------
    motion : ThesisMotion
    curves : bytes
        SVG.
    strips : mapping from a way of tracking, in words, to a JPEG
    frames : tuple of int
        That the strips show.
    """

    motion: ThesisMotion
    curves: bytes
    strips: Mapping[str, bytes]
    frames: tuple[int, ...]


@dataclass(frozen=True)
class Circumstances:
    """How the numbers came about.

    Attributes
    ----------
    command : str
        That makes them again.
    versions : mapping from program to version
    tracked_by : tuple of str
        Versions of this program that made the runs.
    machine : str
    seeds : int
    presets : tuple of str
    runs, wanted : int
        Runs that are finished, and all that belong to the tables.
    short : bool
    """

    command: str
    versions: Mapping[str, str]
    tracked_by: tuple[str, ...]
    machine: str
    seeds: int
    presets: tuple[str, ...]
    runs: int
    wanted: int
    short: bool


@dataclass(frozen=True)
class Results:
    """Everything that the page shows."""

    recordings: tuple[RecordingFacts, ...]
    tables: tuple[ComparedTable, ...]
    timings: tuple[Timing, ...]
    timing_picture: bytes | None
    motions: tuple[MotionPictures, ...]
    circumstances: Circumstances


_FULL_WORDS = (
    "Simulated after what the thesis says of its recordings: four stereo cameras of 640 × 480 with "
    "a base line of 120 mm, 10 frame sets per second, furniture, somebody else now and then (P2), "
    "a defined pose at the beginning. What it shows in pictures stands at its own frame numbers. "
    "Lenses differ: 400 px focal length instead of 267, with which preset thesis, on points of "
    "every second pixel, loses the arms of a person who stands still."
)
_SHORT_WORDS = "Simulated, with pictures of 400 × 300 and every motion in a few frames."


def page(results: Results) -> str:
    """The whole page as HTML."""
    by_key = {compared.key: compared for compared in results.tables}
    parts: list[Html] = [
        heading(1, "The evaluation of the thesis, repeated"),
        paragraph(_lead(by_key["4.1"]), kind="lead"),
        _state(results.circumstances),
        _how_to_read(results),
        heading(2, "What was recorded", "recordings"),
        _recordings(results),
    ]
    for key in ("4.1", "4.2", "4.3", "4.4", "fast", "motions"):
        if key in by_key:
            parts += _table_section(by_key[key])
    parts += [*_timing(results), *_motions(results.motions), *_made(results.circumstances)]
    return document("The evaluation of the thesis, repeated", *parts)


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
        return "Nothing is tracked yet."
    return (
        f"Mean errors in degrees at the thesis's pace. {'; '.join(said).capitalize()}. The "
        "thesis's numbers come from real recordings, ours from simulated ones with exact truth: "
        "what can be compared is how the numbers lie to each other."
    )


def _state(made: Circumstances) -> Html:
    parts = []
    if made.short:
        parts.append(
            "This is the short form, in which recordings last some tens of frames: it shows that "
            "every step works, and its numbers say nothing."
        )
    if made.runs < made.wanted:
        parts.append(
            f"Not finished: {made.runs} of {made.wanted} runs are there. The same command goes on."
        )
    return joined(paragraph(text, kind="note") for text in parts)


def _how_to_read(results: Results) -> Html:
    return joined(
        [
            heading(2, "How to read this", "reading"),
            bullets(
                [
                    f"{OF_THESIS.capitalize()}: its own numbers ({SOURCE}), against a reference "
                    f"that it takes to be good to {REFERENCE_GOOD_TO_DEG:.0f} degrees. Table and "
                    "page stand below each table.",
                    "Preset thesis: its method with its parameters, from the first frame to the "
                    f"last; mean{_spread(results.circumstances.seeds)}.",
                    "Preset thesis, started anew: the same, but put on the true pose at the "
                    "beginning of every segment. A protocol for judging, not a way of tracking: "
                    "it tells errors that grow from arms that were lost before.",
                    "Other presets: this program's own, one run, first pose found without help.",
                    "Tables 4.1 to 4.4 count the frames at the thesis's pace. What is done fast "
                    "at the end of every recording counts in a table of its own.",
                    "Lost: share of upper arms and forearms more than 45 degrees off. A frame that "
                    "is not tracked counts 90 degrees and 500 mm.",
                ]
            ),
        ]
    )


def _spread(seeds: int) -> str:
    return f" ± standard deviation over {seeds} seeds" if seeds > 1 else " over frames, one seed"


def _recordings(results: Results) -> Html:
    rows = [
        (r.name, f"{r.stature:.2f}", str(r.frames), f"{r.frames / r.fps:.0f}", r.clothes, r.motions)
        for r in results.recordings
    ]
    headings = ("", ">stature [m]", ">frames", ">seconds", "clothes", "motions")
    words = _SHORT_WORDS if results.circumstances.short else _FULL_WORDS
    return joined([table(headings, rows), paragraph(words, kind="soft")])


def _table_section(compared: ComparedTable) -> list[Html]:
    return [
        heading(2, compared.title, f"table-{compared.key}"),
        html_table(compared),
        paragraph(compared.remark, kind="soft"),
    ]


def _timing(results: Results) -> list[Html]:
    if not results.timings or results.timing_picture is None:
        return []
    rows: list[tuple[str, ...]] = [
        (
            OF_THESIS,
            number(FILTER_MS, 0),
            number(STEREO_MS_PER_VIEW, 0),
            number(SEGMENTATION_MS, 0),
            "m³, as it says",
        )
    ]
    for timed in results.timings:
        values = (timed.filter_ms, timed.stereo_ms_per_view, timed.segmentation_ms)
        what = "m" if timed.preset == THESIS else "points"
        power = f"{what} to the power {number(timed.exponent(), 2)}"
        rows.append((timed.preset, *(number(value) for value in values), power))
    headings = (
        *("", ">tracking [ms]", ">stereo, each view [ms]", ">segmentation [ms]"),
        "tracking grows with",
    )
    alt = "Time of tracking a frame over the number of points"
    return [
        heading(2, "Figure 4.4: time for a frame", "timing"),
        table(headings, rows),
        picture(
            results.timing_picture,
            "svg+xml",
            alt,
            "Processor time of the tracker's step for a frame. Of the thesis's curve only the "
            "value at m = 64 is told in words (page 66: four frame sets per second).",
            640,
        ),
        paragraph(
            "Tracking is processor time on one core; stereo and segmentation are wall time of "
            "their stages, which other work on the machine makes longer.",
            kind="soft",
        ),
    ]


def _motions(motions: Sequence[MotionPictures]) -> list[Html]:
    if not motions:
        return []
    parts = [heading(2, "Short motions in detail (section 4.3)", "short-motions")]
    for shown in motions:
        motion = shown.motion
        title = (
            f"Figures {motion.pictures} and {motion.curves}: {motion.title} ({motion.recording})"
        )
        parts += [
            heading(3, title, f"motion-{motion.segment}"),
            paragraph(f"The thesis: {motion.remark} (Page {motion.page}.)", kind="soft"),
        ]
        frames = ", ".join(map(str, shown.frames))
        for way, strip in shown.strips.items():
            caption = f"{way}: frames {frames}; model in the limbs' colours, truth dashed white."
            parts.append(picture(strip, "jpeg", f"{motion.title}, tracked by {way}", caption))
        caption = (
            "Errors of each limb. Preset thesis: mean over seeds, band from the smallest to the "
            "largest; others in the limb's colour. Dotted: 45 degrees."
        )
        parts.append(picture(shown.curves, "svg+xml", f"Errors during {motion.title}", caption))
    return parts


def _made(made: Circumstances) -> list[Html]:
    rows = [("command", element("code", made.command)), ("machine", made.machine)]
    rows += [(name, version) for name, version in made.versions.items()]
    rows.append(("runs tracked by version", ", ".join(made.tracked_by) or "–"))
    seeds = f"0 to {made.seeds - 1} for {THESIS}, 0 for others"
    rows.append(("seeds", seeds))
    rows.append(("recordings", "simulated with seed 0; their reference is the exact truth"))
    parts = [
        heading(2, "How this was made", "made"),
        table(("", ""), rows),
    ]
    for name in made.presets:
        changed, same = _parameters(preset(name))
        parts.append(
            fold(
                f"All parameters of preset {name} ({len(changed)} differ from the defaults)",
                paragraph("Different from the default:") if changed else "",
                table(("parameter", ">value", "unit", ">default"), changed) if changed else "",
                paragraph("As the default:"),
                table(("parameter", ">value", "unit", ">default"), same),
            )
        )
    parts.append(paragraph(link("To the tables", "table-4.1")))
    return parts


def _parameters(settings: Settings) -> tuple[list[tuple[str, ...]], list[tuple[str, ...]]]:
    """Rows of the parameters that differ from the defaults, and of the others."""
    changed: list[tuple[str, ...]] = []
    same: list[tuple[str, ...]] = []
    for row in Settings.rows():
        value: Value = settings.values()[row.name]
        line = (row.name, str(value), row.unit, str(row.default))
        (same if value == row.default else changed).append(line)
    return changed, same

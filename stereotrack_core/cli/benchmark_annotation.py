"""``stereotrack benchmark --annotation``: how accurate references fitted to clicks are."""

from __future__ import annotations

import dataclasses
from argparse import Namespace
from collections.abc import Sequence
from typing import Any

from stereotrack_core.annotation.fit.settings import FitSettings
from stereotrack_core.annotation.fit.stretch import recorded_depth
from stereotrack_core.cli.output import OK, put_result, say
from stereotrack_core.cli.progress import progress
from stereotrack_core.evaluation.errors import reference_within, truth_of
from stereotrack_core.experiments.benchmark.annotation import CASES, AnnotationScore, annotated
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.recording.selection import frames_within
from stereotrack_core.tables import Table, number

_ANNOTATION_HEADINGS = (
    *("recording", "clicks", ">upper arms", ">forearms", ">cross axis"),
    *(">inside 95 %", ">limbs inside", ">outliers found", ">false alarms"),
)


def annotation_benchmark(
    recordings: Sequence[Recording], seeds: Sequence[int], args: Namespace
) -> int:
    """Simulate clicks, fit them, and print the table."""
    scores = [
        score
        for recording in recordings
        for score in _annotation_scores(recording, seeds, args.frames)
    ]
    title = (
        "Fitted references; degrees, means over all frames, share of limbs inside their 95 % "
        "interval"
    )
    table = Table(title, _ANNOTATION_HEADINGS, [_annotation_line(score, seeds) for score in scores])
    put_result([_annotation_facts(score) for score in scores], table, as_json=args.json)
    return OK


def _annotation_scores(
    recording: Recording, seeds: Sequence[int], frames: str | None
) -> list[AnnotationScore]:
    settings, found = FitSettings(), []
    with FrameReader(recording, read_ahead=0) as reader:
        asked = frames_within(frames, reader.frame_count)
    recording = dataclasses.replace(recording, reference=reference_within(recording, asked))
    clicked = truth_of(recording).frame.tolist()
    with recorded_depth(recording, settings) as depth:
        clouds = None
        if depth is not None:
            say(f"Depth of {recording.name}: {len(clicked)} frames.")
            with progress("Depth", len(clicked)) as show:
                made = {}
                for frame in clicked:
                    made[frame] = depth(frame)
                    show(len(made))
            clouds = made.get
        cases = [case for case in CASES if clouds is not None or not case.depth]
        with progress("Fitting", len(cases) * len(seeds)) as show:
            for case in cases:
                for seed in seeds:
                    found.append(annotated(recording, case, seed, settings, clouds))
                    show(len(found))
    return found


def _values(score: AnnotationScore) -> dict[str, float]:
    means = {
        name: score.summary.measure(name).statistics.mean
        for name in ("upper_arms", "forearms", "torso_cross")
    }
    return {
        **means,
        "inside": 100.0 * score.inside,
        "limbs_inside": 100.0 * score.limbs_inside,
        "found": 100.0 * score.found,
        "accused": 100.0 * score.accused,
    }


def _annotation_line(score: AnnotationScore, seeds: Sequence[int]) -> tuple[str, ...]:
    seed = f", seed {score.seed}" if len(seeds) > 1 else ""
    return (score.recording, f"{score.case}{seed}", *(number(v) for v in _values(score).values()))


def _annotation_facts(score: AnnotationScore) -> dict[str, Any]:
    return {
        "recording": score.recording,
        "case": score.case,
        "seed": score.seed,
        "frames": score.summary.frames,
        "clicks": score.clicks,
        "outliers": score.outliers,
        **_values(score),
    }

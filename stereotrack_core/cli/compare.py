"""``stereotrack compare``: runs with the first of them, as ``evaluate --against`` does two."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path

from stereotrack_core.cli.arguments import FRAMES, JSON, REFERENCE, SEGMENTS, STATED, option
from stereotrack_core.cli.evaluate import measured_of, put_told
from stereotrack_core.cli.evaluations import against_told
from stereotrack_core.cli.output import OK, put_json
from stereotrack_core.errors import InputError

DESCRIPTION = (
    "Compare runs over the frames they share: all measures of `evaluate` where there is a "
    "reference, otherwise the distance between the runs. Differences are paired by frame."
)

OPTIONS = (
    option(
        "run_files RUN",
        "two or more runs (.npz) or landmark files (.csv, .trc, .c3d, .nc); the others are "
        "compared with the first",
        type=Path,
        nargs="+",
    ),
    REFERENCE,
    *STATED,
    FRAMES,
    SEGMENTS,
    JSON,
)


def run(args: Namespace) -> int:
    """Compare and print."""
    first, *others = args.run_files
    if not others:
        raise InputError("there is one run only", remedy="Give two runs or more.")
    source: Path | None = None
    found = []
    for other in others:
        asked = Namespace(
            **vars(args), run_file=other, against=first, recording=None, max_sigma=None
        )
        measured = measured_of(asked, needs_truth=False)
        source = None if measured.truth is None else measured.truth.source
        found.append((other, against_told(asked, measured)))
    if args.json:
        pairs = [{**facts, "run": other} for other, (facts, _) in found]
        put_json({"run": first, "reference": source, "pairs": pairs})
    else:
        put_told([tables for _, (_, tables) in found], source)
    return OK

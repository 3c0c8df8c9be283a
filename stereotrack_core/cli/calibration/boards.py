"""What all commands about boards share: their options, and the search for the board."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from stereotrack_core.calibrate.board import Board, charuco, chessboard
from stereotrack_core.calibrate.intrinsics import check_model
from stereotrack_core.calibrate.lens import LENS_MODELS
from stereotrack_core.calibrate.pictures import Looked, Pictures, check_same_length
from stereotrack_core.calibrate.report import (
    finding_table,
    left_out_table,
    world_facts,
    world_tables,
)
from stereotrack_core.calibrate.search import Search, search
from stereotrack_core.calibrate.sightings import LeftOut
from stereotrack_core.calibrate.world import World, calibrate_world
from stereotrack_core.cli.arguments import check_least, check_output, check_suffix, option
from stereotrack_core.cli.output import put_json, put_table
from stereotrack_core.cli.progress import progress, stoppable
from stereotrack_core.errors import Finding, InputError
from stereotrack_core.locks import writing
from stereotrack_core.recording.calibration import read_calibration, write_calibration
from stereotrack_core.tables import Table

BOARD = (
    option("--board COLSxROWS", "chessboard: number of inner corners, for example 9x6"),
    option(
        "--charuco COLSxROWS:DICTIONARY:MARKER",
        "ChArUco board: number of squares, dictionary, side of a marker in metres, for example "
        "5x7:4X4_50:0.018",
    ),
    option("--square METRES", "side of a square of the board", type=float, required=True),
)
EVERY = option("--every N", "use only every Nth picture (default: 1)", type=int, default=1)
MODEL = option(
    f"--model auto|{'|'.join(LENS_MODELS)}",
    "lens model (default: auto, the simplest that no other clearly improves on)",
    default="auto",
)
LENSES = option(
    "--lenses FILE.toml",
    "calibration whose lenses are kept, by the names of the cameras; others are calibrated",
    type=Path,
)
_NOT_ALIGNED = Finding(
    "note",
    "world",
    "the world is that of the first camera, taken as level and looking south",
    "Turn it with `stereotrack calibrate align`.",
)
NOTHING = "No calibration was written."


def board_of(args: Namespace) -> Board:
    """The board that was named; InputError where none or two were."""
    if (args.board is None) == (args.charuco is None):
        raise InputError(
            "name one board",
            where="--board",
            remedy="Use either --board 9x6 (inner corners) or --charuco 5x7:4X4_50:0.018.",
        )
    if args.board is not None:
        return chessboard(args.board, args.square)
    return charuco(args.charuco, args.square)


@contextmanager
def calibrating(args: Namespace) -> Iterator[None]:
    """Check what was asked for, and hold the output file meanwhile."""
    check_suffix(args.output, ".toml")
    check_output(args.output)
    check_model(args.model)
    board_of(args)
    with writing(args.output):
        yield


def found_board(args: Namespace, sources: Sequence[Pictures], count: int) -> Search:
    """The board looked for in the first `count` pictures of all cameras, with a progress bar."""
    check_least(1, every=args.every)
    named = board_of(args)
    frames = range(0, count, args.every)
    done = 0
    try:
        with progress("Searching", len(frames) * len(sources)) as show, stoppable(NOTHING) as stop:

            def advance(_looked: Looked) -> None:
                nonlocal done
                done += 1
                show(done)

            return search(sources, named, frames, on_picture=advance, cancelled=stop)
    finally:
        for source in sources:
            source.close()


def put_calibration(
    facts: dict[str, Any],
    tables: Sequence[Table | None],
    left_out: Sequence[LeftOut],
    findings: Sequence[Finding],
    *,
    as_json: bool,
) -> None:
    """Write the result of a calibration to standard output."""
    if as_json:
        put_json({**facts, "remarks": [vars(one) for one in findings]})
        return
    for table in (*tables, left_out_table(left_out), finding_table(findings)):
        if table is not None:
            put_table(table)


def put_world(
    args: Namespace,
    sources: Sequence[Pictures],
    check: Callable[[Search], None] = lambda _: None,
    told: Callable[[World], tuple[dict[str, Any], list[Table]]] = lambda _: ({}, []),
) -> None:
    """Search for the board, calibrate the cameras together, write and print the result.

    `check` refuses what was found, and `told` adds to the result as JSON and as tables.
    """
    given = {} if args.lenses is None else read_calibration(args.lenses)
    found = found_board(args, sources, check_same_length(sources))
    found.check_not_mirrored()
    check(found)
    with stoppable(NOTHING) as stop:
        world = calibrate_world(
            found.sightings, found.board, model=args.model, given=given, stop=stop
        )
    facts, tables = told(world)
    write_calibration(args.output, {camera.name: camera for camera in world.cameras})
    put_calibration(
        {"calibration": args.output, **facts, **world_facts(world)},
        [*world_tables(world), *tables],
        [out for one in world.sightings for out in one.left_out],
        [*found.findings, *world.findings, _NOT_ALIGNED],
        as_json=args.json,
    )

"""What the scripts share: their recordings, their tables, and how they end."""

from __future__ import annotations

import sys
from argparse import ArgumentParser, Namespace
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context
from pathlib import Path

from stereotrack_core.demo import copied_demo
from stereotrack_core.errors import InputError
from stereotrack_core.evaluation.summary import truth_of
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.folder import open_recordings
from stereotrack_core.tables import markdown_text


def parser_of(description: str | None) -> ArgumentParser:
    """A parser of a script that measures on recordings."""
    parser = ArgumentParser(description=description)
    parser.add_argument(
        "recordings", type=Path, nargs="*", help="recordings (default: the demo, copied if missing)"
    )
    return parser


def recordings_of(args: Namespace, *, with_reference: bool = True) -> list[Recording]:
    """Open the recordings that are given, or the demo. Raises InputError without a reference."""
    recordings = open_recordings(args.recordings or [copied_demo().recording])
    for recording in recordings if with_reference else ():
        truth_of(recording)
    return recordings


def say(text: str) -> None:
    """Write a message to standard error."""
    print(text, file=sys.stderr, flush=True)


def put_table(title: str, columns: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print a Markdown table; a heading that begins with ``>`` is right-aligned."""
    print(f"\n{title}\n\n{markdown_text(columns, rows)}", flush=True)


@contextmanager
def worker_pool(workers: int) -> Iterator[ProcessPoolExecutor]:
    """Give processes for work; what waits is dropped when the script is stopped."""
    pool = ProcessPoolExecutor(workers, get_context("spawn"))
    try:
        yield pool
    finally:
        pool.shutdown(cancel_futures=True)


def ended(main: Callable[[], None]) -> int:
    """Run a script; its exit status is 2, with one sentence, if its input is wrong."""
    try:
        main()
    except InputError as error:
        say(str(error))
        return 2
    return 0

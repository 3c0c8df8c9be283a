"""What the scripts share: their recordings, their tables, and how they end."""

import sys
from argparse import ArgumentParser, Namespace
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from stereotrack_core.demo import copied_demo
from stereotrack_core.errors import InputError
from stereotrack_core.evaluation.summary import knows_something, none_of_the_frames, truth_of
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.tables import markdown_text


def parser_of(description: str | None) -> ArgumentParser:
    """A parser of a script that measures on recordings."""
    parser = ArgumentParser(description=description)
    help_text = "recordings (default: the demo, copied if missing)"
    parser.add_argument("recordings", type=Path, nargs="*", help=help_text)
    return parser


def recordings_of(args: Namespace, *, with_reference: bool = True) -> list[Recording]:
    """Open the recordings that are given, or the demo, with names that tell them apart.

    Raises InputError without a reference, and for a recording that is given twice.
    """
    recordings = [open_recording(one) for one in args.recordings or [copied_demo().recording]]
    if len({recording.folder.resolve() for recording in recordings}) < len(recordings):
        what, remedy = "a recording is given twice", "Give each recording once."
        raise InputError(what, where="RECORDING", remedy=remedy)
    for recording in recordings if with_reference else ():
        truth_of(recording)
    count = Counter(recording.name for recording in recordings)
    return [replace(r, name=r.name if count[r.name] == 1 else str(r.folder)) for r in recordings]


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


def reference_within(recording: Recording, frames: range) -> LandmarkTrajectory:
    """The recording's reference in some frames. Raises InputError if it knows none of them."""
    reference = truth_of(recording)
    inside = (reference.frame >= frames.start) & (reference.frame < frames.stop)
    if not np.any(inside & knows_something(reference)):
        raise none_of_the_frames(str(recording.folder))
    return LandmarkTrajectory(reference.frame[inside], reference.points[inside])

"""What can be varied in a sweep, and what one comes to."""

from __future__ import annotations

import json
import os
import subprocess
import time
from collections.abc import Callable

from stereotrack_core.errors import InputError
from stereotrack_core.experiments.durations import in_words
from stereotrack_core.experiments.measures import MEASURES
from stereotrack_core.experiments.sweep.plan import SweepCount, SweepPlan, count_of
from stereotrack_core.experiments.sweep.points import SPECIAL, parameter_rows
from stereotrack_core.experiments.sweep.request import SweepRequest, program_command
from stereotrack_core.experiments.sweep.store import SweepPlaces, stored_results
from stereotrack_core.recording.folder import open_recordings

from ...session.counting import counted

_LOOK_SECONDS = 0.1


def counted_jobs(request: SweepRequest) -> SweepCount:
    """What a sweep would compute; takes as long as looking at the recordings does.

    Raises
    ------
    InputError
        Where something cannot be meant.
    """
    request.check()
    jobs = SweepPlan(request, open_recordings(request.recordings)).jobs_to_count()
    return count_of(jobs, stored_results(SweepPlaces(request.table)), request.workers or 1)[0]


def measured_seconds(request: SweepRequest, cancelled: Callable[[], bool]) -> float | None:
    """What a sweep will take, after tracking some frames in another process.

    None where it was cancelled.

    Raises
    ------
    InputError
        Where it cannot be told.
    """
    words = program_command([*request.arguments(), "--dry-run", "--json"])
    with subprocess.Popen(  # noqa: S603 - our own code in our own interpreter
        words,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
        creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
    ) as process:
        while process.poll() is None:
            if cancelled():
                process.kill()
                return None
            time.sleep(_LOOK_SECONDS)
        told = process.stdout.read() if process.stdout is not None else b""
    try:
        return float(json.loads(told)["seconds"])
    except (ValueError, KeyError, TypeError):
        raise InputError(
            "the run time could not be measured", remedy="Start the sweep; it shows the time left."
        ) from None


def count_words(count: SweepCount, *, cluster: bool) -> str:
    """What a sweep comes to: ``24 runs (4 points), 8 of them are in the table already …``."""
    said = f"{counted(count.jobs, 'run')} ({counted(count.points, 'point')})"
    waiting = count.jobs - count.there
    if not waiting:
        return f"{said}; all results are already in the table."
    if count.there:
        said += f"; {count.there} already in the table"
    said += f". To track: {counted(count.frames, 'frame')}"
    if cluster:
        return f"{said}, on the cluster."
    if count.seconds is None:
        return f"{said}. Duration not known yet."
    processes = f"{count.workers} process{'' if count.workers == 1 else 'es'}"
    return f"{said}, in about {in_words(count.seconds)} with {processes}."


def names_to_vary() -> tuple[tuple[str, str], ...]:
    """Everything that can be varied, with a sentence about it; seeds have a field of their own."""
    rows = parameter_rows().values()
    special = [(name, words) for name, words in SPECIAL.items() if name not in ("seed", "frames")]
    return (*special, *((row.name, row.help) for row in rows))


def measures_to_judge_by() -> tuple[tuple[str, str], ...]:
    """Measures that a search can go by, with words; the first one leaves it to the program."""
    best = {True: "higher is better", False: "lower is better"}
    named = ((one.name, f"{one.title}, {best[one.more_is_better]}") for one in MEASURES)
    return (("", "default measure"), *named)


def hint_for(name: str) -> str:
    """Which values a name takes, and what it is otherwise."""
    if name in SPECIAL:
        examples = {"views": "for example NS,NOSW", "preset": "for example accurate,fast",
                    "init": "auto,tpose", "smooth": "yes,no"}  # fmt: skip
        return examples.get(name, "")
    row = parameter_rows()[name]
    default = ("yes" if row.default else "no") if row.type is bool else row.default
    if row.choices:
        return f"{', '.join(row.choices)}; default {default}"
    if row.type is bool:
        return f"yes,no; default {default}"
    shown = f"{default:g}" if isinstance(default, float) else str(default)
    return f"{row.range_text()}; default {shown}"

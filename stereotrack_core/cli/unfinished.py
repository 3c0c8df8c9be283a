"""Where a run is kept until it is complete: beside its output, whatever ends the program."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from stereotrack_core.cli.output import counted, say
from stereotrack_core.errors import InputError

if TYPE_CHECKING:
    from stereotrack_core.cli.tracking_job import TrackingJob
    from stereotrack_core.interop.run_journal import Wish
    from stereotrack_core.tracking.run import Run
    from stereotrack_core.tracking.unfinished import UnfinishedRun


class UnfinishedOutput:
    """The file ``RUN.part`` that the frames of a run go to at once.

    What stands at the output before is not touched until the new run is complete.

    Parameters
    ----------
    recording : Path
        Folder, as it was given.
    output : Path
        Where the complete run goes.
    """

    def __init__(self, recording: Path, output: Path) -> None:
        from stereotrack_core.interop.run_journal import part_of

        self.output, self.part = output, part_of(output)
        words = ("stereotrack", "track", str(recording), "-o", str(output), "--resume")
        self.command = shlex.join(words)

    def begun(self) -> tuple[UnfinishedRun, Wish]:
        """The run to go on with.

        Raises
        ------
        InputError
            Where there is none, or it cannot be read.
        """
        from stereotrack_core.interop.run_journal import read_unfinished

        if not self.part.is_file():
            raise InputError(
                "there is no unfinished run to go on with",
                where=str(self.part),
                remedy="Leave --resume out to begin.",
            )
        return read_unfinished(self.part)

    def refuse_to_lose(self) -> None:
        """Refuse to begin where an earlier run waits to be gone on with.

        Raises
        ------
        InputError
            Where there is one.
        """
        from stereotrack_core.interop.run_journal import has_frames

        if has_frames(self.part):
            raise InputError(
                "an unfinished run is kept there",
                where=str(self.part),
                remedy="Go on with it: add --resume. To begin anew, delete it, or name another "
                "output.",
            )

    @contextmanager
    def telling(self) -> Iterator[None]:
        """Say where the frames are when an error ends the work."""
        try:
            yield
        except BaseException:
            from stereotrack_core.interop.run_journal import has_frames

            if has_frames(self.part):
                say(f"What was tracked is kept in {self.part}. To go on: {self.command}")
            raise

    def write(self, job: TrackingJob) -> Path | None:
        """Write what came out, and say so where that is not the complete run.

        Returns
        -------
        Path or None
            Where it is; None where nothing was tracked and an older run stands there.
        """
        from stereotrack_core.interop.run_file import write_run

        done = f"{len(job.run.frame)} of {counted(job.wanted, 'frame')}"
        if job.stopped and self.output.exists():
            say(
                f"Stopped after {done}; they are in {self.part}, and what was in {self.output} is "
                f"left as it was. To go on: {self.command}"
            )
            return self.part
        if job.nothing and self.output.exists():
            say(f"What was in {self.output} is left as it was.")
            self.part.unlink(missing_ok=True)
            return None
        write_run(self.output, job.run)
        if job.stopped:
            say(f"Stopped after {done}; they are in {self.output}. To go on: {self.command}")
        else:
            self.part.unlink(missing_ok=True)
        return self.output


def say_if_unfinished(path: Path, run: Run) -> None:
    """Say where a run lacks frames that are still to come."""
    from stereotrack_core.tracking.unfinished import INCOMPLETE

    if run.meta.get(INCOMPLETE):
        first, end = run.meta["frames"]
        say(
            f"{path}: this run was stopped and is not complete; it has {len(run.frame)} of the "
            f"{counted(end - first, 'frame')} that were asked for."
        )

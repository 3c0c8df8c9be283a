"""A job is one run with an identity by which its result is known again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol, TypeAlias

from stereotrack_core.experiments.sweep.points import Point
from stereotrack_core.tracking.run_spec import RunSpec

Status: TypeAlias = Literal["done", "failed"]


@dataclass(frozen=True, eq=False)
class Job:
    """One run, with everything that its outcome depends on.

    Attributes
    ----------
    identity : str
        Hash of all that the result depends on; equal identities, equal results.
    clouds : str
        Hash of all that its clouds depend on; jobs that agree in it may share them.
    recording : str
        Name of the recording.
    folder : str
        Where it is, the same on every machine that takes part.
    fingerprint : str
        What it has to be there.
    spec : RunSpec
        With its frames; without detections, which the recording has.
    """

    identity: str
    clouds: str
    recording: str
    folder: str
    fingerprint: str
    point: Point
    spec: RunSpec

    @property
    def frames(self) -> range:
        """Frames that are tracked."""
        return self.spec.frames_of(0)

    @property
    def seed(self) -> int:
        """Seed of the run."""
        return self.spec.seed

    @property
    def views(self) -> Sequence[str]:
        """Views that are used."""
        return self.spec.views or ()


@dataclass(frozen=True)
class JobResult:
    """What became of a job.

    Attributes
    ----------
    identity : str
        Of the job.
    status : str
        ``done`` or ``failed``.
    measures : mapping from measure to float
        In the measures' units; only what is known.
    frames : int
        Frames that were gone through.
    error : str
        Why it failed; empty where it did not.
    final : bool
        A failure that comes again however often it is tried: the input is wrong.
    attempts : int
        How often it was tried.
    """

    identity: str
    status: Status
    measures: Mapping[str, float] = field(default_factory=dict)
    frames: int = 0
    error: str = ""
    final: bool = False
    attempts: int = 1

    @property
    def done(self) -> bool:
        """Whether there are measures."""
        return self.status == "done"

    def facts(self) -> dict[str, Any]:
        """The same as JSON takes it."""
        return {
            "job": self.identity,
            "status": self.status,
            "measures": dict(self.measures),
            "frames": self.frames,
            "error": self.error,
            "attempts": self.attempts,
        }

    @classmethod
    def of_facts(cls, facts: Mapping[str, Any]) -> JobResult:
        """Read :meth:`facts` again.

        Raises
        ------
        ValueError
            For facts that are not those of a result.
        """
        try:
            status = facts["status"]
            if status not in ("done", "failed"):
                raise ValueError(f"unknown status {status!r}")
            measures = {str(name): float(value) for name, value in facts["measures"].items()}
            return cls(
                identity=str(facts["job"]),
                status=status,
                measures=measures,
                frames=int(facts["frames"]),
                error=str(facts["error"]),
                attempts=int(facts["attempts"]),
            )
        except (KeyError, TypeError, AttributeError, OverflowError) as error:
            raise ValueError(f"this is not the result of a job ({error})") from error


def failure(identity: str, error: BaseException, *, final: bool) -> JobResult:
    """A job that went wrong, with the error's words."""
    words = " ".join(str(error).split()) or "no details"
    said = words if final else f"{type(error).__name__}: {words}"
    return JobResult(identity, "failed", error=said, final=final)


class Watcher(Protocol):
    """Hears of everything that happens; called in the thread that asked for the jobs."""

    def on_frames(self, count: int) -> None:
        """So many frames more were tracked."""

    def on_result(self, job: Job, result: JobResult) -> None:
        """A job has come to its end; called once for each."""

    def stopped(self) -> bool:
        """Whether to stop."""


class Executor(Protocol):
    """Does jobs."""

    @property
    def count(self) -> int:
        """Jobs that are done at once."""

    def do(self, jobs: Sequence[Job], watcher: Watcher) -> None:
        """Do all jobs, whose identities differ; returns when each has a result.

        Raises
        ------
        Cancelled
            When the watcher wants to stop; results that were told stay valid.
        """

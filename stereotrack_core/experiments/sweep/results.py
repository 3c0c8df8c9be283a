"""What became of a job."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, TypeAlias

Status: TypeAlias = Literal["done", "failed"]


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
                raise ValueError(f"the status {status!r} is not known")
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
            raise ValueError(f"this is no result of a job ({error})") from error


def failure(identity: str, error: BaseException, *, final: bool) -> JobResult:
    """A job that went wrong, with the error's words."""
    words = " ".join(str(error).split()) or "no details"
    said = words if final else f"{type(error).__name__}: {words}"
    return JobResult(identity, "failed", error=said, final=final)

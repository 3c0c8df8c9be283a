"""What ``track`` says about a run whose own signs are bad."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stereotrack_core.cli.output import counted, say

if TYPE_CHECKING:
    from stereotrack_core.cli.tracking_job import TrackingJob


def say_signs(job: TrackingJob) -> None:
    """Say why nobody was tracked, or that nothing fits, and what to do about it."""
    from stereotrack_core.tracking.run_checks import CHECK

    for warning in job.run.meta["warnings"]:
        say(f"warning: {warning}. {CHECK}")
    if job.nothing and len(job.run.frame):
        say(f"Nobody was tracked in any of the {counted(len(job.run.frame), 'frame')}.")
        for cause in job.untracked.causes():
            say(cause.sentence())

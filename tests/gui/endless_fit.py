"""A fit that has taken all frames in and then goes on for longer than anybody waits."""

from __future__ import annotations

import time
from collections.abc import Callable

from stereotrack_core.project.fitting import FitJob


def worker() -> Callable[[FitJob], None]:
    """What a helper process answers with."""

    def work(job: FitJob) -> None:
        job.progress.write_text(str(len(job.frames)), encoding="ascii")
        time.sleep(600.0)

    return work

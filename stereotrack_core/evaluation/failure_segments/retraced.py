"""Reasons of a run's failures: the step in which each begins is done again, and recorded."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from stereotrack_core.evaluation.failure_segments.find import FailureSearch
from stereotrack_core.evaluation.failure_segments.reasons import reason_of
from stereotrack_core.evaluation.failure_segments.segment import FailureSegment
from stereotrack_core.evaluation.summary import points_at
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.recording.selection import gives_depth, usable_views
from stereotrack_core.tracking.estimate import Estimate
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.model import cameras_of, model_for
from stereotrack_core.tracking.repeating import stored_spec
from stereotrack_core.tracking.stored import body_of_run, pose_of_run
from stereotrack_core.tracking.tuning.clouds import CloudStore
from stereotrack_core.tracking.tuning.process import KeptRecording, RecordStep
from stereotrack_core.work import NO_WORK, Work


def with_reasons(
    search: FailureSearch, failures: Sequence[FailureSegment], work: Work = NO_WORK
) -> tuple[FailureSegment, ...]:
    """Failures with the reasons of their first frames, if the reference and the run know them.

    Raises Cancelled; InputError if the run does not say how it was made.
    """
    run, recording, reference = search.run, search.recording, search.reference
    if recording is None or reference is None or not failures or not gives_depth(recording):
        return tuple(failures)
    spec, body = stored_spec(run).spec, body_of_run(run)
    views = usable_views(recording, spec.views)
    where, fps, seed = cameras_of(recording, views), recording.fps, spec.seed
    make = partial(model_for, body, spec.settings, where, fps, seed)
    explained = []
    kept = KeptRecording(recording)
    with FrameReader(recording, views=views, colour=False) as reader:
        store = CloudStore(recording, reader)
        for i, failure in enumerate(failures):
            work.step(i / len(failures), "recording the steps in which failures begin")
            frame = failure.first
            truth = points_at(reference, np.array([frame]))[0]
            known = (_estimate(run, frame - 1), _estimate(run, frame))
            seen = {"seen": run.seen(frame), "truth": truth, "views": views}
            step = RecordStep(kept, frame, spec.settings, make, *known, **seen)
            arms = step.recorded(store, work.stopped).trace.search
            explained.append(replace(failure, reason=None if arms is None else reason_of(arms)))
        store.close()
    return tuple(explained)


def _estimate(run: Run, frame: int) -> Estimate | None:
    """Estimate that a run states for a frame, as far as a step begins from it."""
    for i in np.flatnonzero(run.frame == frame):
        pose = pose_of_run(run, int(i))
        if pose is not None:
            return Estimate(True, "", pose, run.x[i], run.P[i])
    return None

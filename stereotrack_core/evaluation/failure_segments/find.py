"""All failures of a run, with their probable causes, and the reasons of their first frames."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.evaluation.failure_segments import causes, segment
from stereotrack_core.evaluation.failure_segments.looks import Looker
from stereotrack_core.evaluation.failure_segments.reasons import reason_of
from stereotrack_core.evaluation.summary import at_frames, errors_against, points_at
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.recording.selection import gives_depth, usable_views
from stereotrack_core.tracking.estimate import Estimate
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.model import cameras_of, model_for
from stereotrack_core.tracking.repeating import stored_spec
from stereotrack_core.tracking.stored import body_of_run, fps_of_run, pose_of_run
from stereotrack_core.tracking.tuning.clouds import CloudStore
from stereotrack_core.tracking.tuning.process import KeptRecording, RecordStep
from stereotrack_core.work import NO_WORK, Work

_INSIDE, _USUAL = 6, 10  # frames that are looked at in a failure, and outside of any
_APART = 0.5  # seconds that a frame outside of any failure is away from all


@dataclass(frozen=True, eq=False)
class FailureSearch:
    """A run in which failures are looked for."""

    run: Run
    fps: float  # frame sets per second
    reference: LandmarkTrajectory | None = None  # truth; without it the run's own signs judge
    recording: Recording | None = None  # its clouds tell more about causes
    rules: segment.FailureRules = field(default_factory=segment.FailureRules)
    pictures: bool = True  # whether clouds are made again for causes


def failures(
    run: Run, *, recording: Recording | None = None, reference: LandmarkTrajectory | None = None
) -> tuple[segment.FailureSegment, ...]:
    """The stretches in which a run fails, with their probable causes.

    Images of the run's `recording` tell more about causes. A `reference` is taken as truth; without
    it the run is judged by its own signs.

    Examples
    --------
    >>> run = read_run(Path("run.npz"))
    >>> for failure in failures(run, recording=open_recording(Path("recording"))):
    ...     print(failure.first, failure.last, failure.limbs)
    """
    fps = fps_of_run(run) if recording is None else recording.fps
    return find_failures(FailureSearch(run, fps, reference, recording))


def find_failures(
    search: FailureSearch, work: Work = NO_WORK
) -> tuple[segment.FailureSegment, ...]:
    """Failures by error and by the run's own signs, with causes. Raises Cancelled, InputError."""
    return explained(search, stretches_of(search), work)


def stretches_of(search: FailureSearch) -> tuple[segment.FailureSegment, ...]:
    """The failures without their causes; a matter of milliseconds."""
    run, reference = search.run, search.reference
    if not len(run.frame):
        return ()
    found = segment.failures_by_signs(run, search.fps, search.rules)
    chance = run.frame, segment.lost_chances(run, search.fps)
    degrees = run.frame[:0], np.empty((0, len(LIMBS)))
    if reference is not None:
        errors = errors_against(run.trajectory(), at_frames(reference, run.frame))
        degrees = errors.frame, errors.degrees
        found = (*found, *segment.failures_by_error(errors, search.fps, search.rules))
    told = ((one, _largest(one, *degrees), _largest(one, *chance)) for one in found)
    idle = segment.idle_parameters(run.meta.get("parameters", {}))
    found = tuple(replace(one, error_deg=deg, chance=share, idle=idle) for one, deg, share in told)
    return tuple(sorted(found, key=lambda e: (e.first, e.last, e.found, e.limbs)))


def _largest(failure: segment.FailureSegment, frame: IntArray, values: FloatArray) -> float | None:
    """Largest value (F, 6) of a failure's limbs in its frames, None where none is known."""
    inside = (frame >= failure.first) & (frame <= failure.last)
    own = values[inside][:, [LIMBS.index(limb) for limb in failure.limbs]]
    return float(np.nanmax(own)) if np.isfinite(own).any() else None


def good_stretches(
    search: FailureSearch, failures: Sequence[segment.FailureSegment], count: int, seconds: float
) -> list[range]:
    """Up to `count` stretches of so many seconds, spread over what is away from all failures."""
    length, free = max(1, round(seconds * search.fps)), set(_free(search, failures).tolist())
    starts = [k for k in sorted(free) if all(k + i in free for i in range(length))]
    found: list[range] = []
    for first in _spread(np.array(starts, dtype=np.int64), count):
        if not found or first >= found[-1].stop:
            found.append(range(first, first + length))
    return found


def explained(
    search: FailureSearch, failures: Sequence[segment.FailureSegment], work: Work = NO_WORK
) -> tuple[segment.FailureSegment, ...]:
    """Failures with probable causes, by clouds of six frames of each and of ten usual ones."""
    places = {
        "truth": causes.whereabouts(search.run, search.fps, search.reference),
        "signs": causes.whereabouts(search.run, search.fps, None),
    }
    evidence = [causes.geometry_evidence(one, places[one.found]) for one in failures]
    recording = search.recording
    if failures and search.pictures and recording is not None and gives_depth(recording):
        asked = [(_spread(_free(search, failures), _USUAL), places["signs"])]
        frame = search.run.frame
        for one in failures:
            inside = frame[(frame >= one.first) & (frame <= one.last)]
            asked.append((_spread(inside, _INSIDE), places[one.found]))
        total, done, looks = sum(len(frames) for frames, _ in asked), 0, []
        with Looker(recording, search.run) as looker:
            for frames, where in asked:
                part = work.part(done / max(total, 1), (done + len(frames)) / max(total, 1))
                points = where.at(np.array(frames, dtype=np.int64))
                looks.append(looker.looks(frames, points, part))
                done += len(frames)
        for one, told, seen in zip(failures, evidence, looks[1:], strict=True):
            told += causes.look_evidence(one, looker.view_names, seen, looks[0])
    pairs = zip(failures, evidence, strict=True)
    return tuple(replace(one, verdict=causes.verdict_of(told)) for one, told in pairs)


def _free(search: FailureSearch, failures: Sequence[segment.FailureSegment]) -> IntArray:
    """Tracked frames that are away from all failures."""
    apart = round(_APART * search.fps)
    frame = search.run.frame[search.run.tracked]
    free = np.ones(len(frame), dtype=np.bool_)
    for failure in failures:
        free &= (frame < failure.first - apart) | (frame > failure.last + apart)
    return frame[free]


def _spread(frames: IntArray, count: int) -> list[int]:
    places = np.linspace(0, len(frames) - 1, min(count, len(frames))).round().astype(int)
    return [int(k) for k in frames[np.unique(places)]]


def with_reasons(
    search: FailureSearch, failures: Sequence[segment.FailureSegment], work: Work = NO_WORK
) -> tuple[segment.FailureSegment, ...]:
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

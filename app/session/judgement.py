"""How good each frame of a run is: against the reference where there is one, else by itself."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Literal, TypeAlias

import numpy as np

from stereotrack_core.annotation.reference import Reference
from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.evaluation.accuracy import arms_good_to, reference_quality
from stereotrack_core.evaluation.summary import LimbErrors, errors_against
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.tracking.frame import TrackedFrame

from .base import Base
from .changes import Part
from .jobs import LatestOnly
from .runs import RunEntry

Against: TypeAlias = Literal["recording", "project"]

TORSO_POSITION = "torso_position"


@dataclass(frozen=True, eq=False)
class Truth:
    """A trajectory that is taken as truth."""

    against: Against
    words: str  # `the project's reference “fitted to clicks”`
    trajectory: LandmarkTrajectory
    reference: Reference | None = None  # what says how good it is; None where nothing does

    def quality(self, frames: IntArray) -> dict[str, float]:
        """How good it is over some frames, by measure; see :func:`reference_quality`."""
        return {} if self.reference is None else reference_quality(self.reference, frames)


def recorded_truth(trajectory: LandmarkTrajectory | None) -> Truth | None:
    """The recording's own reference, which does not say how good it is."""
    words = "the recording's reference"
    return None if trajectory is None else Truth("recording", words, trajectory)


def project_truth(name: str, reference: Reference) -> Truth:
    """The reference that a project uses."""
    words = f"the project's reference “{name}”"
    return Truth("project", words, reference.trajectory(), reference)


def measure_of(limb: str) -> str:
    """The measure that a limb's error is; the torso's is its long axis."""
    return "torso_long" if limb == "torso" else limb


def with_quality(error: str, good: float | None, digits: int = 1) -> str:
    """``9.1°, reference good to 2.3``; the error alone where the reference does not say."""
    if good is None or not np.isfinite(good):
        return error
    return f"{error}, reference uncertainty {good:.{digits}f}"


LOST_DEG = 45.0  # a limb whose direction is farther off is lost
UNCERTAIN_DEG = 22.5
"""A limb's direction with a larger standard deviation is called uncertain: two of them reach 45
degrees, where a limb is lost."""

UNCERTAIN_SHARE = 0.2  # A limb that is lost with a larger probability is called uncertain
LOST_SHARE = 0.5  # A limb that is lost with a larger probability is called probably lost
USUAL_UNEXPLAINED = 0.3
USUAL_RESIDUAL = 0.03
"""Share of the cloud, and metres, up to which a frame's fit says nothing against its limbs."""

MEASURED_LIMBS = tuple(limb for limb in LIMBS if limb != "head")
"""Limbs that errors are stated for; the head enters no measure."""


@dataclass(frozen=True, eq=False)
class Judgement:
    """A run frame by frame; F frames of the run."""

    # angle against the reference, or the tracker's own standard deviation
    measure: Literal["error", "sigma"]
    frame: IntArray
    limbs: dict[str, FloatArray]  # degrees (F,) by limb; NaN where not known
    tracked: BoolArray
    unexplained_fraction: FloatArray
    errors: LimbErrors | None
    lost: Mapping[str, FloatArray] = field(default_factory=dict)
    """Probability (F,) that a limb is lost, as the tracker itself says; NaN where not known."""
    truth: Truth | None = None

    @property
    def words(self) -> str:
        return "angular error" if self.measure == "error" else "standard deviation"

    @property
    def arms(self) -> FloatArray:
        """Degrees (4, F) of the arm segments."""
        return np.array([values for limb, values in self.limbs.items() if "arm" in limb])

    def errors_at(self, frame: int) -> dict[str, float]:
        """Angles against the reference in a frame, degrees; of the limbs that it knows there."""
        if self.measure != "error":
            return {}
        (places,) = np.nonzero(self.frame == frame)
        found = {limb: float(values[i]) for i in places for limb, values in self.limbs.items()}
        return {limb: error for limb, error in found.items() if np.isfinite(error)}

    @cached_property
    def quality(self) -> Mapping[str, float]:
        """How good the reference is over all frames of the run that it knows, by measure."""
        return self.quality_over(self.frame)

    def quality_over(self, frames: IntArray) -> Mapping[str, float]:
        """How good the reference is over some frames; empty where it does not say."""
        if self.truth is None or self.errors is None:
            return {}
        return self.truth.quality(np.intersect1d(frames, self.errors.frame))


def judged(run: RunEntry, truth: Truth | None) -> Judgement:
    """Judge a run by the reference, or by its own signs where it has none of the run's frames."""
    frames = list(run.ordered())
    numbers = run.numbers()
    tracked = np.array([frame.tracked for frame in frames], dtype=bool)
    unexplained_fraction = np.array(
        [frame.estimate.unexplained_fraction for frame in frames], dtype=np.float64
    )
    lost = _by_limb([frame.estimate.limb_lost for frame in frames])
    if truth is not None and np.isin(numbers, truth.trajectory.frame).any():
        limbs, errors = _errors(run.trajectory(), truth.trajectory)
        return Judgement(
            "error", numbers, limbs, tracked, unexplained_fraction, errors, lost, truth
        )
    limbs = _by_limb([frame.estimate.limb_sigma_deg for frame in frames])
    return Judgement("sigma", numbers, limbs, tracked, unexplained_fraction, None, lost)


def _by_limb(values: Sequence[FloatArray] | FloatArray) -> dict[str, FloatArray]:
    """Values (F,) by limb of those of every frame."""
    stacked = np.array(values).reshape(len(values), len(LIMBS))
    return {limb: stacked[:, LIMBS.index(limb)] for limb in MEASURED_LIMBS}


def _errors(
    found: LandmarkTrajectory, reference: LandmarkTrajectory
) -> tuple[dict[str, FloatArray], LimbErrors]:
    """Errors in the frames that were tracked; what has not been done yet is no error."""
    done = np.isin(reference.frame, found.frame)
    own = LandmarkTrajectory(reference.frame[done], reference.points[done])
    errors = errors_against(found, own)
    values: FloatArray = np.full((len(found.frame), len(LIMBS)), np.nan)
    values[np.searchsorted(found.frame, errors.frame)] = errors.degrees
    return _by_limb(values), errors


def reference_at(reference: LandmarkTrajectory | None, frame: int) -> FloatArray | None:
    """Landmarks (9, 3) of the reference in a frame, None where it has none."""
    if reference is None:
        return None
    place = int(np.searchsorted(reference.frame, frame))
    if place >= len(reference.frame) or reference.frame[place] != frame:
        return None
    points: FloatArray = reference.points[place]
    return points if np.isfinite(points).any() else None


def doubts(tracked: TrackedFrame) -> dict[str, str]:
    """Limbs that the tracker is unsure of, the worst first, with what is to be said of them."""
    chance, sigma = (
        np.nan_to_num(tracked.estimate.limb_lost),
        np.nan_to_num(tracked.estimate.limb_sigma_deg),
    )
    unsure = (chance > UNCERTAIN_SHARE) | (sigma > UNCERTAIN_DEG)
    order = [int(i) for i in np.lexsort((-sigma, -chance)) if unsure[i]]
    return {LIMBS[i]: "likely wrong" if chance[i] > LOST_SHARE else "uncertain" for i in order}


def arms_mean(judgement: Judgement | None, frames: IntArray | None = None) -> float:
    """The score of a run: mean over frames and arm segments, degrees; NaN if unknown.

    The angle against the reference, or the tracker's standard deviation without one.
    """
    if judgement is None:
        return float("nan")
    arms = judgement.arms
    known = arms if frames is None else arms[:, np.isin(judgement.frame, frames)]
    known = known[np.isfinite(known)]
    return float(known.mean()) if len(known) else float("nan")


def worst_frame(judgement: Judgement) -> int | None:
    """The frame in which an arm segment is worst; None if nothing is known."""
    if not np.isfinite(judgement.arms).any():
        return None
    place = int(np.nanargmax(judgement.arms)) % len(judgement.frame)
    return int(judgement.frame[place])


def score_words(judgement: Judgement | None) -> str:
    """The score of a run with its unit, and how good the reference is where it says so."""
    score = arms_mean(judgement)
    if judgement is None or not np.isfinite(score):
        return ""
    sign = "" if judgement.measure == "error" else "± "
    return with_quality(f"{sign}{score:.1f}°", arms_good_to(judgement.quality))


_INTERVAL_MS = 250
_SOON_MS = 20
_FRAMES_OF_MS = 4  # so many frames of a run that grows let it be judged a millisecond later


_Known: TypeAlias = tuple[int, int, Truth | None, Judgement]
"""Restarts of a run's frames, their count, the truth, and the judgement."""


def _judged(runs: Mapping[RunEntry, RunEntry], truth: Truth | None) -> dict[RunEntry, _Known]:
    """Judgements of runs as they are now, made in another thread."""
    return {
        entry: (now.begun, len(now.frames), truth, judged(now, truth))
        for entry, now in runs.items()
    }


class JudgementPresenter:
    """Judgements by run, made in a thread of their own."""

    def __init__(self, base: Base) -> None:
        self._changes, self._tasks = base.changes, base.tasks
        self._document, self._runs = base.document, base.runs
        self._known: dict[RunEntry, _Known] = {}
        self.wanted: Against | None = None
        self._recorded: Truth | None = None
        self._project: Truth | None = None
        self._told: Truth | None = None
        self._worker = LatestOnly(
            self._tasks, lambda judge: judge(), "judge runs", self._on_answered, self._on_failed
        )
        self._timer = base.later(self._ask, 0)

    def of(self, entry: RunEntry | None) -> Judgement | None:
        known = self._known.get(entry) if entry is not None else None
        return known[-1] if known is not None else None

    def all(self) -> dict[RunEntry, Judgement]:
        known = self._known
        return {entry: known[entry][-1] for entry in self._runs.entries if entry in known}

    # ---- what errors are measured against

    @property
    def truth(self) -> Truth | None:
        """The reference that is wanted, where it is there; else the recording's, or the project's.

        None where there is none: runs are judged by their own signs then.
        """
        recording = self._document.recording
        trajectory = recording.reference if recording is not None else None
        if self._recorded is None or self._recorded.trajectory is not trajectory:
            self._recorded = recorded_truth(trajectory)
        there = [self._recorded, self._project]
        if self.wanted == "project":
            there.reverse()
        return next((one for one in there if one is not None), None)

    def has(self, against: Against) -> bool:
        recording = self._document.recording
        if against == "project":
            return self._project is not None
        return recording is not None and recording.reference is not None

    def judge_against(self, wanted: Against | None) -> None:
        """Measure errors against the recording's or the project's reference, where it is there."""
        self.wanted = wanted
        self.judge()

    def set_project_reference(self, name: str, reference: Reference | None) -> None:
        self._project = project_truth(name, reference) if reference is not None else None
        self.judge()

    # ---- judging

    def settled(self) -> bool:
        return not self._timer.isActive() and self._worker.settled()

    def close(self) -> None:
        self._timer.stop()
        self._worker.close()

    def judge(self) -> None:
        """Judge what has grown, when everything that happens now has happened."""
        self._timer.start(0)

    def judge_soon(self) -> None:
        """Judge what grows, now and then: a long run less often, since it takes longer."""
        if not self._timer.isActive():
            longest = max((len(entry.frames) for entry in self._runs.entries), default=0)
            self._timer.start(max(_INTERVAL_MS, longest // _FRAMES_OF_MS))

    def _ask(self) -> None:
        if not self._worker.settled():
            self._timer.start(_SOON_MS)  # what is being judged need not be judged again
            return
        truth, entries = self.truth, set(self._runs.entries)
        if truth is not self._told:
            self._told = truth
            self._changes.tell(Part.TRUTH)
        self._known = {entry: known for entry, known in self._known.items() if entry in entries}
        new = [
            entry
            for entry in entries
            if entry.frames
            and self._known.get(entry, ())[:3] != (entry.begun, len(entry.frames), truth)
        ]
        if new:
            self._worker.ask(partial(_judged, {entry: entry.now() for entry in new}, truth))
        else:
            self._changes.tell(Part.JUDGEMENT)

    def _on_answered(self, _asked: object, found: Mapping[RunEntry, _Known]) -> None:
        there = self._runs.entries
        self._known |= {entry: known for entry, known in found.items() if entry in there}
        self._changes.tell(Part.JUDGEMENT)

    def _on_failed(self, _asked: object, error: Exception) -> None:
        self._tasks.failed(error)
        self._changes.tell(Part.JUDGEMENT)

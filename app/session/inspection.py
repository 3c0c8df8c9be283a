"""The steps of the tracker in the frame that is shown: computed in a process, gone through."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Literal, TypeAlias

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.model import body_of_subject
from stereotrack_core.tracking.estimate import Estimate
from stereotrack_core.tracking.inspection import RecordedStep
from stereotrack_core.tracking.model import TrackModel, cameras_of, model_for
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.trace import Correction, StepTrace, movement
from stereotrack_core.tracking.tuning.process import KeptRecording, RecordStep
from stereotrack_core.worker_processes import TaskProcess

from .base import Base
from .changes import Part
from .jobs import NewestAnswer
from .messages import Message
from .runs import RunEntry
from .tracking import TrackPresenter

StepKind: TypeAlias = Literal[
    "predict", "points", "pairs", "sigma", "cross", "correct", "settle", "search", "collisions",
    "result",
]  # fmt: skip


@dataclass(frozen=True, eq=False)
class Step:
    """One step."""

    kind: StepKind
    title: str
    words: str  # what happens, for somebody who learns the method
    source: str  # where the thesis has it, or what it takes the place of
    heading: str = ""  # of the first step of an iteration; empty elsewhere
    correction: int = -1  # index into the trace's corrections; -1 for steps that belong to none


_THESIS: dict[StepKind, tuple[str, str, str]] = {
    "predict": (
        "Predict",
        "The motion is unknown, so the body is predicted to stay where it was. Only the "
        "uncertainty grows: the process noise Q is added to the covariance P.",
        "Section 3.2.1 and figure 3.8: x[k+1|k] = x[k|k], P[k+1|k] = P[k|k] + Q",
    ),
    "points": (
        "Sample",
        "The same number of points is sampled from each cone of the model. Points inside another "
        "cone and points that no camera can see are dropped, because nothing can be measured "
        "there.",
        "Equation (3.4), figure 3.5",
    ),
    "pairs": (
        "Correspondences",
        "Each model point is paired with its nearest measured point. Both are projected on the "
        "line that joins them, so each pair gives one number: the distance between them.",
        "Section 2.3, equations (3.5) to (3.8), figures 3.6 and 3.10",
    ),
    "sigma": (
        "Sigma points",
        "A few poses represent the estimate and its uncertainty: the estimate itself and, for "
        "each uncertain direction, one pose on either side (thin outlines).",
        "Equations (2.12) to (2.14), figure 3.9",
    ),
    "cross": (
        "Cross-covariance",
        "P_xz: how a change of each state goes along with the residual of each pair. The table has "
        "the strongest correlation of a state (row) with the pairs of a part (column); at 0 the "
        "part says nothing about the state.",
        "Equations (2.9) and (2.18), figure 3.14",
    ),
    "correct": (
        "Correct",
        "The residual, weighted by the gain K = P_xz P_νν⁻¹, corrects the state, and the "
        "covariance shrinks. Thin outlines: the model before the correction.",
        "Section 3.2.3: x + Kν and P − K P_νν Kᵀ with P_νν = P_zz + R",
    ),
    "collisions": (
        "Collisions",
        "After the last iteration, arms that are too close to the torso or bent too far are moved "
        "to the minimum distance or angle. Thin outlines: the model before.",
        "Section 3.2.4, figure 3.15",
    ),
    "result": (
        "Result",
        "The pose of this frame. The next frame starts from it and from its covariance.",
        "Section 3.2.3: x[k+1|k+1], P[k+1|k+1]",
    ),
}

_MANIFOLD: dict[StepKind, tuple[str, str, str]] = {
    "predict": (
        "Predict",
        "The body is predicted to stay. The uncertainty grows by the process noise Q.",
        "Section 3.2.1, figure 3.8; rotation states are small rotation vectors, free of "
        "singularities",
    ),
    "points": (
        "Measure",
        "Points are sampled from the cloud. They are assigned to the model (data-to-model), where "
        "the thesis assigns model points to the cloud. A misplaced arm therefore still has data "
        "that attract it.",
        "Replaces equation (3.4)",
    ),
    "pairs": (
        "Correspondences",
        "Each measured point is assigned to the nearest cone and compared along the surface "
        "normal there. Its weight falls with distance and is zero beyond the maximum "
        "correspondence distance.",
        "Replaces equations (3.5) to (3.8)",
    ),
    "sigma": (
        "Sigma points",
        "Poses that represent the estimate and its uncertainty (thin outlines). This tracker "
        "linearises by derivatives; the poses only illustrate its uncertainty.",
        "Equations (2.12) to (2.14), figure 3.9",
    ),
    "cross": (*_THESIS["cross"][:2], "Equation (2.11), P_xz = P Hᵀ; figure 3.14"),
    "correct": (
        "Correct",
        "The prediction is corrected by all correspondences at once, linearised at the start of "
        "the iteration. Joint limits, other sensors and the prediction itself contribute as well.",
        "Section 3.2.3, iterated by posterior linearisation (DOI 10.1109/TSP.2015.2454485)",
    ),
    "settle": (
        "Fit pose",
        "This method finds the pose without a cross-covariance. Thin outlines: the prediction.",
        "Named in the thesis as an alternative; used here as a baseline",
    ),
    "search": (
        "Arm search",
        "Many other positions of both arms are scored and the best pairs are refined. One of them "
        "is chosen if it explains the frame clearly better. Thin outlines: rejected pairs.",
        "Not in the thesis, whose section 3.2.4 describes arms that stay caught on other parts",
    ),
    "result": _THESIS["result"],
}
_KEYPOINTS: dict[StepKind, tuple[str, str, str]] = {
    **_MANIFOLD,
    "pairs": (
        "Measure",
        "There is no cloud. Each keypoint is compared with the picture of the point of the body "
        "that it names, and contours with those of the body. The weight of a keypoint falls with "
        "its distance; where three cameras agree, what contradicts them is left out.",
        "Not in the thesis; docs/keypoints.md",
    ),
    "correct": (
        "Correct",
        "The prediction is corrected by all keypoints and contours at once, linearised at the "
        "start of the iteration. Joint limits and the prediction itself contribute as well.",
        _MANIFOLD["correct"][2],
    ),
}
_IN_ITERATION: tuple[StepKind, ...] = ("points", "pairs", "sigma", "cross", "correct")
_OF_POINTS = frozenset[StepKind]({"points", "cross"})
"""Stages that are about points of a cloud alone."""


def steps_of(trace: StepTrace) -> tuple[Step, ...]:
    """All steps of a frame in their order."""
    cloudless = bool(trace.corrections) and not any(len(c.points.part) for c in trace.corrections)
    texts = _THESIS if trace.method == "thesis" else _KEYPOINTS if cloudless else _MANIFOLD
    after = "After the iterations"
    steps = [Step("predict", *texts["predict"], "Prediction")]
    kinds = [kind for kind in _IN_ITERATION if not cloudless or kind not in _OF_POINTS]
    for index, correction in enumerate(trace.corrections):
        for kind in kinds:
            heading = _heading_of(correction) if kind == kinds[0] else ""
            steps.append(Step(kind, *texts[kind], heading, index))
    if trace.measured:
        steps.append(Step("pairs", *texts["pairs"], "Estimate"))
        steps.append(Step("settle", *texts["settle"]))
    if trace.search is not None:
        steps.append(Step("search", *texts["search"], after))
    if trace.jump is not None:
        steps.append(Step("collisions", *texts["collisions"], after))
    return (*steps, Step("result", *texts["result"], "" if len(steps) > 1 else after))


def _heading_of(correction: Correction) -> str:
    again = ", with prior inflation" if correction.stage == "again" else ""
    return f"Iteration {correction.iteration}{again}"


def name_of(step: Step, trace: StepTrace) -> str:
    """A step with its iteration: ``Iteration 2: Correct``."""
    if step.correction < 0:
        return step.title
    return f"{_heading_of(trace.corrections[step.correction])}: {step.title}"


_SMOOTHED = " The run was smoothed, so its poses also depend on later frames."
_LOOKED_AGAIN = " A second look changed the frame; its arms then come from other random numbers."
_SAME_METRES, _SAME_RADIANS = 1e-4, np.radians(0.01)


@dataclass(frozen=True, eq=False)
class Question:
    """Frame, run and settings of a step that is to be recorded."""

    frame: int
    work: Callable[[], RecordedStep]
    found: Estimate | None  # estimate of the run in this frame, to be compared with
    source: RunEntry | None
    settings: Settings


@dataclass(frozen=True, eq=False)
class Answer:
    """The recorded step, its stages, and its difference from the run."""

    question: Question
    done: RecordedStep
    steps: tuple[Step, ...]
    compared: str


def answer(question: Question) -> Answer:
    """Have the step done; called in a thread of its own."""
    done = question.work()
    return Answer(question, done, steps_of(done.trace), _compared(done.trace, question.found))


def question_of(
    frame: int,
    track: TrackPresenter,
    process: TaskProcess,
    entry: RunEntry | None,
    settings: Settings,
    truth: FloatArray | None = None,
) -> Question:
    """About a frame of a run, or about one that no run knows.

    True landmarks (9, 3) are recorded beside the step, which never sees them.
    """
    kept = track.kept
    assert kept is not None  # noqa: S101 - there are no frames without
    seen = (entry.at(k) if entry is not None else None for k in (frame - 1, frame))
    before, here = (one.estimate if one is not None else None for one in seen)
    make = _maker(kept, entry, settings)
    spec, here_alone = None if entry is None else entry.spec(), range(frame, frame + 1)
    keypoints = track.keypoints.for_trial(settings, here_alone) if spec is None else spec.keypoints
    of_frame = None if entry is None else entry.at(frame)
    looked = None if of_frame is None else of_frame.keypoints
    views = tuple((spec and spec.views) or ())
    task = RecordStep(kept, frame, settings, make, before, here, keypoints, looked, truth, views)
    more = _SMOOTHED if entry is not None and entry.meta.get("smoothed") else ""
    if entry is not None and any(a <= frame <= b for a, b in entry.looked_again):
        more += _LOOKED_AGAIN

    def work() -> RecordedStep:
        done: RecordedStep = process(task)
        return replace(done, words=done.words + more)

    return Question(frame, work, here, entry, settings)


def _maker(
    of: KeptRecording, entry: RunEntry | None, settings: Settings
) -> Callable[[], TrackModel]:
    """Function that makes the model of a run, or of the next run if there is none."""
    recording, usable = of.recording, of.views
    if entry is None:
        body, views, seed = body_of_subject(recording.subject, settings.body), usable, 0
    else:
        spec = entry.spec()
        kept = tuple(name for name in (spec and spec.views) or () if name in usable)
        body, views, seed = entry.body, kept or usable, spec.seed if spec else 0
    cameras, clouds = cameras_of(recording, views), not of.mono
    return partial(model_for, body, settings, cameras, recording.fps, seed, clouds=clouds)


def _compared(trace: StepTrace, found: Estimate | None) -> str:
    if found is None or not (found.tracked and trace.estimate.tracked):
        return ""
    off = movement(trace.body, found.pose, trace.after.pose)
    angle = max(off.turn, float(np.nanmax(off.limbs)))
    if off.shift < _SAME_METRES and angle < _SAME_RADIANS:
        return "The result equals the pose of the run."
    by = f"{1000.0 * off.shift:.1f} mm and up to {np.degrees(angle):.1f}°"
    return f"The result differs from the pose of the run by {by}."


_SOON_MS = 60


class InspectionPresenter:
    """Has the step of the frame that is shown recorded, and goes through its stages."""

    def __init__(
        self, base: Base, track: TrackPresenter, true_landmarks: Callable[[int], FloatArray | None]
    ) -> None:
        self._base, self._document, self._track = base, base.document, track
        self._true_landmarks = true_landmarks
        self.on = False  # whether the frame that is shown is inspected
        self._asked: Question | None = None
        self._chosen: Step | None = None
        self._newest = NewestAnswer(
            base.tasks, lambda: self._asked, answer, "record step trace", self._on_known
        )
        self._soon = base.later(self._ask, _SOON_MS)
        watch = base.changes.watch
        watch(Part.FRAME | Part.PLAYING | Part.TRACKING, self._ask_soon)
        watch(Part.ACTIVE_RUN | Part.WORKSPACE | Part.LEAVING, self.leave)

    @property
    def known(self) -> Answer | None:
        """The recorded step; that of the frame before until the one of this frame is there."""
        return self._newest.known

    @property
    def index(self) -> int:
        """Number of the stage that is shown: in another frame the one that corresponds to it."""
        if self.known is None or self._chosen is None:
            return 0
        wanted = self._chosen.kind, self._chosen.correction
        stages = [(one.kind, one.correction) for one in self.known.steps]
        return stages.index(wanted) if wanted in stages else len(stages) - 1

    @property
    def step(self) -> Step | None:
        return self.known.steps[self.index] if self.known is not None else None

    @property
    def busy(self) -> bool:
        """Whether the step that is known is that of another frame than the one asked for."""
        known = self.known
        elsewhere = known is not None and known.question.frame != self._document.frame
        return elsewhere and not self.settled()

    def settled(self) -> bool:
        asks = self.on and not self._waits()
        return not asks or (not self._soon.isActive() and self._newest.settled())

    def why_no_step(self, by: int) -> str:
        if self.known is None:
            return "No step trace is shown. Choose Inspect step first."
        if 0 <= self.index + by < len(self.known.steps):
            return ""
        return "This is the last stage." if by > 0 else "This is the first stage."

    # ---- what a person does

    def begin(self) -> None:
        """Inspect the frame that is shown, and follow it from now on."""
        self._document.pause()
        self.on = True
        self._ask()
        self._tell()

    def leave(self) -> None:
        """Show the run again."""
        if self.on:
            self.on, self._chosen = False, None
            self._ask_nothing()

    def go(self, index: int) -> None:
        if self.known is not None and 0 <= index < len(self.known.steps) and index != self.index:
            self._chosen = self.known.steps[index]
            self._tell()

    # ---- asking

    def _ask_soon(self) -> None:
        # a tracker that is held tells so all the time
        if self.on and not self._soon.isActive():
            self._soon.start()

    def _waits(self) -> bool:
        return self._document.playing or self._track.running

    def _ask_nothing(self) -> None:
        self._asked = None
        self._newest.close()
        self._base.view_state.draw(None)
        self._tell()

    def _ask(self) -> None:
        self._soon.stop()
        if not self.on or self._document.recording is None:
            return
        if self._waits():
            if not self._newest.settled():
                self._ask_nothing()  # the tracker needs the time
            return
        frame, entry, asked = self._document.frame, self._base.runs.active, self._asked
        settings = self._track.settings if entry is None else entry.made_with()
        if settings is None:
            self.leave()
            what, name = "the run does not state its settings", entry.name if entry else ""
            self._base.tell(Message("error", what, name, "Run the tracker first."))
            return
        known = None if asked is None else (asked.frame, asked.source, asked.settings)
        if known != (frame, entry, settings):
            process, truth = self._base.processes.trials, self._true_landmarks(frame)
            self._asked = question_of(frame, self._track, process, entry, settings, truth)
            self._newest.ask()
            self._tell()

    def _on_known(self) -> None:
        if self.known is None:  # it could not be recorded
            self.leave()
        else:
            self._chosen = self.step
            self._tell()

    def _tell(self) -> None:
        self._base.changes.tell(Part.INSPECTION)

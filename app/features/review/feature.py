"""Review: where a run fails: the curves of its errors, the lanes, and its failures."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import chain
from typing import TypeAlias

import numpy as np
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QStackedWidget

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.evaluation.accuracy import arms_good_to
from stereotrack_core.recording.description import Segment
from stereotrack_core.recording.landmarks import LandmarkTrajectory

from ...context import Context
from ...services.actions import Command, Menu
from ...services.layout import Workspace
from ...session.changes import RECORDING, Part
from ...session.judgement import LOST_SHARE, MEASURED_LIMBS, Judgement, measure_of, with_quality
from ...session.runs import RunEntry
from ...session.session import Session, Snapshot
from ...widgets.plots.limb_plots import ErrorPlot
from ...widgets.plots.plots import Curve, Emphasis
from ...widgets.style.building import label
from ...widgets.style.colours import EXTRA_COLOURS, LIMB_COLOURS, LineStyle, limb_words
from ...widgets.timeline.lanes import Lane, Span
from .failures import FailureController

_FULL_DEG = 45.0  # angle that is shown in a lane's full colour; more than this is a lost limb
_NO_CURVES = (
    "Run the tracker to see the error of each limb: against the reference where there is one, "
    "otherwise as estimated by the tracker."
)


class ErrorCurves:
    """Draws the error of every limb; its threshold is everybody's."""

    def __init__(self, context: Context) -> None:
        self._context, self._session = context, context.session
        self.plot = ErrorPlot(
            context.session.document.visit,
            context.view_state.set_threshold,
            context.docks.timeline.set_visible_range,
        )
        self._drawn: tuple[list[DrawnRun], int] = [], 0
        self._lanes_of: tuple[object, ...] = ()
        centre = Qt.AlignmentFlag.AlignCenter
        self._no_curves = label(_NO_CURVES, "muted", margins=(16, 0, 16, 0), align=centre)
        self.stack = QStackedWidget()
        self.stack.addWidget(self.plot)
        self.stack.addWidget(self._no_curves)
        # the plot says by itself what it shows, and its height is wanted for curves
        context.docks.add("plot", "Limb errors", self.stack, titled=False)
        timeline = context.docks.timeline
        timeline.visible_range_changed.connect(self.plot.set_visible_range)
        timeline.margins_changed.connect(self.plot.set_margins)
        self.plot.set_margins(*timeline.margins)
        watch, state = context.session.changes.watch, context.view_state
        watch(Part.THRESHOLD, lambda: self.plot.set_threshold(state.threshold))
        watch(Part.FRAME, lambda: self.plot.set_frame(context.session.document.frame))
        context.show(Part.JUDGEMENT | RECORDING, self.show)

    def show(self, now: Snapshot) -> None:
        judgement, every, count = now.judgement, now.judgements, now.frame_count
        if judgement is not None:
            self.plot.set_heading(*heading_words(judgement))
        self.stack.setCurrentWidget(self.plot if every else self._no_curves)
        front = now.front if now.front in every else None
        drawn: list[DrawnRun] = [
            (one.name, now.styles[one], _emphasis(one, front), every[one])
            for one in every
            if one.visible
        ]
        if (drawn, count) != self._drawn:
            self._drawn = drawn, count
            self.plot.set_curves(curves_of(drawn, count))
        timeline, truth = self._context.docks.timeline, now.truth
        segments = now.recording.segments if now.recording is not None else ()
        if (judgement, count, segments, truth) != self._lanes_of:
            self._lanes_of = judgement, count, segments, truth
            reference = truth.trajectory if truth is not None else None
            timeline.set_lanes(lanes_of(judgement, count, segments, reference))
        timeline.set_hint(self._hint(now))

    def _hint(self, now: Snapshot) -> str:
        if now.recording is None:
            return ""
        if why_not := self._session.not_tracked():
            return why_not
        keys = self._context.actions.shortcut("run")
        return f"Run the tracker ({keys}) to see a lane for each limb."

    def move_threshold(self, degrees: float) -> None:
        state = self._context.view_state
        state.set_threshold(min(max(state.threshold + degrees, 0.0), 180.0))
        self._context.notifier.say(f"Threshold: {state.threshold:.0f}°.", 3000)

    def go_above(self, direction: int) -> None:
        here, frame = self._session.document.frame, self.plot.crossing(direction)
        if frame is None:
            self._context.notifier.say("No limb exceeds the threshold.", 4000)
            return
        self._session.document.visit(frame)
        if (frame - here) * direction <= 0:
            end = "the end" if direction > 0 else "the beginning"
            self._context.notifier.say(f"Stretch above threshold, coming round from {end}.", 4000)


def heading_words(judgement: Judgement) -> tuple[str, str, str]:
    """Heading of the plot: what it shows and how good that is, in full, in brief, and by limb."""
    if judgement.truth is None:
        return judgement.words, "", ""
    good = arms_good_to(judgement.quality)
    full = with_quality(judgement.words, good)
    if full == judgement.words:
        return full, "", f"Against {judgement.truth.words}, whose uncertainty is not known."
    limbs = ", ".join(
        f"{limb_words(limb)} {judgement.quality[measure_of(limb)]:.1f}°"
        for limb in MEASURED_LIMBS
        if measure_of(limb) in judgement.quality
    )
    tip = f"Against {judgement.truth.words}, with the uncertainty: {limbs}."
    return f"{full}° (arms)", f"reference ± {good:.1f}°", tip


DrawnRun: TypeAlias = tuple[str, LineStyle, Emphasis, Judgement]
"""A run's name, how its curves are drawn, and what they show."""


def _emphasis(run: RunEntry, front: RunEntry | None) -> Emphasis:
    """A trial in front of the run and of other trials; all alike where there is none."""
    return "usual" if front is None else "front" if run is front else "behind"


def curves_of(runs: Iterable[DrawnRun], count: int) -> tuple[Curve, ...]:
    """One curve per limb and run, over all `count` frames, so that it stays under the timeline."""
    curves: list[Curve] = []
    every = np.arange(count)
    for name, style, emphasis, judgement in runs:
        values = {limb: (LIMB_COLOURS[limb], judgement.limbs[limb]) for limb in MEASURED_LIMBS}
        for extra, colour in EXTRA_COLOURS.items():
            values[extra] = (colour, 100.0 * judgement.unexplained_fraction)
        for limb, (colour, value) in values.items():
            spread = _spread(judgement, value, count)
            curves.append(Curve(name, limb, colour, style, every, spread, emphasis=emphasis))
    return tuple(curves)


def lanes_of(
    judgement: Judgement | None,
    count: int,
    segments: Sequence[Segment],
    reference: LandmarkTrajectory | None,
) -> tuple[Lane, ...]:
    """Lanes of the recording and of the active run.

    The recording's segments, and where its reference is known unless that is everywhere; then a
    heat strip per limb, the share of the cloud that is not explained, and untracked stretches.
    """
    lanes = []
    if segments:
        named = [Span(s.first, s.end - 1, s.name) for s in segments]
        lanes.append(Lane("segments", "#9a86c8", "bars", named))
    if reference is not None:
        known = reference.frame[np.isfinite(reference.points).any(axis=(1, 2))]
        if len(known) and len(known) < count:
            lanes.append(Lane("reference", "#9a86c8", "bars", _stretches(known, "known")))
    if judgement is None:
        return tuple(lanes)
    for limb in MEASURED_LIMBS:
        values = _spread(judgement, judgement.limbs[limb], count)
        unit = with_quality("°", judgement.quality.get(measure_of(limb)))
        lanes.append(Lane(limb_words(limb), LIMB_COLOURS[limb], "heat", values, _FULL_DEG, unit))
    if np.isfinite(judgement.unexplained_fraction).any():  # mono views have no cloud
        share = _spread(judgement, 100.0 * judgement.unexplained_fraction, count)
        colour = EXTRA_COLOURS["unexplained %"]
        lanes.append(Lane("unexplained", colour, "heat", share, 60.0, "% of the cloud"))
    doubted = _doubted(judgement)
    if doubted:
        lanes.append(Lane("likely wrong", "#d08a50", "bars", doubted))
    lost = judgement.frame[~judgement.tracked]
    if len(lost):
        lanes.append(Lane("not tracked", "#d05050", "bars", _stretches(lost, "not tracked")))
    return tuple(lanes)


def _doubted(judgement: Judgement) -> list[Span]:
    """Stretches in which the tracker takes the same limbs for lost."""
    chances = {limb: chance > LOST_SHARE for limb, chance in judgement.lost.items()}
    named: dict[str, list[int]] = {}
    for place, frame in enumerate(judgement.frame):
        limbs = [limb_words(limb) for limb, lost in chances.items() if lost[place]]
        if limbs:
            named.setdefault(", ".join(limbs), []).append(int(frame))
    spans = (_stretches(np.array(frames), words) for words, frames in named.items())
    return sorted(chain(*spans), key=lambda span: span.first)


def _spread(judgement: Judgement, values: FloatArray, count: int) -> FloatArray:
    result: FloatArray = np.full(count, np.nan)
    inside = judgement.frame < count
    result[judgement.frame[inside]] = values[inside]
    return result


def _stretches(frames: IntArray, label: str) -> list[Span]:
    breaks = np.flatnonzero(np.diff(frames) > 1) + 1
    return [Span(int(part[0]), int(part[-1]), label) for part in np.split(frames, breaks)]


_STEP_DEG = 5.0


@dataclass(frozen=True)
class Review:
    """What reviewing consists of."""

    plot: ErrorCurves
    failures: FailureController


def register(context: Context) -> Review:
    """Offer the workspace Review, its panels and its commands."""
    review = Review(ErrorCurves(context), FailureController(context))
    session = context.session
    space = Workspace(
        "review", "Review", "Find and understand the failures of a run.", "threshold",
        side=(("scene",), ("failures", "comparison", "numbers", "runs")),
        bottom=("plot", "timeline"), side_share=0.37, bottom_shares=(0.27, 0.16),
        side_heights=(1, 2), tall_side=True,
        why_not=lambda: session.no_run() and session.not_tracked(),
    )  # fmt: skip
    context.docks.add_workspace(space)
    context.actions.add(_commands(session, review.plot, review.failures))
    return review


def _commands(session: Session, plot: ErrorCurves, e: FailureController) -> list[Command]:
    go, command = Menu("&Go", session.no_run).command, Menu("&Review", session.no_run).command
    failure = Menu("&Go", e.none_listed).command
    stretch = "stretch in which the error of a limb exceeds the threshold of the plot."
    return [
        go("next_above", "Next stretch above threshold", f"Go to the next {stretch}",
           partial(plot.go_above, 1), "N", "next-failure", section=True),
        go("previous_above", "Previous stretch above threshold", f"Go to the previous {stretch}",
           partial(plot.go_above, -1), "P", "previous-failure"),
        command("threshold_up", "Raise threshold", "Raise the threshold of the plot by 5°.",
                partial(plot.move_threshold, _STEP_DEG), "Ctrl+Alt+Up", "threshold"),
        command("threshold_down", "Lower threshold", "Lower the threshold of the plot by 5°.",
                partial(plot.move_threshold, -_STEP_DEG), "Ctrl+Alt+Down", "threshold"),
        failure("next_failure", "Next failure", "Go to the worst frame of the next listed failure "
                "of the active run.", partial(e.go, 1), "Shift+N", "next-failure", section=True),
        failure("previous_failure", "Previous failure", "Go to the worst frame of the previous "
                "listed failure.", partial(e.go, -1), "Shift+P", "previous-failure"),
        failure("loop_failure", "Loop failure", "Play the selected failure in a loop, with a few "
                "frames before and after it.", e.toggle_loop, "Shift+Space", "iterate",
                checked=e.looping),
    ]  # fmt: skip

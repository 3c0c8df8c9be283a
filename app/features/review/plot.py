"""The plot of errors and the timeline's lanes of the runs follow their judgements."""

from collections.abc import Iterable, Sequence
from itertools import chain
from typing import TypeAlias

import numpy as np
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QStackedWidget

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.recording.description import Segment
from stereotrack_core.recording.landmarks import LandmarkTrajectory

from ...context import Context
from ...session.changes import RECORDING, Part
from ...session.judgement import (
    LOST_SHARE,
    MEASURED_LIMBS,
    Judgement,
    heading_words,
    measure_of,
    with_quality,
)
from ...session.runs import RunEntry
from ...widgets.plots.limb_plots import ErrorPlot
from ...widgets.plots.plots import Curve, Emphasis
from ...widgets.style.building import label
from ...widgets.style.colours import EXTRA_COLOURS, LIMB_COLOURS, LineStyle, limb_words
from ...widgets.timeline.lanes import Lane, Span

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
        self._connect()

    def _connect(self) -> None:
        plot, session, state = self.plot, self._session, self._context.view_state
        timeline = self._context.docks.timeline
        timeline.visible_range_changed.connect(plot.set_visible_range)
        timeline.margins_changed.connect(plot.set_margins)
        plot.set_margins(*timeline.margins)
        watch = session.changes.watch
        watch(Part.THRESHOLD, lambda: plot.set_threshold(state.threshold))
        watch(Part.FRAME, lambda: plot.set_frame(session.document.frame))
        watch(Part.JUDGEMENT, lambda: self._context.docks.redraw.soon(self.show))
        watch(RECORDING, self.show)

    def show(self) -> None:
        judging, runs, document = self._session.judging, self._session.runs, self._session.document
        recording, count = document.recording, document.frame_count
        judgement, every = judging.of(runs.active), judging.all()
        if judgement is not None:
            self.plot.set_heading(*heading_words(judgement))
        self.stack.setCurrentWidget(self.plot if every else self._no_curves)
        front = runs.front if runs.front in every else None
        drawn: list[DrawnRun] = [
            (one.name, runs.style(one), _emphasis(one, front), every[one])
            for one in every
            if one.visible
        ]
        if (drawn, count) != self._drawn:
            self._drawn = drawn, count
            self.plot.set_curves(curves_of(drawn, count))
        segments = recording.segments if recording is not None else ()
        truth, timeline = judging.truth, self._context.docks.timeline
        if (judgement, count, segments, truth) != self._lanes_of:
            self._lanes_of = judgement, count, segments, truth
            reference = truth.trajectory if truth is not None else None
            timeline.set_lanes(lanes_of(judgement, count, segments, reference))
        timeline.set_hint(self._hint())

    def _hint(self) -> str:
        if self._session.document.recording is None:
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

"""Review: where a run fails: the curves of its errors, the lanes, and its failures."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import chain
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QStackedWidget

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.counting import counted
from stereotrack_core.evaluation.accuracy import arms_good_to
from stereotrack_core.evaluation.failure_segments.reasons import reasons_words
from stereotrack_core.evaluation.failure_segments.segment import (
    CAUSE_WORDS,
    FailureSegment,
    has_signs,
    limbs_words,
)
from stereotrack_core.recording.description import Segment
from stereotrack_core.recording.landmarks import LandmarkTrajectory

from ...context import Context
from ...services.actions import Command, Menu
from ...services.docks import Workspace
from ...session.changes import PROJECT, RECORDING, Part
from ...session.judgement import LOST_SHARE, MEASURED_LIMBS, Judgement, measure_of, with_quality
from ...session.runs import RunEntry
from ...session.session import Session, Snapshot
from ...widgets.style.building import label
from ...widgets.style.colours import EXTRA_COLOURS, LIMB_COLOURS, Emphasis, LineStyle, limb_words
from ...widgets.tables.failures_panel import FailuresPanel
from ...widgets.timeline.lanes import Lane, Span
from .remedies import RemedyController
from .strip import FilmStrip, strip_command

if TYPE_CHECKING:
    from ...widgets.plots.limb_plots import ErrorPlot
    from ...widgets.plots.plots import Curve

_FULL_DEG = 45.0  # angle that is shown in a lane's full colour; more than this is a lost limb
_NO_CURVES = (
    "Run the tracker to see the error of each limb: against the reference where there is one, "
    "otherwise as estimated by the tracker."
)
_TRACKING = "The tracker is running. Errors are shown from its first frame on."


class ErrorCurves:
    """Draws the error of every limb; its threshold is everybody's."""

    def __init__(self, context: Context) -> None:
        self._context, self._session = context, context.session
        self.plot: ErrorPlot
        self._drawn: tuple[list[DrawnRun], int] = [], 0
        self._lanes_of: tuple[object, ...] = ()
        centre = Qt.AlignmentFlag.AlignCenter
        self._no_curves = label(_NO_CURVES, "muted", margins=(16, 0, 16, 0), align=centre)
        self.stack = QStackedWidget()
        self.stack.addWidget(self._no_curves)
        # the plot says by itself what it shows, and its height is wanted for curves
        context.docks.add("plot", "Limb errors", self.stack, titled=False)
        context.session.changes.watch(Part.RECORDING_OPENED, self._make_plot)

    def _make_plot(self) -> None:
        """Make the plot with the first recording: pyqtgraph loads as long as the whole window."""
        if self.stack.count() > 1:
            return
        from ...widgets.plots.limb_plots import ErrorPlot

        context, document = self._context, self._session.document
        state, timeline = context.view_state, context.docks.timeline
        self.plot = ErrorPlot(document.visit, state.set_threshold, timeline.set_visible_range)
        self.stack.addWidget(self.plot)
        timeline.visible_range_changed.connect(self.plot.set_visible_range)
        timeline.margins_changed.connect(self.plot.set_margins)
        for panel in (self.plot, timeline):
            panel.hovered.connect(self.plot.set_hover)
            panel.hovered.connect(timeline.set_hover)
        self.plot.set_margins(*timeline.margins)
        watch = self._session.changes.watch
        watch(Part.SELECTION, lambda: self.plot.set_selection(state.selection))
        watch(Part.THRESHOLD, lambda: self.plot.set_threshold(state.threshold))
        watch(Part.FRAME, lambda: self.plot.set_frame(document.frame))
        self.plot.set_threshold(state.threshold)
        self.plot.set_frame(document.frame)
        parts = Part.JUDGEMENT | RECORDING | PROJECT | Part.SCENARIOS | Part.RUNS
        for show in (self.show, self._show_lanes):  # one after the other: both take their time
            context.show(parts, show)

    def show(self, now: Snapshot) -> None:
        judgement, every, count = now.judgement, now.judgements, now.frame_count
        if judgement is not None:
            self.plot.set_heading(*heading_words(judgement))
        self._no_curves.setText(_NO_CURVES if now.in_progress is None else _TRACKING)
        self.stack.setCurrentWidget(self.plot if every else self._no_curves)
        front = now.front if now.front in every and now.front is not now.active else None
        front = front if front is not None and front.visible else None
        drawn: list[DrawnRun] = [
            (one.name, now.styles[one], _emphasis(one, front), every[one])
            for one in every
            if one.visible
        ]
        if (drawn, count) != self._drawn:
            self._drawn = drawn, count
            self.plot.set_curves(curves_of(drawn, count))

    def _show_lanes(self, now: Snapshot) -> None:
        judgement, count, truth = now.judgement, now.frame_count, now.truth
        timeline = self._context.docks.timeline
        segments = self._session.segments()
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
        if now.in_progress is not None:
            return _TRACKING
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


def curves_of(runs: Iterable[DrawnRun], count: int) -> tuple["Curve", ...]:
    """One curve per limb and run, over all `count` frames, so that it stays under the timeline."""
    from ...widgets.plots.plots import Curve

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


def _beside(segments: Sequence[Segment]) -> list[list[Span]]:
    """Spans of segments in as few lists as there are overlaps."""
    rows: list[list[Span]] = []
    for one in segments:
        span = Span(one.first, one.end - 1, one.name)
        free = (r for r in rows if all(s.last < span.first or s.first > span.last for s in r))
        row = next(free, None)
        if row is None:
            rows.append(row := [])
        row.append(span)
    return rows


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
    lanes = [Lane("segments", "#9a86c8", "bars", spans) for spans in _beside(segments)]
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


LANE_NAMES = {"truth": "failures", "signs": "failures (without reference)"}
LANE_COLOURS = {"truth": "#CC79A7", "signs": "#b8860b"}


def lanes_of_failures(failures: Sequence[FailureSegment]) -> tuple[Lane, ...]:
    """A lane of bars for those found with truth and for those found without."""
    lanes = []
    for found, name in LANE_NAMES.items():
        spans: list[Span] = []
        for e in sorted((e for e in failures if e.found == found), key=lambda e: e.first):
            label = f"{limbs_words(e.limbs)}: {CAUSE_WORDS[e.verdict.cause]}"
            if spans and e.first <= spans[-1].last:
                # labels of bars that overlap would stand on each other
                old = spans.pop()
                spans.append(Span(old.first, max(old.last, e.last), f"{old.label}; {label}"))
            else:
                spans.append(Span(e.first, e.last, label))
        if spans:
            lanes.append(Lane(name, LANE_COLOURS[found], "bars", spans))
    return tuple(lanes)


_NOT_JUDGED = (
    "Without depth, failures are detected against a reference alone. Choose one under Track, "
    "Errors against."
)


class FailureController:
    """Shows the failures of the active run, and hands on what a person does with them."""

    def __init__(self, context: Context) -> None:
        self._context, self._state = context, context.session.failures
        state = self._state
        self.panel = FailuresPanel(
            lambda place: state.choose(state.listed[place] if place >= 0 else None),
            lambda place: state.jump(state.listed[place]),
            state.filter,
            partial(context.session.changes.tell, Part.PARAMETER_WANTED),
        )
        context.docks.add("failures", "Failures", self.panel)
        self._lanes: tuple[FailureSegment, ...] = ()
        facts = Part.FAILURES | Part.ACTIVE_RUN
        context.show(facts, self._show, "failures")
        context.show(facts | Part.WORKSPACE, self._show_lanes)

    def _show(self, now: Snapshot) -> None:
        state, fps = self._state, 1.0 if now.recording is None else now.recording.fps
        listed, chosen = state.listed, state.chosen
        state.explain()
        place = listed.index(chosen) if chosen in listed else -1
        self.panel.show_rows(listed, fps, place, self._words(now))

    def _show_lanes(self, _now: Snapshot) -> None:
        docks = self._context.docks
        lanes = () if docks.workspace == "annotate" else self._state.listed
        if lanes != self._lanes:
            self._lanes = lanes
            docks.timeline.set_lanes(lanes_of_failures(lanes), "failures")
        self._context.actions.refresh_soon()

    def _words(self, now: Snapshot) -> str:
        found, listed = self._state.found, self._state.listed
        if now.active is None:
            return "Run the tracker to see the failures of a run."
        if found is None:
            return "Detecting failures …"
        if found.search is None:
            return "The source recording of the run is not known, so failures cannot be detected."
        every = found.failures
        if not every:
            judged = found.search.reference is not None or has_signs(found.search.run)
            return "No failure was detected." if judged else _NOT_JUDGED
        words, why = counted(len(every), "failure"), reasons_words(one.reason for one in every)
        errors = [-1.0 if e.error_deg is None else e.error_deg for e in every]
        threshold = found.search.rules.episode_error
        if all(e.found == "signs" for e in every) and 0.0 <= min(errors) <= max(errors) < threshold:
            stretches = "1 stretch" if len(every) == 1 else f"{len(every)} stretches"
            words = f"{stretches} flagged; largest error "
            words += f"{max(errors):.0f}°, below your threshold of {threshold:.0f}°"
        if len(listed) < len(every):
            words = f"{len(listed)} of {len(every)} failures"
        if self._state.explaining:
            words += "; images are being analysed for causes"
        return f"{words}. Where they begin: {why}." if why else f"{words}."


_STEP_DEG = 5.0


@dataclass(frozen=True)
class Review:
    """What reviewing consists of."""

    plot: ErrorCurves
    failures: FailureController
    strip: FilmStrip
    remedies: RemedyController


def register(context: Context) -> Review:
    """Offer the workspace Review, its panels and its commands."""
    session, plot, failures = context.session, ErrorCurves(context), FailureController(context)
    strip = FilmStrip(context)
    context.actions.add([*_commands(session, plot), strip_command(strip)])
    review = Review(plot, failures, strip, RemedyController(context))
    names = (
        *("loop_failure", "inspect_failure", "find_reasons"),
        *("find_remedy", "find_parts", "export_failures"),
    )
    offered = {name: context.actions.action(name) for name in names}
    buttons = [offered[name] for name in ("find_remedy", "find_reasons")]
    failures.panel.set_actions(list(offered.values()), buttons)
    space = Workspace(
        "review", "Review", "Find and understand the failures of a run.", "threshold",
        side=(
            ("scene", "remedies"),
            ("failures", "strip", "comparison", "numbers", "runs", "inside"),
        ),
        bottom=("plot", "timeline"), side_share=0.40, bottom_shares=(0.27, 0.16),
        side_heights=(1, 2), tall_side=True,
        why_not=lambda: session.no_run() and session.not_tracked(),
    )  # fmt: skip
    context.docks.add_workspace(space)
    return review


def _commands(session: Session, plot: ErrorCurves) -> list[Command]:
    failures = session.failures
    go, command = Menu("&Go", session.no_run).command, Menu("&Review", session.no_run).command
    failure = Menu("&Go", failures.none_listed).command
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
                "of the active run.", partial(failures.go, 1), "Shift+N", "next-failure",
                section=True),
        failure("previous_failure", "Previous failure", "Go to the worst frame of the previous "
                "listed failure.", partial(failures.go, -1), "Shift+P", "previous-failure"),
        failure("loop_failure", "Loop failure", "Play the selected failure in a loop, with a few "
                "frames before and after it.", failures.toggle_loop, "Shift+Space",
                "iterate", checked=lambda: failures.looping),
    ]  # fmt: skip

"""The plot of errors and the timeline's lanes of the runs follow their judgements."""

from __future__ import annotations

from PySide6.QtCore import QObject, Qt, Slot
from PySide6.QtWidgets import QLabel, QStackedWidget

from ...context import Context
from ...session.judgement import heading_words
from ...widgets.plots.error_plot import ErrorPlot
from .curves import curves_of, lanes_of

_NO_CURVES = (
    "Run the tracker to see the error of each limb: against the reference where there is one, "
    "otherwise as estimated by the tracker."
)


class ErrorCurves(QObject):
    """Draws the error of every limb; its threshold is everybody's.

    Attributes
    ----------
    plot : ErrorPlot
    stack : QStackedWidget
        The plot, or words while there is nothing to draw.
    """

    def __init__(self, context: Context) -> None:
        super().__init__(context.session)
        self._context, self._session = context, context.session
        self.plot = ErrorPlot(unit="deg")
        self._no_curves = QLabel(_NO_CURVES)
        self._no_curves.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self._no_curves.setProperty("role", "muted")
        self._no_curves.setWordWrap(True)
        self._no_curves.setContentsMargins(16, 0, 16, 0)
        self.stack = QStackedWidget()
        self.stack.addWidget(self.plot)
        self.stack.addWidget(self._no_curves)
        # the plot says by itself what it shows, and its height is wanted for curves
        context.docks.add("plot", "Limb errors", self.stack, titled=False)
        self._connect()

    def _connect(self) -> None:
        plot, session, state = self.plot, self._session, self._context.view_state
        timeline = self._context.docks.timeline
        plot.frame_requested.connect(session.document.visit)
        plot.threshold_changed.connect(state.set_threshold)
        state.threshold_changed.connect(plot.set_threshold)
        plot.visible_range_changed.connect(timeline.set_visible_range)
        timeline.visible_range_changed.connect(plot.set_visible_range)
        timeline.margins_changed.connect(plot.set_margins)
        plot.set_margins(*timeline.margins)
        session.document.frame_changed.connect(plot.set_frame)
        session.judging.judged.connect(self.show)
        session.opened.connect(self.show)
        session.closed.connect(self.show)

    @Slot()
    def show(self) -> None:
        """Curves and lanes of the runs as they are now."""
        judging, runs, document = self._session.judging, self._session.runs, self._session.document
        recording, count = document.recording, document.frame_count
        judgement = judging.of(runs.active)
        if judgement is not None:
            self.plot.set_title(judgement.words)
            self.plot.set_heading(*heading_words(judgement))
        self.stack.setCurrentWidget(self.plot if judging.all() else self._no_curves)
        self.plot.set_curves(curves_of(runs, judging.all(), count))
        segments = recording.segments if recording is not None else ()
        reference = judging.truth.trajectory if judging.truth is not None else None
        timeline = self._context.docks.timeline
        timeline.set_lanes(lanes_of(judgement, count, segments, reference))
        timeline.set_hint(self._hint())

    def _hint(self) -> str:
        if self._session.document.recording is None:
            return ""
        if not self._session.clouds.available:
            return (
                "No view of this recording provides depth. Tracking needs a stereo or depth view."
            )
        keys = self._context.actions.shortcut("run")
        return f"Run the tracker ({keys}) to see a lane for each limb."

    def go_above(self, direction: int) -> None:
        """Go to the next or previous stretch above the threshold."""
        frame = self.plot.crossing(direction)
        if frame is not None:
            self._session.document.visit(frame)
        else:
            where = "after" if direction > 0 else "before"
            self._context.notifier.say(f"No limb exceeds the threshold {where} this frame.", 4000)

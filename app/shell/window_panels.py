"""The window's panels, and how they follow the facts."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtWidgets import (
    QDockWidget,
    QLabel,
    QMainWindow,
    QProgressBar,
    QStackedWidget,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from ..features.annotate.panels import AnnotationPanels
from ..features.review.review_panels import TITLES as REVIEW_TITLES
from ..features.review.review_panels import ReviewPanels
from ..services.tasks.task import TaskList
from ..widgets.camera.camera_grid import CameraGrid
from ..widgets.camera.display_panel import DisplayPanel
from ..widgets.forms.message_bar import MessageBar
from ..widgets.forms.parameter_panel import ParameterPanel
from ..widgets.forms.series_panel import SeriesPanel
from ..widgets.forms.welcome import WelcomePage
from ..widgets.plots.error_plot import ErrorPlot
from ..widgets.plots.inside_panel import InsidePanel
from ..widgets.scene.scene_view import SceneView
from ..widgets.style.icons import set_icon
from ..widgets.tables.attempts_panel import AttemptsPanel
from ..widgets.tables.body_panel import BodyPanel
from ..widgets.tables.comparison_panel import ComparisonPanel
from ..widgets.tables.episodes_panel import EpisodesPanel
from ..widgets.tables.findings_panel import FindingsPanel
from ..widgets.tables.landmarks_panel import LandmarksPanel
from ..widgets.tables.numbers_panel import NumbersPanel
from ..widgets.tables.rig_panel import RigPanel
from ..widgets.tables.runs_panel import RunsPanel
from ..widgets.timeline.timeline_view import TimelineView
from ..widgets.timeline.transport import Transport

FIRST_POSE = "auto"
TITLES = {
    "scene": "3-D scene",
    "plot": "Limbs over frames",
    "timeline": "Timeline",
    "parameters": "Parameters",
    "runs": "Runs",
    "comparison": "Comparison",
    "attempts": "Attempts",
    "series": "One parameter",
    "episodes": "Episodes",
    **REVIEW_TITLES,
    "numbers": "Numbers",
    "inside": "Inside the frame",
    "findings": "Findings",
    "rig": "Rig",
    "display": "Light",
    "landmarks": "Landmarks",
    "body": "Body",
    "next": "Next",
    "history": "History",
}


class PanelWindow(QMainWindow):
    """A window with all views and panels, not yet arranged and not yet connected."""

    plot: ErrorPlot

    def __init__(self) -> None:
        super().__init__()
        self.tasks = TaskList(self)
        self.grid = CameraGrid()
        self.welcome = WelcomePage()
        self.messages = MessageBar()
        self.transport = Transport()
        self.scene = SceneView()
        self.timeline = TimelineView()
        self.parameters = ParameterPanel()
        self.runs_panel = RunsPanel()
        self.numbers = NumbersPanel()
        self.comparison = ComparisonPanel()
        self.attempts_panel = AttemptsPanel()
        self.series_panel = SeriesPanel()
        self.episodes_panel = EpisodesPanel()
        self.review_panels = ReviewPanels()
        self.inside_panel = InsidePanel()
        self.findings = FindingsPanel()
        self.rig = RigPanel()
        self.display_panel = DisplayPanel()
        self.landmarks_panel = LandmarksPanel()
        self.body_panel = BodyPanel()
        self.annotation = AnnotationPanels(self.timeline, self.tasks, self)
        self.plot_stack = QStackedWidget()
        self.no_curves = QLabel(
            "When the tracker has run, the error of every limb is drawn here: against the "
            "reference where there is one, else as the tracker itself sees it."
        )
        self.no_curves.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self.no_curves.setProperty("role", "muted")
        self.no_curves.setWordWrap(True)
        self.no_curves.setContentsMargins(16, 0, 16, 0)
        self.plot_stack.addWidget(self.no_curves)
        self.docks: dict[str, QDockWidget] = {}
        for name, widget in self._panels().items():
            dock = QDockWidget(TITLES[name], self)
            dock.setObjectName(name)
            dock.setWidget(widget)
            self.docks[name] = dock
        self._hide_titles()
        self._make_status_line()

    def _panels(self) -> dict[str, QWidget]:
        """What the docks hold, by name."""
        return {
            "scene": self.scene, "plot": self.plot_stack, "timeline": self._timeline_with_bar(),
            "parameters": self.parameters, "runs": self.runs_panel, "numbers": self.numbers,
            "comparison": self.comparison, "episodes": self.episodes_panel,
            "attempts": self.attempts_panel, "series": self.series_panel,
            **self.review_panels.widgets(),
            "inside": self.inside_panel,
            "findings": self.findings, "rig": self.rig, "display": self.display_panel,
            "landmarks": self.landmarks_panel, "body": self.body_panel,
            "next": self.annotation.next_panel, "history": self.annotation.history_panel,
        }  # fmt: skip

    def _hide_titles(self) -> None:
        # the plot says by itself what it shows, and its height is wanted for curves
        # so are explanations and joint angles, which share its place
        for name in ("plot", "explanations", "angles"):
            self.docks[name].setTitleBarWidget(QWidget())
        # the timeline is the scrubber: it stays where it is and needs no title
        self.docks["timeline"].setTitleBarWidget(QWidget())
        self.docks["timeline"].setFeatures(QDockWidget.DockWidgetFeature.NoDockWidgetFeatures)

    def _timeline_with_bar(self) -> QWidget:
        both = QWidget()
        column = QVBoxLayout(both)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addWidget(self.annotation.bar)
        column.addWidget(self.timeline, 1)
        return both

    def _make_status_line(self) -> None:
        self.state_label = QLabel()
        self.state_label.setContentsMargins(8, 0, 0, 0)
        self.pixel_label = QLabel()
        self.progress = QProgressBar()
        self.progress.setMaximumWidth(160)
        self.progress.setMaximumHeight(14)
        self.progress.setTextVisible(False)
        self.cancel_button = QToolButton()
        self.cancel_button.setToolTip("Cancel the work in the background")
        self.cancel_button.setAutoRaise(True)
        set_icon(self.cancel_button, "stop")
        bar = self.statusBar()
        bar.addWidget(self.state_label, 1)
        bar.addPermanentWidget(self.pixel_label)
        bar.addPermanentWidget(self.progress)
        bar.addPermanentWidget(self.cancel_button)
        self.progress.hide()
        self.cancel_button.hide()

"""The panels of reviewing: statistics, explanations, joint angles, range of motion."""

from __future__ import annotations

from stereotrack_core.evaluation.joint_angles.motion import CUT_OFF_HZ

from ...services.docks import Docks
from ...widgets.plots.angle_plot import AnglePlot
from ...widgets.plots.cloud_plot import CloudPlot
from ...widgets.tables.motion_table import MotionTable
from ...widgets.tables.statistics_panel import StatisticsPanel
from .angle_curves import QUANTITIES, choices
from .explaining import KINDS

REVIEW_PANELS = ("statistics", "explanations", "angles", "motion")


class ReviewPanels:
    """Widgets in their docks, not yet connected."""

    def __init__(self, docks: Docks) -> None:
        self.statistics = StatisticsPanel()
        self.explanations = CloudPlot(KINDS)
        self.angles = AnglePlot(choices(), QUANTITIES)
        self.motion = MotionTable(CUT_OFF_HZ)
        docks.add("statistics", "Statistics", self.statistics)
        # these share the place of the plot of errors, and say by themselves what they show
        docks.add("explanations", "Explanations", self.explanations, titled=False)
        docks.add("angles", "Joint angles", self.angles, titled=False)
        docks.add("motion", "Motion", self.motion)

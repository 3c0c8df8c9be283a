"""The panels of reviewing: statistics, explanations, joint angles, range of motion."""

from __future__ import annotations

from PySide6.QtWidgets import QWidget

from stereotrack_core.evaluation.joint_angles.motion import CUT_OFF_HZ

from ...widgets.plots.angle_plot import AnglePlot
from ...widgets.plots.cloud_plot import CloudPlot
from ...widgets.tables.motion_table import MotionTable
from ...widgets.tables.statistics_panel import StatisticsPanel
from .angle_curves import QUANTITIES, choices
from .explaining import KINDS

TITLES = {
    "statistics": "Statistics",
    "explanations": "Explanations",
    "angles": "Joint angles",
    "motion": "Motion",
}
"""Titles by the panels' names."""


class ReviewPanels:
    """Widgets, not yet connected."""

    def __init__(self) -> None:
        self.statistics = StatisticsPanel()
        self.explanations = CloudPlot(KINDS)
        self.angles = AnglePlot(choices(), QUANTITIES)
        self.motion = MotionTable(CUT_OFF_HZ)

    def widgets(self) -> dict[str, QWidget]:
        """What goes into docks, by name."""
        return {
            "statistics": self.statistics,
            "explanations": self.explanations,
            "angles": self.angles,
            "motion": self.motion,
        }

"""What trackers of a person have in common that follow with one filter and know when it is lost."""

from __future__ import annotations

from abc import ABC, abstractmethod

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.angles import state_names
from stereotrack_core.body.pose import Pose
from stereotrack_core.tracking.iekf import PoseFilter


class LeaderTracker(ABC):
    """A filter that follows the pose which is stated, or none that can be trusted.

    Parameters
    ----------
    leader : PoseFilter
        Follows the pose that is stated.
    """

    def __init__(self, leader: PoseFilter) -> None:
        self.setup = leader.setup
        self.leader = leader
        self.state_names = state_names(self.setup.joints)
        self._present = False

    @property
    def pose(self) -> Pose:
        """Where the person is."""
        return self.leader.state.pose

    @property
    def P(self) -> FloatArray:  # noqa: N802
        """Covariance (n, n) of the pose's error state."""
        return self.leader.state.P

    @abstractmethod
    def start(self, pose: Pose, time: float | None = None, *, P: FloatArray | None = None) -> None:
        """Begin from a pose that is roughly right; see :meth:`PoseFilter.start`."""

    def reinitialise(self) -> None:
        """Know nothing: the next frame that shows somebody is searched."""
        self.start(self.pose)
        self._present = False

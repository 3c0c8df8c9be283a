"""Who may be told what a tracker does inside a frame; whoever is told changes nothing."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from stereotrack_core.arrays import BoolArray, FloatArray
    from stereotrack_core.body.pose import Pose
    from stereotrack_core.body.sampling import SurfacePoints
    from stereotrack_core.tracking.correction import Residual
    from stereotrack_core.tracking.data_to_model import SurfaceResidual
    from stereotrack_core.tracking.search.arms import Arms
    from stereotrack_core.tracking.search.search import Evidence
    from stereotrack_core.tracking.state import State
    from stereotrack_core.tracking.ukf import Projection


class Observer:
    """Is told what happens inside a frame, in the order in which it happens.

    This one takes no notice. What it is given belongs to the tracker and is not to be changed.
    """

    def sought(self, pose: Pose) -> None:
        """Somebody was looked for without help, and found in this pose."""

    def predicted(self, before: State, pose: Pose, P: FloatArray) -> None:
        """The frame's prediction from a state before it stands."""

    def predicted_state(self, x: FloatArray, P: FloatArray) -> None:
        """The same by the numbers of the thesis's state."""

    def sampled(self, points: SurfacePoints, inside: BoolArray, seen: BoolArray) -> None:
        """Points (N,) were drawn from the cones; those that are seen and not inside one stay."""

    def paired(self, sampled: SurfacePoints, pairs: Projection) -> None:
        """Sampled model points have found their nearest measured points, but for those on them."""

    def corresponded(self, data: FloatArray, surface: SurfaceResidual) -> None:
        """Data (N, 3 or more) have found their feet on the model, as far as they are near."""

    def correcting(
        self, prior: Pose, P0: FloatArray, pose: Pose, P: FloatArray, rows: tuple[Residual, ...]
    ) -> None:
        """A prior is about to be corrected by rows that are linearised at a pose."""

    def corrected_state(self, x: FloatArray, P: FloatArray) -> None:
        """A correction has led to these numbers of the thesis's state."""

    def corrected(self, pose: Pose, P: FloatArray, dx: FloatArray) -> None:
        """A correction (n,) has led to a pose and its covariance."""

    def widened(self, P0: FloatArray) -> None:
        """The frame is followed again from a wider prior."""

    def avoided(self, x: FloatArray) -> None:
        """Collisions were avoided by a jump of the thesis's state to these numbers."""

    def searching(self, evidence: Evidence, predicted: Pose, present: Pose) -> None:
        """Other places for the arms are about to be looked for."""

    def proposed(
        self, side: int, arms: Arms, kept: Arms, expected: Arms, other: FloatArray
    ) -> None:
        """Places for one arm were scored, the other one being so far (N,) from the data."""

    def refining(self, proposed: Pose) -> None:
        """A pair of places for the arms is about to be refined."""

    def refined(self, pose: Pose, cost: float) -> None:
        """A pair of places was refined and costs so much."""

    def searched(self, pose: Pose) -> None:
        """The search has decided."""


SILENT = Observer()
"""Takes no notice of any tracker."""

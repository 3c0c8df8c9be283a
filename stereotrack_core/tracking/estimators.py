"""The tracker that the parameters ask for."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.model import BodyModel, body_model
from stereotrack_core.body.proportions import proportions_of
from stereotrack_core.depth.points import Volume
from stereotrack_core.recording.description import Recording
from stereotrack_core.tracking.correspondences import DataToModel
from stereotrack_core.tracking.estimate import Tracker
from stereotrack_core.tracking.estimator import Estimator
from stereotrack_core.tracking.iekf import IteratedEstimator, PoseFilter
from stereotrack_core.tracking.parameters import TrackingParameters
from stereotrack_core.tracking.peers.annealed import AnnealedParticles
from stereotrack_core.tracking.peers.extended_kalman import ExtendedKalman
from stereotrack_core.tracking.peers.limb_icp import LimbIcp
from stereotrack_core.tracking.peers.scalar_distance import ScalarDistance
from stereotrack_core.tracking.settings import Settings
from stereotrack_core.tracking.state import Setup
from stereotrack_core.tracking.tracker import PersonTracker
from stereotrack_core.tracking.ukf import ThesisTracker

_ESTIMATORS: Mapping[str, type[Estimator]] = MappingProxyType(
    {
        "iterated": IteratedEstimator,
        "extended_kalman": ExtendedKalman,
        "annealed_particles": AnnealedParticles,
        "limb_icp": LimbIcp,
        "scalar_distance": ScalarDistance,
    }
)


def tracker_for(
    body: BodyModel, settings: Settings, cameras: FloatArray, fps: float, seed: int
) -> Tracker:
    """Make the tracker that the settings ask for; `cameras` (V, 3) are optical centres, world."""
    p = settings.tracking
    setup = Setup(body, p, cameras, fps, seed, Volume.of(settings.depth))
    if p.matching == "model_to_data":
        return ThesisTracker(setup)
    estimator, correspondences = _ESTIMATORS[p.estimator](setup), DataToModel(setup, coloured=True)
    return PersonTracker(PoseFilter(setup, estimator, correspondences, listens=True))


def seeker_for(
    body: BodyModel, settings: Settings, cameras: FloatArray, recording: Recording, seed: int
) -> PersonTracker:
    """A tracker that only looks for first poses: without colours and detections between frames.

    The thesis begins from a known pose; its body, without legs, is not made for search, so for
    it another body of the same lengths is looked for.
    """
    p = settings.tracking
    if p.matching == "model_to_data":
        p, body = TrackingParameters(), body_model(proportions_of(recording.subject))
    return seeker(Setup(body, p, cameras, recording.fps, seed, Volume.of(settings.depth)))


def seeker(setup: Setup) -> PersonTracker:
    """A tracker of the iterated estimator alone."""
    return PersonTracker(PoseFilter(setup, IteratedEstimator(setup), DataToModel(setup)))

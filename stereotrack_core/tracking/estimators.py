"""The tracker that the parameters ask for."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.model import BodyModel, body_model
from stereotrack_core.body.proportions import proportions_of
from stereotrack_core.depth.points import Volume
from stereotrack_core.recording.description import Recording
from stereotrack_core.tracking.acquire import SeekingTracker
from stereotrack_core.tracking.colours.tracker import ColouredTracker
from stereotrack_core.tracking.estimate import Tracker
from stereotrack_core.tracking.parameters import TrackingParameters
from stereotrack_core.tracking.peers.annealed import AnnealedParticleTracker
from stereotrack_core.tracking.peers.extended_kalman import ExtendedKalmanTracker
from stereotrack_core.tracking.peers.limb_icp import LimbIcpTracker
from stereotrack_core.tracking.peers.scalar_distance import ScalarDistanceTracker
from stereotrack_core.tracking.settings import Settings
from stereotrack_core.tracking.thesis import ThesisTracker

_ESTIMATORS: Mapping[str, type[SeekingTracker]] = MappingProxyType(
    {
        "iterated": ColouredTracker,
        "extended_kalman": ExtendedKalmanTracker,
        "annealed_particles": AnnealedParticleTracker,
        "limb_icp": LimbIcpTracker,
        "scalar_distance": ScalarDistanceTracker,
    }
)


def tracker_for(
    body: BodyModel, settings: Settings, cameras: FloatArray, fps: float, seed: int
) -> Tracker:
    """Make the tracker that the settings ask for; `cameras` (V, 3) are optical centres, world."""
    p = settings.tracking
    if p.matching == "model_to_data":
        return ThesisTracker(body, p, cameras, fps, seed)
    tracker = _ESTIMATORS[p.estimator](body, p, cameras, fps, seed)
    tracker.volume = Volume.of(settings.depth)
    return tracker


def seeker_for(
    body: BodyModel, settings: Settings, cameras: FloatArray, recording: Recording, seed: int
) -> SeekingTracker:
    """A tracker that only looks for first poses.

    The thesis begins from a known pose; its body, without legs, is not made for search, so for
    it another body of the same lengths is looked for.
    """
    p = settings.tracking
    if p.matching == "model_to_data":
        p, body = TrackingParameters(), body_model(proportions_of(recording.subject))
    seeker = SeekingTracker(body, p, cameras, recording.fps, seed)
    seeker.volume = Volume.of(settings.depth)
    return seeker

"""Detections of a frame's own instant, measured together with its cloud."""

from __future__ import annotations

from dataclasses import dataclass

from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import Pose
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.recording.detections import Detection
from stereotrack_core.tracking.detections.extremities import extremities
from stereotrack_core.tracking.detections.parameters import DetectionParameters
from stereotrack_core.tracking.detections.residual import DetectionResidual, detection_residuals
from stereotrack_core.tracking.detections.skin import skin_detections


@dataclass(frozen=True)
class DetectionObservation:
    """Detections of one instant; given anew to the points of the body at every pose.

    Attributes
    ----------
    detections : tuple of Detection
    gate : float, metres
    """

    detections: tuple[Detection, ...]
    gate: float

    def residuals(self, body: BodyModel, pose: Pose) -> tuple[DetectionResidual, ...]:
        """Residuals at a pose; see :func:`detection_residuals`."""
        return detection_residuals(self.detections, body, pose, self.gate)


class DetectionSensor:
    """Takes the detections that came with a frame, and makes those the parameters ask for.

    Those that came before the frame's instant are not its business (:mod:`listening`).

    Parameters
    ----------
    parameters : DetectionParameters
    """

    def __init__(self, parameters: DetectionParameters) -> None:
        self._p = parameters

    def observe(self, cloud: Cloud) -> DetectionObservation:
        """Detect in one cloud."""
        found = tuple(d for d in cloud.detections if d.time == cloud.frame)
        if self._p.detect == "extremities":
            found += extremities(cloud.points, cloud.frame)
        elif self._p.detect == "skin":
            found += skin_detections(cloud)
        return DetectionObservation(found, self._p.detection_gate)

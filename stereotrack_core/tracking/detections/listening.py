"""The tracker that also listens to what comes between the frames, and to colours."""

from __future__ import annotations

from stereotrack_core.body.manifold import displaced
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.recording.detections import Detection
from stereotrack_core.tracking.acquire import SeekingTracker
from stereotrack_core.tracking.detections.scaat import corrected_by
from stereotrack_core.tracking.estimate import Estimate


class ListeningTracker(SeekingTracker):
    """Seek and follow, and let detections that come between two frames correct the prediction.

    Each of them is one correction of its own, with the process noise of the time since the last.
    Where none comes, nothing differs from :class:`SeekingTracker`.

    Parameters are those of :class:`ManifoldTracker`.
    """

    _due: tuple[Detection, ...] = ()
    _time = 0.0

    def step(self, cloud: Cloud) -> Estimate:
        """Follow to the next cloud; see :class:`SeekingTracker`."""
        self._due = tuple(d for d in cloud.detections if d.time < cloud.frame)
        self._time = cloud.frame - 1.0
        return super().step(cloud)

    def predict(self) -> None:
        """Predict up to the frame, with corrections by the detections on the way."""
        if not self._due:
            super().predict()
            return
        end = self._time + 1.0
        for detection in self._due:
            self._advance(detection.time)
            self.pose, self.P = corrected_by(
                detection,
                self.body,
                self.pose,
                self.P,
                self.joints,
                self.parameters.detections.detection_gate,
            )
        self._advance(end)

    def _advance(self, time: float) -> None:
        share = time - self._time
        moved = share * self.parameters.velocity * self.movement
        self.pose = displaced(self.pose, moved, self.joints)
        self.P = self.P + share * self.Q
        self._time = time

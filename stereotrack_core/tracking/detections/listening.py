"""The tracker that also listens to what comes between the frames, and to colours."""

from __future__ import annotations

from dataclasses import replace

from stereotrack_core.arrays import BoolArray, FloatArray
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.recording.detections import Detection
from stereotrack_core.tracking.acquire import SeekingTracker
from stereotrack_core.tracking.detections.scaat import corrected_by
from stereotrack_core.tracking.estimate import Estimate, Prior
from stereotrack_core.tracking.process import elapsed


class ListeningTracker(SeekingTracker):
    """Seek and follow, and let detections that come between two frames correct the prediction.

    Each of them is one correction of its own, with the process noise of the time since the last.
    Those that are not later than the state that is predicted from say nothing about it. Where
    none comes, nothing differs from :class:`SeekingTracker`.

    Parameters are those of :class:`ManifoldTracker`.
    """

    _heard: tuple[Detection, ...] = ()
    _learned: FloatArray | None = None

    def step(self, cloud: Cloud) -> Estimate:
        """Follow to the next cloud; see :class:`SeekingTracker`."""
        self._heard = cloud.detections
        return super().step(cloud)

    def predict(self, time: float) -> None:
        """Predict up to a time, with corrections by the detections on the way."""
        since = time - 1.0 if self.time is None else self.time
        due = sorted((d for d in self._heard if since < d.time < time), key=lambda d: d.time)
        unheard, self.time = self.P + elapsed(since, time) * self.Q, since
        gate = self.parameters.detections.detection_gate
        for detection in due:
            super().predict(detection.time)
            self.pose, self.P = corrected_by(
                detection, self.body, self.pose, self.P, self.joints, gate
            )
        super().predict(time)
        self._learned = unheard - self.P if due else None

    def prior(self, P0: FloatArray, carried: BoolArray) -> Prior:
        """What the frame's correction has begun from; the detections belong to the frame."""
        prior = super().prior(P0, carried)
        return prior if self._learned is None else replace(prior, P=prior.P + self._learned)

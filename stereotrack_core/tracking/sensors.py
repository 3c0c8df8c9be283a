"""Sensors beside the cloud's points, as the parameters ask for them."""

from __future__ import annotations

from stereotrack_core.tracking.detections.sensor import DetectionSensor
from stereotrack_core.tracking.outlines.sensor import OutlineSensor
from stereotrack_core.tracking.parameters import TrackingParameters
from stereotrack_core.tracking.residuals import Sensor


def sensors_for(parameters: TrackingParameters) -> tuple[Sensor, ...]:
    """Sensors that a tracker with these parameters listens to."""
    sensors: list[Sensor] = [DetectionSensor(parameters.detections)]
    if parameters.outlines.measure_outlines:
        sensors.append(OutlineSensor(parameters.outlines))
    return tuple(sensors)

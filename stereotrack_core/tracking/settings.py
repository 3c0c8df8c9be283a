"""All parameters of a run in one object."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

from stereotrack_core.body.parameters import BodyParameters
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.parameters import ParameterGroup
from stereotrack_core.tracking.parameters import TrackingParameters


@dataclass(frozen=True)
class Settings(ParameterGroup):
    """Parameters from the images to the pose, in the order in which they act."""

    depth: DepthParameters = dataclasses.field(default_factory=DepthParameters)
    body: BodyParameters = dataclasses.field(default_factory=BodyParameters)
    tracking: TrackingParameters = dataclasses.field(default_factory=TrackingParameters)

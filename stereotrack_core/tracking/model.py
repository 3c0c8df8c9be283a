"""Models of what is tracked: a person in clouds, by keypoints, or as in the thesis."""

import pkgutil
from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.model import BodyModel
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.depth.points import Volume
from stereotrack_core.errors import InputError
from stereotrack_core.recording.description import Recording
from stereotrack_core.tracking.estimate import Estimate
from stereotrack_core.tracking.iekf import Follower
from stereotrack_core.tracking.keypoint_step import KeypointModel
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.state import Setup
from stereotrack_core.tracking.step import PersonModel, PersonState
from stereotrack_core.tracking.step_recorder import StepRecorder
from stereotrack_core.tracking.thesis import ThesisModel, ThesisState

# Body, parameters and cameras of a run; immutable. ``first(pose)`` gives the state before the first
# frame, ``step(state, cloud)`` the next state and the estimate. A state is a value: steps from
# equal states are equal to the last bit.
TrackModel: TypeAlias = PersonModel | KeypointModel | ThesisModel

TrackState: TypeAlias = PersonState | ThesisState


def step(
    model: TrackModel, state: Any, cloud: Cloud, recorder: StepRecorder | None = None
) -> tuple[TrackState, Estimate]:
    """State after the next cloud, and the estimate of its frame; `state` is one of the model's."""
    found: tuple[TrackState, Estimate] = model.step(state, cloud, recorder)
    return found


def cameras_of(recording: Recording, views: Sequence[str]) -> FloatArray:
    """Optical centres (V, 3) of views, world, metres."""
    cameras = [recording.reference_camera(recording.view(name)) for name in views]
    return np.array([camera.position_world for camera in cameras])


def model_for(
    body: BodyModel,
    settings: Settings,
    cameras: FloatArray,
    fps: float,
    seed: int,
    *,
    clouds: bool = True,
) -> TrackModel:
    """Make the model that the settings ask for; `cameras` (V, 3) are optical centres, world.

    Without `clouds`, keypoints alone are followed, by the filter of the iterated estimator.
    """
    volume, upright = Volume.of(settings.depth), settings.depth.upright
    setup = Setup(body, settings.tracking, cameras, fps, seed, volume, upright)
    if not clouds:
        if settings.needs_depth:
            raise InputError(
                "this preset's tracker needs depth, and no view provides it",
                where="--preset",
                remedy="Use the preset accurate or fast.",
            )
        return KeypointModel(Follower(setup))
    if setup.parameters.matching == "model_to_data":
        return ThesisModel(setup)
    name, baseline = setup.parameters.estimator, None
    if name != "iterated":  # loaded by name, because baselines are made of parts of the tracker
        module = "particles" if name == "annealed_particles" else "estimators"
        baseline = pkgutil.resolve_name(f"stereotrack_core.experiments.baselines.{module}:{name}")
    return PersonModel(
        Follower(setup, uses_colours=True, uses_async_detections=True, baseline=baseline)
    )


def initialiser(setup: Setup) -> PersonModel:
    """A model that only looks for first poses: without colours and detections between frames."""
    return PersonModel(Follower(setup, judges=False))

"""The body fitted to the clicks of the frame that is shown."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from stereotrack_core.annotation.click import Click, ClickKey, measurements
from stereotrack_core.annotation.fit.fit import ClickFit
from stereotrack_core.annotation.fit.results import FrameFit
from stereotrack_core.annotation.fit.settings import FitSettings
from stereotrack_core.annotation.landmark_set import LandmarkSet
from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.mesh import PartMesh, body_mesh
from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import Proportions
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.geometry.camera import Camera

from ....services.tasks.helper_process import HelperProcess

FEWEST = 3
"""Clicks from which on a body is shown; fewer would only show the usual pose."""

_AROUND = 16


@dataclass(frozen=True, eq=False)
class FitQuestion:
    """Which clicks the body is fitted to.

    Attributes
    ----------
    frame : int
    clicks : tuple of Click
    cameras : mapping from name to Camera
        Those that have clicks, and those of the reference images.
    views : mapping from camera name to view name
    landmark_set : LandmarkSet
    proportions : Proportions
    fps : float
    sigmas : mapping from landmark to float
        How good clicks are, pixels per axis, as far as measured.
    cloud : Cloud or None
        Measured points, where they are there and wanted.
    """

    frame: int
    clicks: tuple[Click, ...]
    cameras: Mapping[str, Camera]
    views: Mapping[str, str]
    landmark_set: LandmarkSet
    proportions: Proportions
    fps: float
    sigmas: Mapping[str, float]
    cloud: Cloud | None


@dataclass(frozen=True, eq=False)
class ShownFit:
    """A fit and what is drawn of it.

    Attributes
    ----------
    question : FitQuestion
    fit : FrameFit
    meshes : tuple of PartMesh
    residuals : mapping from ClickKey to (2,) float64
        Click minus model, raw pixels.
    mistakes : mapping from ClickKey to float
        Probability that the click is a gross mistake.
    places : mapping from landmark to (3,) float64
        Landmarks of the model, world, metres.
    """

    question: FitQuestion
    fit: FrameFit
    meshes: tuple[PartMesh, ...]
    residuals: Mapping[ClickKey, FloatArray]
    mistakes: Mapping[ClickKey, float]
    places: Mapping[str, FloatArray]


class Fitter:
    """Fits; keeps what is the same from click to click. Called in one thread at a time."""

    def __init__(self) -> None:
        self._made: tuple[object, ClickFit] | None = None

    def __call__(self, question: FitQuestion) -> ShownFit:
        """Fit the body to the clicks of one frame."""
        clicks = [one for one in question.clicks if one.camera in question.cameras]
        taken = measurements(clicks, question.landmark_set.names, question.sigmas)
        fit = self._fit_for(question).frame(taken, cloud=question.cloud)
        keys = [one.key for one in taken]
        body = body_model(question.proportions)
        return ShownFit(
            replace(question, cloud=None),  # the points are large, and are known where it goes
            fit,
            body_mesh(body, fit.pose, around=_AROUND),
            dict(zip(keys, fit.residual_px, strict=True)),
            dict(zip(keys, fit.mistake.tolist(), strict=True)),
            dict(zip(question.landmark_set.names, fit.landmarks_world, strict=True)),
        )

    def _fit_for(self, question: FitQuestion) -> ClickFit:
        depth = question.cloud is not None
        cameras = tuple((name, _numbers(camera)) for name, camera in question.cameras.items())
        key = (cameras, question.landmark_set, question.proportions, depth)
        if self._made is None or self._made[0] != key:
            settings = replace(FitSettings(), use_depth=depth)
            made = ClickFit(
                question.cameras,
                question.landmark_set,
                question.proportions,
                settings,
                fps=question.fps,
                views=question.views,
            )
            self._made = (key, made)
        return self._made[1]


class FitProcess:
    """Fits in another process."""

    def __init__(self) -> None:
        self._process = HelperProcess(f"{__name__}:Fitter")

    def __call__(self, question: FitQuestion) -> ShownFit:
        """Fit the body to the clicks of one frame."""
        cloud = question.cloud
        if cloud is not None:  # the fit takes points alone
            cloud = replace(cloud, depths={})
        shown: ShownFit = self._process(replace(question, cloud=cloud))
        return replace(shown, question=question)

    def close(self) -> None:
        """End the process."""
        self._process.close()


def _numbers(camera: Camera) -> bytes:
    """What a camera is known by."""
    pose = camera.camera_from_world
    arrays = (camera.matrix, camera.distortions, pose.rotation, pose.translation)
    return b"".join(array.tobytes() for array in arrays)

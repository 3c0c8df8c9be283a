"""The body fitted to clicked landmarks: one frame live, or a whole trajectory."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from stereotrack_core.annotation.fit.context import CLICKED_SHAPE, FitContext
from stereotrack_core.annotation.fit.depth import MeasuredDepth
from stereotrack_core.annotation.fit.live import fitted_frame
from stereotrack_core.annotation.fit.measurement import ClickMeasurement
from stereotrack_core.annotation.fit.results import FrameFit, TrajectoryFit
from stereotrack_core.annotation.fit.settings import FitSettings
from stereotrack_core.annotation.fit.trajectory import Clouds, fitted_trajectory
from stereotrack_core.annotation.landmark_set import LandmarkSet
from stereotrack_core.blas_threads import one_blas_thread
from stereotrack_core.body.model import body_model
from stereotrack_core.body.parameters import BodyParameters
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.proportions import Proportions
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.geometry.camera import Camera


class ClickFit:
    """Fits one person's body to clicks.

    Parameters
    ----------
    cameras : mapping from camera name to Camera
    landmark_set : LandmarkSet
    proportions : Proportions
    settings : FitSettings, optional
    fps : float
        Frame sets per second.
    shape : BodyParameters, optional
        The body's surface, for measured points. When not given, a trajectory's is fitted to
        clicked frames, and a single frame has an average one.
    views : mapping from camera name to view name, optional
        How people call the cameras.
    """

    def __init__(
        self,
        cameras: Mapping[str, Camera],
        landmark_set: LandmarkSet,
        proportions: Proportions,
        settings: FitSettings | None = None,
        *,
        fps: float = 10.0,
        shape: BodyParameters | None = None,
        views: Mapping[str, str] | None = None,
    ) -> None:
        self.settings = FitSettings() if settings is None else settings
        self._context = FitContext(
            cameras,
            landmark_set,
            body_model(proportions, (shape or CLICKED_SHAPE).replaced(girdle=False)),
            shape,
            self.settings,
            fps,
            views or {},
        )

    def frame(
        self,
        measurements: Sequence[ClickMeasurement],
        *,
        cloud: Cloud | MeasuredDepth | None = None,
        start: Pose | None = None,
    ) -> FrameFit:
        """Fit one frame; what the clicks do not decide, the usual pose does.

        Parameters
        ----------
        measurements : sequence of ClickMeasurement
            May be few, or none.
        cloud : Cloud or MeasuredDepth, optional
            Measured points of the frame; used where the settings say so. Fitting one frame again
            and again, :func:`measured_depth` need be called only once.
        start : Pose, optional
            A pose nearby, such as that of the frame before. It is then what is expected.

        Raises
        ------
        KeyError
            For a camera that is not known.
        """
        with one_blas_thread():
            return fitted_frame(self._context, measurements, cloud, start)

    def trajectory(
        self,
        measurements_by_frame: Mapping[int, Sequence[ClickMeasurement]],
        frames: range,
        *,
        clouds: Clouds | None = None,
        gaps: Sequence[range] = (),
        on_frame: Callable[[int], None] | None = None,
        cancelled: Callable[[], bool] | None = None,
    ) -> TrajectoryFit:
        """Follow the clicks over the frames, forward and backward.

        Parameters
        ----------
        measurements_by_frame : mapping from frame to measurements
        frames : range
            To be filled.
        clouds : callable, optional
            Gives the cloud of a frame, or what :func:`measured_depth` kept of it, or None.
        gaps : sequence of range
            Frames over which nothing is filled in.
        on_frame : callable, optional
            Told every frame whose clicks and cloud have been taken in.
        cancelled : callable, optional
            Asked before every frame whether to stop.

        Raises
        ------
        Cancelled
            When stopped.
        """
        with one_blas_thread():
            return fitted_trajectory(
                self._context, measurements_by_frame, frames, clouds, gaps, on_frame, cancelled
            )

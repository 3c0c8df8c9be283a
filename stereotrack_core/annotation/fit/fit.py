"""The body fitted to clicked landmarks: one frame live, a trajectory, or a whole recording."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence

from stereotrack_core.annotation.click import (
    USUAL_SIGMA,
    Click,
    measurements,
)
from stereotrack_core.annotation.fit.context import FitContext
from stereotrack_core.annotation.fit.live import fitted_frame
from stereotrack_core.annotation.fit.results import FrameFit, TrajectoryFit
from stereotrack_core.annotation.fit.state import FitSettings
from stereotrack_core.annotation.fit.stretch import MeasuredDepth, recorded_depth
from stereotrack_core.annotation.fit.trajectory import Clouds, fitted_trajectory
from stereotrack_core.annotation.landmark_set import NINE, LandmarkSet
from stereotrack_core.blas_threads import one_blas_thread
from stereotrack_core.body.proportions import proportions_of
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.errors import InputError
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.reader import FrameReader


class ClickFit(FitContext):
    """Fits one person's body to clicks."""

    def frame(
        self, measurements: Sequence[Click], *, cloud: Cloud | MeasuredDepth | None = None
    ) -> FrameFit:
        """Fit one frame to clicks, which may be few or none.

        What the clicks do not decide, the measured points of a cloud do where the settings say so,
        and else the usual pose. Fitting one frame again and again, :func:`measured_depth` need be
        called only once.

        Raises KeyError for a camera that is not known.
        """
        with one_blas_thread():
            return fitted_frame(self, measurements, cloud)

    def trajectory(
        self,
        measurements_by_frame: Mapping[int, Sequence[Click]],
        frames: range,
        *,
        clouds: Clouds | None = None,
        gaps: Sequence[range] = (),
        on_frame: Callable[[int], None] | None = None,
        cancelled: Callable[[], bool] | None = None,
    ) -> TrajectoryFit:
        """Follow the clicks over the frames, forward and backward.

        Raises Cancelled when stopped.

        Parameters
        ----------
        frames : to be filled
        clouds : gives the cloud of a frame, or what :func:`measured_depth` kept of it, or None
        gaps : frames over which nothing is filled in
        on_frame : told every frame whose clicks and cloud have been taken in
        cancelled : asked before every frame whether to stop
        """
        with one_blas_thread():
            return fitted_trajectory(
                self, measurements_by_frame, frames, clouds, gaps, on_frame, cancelled
            )


def fit_reference(
    recording: Recording,
    clicks: Sequence[Click],
    *,
    frames: range | None = None,
    views: Sequence[str] | None = None,
    settings: FitSettings | None = None,
    landmarks: LandmarkSet = NINE,
    sigma: Mapping[str, float] | float = USUAL_SIGMA,
    source: str = "clicks",
    gaps: Sequence[range] = (),
    on_frame: Callable[[int], None] | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> TrajectoryFit:
    """Fit the body to clicked landmarks, forward and backward over the frames.

    The recording's depth is used where it has any; frames between clicked ones are filled.

    Raises InputError where none of these frames is clicked in these views; Cancelled.

    Parameters
    ----------
    frames : frames to fit; all when not given
    views : clicks and depth of these views alone count; all when not given
    sigma : float, or mapping from landmark to float, pixels; standard deviation of a click along
        each axis
    source : where the clicks come from, for messages
    gaps : frames that are left unknown
    on_frame : told every frame whose depth is read

    Returns
    -------
    TrajectoryFit
        Landmarks with covariances, and which clicks are probably outliers.

    Examples
    --------
    >>> recording = open_recording(Path("recording"))
    >>> fit = fit_reference(recording, read_clicks(Path("clicks.csv"), recording).checked())
    >>> fit.trajectory().points.shape  # frames, nine landmarks, x y z in metres
    (120, 9, 3)
    """
    settings = FitSettings() if settings is None else settings
    if frames is None:
        with FrameReader(recording, views=views, read_ahead=0) as reader:
            frames = range(reader.frame_count)
    by_frame: dict[int, list[Click]] = defaultdict(list)
    for click in measurements(clicks_in(recording, clicks, views), landmarks.names, sigma):
        if click.frame in frames:
            by_frame[click.frame].append(click)
    if not by_frame:
        where = "" if views is None else " of these views"
        raise InputError(
            f"there is no click in frames {frames.start} to {frames.stop - 1}{where}",
            where=source,
            remedy="Click a few frames first, or choose other frames or views.",
        )
    person = proportions_of(recording.subject)
    fitting = ClickFit(recording.cameras, landmarks, person, settings, recording.fps)
    with recorded_depth(recording, settings, views) as depth:
        return fitting.trajectory(
            by_frame, frames, clouds=depth, gaps=gaps, on_frame=on_frame, cancelled=cancelled
        )


def clicks_in(
    recording: Recording, clicks: Sequence[Click], views: Sequence[str] | None
) -> list[Click]:
    """Clicks in the cameras of the chosen views; all where none are chosen."""
    if views is None:
        return list(clicks)
    cameras = {
        stream.camera for name in views for stream in recording.view(name).streams().values()
    }
    return [click for click in clicks if click.camera in cameras]

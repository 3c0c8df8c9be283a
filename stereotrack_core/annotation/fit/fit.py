"""The body fitted to clicked landmarks: one frame live, a trajectory, or a whole recording."""

from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from stereotrack_core.annotation.click import USUAL_SIGMA, Click, measurements
from stereotrack_core.annotation.fit.context import FitContext
from stereotrack_core.annotation.fit.live import fitted_frame
from stereotrack_core.annotation.fit.results import FrameFit, TrajectoryFit
from stereotrack_core.annotation.fit.state import FitSettings
from stereotrack_core.annotation.fit.stretch import MeasuredDepth, recorded_depth
from stereotrack_core.annotation.fit.trajectory import (
    Clouds,
    connected_stretches,
    fitted_stretch,
    put_together,
)
from stereotrack_core.annotation.landmark_set import NINE, LandmarkSet
from stereotrack_core.blas_threads import one_blas_thread
from stereotrack_core.body.proportions import proportions_of
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.errors import Cancelled, InputError
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.reader import FrameReader


class ClickFit(FitContext):
    """Fits one person's body to clicks."""

    def frame(
        self, measurements: Sequence[Click], *, cloud: Cloud | MeasuredDepth | None = None
    ) -> FrameFit:
        """Fit one frame to clicks, which may be few or none, and to measured points.

        What they do not decide is as in the usual pose. Raises KeyError for an unknown camera.
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
        on_frame: Callable[[int], None] = lambda _frame: None,
        cancelled: Callable[[], bool] = lambda: False,
    ) -> TrajectoryFit:
        """Follow the clicks forward and backward, not over gaps. Raises Cancelled."""
        clicked = {frame: tuple(measurements_by_frame.get(frame, ())) for frame in frames}
        clouds = clouds if self.settings.use_depth else None
        filled = []
        with one_blas_thread():
            for stretch in connected_stretches(self, clicked, gaps, clouds is not None):
                data = []
                for frame in stretch:
                    if cancelled():
                        raise Cancelled
                    data.append(self.data(clicked[frame], clouds(frame) if clouds else None))
                    on_frame(frame)
                filled.append(fitted_stretch(self, stretch, data, cancelled))
            return put_together(self, clicked, frames, filled)


@dataclass(frozen=True)
class FitRequest:
    """Frames to fit, and the clicks that count; all frames and views if not given.

    Examples
    --------
    >>> FitRequest(range(20, 60), views=("N", "S"), sigma=2.0)
    """

    frames: range | None = None
    views: Sequence[str] | None = None
    settings: FitSettings = field(default_factory=FitSettings)
    landmarks: LandmarkSet = NINE
    sigma: Mapping[str, float] | float = USUAL_SIGMA  # of a click, pixels per axis
    source: str = "clicks"  # of the clicks, for messages
    gaps: Sequence[range] = ()  # frames that are left unknown


def fit_reference(
    recording: Recording,
    clicks: Sequence[Click],
    request: FitRequest | None = None,
    *,
    on_frame: Callable[[int], None] = lambda _frame: None,
    cancelled: Callable[[], bool] = lambda: False,
) -> TrajectoryFit:
    """Fit the body to clicked landmarks, forward and backward over the frames.

    The recording's depth is used where it has any; frames between clicked ones are filled.
    `on_frame` is told every frame whose depth is read.

    Raises InputError where none of these frames is clicked in these views; Cancelled.

    Examples
    --------
    >>> recording = open_recording(Path("recording"))
    >>> fit = fit_reference(recording, read_clicks(Path("clicks.csv"), recording).checked())
    >>> fit.trajectory().points.shape  # frames, nine landmarks, x y z in metres
    (120, 9, 3)
    """
    r = FitRequest() if request is None else request
    frames = r.frames
    if frames is None:
        with FrameReader(recording, views=r.views, read_ahead=0) as reader:
            frames = range(reader.frame_count)
    by_frame: dict[int, list[Click]] = defaultdict(list)
    for click in measurements(clicks_in(recording, clicks, r.views), r.landmarks.names, r.sigma):
        if click.frame in frames:
            by_frame[click.frame].append(click)
    if not by_frame:
        where = "" if r.views is None else " of these views"
        raise InputError(
            f"there is no click in frames {frames.start} to {frames.stop - 1}{where}",
            where=r.source,
            remedy="Click a few frames first, or choose other frames or views.",
        )
    person = proportions_of(recording.subject)
    fitting = ClickFit(recording.cameras, r.landmarks, person, r.settings, recording.fps)
    with recorded_depth(recording, r.settings, r.views) as depth:
        return fitting.trajectory(
            by_frame, frames, clouds=depth, gaps=r.gaps, on_frame=on_frame, cancelled=cancelled
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

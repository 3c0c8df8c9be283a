"""The body fitted to the clicks on a recording, over all its frames."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence

from stereotrack_core.annotation.click import Click
from stereotrack_core.annotation.fit.fit import ClickFit
from stereotrack_core.annotation.fit.measurement import (
    USUAL_SIGMA,
    ClickMeasurement,
    measurements,
)
from stereotrack_core.annotation.fit.recorded_depth import recorded_depth
from stereotrack_core.annotation.fit.results import TrajectoryFit
from stereotrack_core.annotation.fit.settings import FitSettings
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.body.proportions import Proportions, proportions_of
from stereotrack_core.errors import InputError
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.reader import FrameReader


def fit_reference(
    recording: Recording,
    clicks: Sequence[Click],
    *,
    frames: range | None = None,
    views: Sequence[str] | None = None,
    settings: FitSettings | None = None,
    proportions: Proportions | None = None,
    sigma: float = USUAL_SIGMA,
    source: str = "clicks",
    gaps: Sequence[range] = (),
    on_frame: Callable[[int], None] | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> TrajectoryFit:
    """Fit the body to clicked landmarks, forward and backward over the frames.

    The recording's depth is used where it has any; frames between clicked ones are filled.

    Parameters
    ----------
    recording : Recording
    clicks : sequence of Click
    frames : range, optional
        Frames to fit; all when not given.
    views : sequence of str, optional
        Clicks and depth of these views alone count; all when not given.
    settings : FitSettings, optional
    proportions : Proportions, optional
        The person's; those of the recording's subject when not given.
    sigma : float, pixels
        Standard deviation of a click along each axis.
    source : str
        Where the clicks come from, for messages.
    gaps : sequence of range
        Frames that are left unknown.
    on_frame : callable, optional
        Told every frame whose depth is read.
    cancelled : callable, optional

    Returns
    -------
    TrajectoryFit
        Landmarks with covariances, and which clicks are probably outliers.

    Raises
    ------
    InputError
        Where none of these frames is clicked in these views.
    Cancelled

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
    measured = _measured(clicks_in(recording, clicks, views), frames, sigma, source)
    known = proportions_of(recording.subject) if proportions is None else proportions
    fitting = ClickFit(recording.cameras, NINE, known, settings, fps=recording.fps)
    with recorded_depth(recording, settings, views) as depth:
        return fitting.trajectory(
            measured, frames, clouds=depth, gaps=gaps, on_frame=on_frame, cancelled=cancelled
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


def _measured(
    clicks: Sequence[Click], frames: range, sigma: float, source: str
) -> Mapping[int, Sequence[ClickMeasurement]]:
    by_frame: dict[int, list[Click]] = defaultdict(list)
    for click in clicks:
        if click.frame in frames and click.position is not None:
            by_frame[click.frame].append(click)
    if not by_frame:
        raise InputError(
            f"there is no click in frames {frames.start} to {frames.stop - 1} of these views",
            where=source,
            remedy="Click a few frames first, or choose other frames or views.",
        )
    return {frame: measurements(own, NINE, sigma) for frame, own in by_frame.items()}

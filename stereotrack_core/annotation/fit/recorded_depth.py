"""Depth of a recording's frames for the fit."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

from stereotrack_core.annotation.fit.depth import MeasuredDepth, measured_depth
from stereotrack_core.annotation.fit.settings import FitSettings
from stereotrack_core.depth.chain import DepthChain
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.reader import FrameReader


@contextmanager
def recorded_depth(
    recording: Recording, settings: FitSettings, views: Sequence[str] | None = None
) -> Iterator[Callable[[int], MeasuredDepth] | None]:
    """Give a function from frame to depth; None where no view gives any or none is wanted.

    Parameters
    ----------
    recording : Recording
    settings : FitSettings
    views : sequence of str, optional
        Only these views.

    Raises
    ------
    InputError
        Where images cannot be read.
    """
    names = [
        view.name
        for view in recording.views
        if view.kind != "mono" and (views is None or view.name in views)
    ]
    if not names or not settings.use_depth:
        yield None
        return
    with FrameReader(recording, views=names, colour=False) as reader:
        chain = DepthChain(recording, DepthParameters(), views=names)
        try:
            chain.learn_background(reader, range(reader.frame_count))

            def depth_of(frame: int) -> MeasuredDepth:
                cloud = chain.process(reader.frame_set(frame))
                return measured_depth(cloud, settings.depth_points, outlines=settings.use_outlines)

            yield depth_of
        finally:
            chain.close()

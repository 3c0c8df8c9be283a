"""What a cloud tells the fit: points that look for the body, and edges for its outlines."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stereotrack_core.annotation.fit.settings import FitSettings
from stereotrack_core.arrays import FloatArray
from stereotrack_core.depth.chain import DepthChain
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.tracking.residuals.silhouette import EdgeMap, edge_maps

_FARTHEST = 1.0e4
"""Pixels and metres beyond what half precision must hold."""


@dataclass(frozen=True, eq=False)
class MeasuredDepth:
    """Points (N, 3), world, of one instant, small enough that those of a recording are kept."""

    points: FloatArray
    _edges: tuple[EdgeMap, ...]
    _halves: tuple[tuple[NDArray[np.float16], NDArray[np.float16]], ...]

    def edges(self) -> tuple[EdgeMap, ...]:
        """Edges of the person in the views that know them."""
        return tuple(
            replace(edge, distance=distance.astype(np.float32), range_z=range_z.astype(np.float32))
            for edge, (distance, range_z) in zip(self._edges, self._halves, strict=True)
        )


def measured_depth(cloud: Cloud, wanted: int, *, outlines: bool) -> MeasuredDepth:
    """Keep of a cloud what the fit needs: points, drawn evenly, the same for the same frame.

    Edges, for outlines, are kept in half precision, which is enough near an edge.
    """
    points = cloud.points
    if len(points) > wanted:
        rng = np.random.default_rng(cloud.frame)
        points = points[np.sort(rng.choice(len(points), wanted, replace=False))]
    maps = edge_maps(cloud) if outlines else ()
    nothing = np.empty((0, 0), dtype=np.float32)
    halves = tuple(
        (
            np.clip(edge.distance, -_FARTHEST, _FARTHEST).astype(np.float16),
            np.clip(edge.range_z, -_FARTHEST, _FARTHEST).astype(np.float16),
        )
        for edge in maps
    )
    bare = tuple(replace(edge, distance=nothing, range_z=nothing) for edge in maps)
    return MeasuredDepth(points, bare, halves)


@contextmanager
def recorded_depth(
    recording: Recording, settings: FitSettings, views: Sequence[str] | None = None
) -> Iterator[Callable[[int], MeasuredDepth] | None]:
    """Give a function from frame to depth; None where no view gives any or none is wanted.

    InputError where images cannot be read.
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

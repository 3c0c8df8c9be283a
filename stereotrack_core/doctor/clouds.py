"""Is there anything to track? Clouds of some frames, and what took their points if not."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from stereotrack_core.depth.chain import DepthChain
from stereotrack_core.depth.lost_points import LEAST_POINTS, LostPoints
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.volume import settled
from stereotrack_core.errors import Finding, InputError
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.recording.selection import usable_views

_FRAMES = 6


def check_clouds(
    recording: Recording, reader: FrameReader, doubtful: Sequence[str] = ()
) -> Iterator[Finding]:
    """Findings where no frame gives enough points; views that are `doubtful` are not asked."""
    try:
        views = [name for name in usable_views(recording, None) if name not in doubtful]
    except InputError:
        return  # nothing gives depth, which is no mistake
    if not views:
        return
    parameters, count = DepthParameters(subpixel="matcher", silhouettes=False), reader.frame_count
    try:
        depth = settled(recording, parameters, reader, views)
        chain = DepthChain(recording, depth, views=views)
    except InputError as error:
        yield Finding.of(error)
        return
    lost = LostPoints(recording, depth)
    try:
        chain.learn_background(reader, range(count))
        for k in np.unique(np.linspace(0, count - 1, min(_FRAMES, count)).astype(int)):
            cloud = chain.process(reader.frame_set(int(k)))
            if len(cloud.points) >= LEAST_POINTS:
                return
            lost.note(cloud)
    finally:
        chain.close()
    for cause in lost.causes("too few of all views together"):
        where = f"view {', '.join(cause.views)}" if cause.views else "recording.toml"
        yield Finding("error", where, f"there is nothing to track: {cause.what}", cause.remedy)

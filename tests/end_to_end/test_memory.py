"""Memory stays flat however long a recording is."""

from __future__ import annotations

import gc
import tracemalloc
from pathlib import Path

import pytest

from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.frames import FrameSet
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.tracking.pipeline import Pipeline
from stereotrack_core.tracking.presets import preset

SETTLED, FRAMES = 200, 2250
MOST_PER_FRAME = 300
"""Bytes by which memory may grow with a frame; a kept pose has 2,000, a kept cloud 500,000."""

MOST_RESIDENT = 4_000
"""The same for the whole process, where the allocator's own needs come in."""


class EndlessReader(FrameReader):
    """Gives the frames of a short recording over and over, decoded each time."""

    def frame_set(self, index: int) -> FrameSet:
        images = super().frame_set(index % self.frame_count)
        return FrameSet(index, images.views, images.problems)


def resident_bytes() -> int:
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * 4096


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/statm").is_file(), reason="memory is read from /proc")
@pytest.mark.parametrize("name", ["accurate", "thesis"])
def test_memory_is_flat_over_many_frames(name, sound):
    recording = open_recording(sound)
    settings = preset(name).replaced(
        search_proposals=40, data_points=400, speckle_size=10, pixel_step=1, match_window=9
    )
    with (
        EndlessReader(recording, colour=False, cache_bytes=1 << 20) as reader,
        Pipeline(recording, settings, reader=reader) as pipeline,
    ):
        pipeline.prepare(range(reader.frame_count))
        for frame in pipeline.frames(range(SETTLED)):
            assert frame.tracked
        gc.collect()
        tracemalloc.start()
        try:
            for _ in pipeline.frames(range(SETTLED, SETTLED + 50)):
                pass
            gc.collect()
            before, resident = tracemalloc.get_traced_memory()[0], resident_bytes()
            for _ in pipeline.frames(range(SETTLED + 50, FRAMES)):
                pass
            gc.collect()
            after = tracemalloc.get_traced_memory()[0]
        finally:
            tracemalloc.stop()
        count = FRAMES - SETTLED - 50
        assert (after - before) / count < MOST_PER_FRAME
        assert (resident_bytes() - resident) / count < MOST_RESIDENT


def test_what_is_kept_of_a_frame_is_small(sound):
    with Pipeline(open_recording(sound), preset("fast")) as pipeline:
        kept = [frame.without_cloud() for frame in pipeline.frames(range(4))]
    for frame in kept:
        prior = 0 if frame.estimate.prior is None else frame.estimate.prior.P.nbytes
        arrays = (frame.landmarks, frame.P, frame.x, frame.cloud.points, frame.limb_sigma_deg)
        assert sum(array.nbytes for array in arrays) + prior < 20_000
        assert not frame.cloud.depths
        assert frame.correspondences is None

"""Memory stays flat however long a recording is."""

import gc
import mmap
from contextlib import closing
from pathlib import Path

import pytest

from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.reader import FrameReader, FrameSet
from stereotrack_core.tracking.clouds import Clouds, CloudSource, chain_of
from stereotrack_core.tracking.prepare import prepare
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run import advances
from stereotrack_core.tracking.run_spec import RunSpec

# Every stage at work, on little.
QUICK = {
    "speckle_size": 10,
    "match_window": 9,
    "pixel_step": 1,
    "max_unexplained_fraction": 0.95,
    "data_points": 300,
    "model_points": 16,
    "iterations": 3,
    "search_proposals": 20,
    "search_refined": 1,
}
SETTLED = 150
# Bytes by which the process may grow with a frame, for the allocator's own needs; a kept estimate
# has 10,000, a kept cloud 500,000.
MOST_PER_FRAME = 4_000
MOST_OBJECTS_PER_FRAME = 0.1  # none stays of a frame, but the program is not quite still


class EndlessReader(FrameReader):
    """Gives the frames of a short recording over and over, decoded each time."""

    def frame_set(self, index: int) -> FrameSet:
        images = super().frame_set(index % self.frame_count)
        return FrameSet(index, images.views, images.problems)


def resident_bytes() -> int:
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * mmap.PAGESIZE


def living_objects() -> int:
    """Containers that the collector knows, garbage left out."""
    gc.collect()
    return len(gc.get_objects())


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/statm").is_file(), reason="memory is read from /proc")
@pytest.mark.parametrize(("name", "frames"), [("accurate", 2150), ("thesis", 1150)])
def test_memory_is_flat_over_many_frames(name, frames, sound):
    recording = open_recording(sound)
    spec = RunSpec(preset(name).replaced(**QUICK))
    with (
        EndlessReader(recording, colour=False, cache_bytes=1 << 20) as reader,
        closing(
            chain_of(recording, spec, [view.name for view in recording.views], reader)[0]
        ) as chain,
        Clouds(recording, spec, CloudSource(chain, reader)) as clouds,
    ):
        run = prepare(clouds)
        for advance in advances(run, range(SETTLED)):
            run = advance.run
            assert all(frame.tracked for frame in advance.gained.frames)
        objects, resident = living_objects(), resident_bytes()
        for _ in advances(run, range(SETTLED, frames)):
            pass
        count = frames - SETTLED
        assert (living_objects() - objects) / count < MOST_OBJECTS_PER_FRAME
        assert (resident_bytes() - resident) / count < MOST_PER_FRAME

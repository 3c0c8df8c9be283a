"""Open a recording, look at the point cloud of a frame: ``python open_and_look.py RECORDING``."""

import sys
from contextlib import closing
from pathlib import Path

import stereotrack_core as stereotrack
from stereotrack_core.recording.reader import FrameReader


def main(folder: Path) -> None:
    recording = stereotrack.open_recording(folder)
    views = ", ".join(f"{view.name} ({view.kind})" for view in recording.views)
    print(f"{recording.name}: {recording.fps:g} frame sets per second; views {views}")

    parameters = stereotrack.preset("accurate").depth
    with (
        FrameReader(recording) as reader,
        closing(stereotrack.DepthChain(recording, parameters)) as chain,
    ):
        chain.learn_background(reader, range(reader.frame_count))
        cloud = chain.process(reader.frame_set(0))
    low, high = cloud.points.min(axis=0), cloud.points.max(axis=0)
    print(f"Frame 0 has {len(cloud.points)} points, {high[2] - low[2]:.2f} m from foot to head")
    for k, name in enumerate(cloud.view_names):
        print(f"  {name} sees {(cloud.view == k).sum()} of them")


if __name__ == "__main__":
    main(Path(sys.argv[1]))

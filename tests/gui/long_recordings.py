"""A short recording made long, for tests of what grows."""

import shutil
from pathlib import Path

import av
import numpy as np

from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.landmarks import LandmarkTrajectory, write_landmarks


def repeated(folder: Path, target: Path, times: int) -> Path:
    """A copy of a recording of videos in which everything happens so many times."""
    shutil.copytree(folder, target)
    for video in target.glob("*.mp4"):
        _repeat(folder / video.name, video, times)
    reference = open_recording(folder).reference
    if reference is not None:
        count = len(reference.frame)
        frame = np.arange(count * times)
        points = np.tile(reference.points, (times, 1, 1))
        write_landmarks(target / "reference.csv", LandmarkTrajectory(frame, points))
    (target / "segments.csv").unlink(missing_ok=True)
    text = (target / "recording.toml").read_text(encoding="utf-8")
    kept = [line for line in text.splitlines() if not line.startswith("segments")]
    (target / "recording.toml").write_text("\n".join([*kept, ""]), encoding="utf-8")
    return target


def _repeat(video: Path, target: Path, times: int) -> None:
    """Write the packets of a video again and again; nothing is decoded."""
    with av.open(str(video)) as source, av.open(str(target), "w") as made:
        stream = source.streams.video[0]
        copied = made.add_stream_from_template(stream)
        packets = [packet for packet in source.demux(stream) if packet.dts is not None]
        kept = [(bytes(packet), packet.pts, packet.dts, packet.is_keyframe) for packet in packets]
        length = sum(packet.duration for packet in packets)
        for turn in range(times):
            for data, pts, dts, key in kept:
                packet = av.Packet(data)
                packet.pts, packet.dts = pts + turn * length, dts + turn * length
                packet.is_keyframe, packet.time_base = key, stream.time_base
                packet.stream = copied
                made.mux(packet)

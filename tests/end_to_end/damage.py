"""Ways to damage a recording."""

import re
from pathlib import Path

import av
import numpy as np


def substitute(path: Path, pattern: str, text: str) -> None:
    """Replace the first match of a regular expression in a text file; it has to be there."""
    old = path.read_text(encoding="utf-8")
    assert re.search(pattern, old), pattern
    path.write_text(re.sub(pattern, text, old, count=1), encoding="utf-8")


def pictures_of(path: Path) -> list[np.ndarray]:
    """All pictures (H, W) uint8 of a video."""
    with av.open(str(path)) as container:
        return [frame.to_ndarray(format="gray") for frame in container.decode(video=0)]


def write_pictures(path: Path, pictures: list[np.ndarray]) -> None:
    """Write a video again, ten frames per second; by one thread, so that it is the same always."""
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=10)
        stream.height, stream.width = pictures[0].shape
        stream.pix_fmt = "yuv420p"
        stream.options = {"crf": "14"}
        stream.thread_count = 1
        for picture in pictures:
            frame = av.VideoFrame.from_ndarray(picture, format="gray").reformat(format="yuv420p")
            container.mux(stream.encode(frame))
        container.mux(stream.encode())

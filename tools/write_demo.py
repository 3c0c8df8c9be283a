"""The demo recording that is shipped: ``python tools/write_demo.py`` renders it anew."""

import shutil
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import av
import cv2

from stereotrack_core.demo import SHIPPED
from stereotrack_core.simulation.make import Simulation, simulate
from stereotrack_core.simulation.rig import SceneOptions
from stereotrack_core.work import Work

_DEMO = Simulation(
    person="P2",
    motion="t-pose+cross-arms+point",
    frames=100,
    seed=7,
    options=SceneOptions(
        colour=True, camera_distance=2.6, camera_height=1.75, noise=0.5, lossless=True, shadow=0.3
    ),
)
_JPEG_QUALITY = 80
_ENCODING = {"crf": "26", "preset": "fast", "bf": "0", "g": "10"}


def main() -> int:
    """Render, compress, and replace the shipped recording."""
    with TemporaryDirectory() as temporary:
        made = Path(temporary) / "demo"
        simulate(made, _DEMO, Work(lambda _share, words: print(words, end="\r")))
        shutil.rmtree(SHIPPED, ignore_errors=True)
        compress(made, SHIPPED)
    print(f"{sum(file.stat().st_size for file in SHIPPED.iterdir()) / 1e6:.2f} MB in {SHIPPED}")
    return 0


def compress(made: Path, folder: Path) -> None:
    """Copy a rendered recording with smaller videos, and JPEG pictures of the empty room."""
    folder.mkdir()
    for file in made.iterdir():
        if file.suffix == ".mp4":
            _compress_video(file, folder / file.name)
        elif file.suffix == ".png":
            picture: Any = cv2.imread(str(file))
            path = folder / f"{file.stem}.jpg"
            cv2.imwrite(str(path), picture, [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY])
        else:
            text = file.read_text().replace("_background.png", "_background.jpg")
            (folder / file.name).write_text(text)


def _compress_video(source: Path, target: Path) -> None:
    with av.open(str(source)) as film, av.open(str(target), "w") as out:
        shown = film.streams.video[0]
        stream: Any = out.add_stream("libx264", rate=shown.average_rate)
        stream.width, stream.height, stream.pix_fmt = shown.width, shown.height, "yuv420p"
        stream.options = _ENCODING
        for frame in film.decode(video=0):
            out.mux(stream.encode(frame))
        out.mux(stream.encode(None))


if __name__ == "__main__":
    sys.exit(main())

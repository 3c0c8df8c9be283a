"""The demo recording that is shipped: ``python tools/write_demo.py`` renders it anew."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2

from stereotrack_core.demo import SHIPPED
from stereotrack_core.simulation.disturbances import parsed_disturbances
from stereotrack_core.simulation.make import Simulation, simulate
from stereotrack_core.simulation.rig import SceneOptions

_SCENE = SceneOptions(colour=True, camera_distance=2.6, camera_height=1.75, noise=0.8)
_DEMO = Simulation(
    person="P2",
    motion="t-pose+cross-arms+point",
    frames=100,
    seed=7,
    options=_SCENE,
    disturbances=parsed_disturbances("shadow=0.3,compress=26"),
)
_JPEG_QUALITY = 85


def main() -> int:
    """Render, store the pictures of the empty room as JPEG, and replace the shipped recording."""
    with TemporaryDirectory() as temporary:
        made = Path(temporary) / "demo"
        simulate(made, _DEMO, on_progress=lambda done, of: print(f"{done} of {of}", end="\r"))
        for png in made.glob("*_background.png"):
            picture = cv2.imread(str(png))
            assert picture is not None
            cv2.imwrite(
                str(png.with_suffix(".jpg")), picture, [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY]
            )
            png.unlink()
        description = made / "recording.toml"
        description.write_text(
            description.read_text().replace("_background.png", "_background.jpg")
        )
        shutil.rmtree(SHIPPED, ignore_errors=True)
        shutil.copytree(made, SHIPPED)
    print(f"{sum(file.stat().st_size for file in SHIPPED.iterdir()) / 1e6:.2f} MB in {SHIPPED}")
    return 0


if __name__ == "__main__":
    sys.exit(main())

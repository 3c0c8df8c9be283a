"""The demo recording that is shipped, and the copy of it that a person works on."""

from dataclasses import dataclass
from pathlib import Path

from platformdirs import user_data_path

from stereotrack_core.atomic import filling, write_file

SHIPPED = Path(__file__).with_name("demo_recording")  # made by ``tools/write_demo.py``


@dataclass(frozen=True)
class DemoPlaces:
    """Where the demo keeps its recording and its run."""

    recording: Path
    run: Path


def copied_demo(folder: Path | None = None) -> DemoPlaces:
    """Copy the demo to `folder`, or to the data folder, unless it is there; else InputError."""
    if folder is None:
        folder = user_data_path("stereotrack", appauthor=False) / "demo"
    places = DemoPlaces(folder / "recording", folder / "run.npz")
    if (places.recording / "recording.toml").is_file():
        return places
    with filling(places.recording) as workplace:
        for file in SHIPPED.iterdir():
            write_file(workplace / file.name, file.read_bytes())
    return places

"""The demo recording: what it shows, and where it and its run are kept."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from platformdirs import user_data_path

from stereotrack_core.errors import InputError
from stereotrack_core.simulation.make import Progress, simulate

DEMO_FRAMES = 100
_MOTION, _PERSON, _SEED = "t-pose+cross-arms+point", "P2", 7


@dataclass(frozen=True)
class DemoPlaces:
    """Where the demo keeps its recording and its run."""

    recording: Path
    run: Path

    @property
    def made(self) -> bool:
        """Whether the recording is there."""
        return (self.recording / "recording.toml").is_file()


def demo_places(folder: Path | None) -> DemoPlaces:
    """Recording and run in `folder`, or in the program's own data folder.

    Raises
    ------
    InputError
        Where that is no folder.
    """
    if folder is None:
        folder = user_data_path("stereotrack", appauthor=False) / "demo"
    if folder.exists() and not folder.is_dir():
        raise InputError(
            "this is not a folder", where=str(folder), remedy="Give the name of a folder."
        )
    return DemoPlaces(folder / "recording", folder / "run.npz")


def make_demo(
    places: DemoPlaces,
    *,
    on_progress: Progress | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> None:
    """Render the demo recording: four views, T pose, crossed arms, pointing.

    Raises
    ------
    InputError
        Where its folder cannot be made.
    Cancelled
        Nothing is left behind.
    """
    try:
        places.recording.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"the folder cannot be created ({error.strerror})",
            where=str(places.recording.parent),
            remedy="Give a folder that you may write to: stereotrack demo DIR.",
        ) from error
    simulate(
        places.recording,
        person=_PERSON,
        motion=_MOTION,
        frames=DEMO_FRAMES,
        seed=_SEED,
        on_progress=on_progress,
        cancelled=cancelled,
    )

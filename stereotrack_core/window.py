"""What the program asks of the window, which the core does not know: it is handed over at start."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from stereotrack_core.recording.description import Recording
    from stereotrack_core.recording.landmarks import LandmarkTrajectory
    from stereotrack_core.tracking.parameters import Settings


@dataclass(frozen=True)
class DemoTracking:
    """The demo, to be tracked in the window.

    Recording and run are kept in `folder`, or in the program's own data folder. `on_tracked` is
    told the recording, the landmarks that were found, the frames per second and where the run is
    kept, where it is.
    """

    folder: Path | None
    preset: str
    settings: Settings
    on_tracked: Callable[[Recording, LandmarkTrajectory, float | None, Path | None], None]


@dataclass(frozen=True)
class Opening:
    """What the window begins with; nothing of it: the welcome page.

    `path` is a recording folder or project file, `frame` the one to show first (of a demo when it
    has been tracked), `workspace` None where it is as it was left, `run` one to show. With
    `picture` the window is saved as a picture when everything is painted, and closed.
    """

    path: Path | None = None
    frame: int = 0
    workspace: str | None = None
    run: Path | None = None
    demo: DemoTracking | None = None
    picture: Path | None = None


ShowWindow: TypeAlias = Callable[[Opening, Callable[[str], None]], bool]
"""Shows the window until it is closed.

It is given what to begin with and what tells the person a sentence, and returns whether all went
well.
"""

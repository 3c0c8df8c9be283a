"""What the program asks of the window, which the core does not know: it is handed over at start."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from stereotrack_core.recording.description import Recording
    from stereotrack_core.recording.landmarks import LandmarkTrajectory
    from stereotrack_core.tracking.parameters import Settings


@dataclass(frozen=True)
class DemoTracking:
    """The demo, to be tracked in the window.

    Attributes
    ----------
    folder : Path or None
        Where recording and run are kept; None: the program's own data folder.
    on_tracked : callable
        Told the recording, the landmarks that were found, the frames per second and where the run
        is kept, where it is.
    """

    folder: Path | None
    preset: str
    settings: Settings
    on_tracked: Callable[[Recording, LandmarkTrajectory, float | None, Path | None], None]


@dataclass(frozen=True)
class Opening:
    """What the window begins with; nothing of it: the welcome page.

    Attributes
    ----------
    path : Path or None
        Recording folder or project file.
    frame : int
        Frame to show first; of a demo when it has been tracked.
    workspace : str or None
        None: as it was left.
    run : Path or None
        A run to show.
    picture : Path or None
        The window is saved as a picture when everything is painted, and closed.
    """

    path: Path | None = None
    frame: int = 0
    workspace: str | None = None
    run: Path | None = None
    demo: DemoTracking | None = None
    picture: Path | None = None


@dataclass(frozen=True)
class Window:
    """The window, as the program knows it.

    Attributes
    ----------
    package : str
        Name of its package, of which some modules run in processes of their own.
    show : callable
        Shows the window until it is closed. It is given what to begin with and what tells the
        person a sentence, and returns whether all went well.
    """

    package: str
    show: Callable[[Opening, Callable[[str], None]], bool]

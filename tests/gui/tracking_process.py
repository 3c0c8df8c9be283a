"""A window that tracks so many frames of a recording, and says so; then it waits to be killed.

It is given a recording, a folder for its project, and the number of frames.
"""

import sys
from pathlib import Path

from stereotrack_core.tracking.presets import preset
from tests.gui.window_process import until, window_on


def track(recording: Path, folder: Path, frames: int) -> None:
    app, window = window_on(recording, folder)
    tracker, document = window.context.session.track, window.context.session.document
    tracker.choose("fast", preset("fast").replaced(fit_shape=False))
    asked = range(document.frame_count)
    entry = tracker.begin(document.recording, asked, "tpose", allowed=frames)
    until(app, lambda: len(entry.frames) == frames)
    sys.stdout.write("held\n")
    sys.stdout.flush()
    app.exec()


if __name__ == "__main__":
    track(Path(sys.argv[1]), Path(sys.argv[2]), int(sys.argv[3]))

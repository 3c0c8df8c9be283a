"""Why commands cannot be done now, in sentences."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .main_window import MainWindow


def no_recording(w: MainWindow) -> str:
    """Nothing is open."""
    if w.document.opening:
        return "The recording is still being opened."
    return "" if w.document.recording is not None else "Open a recording first."


def no_project(w: MainWindow) -> str:
    """No project is open, be it for reading."""
    return no_recording(w) or ("" if w.project.project is not None else w.project.why_no_edit())


def no_edit(w: MainWindow) -> str:
    """Nothing can be changed in the project."""
    return no_recording(w) or w.project.why_no_edit()


def no_frames(w: MainWindow) -> str:
    """There is no frame to go to."""
    reason = no_recording(w)
    if reason:
        return reason
    return "" if w.document.frame_count else "The recording has no frames."


def no_depth(w: MainWindow) -> str:
    """No view gives depth."""
    reason = no_frames(w)
    if reason:
        return reason
    if w.clouds.available:
        return ""
    return "No view of this recording gives depth; tracking needs a stereo or depth view."


def no_run(w: MainWindow) -> str:
    """There is no run."""
    reason = no_recording(w)
    if reason:
        return reason
    active = w.runs.active
    return "" if active is not None and active.frames else "There is no run yet."


def no_judgement(w: MainWindow) -> str:
    """No curve is there."""
    return no_run(w)


def running(w: MainWindow) -> str:
    """The tracker works."""
    return "The tracker is running; pause it first." if w.track.running else ""

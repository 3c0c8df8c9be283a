"""Clicks into a file, and what that would do to the file that is there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from stereotrack_core.annotation.click import Click
from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.interop.labels import read_clicks, write_clicks
from stereotrack_core.recording.description import Recording


@dataclass(frozen=True)
class ExportPreview:
    """What writing would do.

    Attributes
    ----------
    words : str
    warning : str
        What would be lost; empty where nothing would.
    """

    words: str
    warning: str = ""


def export_preview(
    clicks: Sequence[Click], path: Path, recording: Recording, landmarks: Sequence[str]
) -> ExportPreview:
    """Compare the clicks with those of the file that would be replaced."""
    frames = len({click.frame for click in clicks})
    words = f"{counted(len(clicks), 'click')} in {counted(frames, 'frame')} will be written."
    if not path.exists():
        return ExportPreview(words)
    try:
        there = read_clicks(path, recording, landmarks=landmarks)
    except InputError as error:
        return ExportPreview(
            words, f"The existing file will be replaced. It holds no clicks: {error.what}."
        )
    old = {click.key: click for click in there.clicks}
    new = {click.key: click for click in clicks}
    both = old.keys() & new.keys()
    same = sum(
        (old[key].position, old[key].visibility) == (new[key].position, new[key].visibility)
        for key in both
    )
    lost = len(old) - len(both) + len(there.problems)
    words += (
        f" Of the {counted(len(old), 'click')} in the existing file, {same} stay the same and "
        f"{len(both) - same} change; {len(new) - len(both)} are new."
    )
    gone = f"{counted(lost, 'line')} of the existing file will be lost." if lost else ""
    return ExportPreview(words, gone)


def export_clicks(clicks: Sequence[Click], path: Path, recording: Recording) -> str:
    """Write clicks; what was done, in words.

    Raises
    ------
    InputError
        Where the file cannot be written, or does not hold afterwards what was written.
    """
    write_clicks(path, clicks, recording)
    names = tuple(dict.fromkeys(click.landmark for click in clicks))
    again = read_clicks(path, recording, landmarks=names).checked()
    if len(again) != len(clicks):
        raise InputError(
            f"{len(again)} of {len(clicks)} clicks could be read back from the file",
            where=str(path),
            remedy="Export to a different drive.",
        )
    return f"{counted(len(clicks), 'click')} saved to {path}."

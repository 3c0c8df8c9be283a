"""What a project says is different from its recording's folder: found, compared, said in words."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.project.project import Project
from stereotrack_core.project.setups import Corrections, save_corrections
from stereotrack_core.project.whereabouts import projects_of

from ..widgets.forms.message import Message


def corrections_of(folder: Path, home: Path | None) -> Corrections | None:
    """What the newest project of a recording corrects; None without one that can be read.

    A project that cannot be read is no failure here: whoever opens it says so.
    """
    found = projects_of(folder, home)
    if not found:
        return None
    try:
        with Project.open(found[0], read_only=True) as project:
            return corrections_in(project)
    except InputError:
        return None


def corrections_in(project: Project) -> Corrections | None:
    """What an open project corrects; None also where that is damaged, which is said later."""
    try:
        return project.corrections()
    except InputError:
        return None


def same_corrections(one: Corrections | None, other: Corrections | None) -> bool:
    """Whether two versions of a recording's description differ from the folder in the same way."""
    if one is None or other is None:
        return one is other
    return save_corrections("", one) == save_corrections("", other)


def applied_message(corrections: Corrections, recording: str) -> Message:
    """Say that the recording is shown corrected, and in what."""
    rows = (
        (len(corrections.time_offsets), "time offset"),
        (len(corrections.first_frames), "first frame"),
        (len(corrections.stream_cameras), "swapped stream"),
        (len(corrections.cameras), "camera"),
    )
    what = ", ".join(counted(number, word) for number, word in rows if number)
    why = f" ({corrections.reason})" if corrections.reason else ""
    return Message(
        "note",
        f"the recording is shown with the corrections of its project{why}",
        recording,
        f"Corrected: {what or 'nothing'}. The recording folder is unchanged.",
    )


def refused_message(error: InputError, recording: str) -> Message:
    """Say that the project asks for corrections that cannot be applied."""
    return Message(
        "warning",
        f"the corrections of the recording in the project cannot be applied: {error.what}",
        recording,
        "The recording is shown without corrections. Clicks may not fit its cameras.",
    )


def differ_message(project: str, reopen: Callable[[], None]) -> Message:
    """Say that the project asks for other corrections than the recording is shown with."""
    return Message(
        "warning",
        "the corrections of the recording in the project have changed",
        project,
        "Open the project again to apply them.",
        button="Reopen project",
        do=reopen,
    )

"""Replace files of the open recording: it is opened again as it is shown."""

from collections.abc import Mapping

from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.writing import replace_calibration

from .messages import Message
from .session import Session


def replace_cameras(session: Session, cameras: Mapping[str, Camera], what: str) -> Message:
    """Give the open recording other cameras, and say `what` was done. Raises InputError."""
    recording = session.document.recording
    if recording is None:
        raise InputError("no recording is open", remedy="Open it again.")
    kept = replace_calibration(recording.folder, cameras)
    said = Message("note", what, remedy=f"The calibration before is {kept.name}.")
    open_again(session, said)
    return said


def open_again(session: Session, said: Message) -> None:
    """Open what is open once more, a file of it was replaced; that is said then."""
    recording, project = session.document.recording, session.project.project
    if recording is None:
        return
    if project is not None and not project.read_only:
        project.use_recording(recording.folder, even_another=True)
    path, frame = session.asked.project or recording.folder, session.document.frame
    session.open(path, frame=frame, workspace=session.view_state.workspace)
    session.said = said

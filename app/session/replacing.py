"""Replace files of the open recording: it is opened again as it is shown."""

from collections.abc import Mapping

import numpy as np

from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.writing import replace_calibration

from .messages import Message
from .session import Session

_MOVED_M = 0.05  # by which a camera may stand elsewhere in the same world
_ANOTHER_WORLD = (
    " A camera stands elsewhere than before. The reference, runs and landmarks in space stay in "
    "the world before: track and fit again. Clicks in the images stay right."
)


def replace_cameras(session: Session, cameras: Mapping[str, Camera], what: str) -> Message:
    """Give the open recording other cameras, and say `what` was done. Raises InputError."""
    recording = session.document.recording
    if recording is None:
        raise InputError("no recording is open", remedy="Open it again.")
    kept = replace_calibration(recording.folder, cameras)
    old = {} if recording.guessed else recording.cameras
    moved = (
        float(np.linalg.norm(one.position_world - old[name].position_world))
        for name, one in cameras.items()
        if name in old
    )
    another = max(moved, default=0.0) > _MOVED_M
    remedy = f"The calibration before is {kept.name}.{_ANOTHER_WORLD if another else ''}"
    said = Message("warning" if another else "note", what, remedy=remedy)
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

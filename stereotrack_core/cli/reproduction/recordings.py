"""The four recordings: rendered once, and recognised when they are there."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stereotrack_core.cli.output import say
from stereotrack_core.cli.progress import stoppable
from stereotrack_core.cli.reproduction.pace import pace
from stereotrack_core.cli.reproduction.places import Places
from stereotrack_core.errors import InputError

if TYPE_CHECKING:
    from stereotrack_core.recording.description import Recording
    from stereotrack_core.simulation.thesis_recordings import ThesisRecording

_SEED = 0


def make_recordings(places: Places, *, short: bool) -> tuple[Recording, ...]:
    """Render what is missing of the four recordings, and open them.

    Raises
    ------
    Cancelled
        When stopped; recordings that are finished stay.
    InputError
        Where a recording is there that is another one.
    """
    from stereotrack_core.simulation.make import simulate
    from stereotrack_core.simulation.thesis_recordings import thesis_recordings

    wanted = thesis_recordings(short=short)
    for one in wanted:
        if _is_there(places, one):
            _opened(places, one)  # refuse another one before anything is rendered
    missing = [one for one in wanted if not _is_there(places, one)]
    with pace("Rendering", sum(one.frames for one in missing)) as going, stoppable() as stopped:
        for one in missing:
            say(f"Rendering {one.name}, {one.frames} frames.")
            places.recordings.mkdir(parents=True, exist_ok=True)
            simulate(
                places.recording(one.name),
                person=one.name,
                frames=one.frames,
                seed=_SEED,
                options=one.options,
                parts=one.parts,
                on_progress=going.advance,
                cancelled=stopped,
            )
            going.next(one.frames)
    return tuple(_opened(places, one) for one in wanted)


def _is_there(places: Places, one: ThesisRecording) -> bool:
    return (places.recording(one.name) / "recording.toml").is_file()


def _opened(places: Places, one: ThesisRecording) -> Recording:
    """Open a recording that is the wanted one: its motions, frames and lenses."""
    from stereotrack_core.recording.folder import open_recording

    recording = open_recording(places.recording(one.name))
    frames = 0 if recording.reference is None else len(recording.reference.frame)
    planned = [(part.name, part.first, part.end) for part in one.parts]
    found = [(segment.name, segment.first, segment.end) for segment in recording.segments]
    options = one.options
    lenses = {
        (camera.width, camera.height, round(float(camera.matrix[0, 0]), 3))
        for camera in recording.cameras.values()
    }
    right = {(options.width, options.height, round(options.focal, 3))}
    if frames != one.frames or found != planned or lenses != right:
        raise InputError(
            "there is another recording than this version would make",
            where=str(recording.folder),
            remedy="Name another folder, or delete this recording.",
        )
    return recording

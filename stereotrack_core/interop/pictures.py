"""Pictures of single frames, beside the labels that other programs show on them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

from stereotrack_core.annotation.click import Click
from stereotrack_core.arrays import ImageArray
from stereotrack_core.errors import Cancelled, InputError
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.recording.writing import write_png


def labelled_pictures(clicks: Iterable[Click]) -> list[tuple[str, int]]:
    """Camera and frame of every picture in which something is clicked, in order of the frames."""
    places = {(click.frame, click.camera) for click in clicks if not click.deleted}
    return [(camera, frame) for frame, camera in sorted(places)]


def write_pictures(
    files: Mapping[tuple[str, int], Path],
    recording: Recording,
    report: Callable[[float], None] = lambda _share: None,
    stopped: Callable[[], bool] = lambda: False,
) -> None:
    """Write raw pictures as PNG, each of a camera and a frame of the recording; folders are made.

    `report` is told the share that is done. What is there already is replaced.

    InputError where a picture cannot be read or written, Cancelled where `stopped` says so; the
    pictures written until then stay.
    """
    if not files:
        return
    shown = _shown(recording)
    wanted = {shown[camera][0] for camera, _ in files if camera in shown}
    views = [view.name for view in recording.views if view.name in wanted]
    with FrameReader(recording, views=views, read_ahead=0) as reader:
        for done, ((camera, frame), path) in enumerate(files.items()):
            if stopped():
                raise Cancelled
            report(done / len(files))
            picture = _picture(reader, frame, *shown[camera])
            make_folder(path.parent)
            write_png(path, picture)


def make_folder(folder: Path) -> None:
    """Make a folder where there is none; InputError where that is not possible."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"this folder cannot be made ({error.strerror})",
            where=str(folder),
            remedy="Choose another place for the labels.",
        ) from error


def _shown(recording: Recording) -> dict[str, tuple[str, bool]]:
    """Of each camera that shows pictures its view, and whether it is the view's left camera."""
    shown = {view.left.camera: (view.name, True) for view in recording.views if view.left}
    return shown | {view.image.camera: (view.name, False) for view in recording.views}


def _picture(reader: FrameReader, frame: int, view: str, is_left: bool) -> ImageArray:
    frame_set = reader.frame_set(frame)
    if view not in frame_set.views:
        raise InputError(
            frame_set.problems.get(view, f"view {view} has no frame {frame}"),
            where=str(reader.recording.folder),
            remedy="Export the labels without --pictures, or delete the clicks of this frame.",
        )
    images = frame_set.views[view]
    return images.image if not is_left or images.left is None else images.left

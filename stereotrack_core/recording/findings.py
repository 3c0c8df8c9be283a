"""Everything that is worth telling about a recording folder, at once."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from stereotrack_core.errors import InputError
from stereotrack_core.recording.camera_checks import check_cameras
from stereotrack_core.recording.consistency import check_consistency
from stereotrack_core.recording.content_checks import (
    check_lengths,
    check_reference,
    check_segments,
    check_subject,
    check_times,
)
from stereotrack_core.recording.description import Recording, Stream, View
from stereotrack_core.recording.detections import own_detections
from stereotrack_core.recording.finding import Finding, Severity
from stereotrack_core.recording.folder import describe
from stereotrack_core.recording.image_checks import check_images
from stereotrack_core.recording.stream_files import open_stream
from stereotrack_core.recording.stream_source import StreamSource
from stereotrack_core.recording.video import VideoStream

__all__ = ["Finding", "Severity", "examine"]

ORDER: dict[Severity, int] = {"error": 0, "warning": 1, "note": 2}


def examine(folder: Path, deep: bool = False, *, compare: bool = False) -> tuple[Finding, ...]:
    """All findings about a recording folder, the gravest first.

    Parameters
    ----------
    folder : Path
    deep : bool
        Whether to decode all images too (undecodable, dark and frozen views, gain differences)
        and to compare the cameras.
    compare : bool
        Whether to compare the cameras by clicks or board corners that lie beside the recording.
    """
    folder = Path(folder)
    complaints: list[InputError] = []
    recording = describe(folder, complaints)
    findings = [Finding.of(error) for error in complaints]
    if recording is not None:
        paced = not any((error.where or "").endswith(", fps") for error in complaints)
        findings += _check(
            recording, readable=not complaints, paced=paced, deep=deep, compare=deep or compare
        )
    return tuple(sorted(findings, key=lambda finding: ORDER[finding.severity]))


def _check(
    recording: Recording, *, readable: bool, paced: bool, deep: bool, compare: bool
) -> Iterator[Finding]:
    yield from check_cameras(recording)
    yield from check_subject(recording)
    counts: dict[str, tuple[int, Stream]] = {}
    for view in recording.views:
        for key, stream in view.streams().items():
            yield from _check_stream(recording, view, key, stream, counts, paced)
        yield from _check_background(view)
    yield from check_lengths(recording, counts)
    lasting = [
        n - stream.first_frame - round(stream.time_offset * recording.fps)
        for n, stream in counts.values()
    ]
    frame_count = max(0, min(lasting, default=0))
    if frame_count:
        yield from check_segments(recording, frame_count)
        yield from check_reference(recording, frame_count)
    yield from _check_detections(recording)
    if deep and readable and frame_count:
        yield from check_images(recording)
    if compare and frame_count:
        yield from check_consistency(recording, frame_count)


def _check_stream(
    recording: Recording,
    view: View,
    key: str,
    stream: Stream,
    counts: dict[str, tuple[int, Stream]],
    paced: bool,
) -> Iterator[Finding]:
    where = f"recording.toml, view {view.name}, {key}"
    try:
        source: StreamSource = open_stream(recording.folder, stream.frames, "grey", where)
    except InputError:
        return  # told when the recording was read
    try:
        counts[f"{view.name} {key}"] = (source.count(), stream)
        missing = source.missing()
        if missing:
            yield Finding(
                "warning",
                f"{where}.frames",
                f"{len(missing)} images are missing between the first and the last of "
                f"{stream.frames!r} (the first missing one is number {missing[0]})",
                "Add them. Without them the view has no image in these frames.",
            )
        if isinstance(source, VideoStream):
            yield from _check_video(where, stream, source, recording.fps if paced else None)
    finally:
        source.close()


def _check_video(
    where: str, stream: Stream, video: VideoStream, fps: float | None
) -> Iterator[Finding]:
    times = video.times
    if times.damage:
        yield Finding(
            "warning",
            f"{where}.frames",
            f"{stream.frames!r} ends early after {times.count()} frames ({times.damage})",
            "Copy it again from the source.",
        )
    if not times.ordered:
        yield Finding(
            "warning",
            f"{where}.frames",
            f"{stream.frames!r} has no usable time stamps. Its frames are counted from the start, "
            "which makes seeking slow",
            "Convert it to MP4 or Matroska.",
        )
        return
    seconds = np.array(times.times(), dtype=np.float64) * video.seconds_per_tick
    yield from check_times(f"{where}.frames", seconds, fps)


def _check_detections(recording: Recording) -> Iterator[Finding]:
    try:
        own_detections(recording)
    except InputError as error:
        yield Finding.of(error)


def _check_background(view: View) -> Iterator[Finding]:
    if view.left is None or (view.left.background and view.image.background):
        return
    yield Finding(
        "note",
        f"recording.toml, view {view.name}",
        "one or both cameras have no background image",
        "The background is learned from the sequence. Set `background` to an image of the empty "
        "scene for better results.",
    )

"""Everything that is worth telling about a recording folder, at once."""

from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.errors import Finding, InputError, Severity
from stereotrack_core.geometry.upright import UP_AXES, Upright
from stereotrack_core.recording.camera_checks import check_cameras, up_of_cameras, view_cameras
from stereotrack_core.recording.consistency import check_consistency
from stereotrack_core.recording.description import Recording, Stream, View
from stereotrack_core.recording.detections import own_detections
from stereotrack_core.recording.folder import describe
from stereotrack_core.recording.image_checks import check_images
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory, unknown_landmarks
from stereotrack_core.recording.stream_files import open_stream
from stereotrack_core.recording.video import VideoStream

__all__ = ["Finding", "Severity", "by_severity", "examine", "examine_described"]

ORDER: dict[Severity, int] = {"error": 0, "warning": 1, "note": 2}
_MOST_TILT = 60.0  # degrees from up that the trunk of somebody who neither lies nor bends may have


def examine(folder: Path, deep: bool = False, *, compare: bool = False) -> tuple[Finding, ...]:
    """All findings about a recording folder, the gravest first.

    `deep`: whether to decode all images too (undecodable, dark and frozen views, gain differences)
    and to compare the cameras. `compare`: whether to compare the cameras by clicks or board corners
    that lie beside the recording.
    """
    folder = Path(folder)
    complaints: list[InputError] = []
    recording = describe(folder, complaints)
    findings = [Finding.of(error) for error in complaints]
    if recording is not None:
        findings += _check(recording, readable=not complaints, deep=deep, compare=deep or compare)
    return by_severity(findings)


def examine_described(recording: Recording) -> tuple[Finding, ...]:
    """The same of a recording that was read without complaints, by its files alone."""
    return by_severity(_check(recording, readable=True, deep=False, compare=False))


def by_severity(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """The findings, the gravest first; else in their order."""
    return tuple(sorted(findings, key=lambda finding: ORDER[finding.severity]))


def _check(recording: Recording, *, readable: bool, deep: bool, compare: bool) -> Iterator[Finding]:
    if recording.guessed:
        what = "the cameras are guessed from the size of the images"
        then = "replace it with a calibration of these cameras"
        remedy = f"Landmarks can be clicked. For 3-D positions, fitting and tracking, {then}."
        yield Finding("warning", "calibration.toml, [metadata] guess", what, remedy)
    else:
        yield from check_cameras(recording)
    yield from _check_subject(recording)
    lasting: dict[str, int] = {}
    for view in recording.views:
        for key in view.streams():
            yield from _check_stream(recording, view, key, lasting, readable)
        yield from _check_background(view)
    yield from _check_lengths(lasting)
    frame_count = max(0, min(lasting.values(), default=0))
    if frame_count:
        yield from _check_segments(recording, frame_count)
        yield from _check_reference(recording, frame_count)
    try:
        own_detections(recording)
    except InputError as error:
        yield Finding.of(error)
    if deep and readable and frame_count:
        yield from check_images(recording)
    if compare and frame_count and not recording.guessed:
        yield from check_consistency(recording, frame_count)


def _check_stream(
    recording: Recording, view: View, key: str, lasting: dict[str, int], readable: bool
) -> Iterator[Finding]:
    stream = view.streams()[key]
    where = f"recording.toml, view {view.name}, {key}"
    try:
        source = open_stream(recording.folder, stream.frames, "grey", where)
    except InputError:
        return  # told when the recording was read
    try:
        lasting[f"{view.name} {key}"] = source.count() - stream.shift(recording.fps)
        if isinstance(source, VideoStream):
            yield from _check_video(where, stream, source, recording.fps if readable else None)
        elif missing := source.missing():
            between = f"between the first and the last of {stream.frames!r}"
            first = f"(the first missing one is number {missing[0]})"
            what = f"{len(missing)} images are missing {between} {first}"
            remedy = "Add them. Without them the view has no image in these frames."
            yield Finding("warning", f"{where}.frames", what, remedy)
    finally:
        source.close()


def _check_video(
    where: str, stream: Stream, video: VideoStream, fps: float | None
) -> Iterator[Finding]:
    times = video.times
    if times.damage:
        what = f"{stream.frames!r} ends early after {times.count()} frames ({times.damage})"
        yield Finding("warning", f"{where}.frames", what, "Copy it again from the source.")
    if not times.ordered:
        slow = "Its frames are counted from the start, which makes seeking slow"
        what = f"{stream.frames!r} has no usable time stamps. {slow}"
        yield Finding("warning", f"{where}.frames", what, "Convert it to MP4 or Matroska.")
        return
    seconds = np.array(times.times(), dtype=np.float64) * video.seconds_per_tick
    yield from check_times(f"{where}.frames", seconds, fps)


def _check_background(view: View) -> Iterator[Finding]:
    if view.left is None or (view.left.background and view.image.background):
        return
    what = "one or both cameras have no background image"
    better = "Set `background` to an image of the empty scene for better results."
    remedy = f"The background is learned from the sequence. {better}"
    yield Finding("note", f"recording.toml, view {view.name}", what, remedy)


PLAUSIBLE_LENGTHS_M: dict[str, tuple[float, float]] = {
    "shoulder_width": (0.2, 0.55),
    "hip_width": (0.12, 0.5),
    "torso_length": (0.3, 0.75),
    "upper_arm_length": (0.17, 0.45),
    "forearm_length": (0.15, 0.4),
    "hand_length": (0.08, 0.28),
    "shoulder_to_head": (0.04, 0.45),
}
"""From small children's to very tall adults' values; other lengths are a slip."""


def _check_lengths(lasting: Mapping[str, int]) -> Iterator[Finding]:
    """Streams of different length, from frame 0 of the recording on, by place of the stream."""
    if not lasting:
        return
    shortest, longest = min(lasting.values()), max(lasting.values())
    if shortest < 1:
        remedy = "Check first_frame and time_offset, and that the files belong together."
        yield Finding("error", "recording.toml", "the streams have no frame in common", remedy)
    elif shortest != longest:
        names = ", ".join(f"{place} {count}" for place, count in lasting.items())
        used = f"the first {shortest} frames are used"
        what = f"the streams have different lengths ({names} frames); {used}"
        start = "Check that all streams start at the same instant."
        remedy = f"{start} Set first_frame for those that do not."
        yield Finding("warning", "recording.toml", what, remedy)


def check_times(where: str, times: FloatArray, fps: float | None) -> Iterator[Finding]:
    """Time stamps in seconds of a video against the recording's rate, where that is known."""
    steps = np.diff(times)
    if len(steps) < 2:
        return
    usual = float(np.median(steps))
    if fps is not None and usual > 0 and abs(1 / usual - fps) > 0.05 * fps:
        what = f"the video states {1 / usual:.2f} frames per second, the recording {fps:g}"
        right = f"fps = {1 / usual:.4g} if the video is right (tested: then its time stamps fit)"
        remedy = f"The value of the recording is used. Write {right}."
        yield Finding("warning", where, what, remedy)
    uneven = np.flatnonzero(np.abs(steps - usual) > 0.5 * usual)
    if uneven.size:
        k = int(uneven[0])
        late = f"{1000 * steps[k]:.0f} ms after frame {k} instead of {1000 * usual:.0f} ms"
        places = f"{uneven.size} of {len(steps)} steps"
        what = f"the time stamps are irregular at {places}: frame {k + 1} comes {late}"
        remedy = "Frames may be missing. Compare with the other views at that frame."
        yield Finding("warning", where, what, remedy)


def _check_subject(recording: Recording) -> Iterator[Finding]:
    """Lengths that no person has."""
    if recording.subject is None:
        return
    for key, (low, high) in PLAUSIBLE_LENGTHS_M.items():
        length = getattr(recording.subject, key)
        if length is not None and not low <= length <= high:
            severity: Severity = "warning"
            remedy = f"Measure it again. Usual values are {low} to {high} m."
            if low <= length / 1000 <= high:
                severity, remedy = "error", f"Lengths are in metres: write {length / 1000:g}."
            what = f"{length:g} m is not a body length"
            yield Finding(severity, f"subject.toml, {key}", what, remedy)


def _check_segments(recording: Recording, frame_count: int) -> Iterator[Finding]:
    """Segments behind the end of the recording."""
    for segment in recording.segments:
        if segment.end > frame_count:
            late = segment.first >= frame_count
            span = f"starts at frame {segment.first}" if late else f"ends at frame {segment.end}"
            what = f"it {span}, but the recording has {frame_count} frames"
            remedy = "Correct the segment, or check whether a stream is too short."
            yield Finding("warning", f"segments.csv, {segment.name}", what, remedy)


def _check_reference(recording: Recording, frame_count: int) -> Iterator[Finding]:
    """Names, range, size, sides and place of the reference."""
    reference = recording.reference
    if reference is None:
        return
    where = "reference.csv"
    yield from reference.notes
    with suppress(InputError):  # told when the recording was read
        others = unknown_landmarks(recording.folder / where)
        what = f"unknown landmarks are ignored: {', '.join(others)}"
        if others:
            yield Finding("note", where, what, f"The nine landmarks are {', '.join(LANDMARKS)}.")
    if not np.isfinite(reference.points).all(axis=2).any():
        yield Finding(
            "warning", where, "it contains no landmarks", "Add rows frame,landmark,x,y,z in metres."
        )
        return
    outside = int(((reference.frame < 0) | (reference.frame >= frame_count)).sum())
    if outside:
        frames = f"{outside} of its {len(reference.frame)} frames"
        what = f"{frames} are not in the recording, which has {frame_count}"
        counts = "or whether the reference counts frames differently"
        remedy = f"Check whether a stream is too short, {counts}."
        yield Finding("warning", where, what, remedy)
    if (wrong := wrong_size(reference)) is not None:
        yield wrong
    else:
        axis = up_of_cameras(recording).axis
        yield from _check_trunk(reference, Upright(axis))
        yield from _check_sides(reference, has_north=axis == UP_AXES[0])
        yield from _check_visible(recording, reference)


def _median(values: FloatArray) -> float:
    known = values[np.isfinite(values)]
    return float(np.median(known)) if known.size else float("nan")


def wrong_size(trajectory: LandmarkTrajectory) -> Finding | None:
    """The finding that the person is of no possible size, as in other units than metres."""
    points = trajectory.by_name()
    hips = (points["left_hip"] + points["right_hip"]) / 2
    shoulders = (points["left_shoulder"] + points["right_shoulder"]) / 2
    across = points["left_shoulder"] - points["right_shoulder"]
    for key, vectors in (("torso_length", shoulders - hips), ("shoulder_width", across)):
        length, (low, high) = _median(np.linalg.norm(vectors, axis=1)), PLAUSIBLE_LENGTHS_M[key]
        if not np.isfinite(length) or 0.7 * low <= length <= 1.4 * high:
            continue
        tall = 1.7 * length / ((low + high) / 2)
        size = f"{tall / 1000:.2g} km" if tall > 500 else f"{tall:.2g} m"
        size = size if tall > 0.02 else f"{1000 * tall:.2g} mm"
        own = f"its {key.replace('_', ' ')} is {length:.4g} m"
        what = f"{own}, which corresponds to a person {size} tall"
        return Finding("error", "reference.csv", what, "Landmarks must be in metres.")
    return None


def _check_trunk(reference: LandmarkTrajectory, world: Upright) -> Iterator[Finding]:
    points = reference.by_name()
    ends = [points[f"left_{end}"] + points[f"right_{end}"] for end in ("hip", "shoulder")]
    trunk = ends[1] - ends[0]
    tilt = _median(np.degrees(np.arccos(trunk @ world.up / np.linalg.norm(trunk, axis=1))))
    if tilt > _MOST_TILT:
        what = f"the person's trunk is {tilt:.0f}° from {world.axis}, which points up"
        remedy = "If the person neither lies nor bends, the axes are not those of the world."
        yield Finding("warning", "reference.csv", what, remedy)


def _check_sides(reference: LandmarkTrajectory, *, has_north: bool) -> Iterator[Finding]:
    points = reference.by_name()
    across = points["right_shoulder"] - points["left_shoulder"]
    at_hips = points["right_hip"] - points["left_hip"]
    if _median(np.einsum("ij,ij->i", across, at_hips)) < 0:
        what = "left and right are swapped at the hips or at the shoulders"
        remedy = "Left and right are those of the person. Swap the names of one pair."
        yield Finding("error", "reference.csv", what, remedy)
        return
    far = []
    for side, other in (("left", "right"), ("right", "left")):
        elbow = points[f"{side}_elbow"]
        own = np.linalg.norm(elbow - points[f"{side}_shoulder"], axis=1)
        opposite = np.linalg.norm(elbow - points[f"{other}_shoulder"], axis=1)
        far.append(_median(own - opposite))
    if min(far) > 0:
        what = "each elbow is closer to the shoulder of the other side"
        swap = "Swap the names of the elbows or of the shoulders."
        remedy = f"Left and right are those of the person. {swap}"
        yield Finding("error", "reference.csv", what, remedy)
    first = across[np.isfinite(across).all(axis=1)][:1]
    if has_north and first.size and first[0, 0] < -0.5 * np.linalg.norm(first[0]):
        causes = "the person faces south, or left and right are swapped"
        what = f"at the start the person's right shoulder points west: {causes}"
        remedy = "In the initial pose the person faces north, and the right hand points east."
        yield Finding("warning", "reference.csv", what, remedy)


def _check_visible(recording: Recording, reference: LandmarkTrajectory) -> Iterator[Finding]:
    points = reference.points.reshape(-1, 3)
    points = points[np.isfinite(points).all(axis=1)]
    for name, camera in view_cameras(recording).items():
        x, y = camera.project(points).T
        inside = (x >= 0) & (x < camera.width) & (y >= 0) & (y < camera.height)
        if inside.mean() < 0.05:
            what = f"only {100 * inside.mean():.0f} % of the reference is within this view's image"
            check = "Check the calibration of this camera, the units"
            remedy = f"{check}, and the world frame of the reference."
            yield Finding("warning", f"reference.csv, view {name}", what, remedy)

"""Do the cameras agree with each other, in space and in time?

Asks points that were seen by several views: clicks, a detector's output or the corners of a
calibration board that lie beside the recording, and its reference.
"""

from collections.abc import Container, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.errors import Finding, InputError
from stereotrack_core.geometry.camera_agreement import disagreeing_camera
from stereotrack_core.geometry.triangulation import epipolar_distance
from stereotrack_core.recording.camera_checks import view_cameras
from stereotrack_core.recording.description import Cameras, Recording
from stereotrack_core.recording.keypoint_names import exchanged
from stereotrack_core.tables import read_rows, whole_number

FILES = (("clicks.csv", "landmark"), ("board_corners_2d.csv", "corner"))
"""Files of pixels and the column that names the point."""

_LEAST_POINTS = 30
_LEAST_SPEED_PX = 3.0  # pixels per frame; slower points say nothing about time
_MOST_PLACES = 20_000_000  # views times frames times points that fit into memory comfortably
_SHIFTS = np.round(np.arange(-2.0, 2.01, 0.05), 2)
_LEAST_SHIFT = 0.15
LEAST_GAIN = 0.12
_CAP_PX = 15.0  # larger errors count as this much, so that wrong points do not decide


@dataclass(frozen=True, eq=False)
class Observations:
    """Pixels (V, F, L, 2) of points in views over contiguous frames (F,); NaN where not seen.

    `mirror` names for each of the L points the one of the other side, or itself.
    """

    views: tuple[str, ...]
    frame: IntArray
    pixels: FloatArray
    mirror: tuple[int, ...]


def check_consistency(recording: Recording, frame_count: int) -> Iterator[Finding]:
    """Views that contradict the others, in place or in time."""
    # a row of clicks names a view or a camera
    cameras = {**recording.cameras, **view_cameras(recording)}
    for file, column in FILES:
        seen = observations(recording.folder / file, column, cameras, frame_count)
        if seen is None or len(seen.views) < 2:
            continue
        misplaced = list(_check_place(file, cameras, seen))
        yield from misplaced
        if not misplaced and len(seen.views) > 2:
            yield from _check_time(file, cameras, seen, recording.fps)


def observations(
    path: Path, column: str, views: Container[str], frame_count: int
) -> Observations | None:
    """Pixels of a file of :data:`FILES` in views, or cameras, of these names.

    None where there is no such file, or it is laid out in another way: the format does not name it.
    """
    names: dict[str, int] = {}
    points: dict[str, int] = {}
    rows: list[tuple[int, int, int, float, float]] = []
    header = ("frame", "view", column, "x", "y")
    try:
        for line, cells in read_rows(path, header) if path.is_file() else ():
            if cells["view"] not in views:
                continue
            try:
                x, y = float(cells["x"]), float(cells["y"])
            except ValueError:
                continue  # not seen there
            frame = whole_number(cells["frame"], path, line, "frame")
            if 0 <= frame < frame_count and np.isfinite([x, y]).all():
                view = names.setdefault(cells["view"], len(names))
                point = points.setdefault(cells[column], len(points))
                rows.append((view, frame, point, x, y))
    except InputError:
        return None
    if not rows:
        return None
    table = np.array(rows)
    view_at, frame_at, point_at = table[:, :3].astype(np.int64).T
    frames = np.arange(frame_at.min(), frame_at.max() + 1)
    if len(names) * len(frames) * len(points) > _MOST_PLACES:
        return None
    pixels = np.full((len(names), len(frames), len(points), 2), np.nan)
    pixels[view_at, frame_at - frames[0], point_at] = table[:, 3:]
    mirror = tuple(points.get(exchanged(name), place) for name, place in points.items())
    return Observations(tuple(names), frames, pixels, mirror)


def _check_place(file: str, cameras: Cameras, seen: Observations) -> Iterator[Finding]:
    """The view that contradicts the others in place; what is late is measured by itself."""
    named = [replace(cameras[name], name=name) for name in seen.views]
    found = disagreeing_camera(named, seen.frame, seen.pixels, seen.mirror)
    if found is None or np.isfinite(found.late_frames):
        return
    if not found.camera:
        both = " and ".join(found.others)
        off = f"the median distance of the points of {file} is {found.off_px:.0f} px"
        what = f"they disagree: {off}, and it cannot be told which of them is wrong"
        third = "A third view would help to find out which is wrong."
        remedy = f"Check calibration and synchronisation of both. {third}"
        yield Finding("warning", f"calibration.toml, views {both}", what, remedy)
        return
    agreed = f"points of {file} on which they agree within {found.agreement_px:.0f} px"
    off = f"are {found.off_px:.0f} px off in its image (median)"
    what = f"it disagrees with the other cameras: {agreed} {off}"
    remedy = "Leave this view out where accuracy matters, or calibrate it again."
    yield Finding("warning", f"calibration.toml, view {found.camera}", what, remedy)


def _check_time(file: str, cameras: Cameras, seen: Observations, fps: float) -> Iterator[Finding]:
    """The view whose epipolar error falls most when its frames are taken as earlier or later."""
    verdicts = [(*_best_shift(cameras, seen, i), name) for i, name in enumerate(seen.views)]
    shift, gain, name = max(verdicts, key=lambda verdict: verdict[1])
    if abs(shift) < _LEAST_SHIFT or gain < LEAST_GAIN:
        return
    off = f"{1000 * abs(shift) / fps:.0f} ms ({abs(shift):.2f} frames)"
    shows = f"it shows the same instant {off} {'later' if shift > 0 else 'earlier'}"
    better = f"corrected for this, the points of {file} fit {100 * gain:.0f} % better"
    what = f"it is not synchronised with the other views: {shows}; {better}"
    remedy = f"Set time_offset = {shift / fps:.3f} for its stream, or synchronise the cameras."
    yield Finding("warning", f"recording.toml, view {name}, time_offset", what, remedy)


def _best_shift(cameras: Cameras, seen: Observations, i: int) -> tuple[float, float]:
    """Shift s in frames for which view i at k + s fits the others at k best, and the gain.

    The gain is the relative fall of the mean epipolar error, over the same points for all s.
    """
    pixels = seen.pixels[i]
    if len(pixels) < 2:
        return 0.0, 0.0
    speed = np.linalg.norm(np.gradient(pixels, axis=0), axis=-1)
    both_ends = _shifted(pixels, float(_SHIFTS[0])) + _shifted(pixels, float(_SHIFTS[-1]))
    usable = np.isfinite(both_ends).all(axis=-1) & (speed > _LEAST_SPEED_PX)
    others = [j for j in range(len(seen.views)) if j != i]
    own_camera = cameras[seen.views[i]]
    errors = []
    for s in _SHIFTS:
        own = _shifted(pixels, float(s))[usable]
        known_there = ((cameras[seen.views[j]], seen.pixels[j][usable]) for j in others)
        against = [epipolar_distance(own_camera, own, *other) for other in known_there]
        every = np.concatenate(against)
        known = every[np.isfinite(every)]
        if len(known) < _LEAST_POINTS:
            return 0.0, 0.0
        errors.append(float(np.mean(np.minimum(known, _CAP_PX))))
    now, best = errors[int(np.abs(_SHIFTS).argmin())], int(np.argmin(errors))
    return float(_SHIFTS[best]), (now - errors[best]) / now if now > 0 else 0.0


def _shifted(path: FloatArray, shift: float) -> FloatArray:
    """A path (F, L, 2) at k + shift, linear between frames; NaN where a neighbour is not known."""
    at = np.arange(len(path)) + shift
    below = np.floor(at).astype(int)
    part = (at - below)[:, None, None]
    padded = np.concatenate([path, np.full((1, *path.shape[1:]), np.nan)])
    first = padded[np.where((below >= 0) & (below < len(path)), below, len(path))]
    second = padded[np.where((below >= -1) & (below + 1 < len(path)), below + 1, len(path))]
    return np.asarray(np.where(part == 0, first, (1 - part) * first + part * second))

"""MediaPipe's and FreeMoCap's keypoints: arrays (.npy) of all cameras, and wide tables (.csv).

An array has the axes camera, frame, point and x, y (and a third number, which is no confidence and
is passed over), the cameras in the order of their names, or frame, point, x, y of one camera. A
table has a row for each frame and the columns ``NAME_x``, ``NAME_y`` and perhaps
``NAME_visibility``, ``NAME_likelihood`` or ``NAME_confidence``. Places from 0 to 1 are shares of
the image's size, as MediaPipe gives them.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.interop.keypoints.source import FileRow, KeypointSource, Who
from stereotrack_core.interop.label_source import checked_frame
from stereotrack_core.interop.npz import read_number_array
from stereotrack_core.recording.keypoint_names import MEDIAPIPE_33, layouts_of
from stereotrack_core.tables import number_or_nan, read_cells, whole_number

CONFIDENCES = ("visibility", "likelihood", "confidence", "score", "presence")
"""What a point's confidence is called."""
_SHARE = 2.0  # below it all places of a picture are shares of its size: nobody is two pixels large


def read_array(source: KeypointSource) -> Iterator[FileRow]:
    """Rows of a .npy file; InputError where its shape or its cameras make no sense."""
    path = source.path
    remedy = "Save an array of camera, frame, point, x y with numpy.save."
    array = read_number_array(path, remedy)
    if array.ndim == 3:
        array = array[None]
    if array.ndim != 4 or array.shape[3] < 2:
        raise InputError(f"the array has the shape {array.shape}", path, remedy)
    count, body = array.shape[2], len(MEDIAPIPE_33)
    if source.layout is None and count > body and not layouts_of(count):  # hands and face follow
        names: Sequence[str] = (*MEDIAPIPE_33, *(f"point_{i}" for i in range(body, count)))
    else:
        names = source.points_of(count, str(path))
    for camera, places in zip(_cameras(source, len(array)), array[..., :2], strict=True):
        if source.camera is not None and camera != source.camera_of("", str(path)):
            continue
        places = pixels_of_shares(places, source.recording.cameras[camera])
        for frame, k in np.argwhere(np.isfinite(places).all(axis=2)).tolist():
            x, y = places[frame, k].tolist()
            yield frame, camera, names[k], x, y, 1.0, source.name, Who(0)


def _cameras(source: KeypointSource, count: int) -> Sequence[str]:
    """Cameras of an array's first axis: of the mono views, or of all, by their names' order."""
    if count == 1:
        return [source.camera_of(source.path.name, str(source.path))]
    views = source.recording.views
    mono = sorted(view.image.camera for view in views if view.kind == "mono")
    every = sorted(view.image.camera for view in views)
    for found in (mono, every, sorted(source.recording.cameras)):
        if len(found) == count:
            return found
    what = f"the array has {count} cameras, the recording {len(every)}"
    raise InputError(what, source.path, "Save one array for each camera, and give --camera.")


def pixels_of_shares(places: FloatArray, camera: Camera) -> FloatArray:
    """Places (..., 2) in pixels, where they are shares of the image's size."""
    known = places[np.isfinite(places)]
    if not known.size or float(np.percentile(np.abs(known), 95)) >= _SHARE:
        return places
    with np.errstate(over="ignore"):  # a number of a damaged file
        pixels = places * np.array([camera.width, camera.height]) - 0.5
    return np.where(np.isfinite(pixels), pixels, np.nan)


def wide_columns(header: Sequence[str]) -> dict[str, dict[str, int]]:
    """Columns of a first line by keypoint and ``x``, ``y``, ``sure``; empty of other tables."""
    found: dict[str, dict[str, int]] = {}
    for place, title in enumerate(header):
        name, _, kind = title.strip().rpartition("_")
        kind = "sure" if kind.lower() in CONFIDENCES else kind.lower()
        if name and kind in ("x", "y", "sure"):
            found.setdefault(name, {})[kind] = place
    return {name: own for name, own in found.items() if {"x", "y"} <= set(own)}


def read_wide(source: KeypointSource) -> Iterator[FileRow]:
    """Rows of a table of one camera, by its column ``frame`` or in order; else InputError."""
    path = source.path
    lines = read_cells(path, headers=1)
    header, columns = lines[0], wide_columns(lines[0])
    camera = source.camera_of(path.name, str(path))
    filled = [(number, line) for number, line in enumerate(lines[1:], start=2) if any(line)]
    places = np.full((len(filled), len(columns), 2), np.nan)
    sure = np.ones((len(filled), len(columns)))
    frames = []
    own_frame = header.index("frame") if "frame" in header else None
    for row, (number, line) in enumerate(filled):
        cells = [*line, *[""] * (len(header) - len(line))]
        frame = row if own_frame is None else whole_number(cells[own_frame], path, number, "frame")
        frames.append(checked_frame(frame, where=f"{path}, line {number}"))
        for k, own in enumerate(columns.values()):
            values = {a: number_or_nan(cells[j], path, number, header[j]) for a, j in own.items()}
            places[row, k] = values["x"], values["y"]
            sure[row, k] = values.get("sure", 1.0)
    places = pixels_of_shares(places, source.recording.cameras[camera])
    for row, frame in enumerate(frames):
        for k, name in enumerate(columns):
            x, y = places[row, k].tolist()
            yield frame, camera, name, x, y, float(sure[row, k]), source.name, Who(0)

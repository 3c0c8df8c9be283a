"""From the state of a calibration to what the widgets show."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.calibrate.bundle import rms_of
from stereotrack_core.calibrate.pictures import Sightings
from stereotrack_core.calibrate.report import lens_table
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.tables import Table, number

from ...widgets.camera.board_picture import BoardShot, CoverageShown
from ...widgets.forms.step_list import StepShown
from ...widgets.scene.content import SceneContent
from ...widgets.tables.trees import CameraRows, PictureRow
from .saving import ReadPicture
from .state import DOING, STEPS, Calibration, StepName

_MOST_EMPTY = 200
"""Pictures without a board that are listed for a camera; of long videos only those with one are."""
_BAD, _BAD_PX = 2.0, 0.3
"""Times the usual error, and pixels, from which a picture is marked."""
_MOST_BOARDS = 150


def steps_shown(state: Calibration) -> list[StepShown]:
    """All steps with their ticks."""
    return [
        StepShown(name, title, state.is_done(name), state.is_stale(name), state.why_not(name))
        for name, title in STEPS.items()
    ]


_HINTS: dict[StepName, tuple[str, tuple[str, ...]]] = {
    "board": (
        "Choose the pictures of each camera, and describe the board.",
        (
            "Film 15 to 30 positions for each camera, sharp, tilted by 30 to 45 degrees to all "
            "sides, near and far, and into every corner of the image.",
            "For several cameras, carry the board to where two of them see it at the same time. "
            "Picture k of all cameras must show the same instant.",
        ),
    ),
    "pictures": (
        "Find the board in the pictures.",
        ("Corners are shown on the pictures while the search goes on.",),
    ),
    "lenses": (
        "Calculate the lenses.",
        ("Each camera is calibrated from its own pictures; all lens models are tried.",),
    ),
    "world": (
        "Place all cameras in one world.",
        ("All cameras and all boards are adjusted together.",),
    ),
    "axes": ("Choose where up, north and the origin are.", ()),
    "save": ("Save the calibration.", ()),
}
_COLOURS = {"good": "good", "doubtful": "warning", "bad": "error"}


def verdict_shown(state: Calibration) -> tuple[str, Sequence[str], str]:
    """Sentence, remarks and colour of the step that is shown."""
    if state.busy == state.step:
        return f"{DOING[state.step]} …", (), "accent"
    if state.step == "save" and state.saved:
        return state.saved, (), "good"
    if state.step == "board" and state.recognised:
        return state.recognised, (), "good"
    found = state.verdict(state.step)
    if found is None and state.step == "lenses" and state.kept is not None:
        left = [one.camera for one in state.sources if one.camera not in state.given]
        words = f"The lenses of {state.kept.file.name} are kept as they are."
        more = (f"Those of {', '.join(left)} are to be calculated.",) if left else ()
        return words, more, "muted" if left else "good"
    if found is None:
        return *_HINTS[state.step], "muted"
    remarks = list(found.remarks)
    if state.is_stale(state.step):
        remarks.insert(0, "Other pictures are ticked now, or other lenses are chosen: calculate "
                       "again.")  # fmt: skip
    return found.words, remarks, _COLOURS[found.grade]


# ---- pictures


def camera_rows(state: Calibration) -> list[CameraRows]:
    """The pictures of all cameras with their ticks and errors."""
    if state.found is None:
        return []
    return [_rows_of(state, one) for one in state.found.search.sightings]


def _rows_of(state: Calibration, seen: Sightings) -> CameraRows:
    names = dict(zip(seen.frames.tolist(), seen.pictures, strict=True))
    corners = {int(f): _count(p) for f, p in zip(seen.frames, seen.pixels, strict=True)}
    shown = state.step not in ("board", "pictures")
    errors = (
        {
            frame: rms_of(error)
            for (name, frame), error in state.errors.items()
            if name == seen.camera
        }
        if shown
        else {}
    )
    usual = float(np.median(list(errors.values()))) if errors else np.inf
    rows = [
        PictureRow(
            frame,
            name,
            (seen.camera, frame) not in state.unticked,
            str(corners[frame]),
            number(errors.get(frame, np.nan), 2) if shown else "",
            _remark(state, seen.camera, frame),
            "warning" if errors.get(frame, 0.0) > max(_BAD * usual, _BAD_PX) else "",
        )
        for frame, name in names.items()
    ]
    empty = [PictureRow(out.frame, out.picture, remark=out.reason) for out in seen.left_out]
    if len(empty) <= _MOST_EMPTY:
        rows += empty
    ticked = sum(row.ticked for row in rows if row.corners)
    whole = (
        rms_of(np.concatenate([e for (n, _), e in state.errors.items() if n == seen.camera]))
        if errors
        else np.nan
    )
    summary = ("", number(whole, 2) if errors else "",
               f"{ticked} of {seen.searched} used" if shown else
               f"found in {len(seen)} of {seen.searched}")  # fmt: skip
    return CameraRows(seen.camera, summary, tuple(sorted(rows, key=lambda row: row.frame)))


def _remark(state: Calibration, camera: str, frame: int) -> str:
    if (camera, frame) in state.unticked:
        return "left out by hand"
    return state.left_out.get((camera, frame), "")


def _count(pixels: FloatArray) -> int:
    return int(np.isfinite(pixels[:, 0]).sum())


def shot_shown(state: Calibration, read: ReadPicture | None) -> BoardShot | None:
    """The picture that is chosen, with corners and errors; the newest while the search goes on."""
    if state.busy == "pictures":
        live = state.looked
        if live is None:
            return BoardShot("", message="Opening the pictures …")
        columns = state.board.columns if live.pixels is not None and len(live.pixels) == len(
            state.board.corners) else 0  # fmt: skip
        title = f"{live.camera}, {live.name}"
        title += "" if live.pixels is not None else ": no board found"
        return BoardShot(title, live.image, live.pixels, None, columns)
    if read is None or state.shot != (read.source.camera, read.frame):
        return None
    camera, frame = state.shot
    corners, errors, columns = None, None, 0
    if state.found is not None:
        board = state.found.search.board
        seen = next((s for s in state.found.search.sightings if s.camera == camera), None)
        rows = [] if seen is None else np.flatnonzero(seen.frames == frame).tolist()
        if seen is not None and rows:
            corners, columns = seen.pixels[rows[0]], board.columns
        if state.step not in ("board", "pictures"):
            errors = state.errors.get((camera, frame))
    title = f"{camera}, {read.name}"
    if errors is not None:
        title += f": {rms_of(errors):.2f} px"
    return BoardShot(title, read.image, corners, errors, columns, read.problem)


def coverage_shown(state: Calibration) -> CoverageShown | None:
    """Coverage of the camera whose picture is shown, or of the first one."""
    name = state.shot[0] if state.shot is not None else ""
    fit = state.fits.get(name) or next(iter(state.fits.values()), None)
    if fit is None:
        return None
    coverage, pixels = fit.coverage, fit.sightings.pixels
    title = (
        f"{fit.camera.name}: {100 * coverage.share:.0f} % covered, tilted up to "
        f"{coverage.tilt_deg:.0f}°, {coverage.nearest_m:.1f} to {coverage.farthest_m:.1f} m"
    )
    corners = pixels[np.isfinite(pixels[..., 0])]
    return CoverageShown(title, fit.sightings.size, coverage.cells, corners)


# ---- tables and scene


def short_lens_table(state: Calibration) -> Table | None:
    """Errors of the lenses, without what does not help to judge them."""
    if not state.fits:
        return None
    whole = lens_table(list(state.fits.values()))
    kept = [k for k, name in enumerate(whole.columns) if name != ">principal point"]
    rows = [[row[k] for k in kept] for row in whole.rows]
    return Table(whole.title, [whole.columns[k] for k in kept], rows)


def scene_shown(state: Calibration) -> SceneContent:
    """Cameras and boards in the chosen world; on the last step also the cameras as they were."""
    if not state.base:
        return SceneContent()
    outline = _outline(state)
    boards = state.boards[:: max(1, len(state.boards) // _MOST_BOARDS)]
    if state.step == "axes" and state.axes.way == "board":
        boards = state.boards
    recorded = {} if state.recording is None else state.recording.cameras
    same_world = state.of_recording or (state.step == "save" and state.axes.way == "recording")
    before = tuple(one for name, one in recorded.items() if name in state.cameras)
    return SceneContent(
        cameras=tuple((state.cameras or state.base).values()),
        cameras_before=before if same_world else (),
        boards=tuple(_placed(one, outline) for one in boards),
    )


def _outline(state: Calibration) -> FloatArray:
    """Corners (4, 3) of the outer squares, metres, board frame, from the upper left."""
    board = state.board if state.world is None else state.world.result.board
    right, low = board.columns * board.square, board.rows * board.square
    start = -board.square
    return np.array([[start, start, 0], [right, start, 0], [right, low, 0], [start, low, 0]])


def _placed(world_from_board: RigidTransform, outline: FloatArray) -> FloatArray:
    return world_from_board.apply(outline)

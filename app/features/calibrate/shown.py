"""From the state of a calibration to what the widgets show."""

from collections.abc import Sequence

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.calibrate.bundle import rms_of
from stereotrack_core.calibrate.pictures import Sightings
from stereotrack_core.calibrate.report import lens_table
from stereotrack_core.tables import Table, number

from ...widgets.camera.board_picture import BoardShot
from ...widgets.forms.step_list import StepShown
from ...widgets.scene.content import SceneContent
from ...widgets.tables.table import Cell
from ...widgets.tables.trees import TreeRow
from .state import DOING, STEPS, Calibration, ReadPicture, StepName

_MOST_EMPTY = 200
"""Pictures without a board that are listed for a camera; of long videos only those with one are."""
_BAD, _BAD_PX = 2.0, 0.3  # times the usual error, and pixels, from which a picture is marked
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
        ("Other descriptions of the board are tried too, and the one that fits is taken.",),
    ),
    "lenses": (
        "Calculate the lenses.",
        ("Each camera is calibrated from its own pictures; all lens models are tried.",),
    ),
    "world": (
        "Place all cameras in one world.",
        ("All cameras and all boards are adjusted together.",),
    ),
    "axes": ("Choose where up, north and the origin are, and save the calibration.", ()),
}
_STALE = "Other pictures are ticked now, or another lens model is chosen: calculate again."
_COLOURS = {"good": "good", "doubtful": "warning", "bad": "error"}


def verdict_shown(state: Calibration) -> tuple[str, Sequence[str], str]:
    """Sentence, remarks and colour of the step that is shown."""
    if state.busy == state.step:
        return f"{DOING[state.step]} …", (), "accent"
    if state.step == "axes" and state.saved:
        return state.saved, (), "good"
    found = state.verdict(state.step)
    if found is None:
        return *_HINTS[state.step], "muted"
    remarks = [_STALE] if state.is_stale(state.step) else []
    return found.words, [*remarks, *found.remarks], _COLOURS[found.grade]


# ---- pictures


def camera_rows(state: Calibration) -> list[TreeRow]:
    """The pictures of all cameras with their ticks and errors."""
    if state.found is None:
        return []
    return [_rows_of(state, one) for one in state.found.sightings]


def _rows_of(state: Calibration, seen: Sightings) -> TreeRow:
    calculated = state.step not in ("board", "pictures")
    errors: dict[int, FloatArray] = {}
    if calculated:
        errors = {k: error for (name, k), error in state.errors.items() if name == seen.camera}
    rms = {frame: rms_of(error) for frame, error in errors.items()}
    limit = max(_BAD * float(np.median([*rms.values()])), _BAD_PX) if rms else np.inf
    rows, ticked = {}, 0
    for frame, name, pixels in zip(seen.frames.tolist(), seen.pictures, seen.pixels, strict=True):
        shot, error = (seen.camera, frame), rms.get(frame, np.nan)
        used = shot not in state.unticked
        remark = state.left_out.get(shot, "") if used else "left out by hand"
        ticked, muted = ticked + used, "" if used else "muted"
        rows[frame] = TreeRow((
            Cell(name, name, muted, value=shot, ticked=used),
            Cell(str(int(np.isfinite(pixels[:, 0]).sum())), colour=muted),
            Cell(number(error, 2) if calculated else "",
                 colour="warning" if error > limit else muted),
            Cell(remark, remark, muted),
        ))  # fmt: skip
    for out in seen.left_out if len(seen.left_out) <= _MOST_EMPTY else ():
        picture = Cell(out.picture, out.picture, "muted", value=(seen.camera, out.frame))
        rows[out.frame] = TreeRow((picture, Cell(), Cell(), Cell(out.reason, out.reason, "muted")))
    whole = number(rms_of(np.concatenate([*errors.values()])), 2) if errors else ""
    found = f"{ticked} of {seen.searched} used"
    if not calculated:
        found = f"found in {len(seen)} of {seen.searched}"
    head = (Cell(seen.camera, bold=True), Cell(), Cell(whole), Cell(found))
    return TreeRow(head, tuple(rows[frame] for frame in sorted(rows)))


def shot_shown(state: Calibration, read: ReadPicture | None) -> BoardShot | None:
    """The picture that is chosen, with corners and errors."""
    if read is None or state.shot != (read.source.camera, read.frame):
        return None
    camera, frame = state.shot
    title, corners, errors = f"{camera}, {read.name}", None, None
    for seen in state.found.sightings if state.found is not None else ():
        rows = np.flatnonzero(seen.frames == frame)
        if seen.camera == camera and len(rows):
            corners = seen.pixels[rows[0]]
            errors = None if state.step == "pictures" else state.errors.get(state.shot)
    if errors is not None:
        title += f": {rms_of(errors):.2f} px"
    columns = state.found_board.columns if corners is not None else 0
    size = (0, 0) if read.image is None else (read.image.shape[1], read.image.shape[0])
    return BoardShot(title, size, corners, errors, columns, image=read.image, message=read.problem)


def coverage_shown(state: Calibration) -> BoardShot | None:
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
    return BoardShot(title, fit.sightings.size, corners, cells=coverage.cells)


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
    board = state.found_board
    right, low, start = board.columns * board.square, board.rows * board.square, -board.square
    outline = np.array([[start, start, 0], [right, start, 0], [right, low, 0], [start, low, 0]])
    boards = state.boards[:: max(1, len(state.boards) // _MOST_BOARDS)]
    if state.step == "axes" and state.axes.way == "board":
        boards = state.boards
    same_world = state.of_recording or (state.step == "axes" and state.axes.way == "recording")
    before = tuple(one for name, one in state.recorded.items() if name in state.cameras)
    return SceneContent(
        cameras=tuple((state.cameras or state.base).values()),
        cameras_before=before if same_world else (),
        boards=tuple(one.apply(outline) for one in boards),
    )

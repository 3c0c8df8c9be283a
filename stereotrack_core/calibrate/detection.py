"""Corners of a board in a picture, whether it is the board that was named, and where it may be."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import product

import cv2
import numpy as np

from stereotrack_core.arrays import FloatArray, ImageArray
from stereotrack_core.calibrate.board import Board
from stereotrack_core.calibrate.lens import Lens
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.work import NO_WORK, Work

_LEAST_CHARUCO = 6  # corners; with fewer a board's pose is a guess
_WINDOW_SHARE = 0.35  # of a square's side, within which a corner is refined
_GAP_SHARE = 0.85  # of the gap between a corner and the nearest marker, for the same
_LEAST_WINDOW, _WIDEST_WINDOW = 2, 11
_FARTHEST_MOVE = 1.5  # pixels; farther away there is another corner
_FLAGS = cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_ACCURACY
_CRITERIA = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 60, 1e-3)


def find_board(image: ImageArray, board: Board) -> FloatArray | None:
    """Raw pixels (n, 2) of all corners in a grey picture, NaN where unseen; None without a board.

    A chessboard has to be seen whole. Its corners begin where the first inner square is light,
    unless it looks the same after half a turn.
    """
    found = _charuco(image, board) if board.dictionary else _chessboard(image, board)
    return found if found is not None and _is_plausible(found, board) else None


def _chessboard(image: ImageArray, board: Board) -> FloatArray | None:
    size = board.columns, board.rows
    seen, corners = cv2.findChessboardCornersSB(image, size, flags=_FLAGS)
    if not seen:
        return None
    pixels = np.asarray(corners, dtype=np.float64).reshape(-1, 2)
    if not board.ambiguous:  # begin where the square between four corners is the lighter one
        grid = pixels.reshape(-1, board.columns, 2)
        middles = 0.25 * (grid[:-1, :-1] + grid[1:, :-1] + grid[:-1, 1:] + grid[1:, 1:])
        at = np.clip(np.rint(middles).astype(int), 0, np.array(image.shape[1::-1]) - 1)
        value = image[at[..., 1], at[..., 0]].astype(np.float64)
        odd = np.indices(value.shape).sum(axis=0) % 2
        if not value[odd == 0].mean() > value[odd == 1].mean():
            pixels = pixels[::-1].copy()
    return _refined(image, pixels, board)


def _charuco(image: ImageArray, board: Board) -> FloatArray | None:
    corners, numbers, _, _ = _charuco_detector(board).detectBoard(image)
    if corners is None or numbers is None or len(corners) < _LEAST_CHARUCO:
        return None
    pixels = np.full((len(board.corners), 2), np.nan)
    pixels[np.asarray(numbers).ravel()] = np.asarray(corners, dtype=np.float64).reshape(-1, 2)
    return _refined(image, pixels, board)


@lru_cache(maxsize=64)
def _charuco_detector(board: Board) -> cv2.aruco.CharucoDetector:
    parameters = cv2.aruco.DetectorParameters()
    parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    return cv2.aruco.CharucoDetector(board.aruco_board(), cv2.aruco.CharucoParameters(), parameters)


def _refined(image: ImageArray, pixels: FloatArray, board: Board) -> FloatArray:
    """Corners moved to the saddle of the grey values, without reaching other corners or markers."""
    heights = _heights(pixels.reshape(board.rows, board.columns, 2)).ravel()
    usual = np.nanmedian(heights) if np.isfinite(heights).any() else np.nan
    heights = np.where(np.isfinite(heights), heights, usual)
    gap = 0.5 * (1.0 - board.marker / board.square)  # between a corner and the nearest marker
    share = min(_WINDOW_SHARE, _GAP_SHARE * gap)
    halves = np.clip(np.nan_to_num(np.floor(share * heights)), 0, _WIDEST_WINDOW)
    result = pixels.copy()
    for half in np.unique(halves[halves >= _LEAST_WINDOW]).astype(int).tolist():
        rows = np.flatnonzero((halves == half) & np.isfinite(pixels[:, 0]))
        if not rows.size:
            continue
        start = np.ascontiguousarray(pixels[rows][:, None], dtype=np.float32)
        found = cv2.cornerSubPix(image, start, (half, half), (-1, -1), _CRITERIA)
        moved = np.asarray(found, dtype=np.float64).reshape(-1, 2)
        near = np.linalg.norm(moved - pixels[rows], axis=1) < min(_FARTHEST_MOVE, half)
        result[rows[near]] = moved[near]
    return result


def _heights(grid: FloatArray) -> FloatArray:
    """Least heights (r, c) in pixels of the parallelograms around corners (r, c, 2)."""
    along, down = np.diff(grid, axis=1), np.diff(grid, axis=0)
    tops, sides = along[:-1], down[:, :-1]
    area = np.abs(tops[..., 0] * sides[..., 1] - tops[..., 1] * sides[..., 0])
    longest = np.maximum(np.linalg.norm(tops, axis=-1), np.linalg.norm(sides, axis=-1))
    squares = np.pad(area / np.maximum(longest, 1e-9), 1, constant_values=np.nan)
    around = [squares[:-1, :-1], squares[1:, :-1], squares[:-1, 1:], squares[1:, 1:]]
    return np.asarray(np.fmin.reduce(around))


def _is_plausible(pixels: FloatArray, board: Board) -> bool:
    """Whether neighbours are apart and the corners span an area."""
    ends = pixels[board.neighbours]
    side = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    side = side[np.isfinite(side)]
    if not side.size or side.min() < 2.0:
        return False
    seen = pixels[np.isfinite(pixels[:, 0])]
    spread = np.linalg.svd(seen - seen.mean(axis=0), compute_uv=False)
    return bool(spread[1] > 0.02 * spread[0])


_LEAST_SHARE = 0.25  # of the corners of all pictures, from which a board is taken as it was named
_SAMPLE = 3  # pictures in which larger boards are looked for


@dataclass(frozen=True)
class Recognition:
    """The board, perhaps mirrored, and clauses on what differs from what was named."""

    board: Board
    mirrored: bool = False
    differences: tuple[str, ...] = ()

    def find(self, image: ImageArray) -> FloatArray | None:
        """Corners (n, 2) in a grey picture, in its own pixels; see :func:`find_board`."""
        if not self.mirrored:
            return find_board(image, self.board)
        pixels = find_board(np.ascontiguousarray(image[:, ::-1]), self.board)
        if pixels is not None:
            pixels[:, 0] = image.shape[1] - 1 - pixels[:, 0]
        return pixels


def recognised(images: Sequence[ImageArray], named: Board, work: Work = NO_WORK) -> Recognition:
    """The board that shows most corners in some pictures, the named one before others.

    Chessboards are tried with other counts; ChArUco boards transposed, of the pattern before OpenCV
    4.6, and mirrored.
    """
    first = Recognition(named)
    most = _count(images, first, work)
    enough = _LEAST_SHARE * len(images) * len(named.corners)
    if not named.dictionary:
        tried = list(_chessboards(named))
        if most >= enough:  # it may be only a part of a larger board
            images = [image for image in images if first.find(image) is not None][:_SAMPLE]
            size = len(named.corners)
            tried = [one for one in tried if len(one.board.corners) > size]
        return max([first, *tried], key=lambda one: _count(images, one, work))
    best, others = first, _charuco_variants(named)
    while most < enough and (other := next(others, None)) is not None:
        count = _count(images, other, work)
        if count > most:
            best, most = other, count
    return best


def _count(images: Sequence[ImageArray], recognition: Recognition, work: Work) -> int:
    """Corners in all images."""
    count = 0
    for image in images:
        work.check()
        if (found := recognition.find(image)) is not None:
            count += int(np.isfinite(found[:, 0]).sum())
    return count


def _chessboards(named: Board) -> Iterator[Recognition]:
    columns, rows = named.columns, named.rows
    sizes = [(columns - 1, rows - 1)]
    sizes += [(columns + i, rows + j) for i in (-1, 0, 1) for j in (-1, 0, 1)]
    for size in dict.fromkeys(sizes):
        if size == (columns, rows) or min(size) < 3:
            continue
        words = (
            f"the board has {size[0]}x{size[1]} inner corners; {columns}x{rows} "
            f"{'are its squares' if size == (columns - 1, rows - 1) else 'were named'}"
        )
        yield Recognition(replace(named, columns=size[0], rows=size[1]), False, (words,))


def _charuco_variants(named: Board) -> Iterator[Recognition]:
    sizes = dict.fromkeys([(named.columns, named.rows), (named.rows, named.columns)])
    for mirrored, (columns, rows), legacy in product((False, True), sizes, (False, True)):
        found = []
        if (columns, rows) != (named.columns, named.rows):
            found.append(f"the board has {columns + 1}x{rows + 1} squares, not the reverse")
        if legacy != named.legacy:
            found.append("it is a legacy pattern, from before OpenCV 4.6")
        if mirrored:
            found.append("the pictures are mirrored")
        board = replace(named, columns=columns, rows=rows, legacy=legacy)
        yield Recognition(board, mirrored, tuple(found))


_LEAST_CORNERS = 4


def board_poses(lens: Lens, corners: FloatArray, pixels: FloatArray) -> list[RigidTransform]:
    """Poses camera_from_board of corners (n, 3) at raw pixels (n, 2), the likelier one first.

    A flat board far away looks nearly the same tilted either way (Collins and Bartoli,
    Infinitesimal plane-based pose estimation, 2014).
    """
    seen = np.isfinite(pixels[:, 0])
    if seen.sum() < _LEAST_CORNERS:
        return []
    camera = lens.camera("", (1, 1), RigidTransform.identity())
    flat = camera.normalised(pixels[seen])
    known = np.isfinite(flat).all(axis=1) & (np.abs(flat) < 50).all(axis=1)
    if known.sum() < _LEAST_CORNERS:
        return []
    board = corners[seen][known]
    middle = board.mean(axis=0)
    try:
        _, vectors, places, _ = cv2.solvePnPGeneric(
            board - middle, flat[known], np.eye(3), np.zeros(4), flags=cv2.SOLVEPNP_IPPE
        )
    except cv2.error:
        return []
    found = []
    for vector, place in zip(vectors, places, strict=True):
        rotation = rotation_from_vector(np.asarray(vector, dtype=np.float64).ravel())
        translation = np.asarray(place, dtype=np.float64).ravel() - rotation @ middle
        if np.isfinite(translation).all() and (board @ rotation[2] + translation[2] > 0).all():
            found.append(RigidTransform(rotation, translation))
    return found


def likeliest_poses(
    lens: Lens, corners: FloatArray, pictures: FloatArray
) -> list[RigidTransform | None]:
    """The likelier camera_from_board of pictures (F, n, 2); None where there is none."""
    poses = [board_poses(lens, corners, pixels) for pixels in pictures]
    return [found[0] if found else None for found in poses]


def tilts(poses: Sequence[RigidTransform]) -> FloatArray:
    """Angles (F,) in radians between the boards' normals and their mean direction."""
    normals = np.array([pose.rotation[:, 2] for pose in poses]).reshape(-1, 3)
    # A board is seen from its front, but corners in the other order turn its normal round.
    normals *= np.where(normals[:, 2:] > 0.0, -1.0, 1.0)
    mean = normals.mean(axis=0)
    length = np.linalg.norm(mean)
    return np.asarray(np.arccos(np.clip(normals @ mean / max(length, 1e-12), -1.0, 1.0)))

"""Corners of a board in a picture, to fractions of a pixel."""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np

from stereotrack_core.arrays import FloatArray, ImageArray
from stereotrack_core.calibrate.board import DICTIONARIES, Board

_LEAST_CHARUCO = 6  # corners; with fewer a board's pose is a guess
_WINDOW_SHARE = 0.35  # of a square's side, within which a corner is refined
_GAP_SHARE = 0.85  # of the gap between a corner and the nearest marker, for the same
_LEAST_WINDOW, _WIDEST_WINDOW = 2, 11
_FARTHEST_MOVE = 1.5  # pixels; farther away there is another corner
_FLAGS = cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_ACCURACY
_CRITERIA = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 60, 1e-3)


def find_board(image: ImageArray, board: Board) -> FloatArray | None:
    """Raw pixels (n, 2) of all corners in a grey picture, NaN where unseen; None without a board.

    A chessboard has to be seen whole, of a ChArUco board some corners are enough. The corners of a
    chessboard begin where the first inner square is light, so that all cameras number them alike;
    a board that looks the same after half a turn has no such corner.
    """
    found = _charuco(image, board) if board.dictionary else _chessboard(image, board)
    if found is None or not _is_plausible(found, board):
        return None
    return found


def _chessboard(image: ImageArray, board: Board) -> FloatArray | None:
    size = board.columns, board.rows
    seen, corners = cv2.findChessboardCornersSB(image, size, flags=_FLAGS)
    if not seen:
        return None
    pixels = np.asarray(corners, dtype=np.float64).reshape(-1, 2)
    if not board.ambiguous and not _begins_light(image, pixels, board.columns):
        pixels = pixels[::-1].copy()
    return _refined(image, pixels, board)


def _begins_light(image: ImageArray, pixels: FloatArray, columns: int) -> bool:
    """Whether the square between the first four corners is lighter than its neighbour."""
    grid = pixels.reshape(-1, columns, 2)
    middles = 0.25 * (grid[:-1, :-1] + grid[1:, :-1] + grid[:-1, 1:] + grid[1:, 1:])
    column, row = np.rint(middles).astype(int).reshape(-1, 2).T
    value = image[
        np.clip(row, 0, image.shape[0] - 1), np.clip(column, 0, image.shape[1] - 1)
    ].astype(np.float64)
    odd = np.indices(middles.shape[:2]).sum(axis=0).ravel() % 2
    return bool(value[odd == 0].mean() > value[odd == 1].mean())


def _charuco(image: ImageArray, board: Board) -> FloatArray | None:
    picture = 255 - image if board.inverted else image
    corners, numbers, _, _ = _charuco_detector(board).detectBoard(picture)
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
    """Corners moved to the saddle of the grey values within a part of the squares around them.

    The window may not reach the neighbouring corners or markers, so that it follows the squares'
    local size.
    """
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
    least: FloatArray = np.fmin.reduce(around)
    return least


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


def mirrored_picture(image: ImageArray) -> ImageArray:
    """The picture with left and right exchanged."""
    return np.ascontiguousarray(image[:, ::-1])


def mirrored_pixels(pixels: FloatArray, width: int) -> FloatArray:
    """Where pixels (..., 2) of a mirrored picture are in the picture itself."""
    return np.stack([width - 1 - pixels[..., 0], pixels[..., 1]], axis=-1)


def count_markers(image: ImageArray, dictionary: str, below: int) -> int:
    """Number of different markers of a dictionary in a grey picture, numbered below a limit."""
    _, numbers, _ = _marker_detector(dictionary).detectMarkers(image)
    return 0 if numbers is None else int((np.unique(numbers) < below).sum())


@lru_cache(maxsize=64)
def _marker_detector(dictionary: str) -> cv2.aruco.ArucoDetector:
    return cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(DICTIONARIES[dictionary]))

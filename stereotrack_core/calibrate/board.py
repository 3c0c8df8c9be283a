"""The board that is filmed: its corners, its size, and what a person writes to name it."""

import re
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.errors import InputError, did_you_mean

DICTIONARIES: dict[str, int] = {
    name.removeprefix("DICT_"): int(getattr(cv2.aruco, name))
    for name in dir(cv2.aruco)
    if name.startswith("DICT_") and name == name.upper()
}
"""Sets of markers by their OpenCV name without ``DICT_``."""

_SQUARE_M = (0.002, 0.5)  # nobody prints smaller or carries larger ones
_SIZE = re.compile(r"(\d+)x(\d+)")


@dataclass(frozen=True)
class Board:
    """A chessboard, or a ChArUco board with a dictionary; inner corners, squares in metres."""

    columns: int
    rows: int
    square: float
    dictionary: str = ""
    marker: float = 0.0  # side of a marker in metres
    legacy: bool = False  # a ChArUco pattern of OpenCV before 4.6, with a marker in the corner

    @cached_property
    def corners(self) -> FloatArray:
        """Inner corners (n, 3) row by row, metres, in the board's own frame at z = 0."""
        x, y = np.meshgrid(np.arange(self.columns), np.arange(self.rows))
        flat = np.stack([x, y, np.zeros_like(x)], axis=-1).reshape(-1, 3)
        return self.square * flat.astype(np.float64)

    @cached_property
    def neighbours(self) -> IntArray:
        """Pairs (m, 2) of corners that are one square apart."""
        numbers = np.arange(self.columns * self.rows).reshape(self.rows, self.columns)
        across = np.stack([numbers[:, :-1], numbers[:, 1:]], axis=-1).reshape(-1, 2)
        down = np.stack([numbers[:-1], numbers[1:]], axis=-1).reshape(-1, 2)
        return np.concatenate([across, down])

    @property
    def ambiguous(self) -> bool:
        """Whether the board looks the same after half a turn, so that corners have two numbers."""
        return not self.dictionary and (self.columns + self.rows) % 2 == 0

    @property
    def words(self) -> str:
        """``chessboard with 9x6 inner corners``."""
        if not self.dictionary:
            return f"chessboard with {self.columns}x{self.rows} inner corners"
        kind = f"{'legacy ' * self.legacy}ChArUco board"
        return f"{kind} with {self.columns + 1}x{self.rows + 1} squares, {self.dictionary}"

    def aruco_board(self) -> cv2.aruco.CharucoBoard:
        """The same board for OpenCV's detector."""
        dictionary = cv2.aruco.getPredefinedDictionary(DICTIONARIES[self.dictionary])
        size = self.columns + 1, self.rows + 1
        board = cv2.aruco.CharucoBoard(size, self.square, self.marker, dictionary)
        board.setLegacyPattern(self.legacy)
        return board


def chessboard(size: str, square: float) -> Board:
    """The board of ``--board 9x6 --square 0.025``. Raises InputError."""
    return Board(*_counts(size, "--board", "9x6, which counts inner corners"), _square(square))


def charuco(text: str, square: float) -> Board:
    """The board of ``--charuco 5x7:4X4_50:0.018``, which counts squares. Raises InputError."""
    parts = text.split(":")
    if len(parts) != 3:
        named = "columns and rows of squares, dictionary and marker side in metres"
        remedy = f"Write {named}, as 5x7:4X4_50:0.018."
        raise InputError(f"{text!r} is not a ChArUco board", "--charuco", remedy)
    inner = _counts(parts[0], "--charuco", "5x7, which counts squares", squares=1)
    dictionary = parts[1].upper().removeprefix("DICT_")
    if dictionary not in DICTIONARIES:
        names = "Names are those of OpenCV, such as 4X4_50 or APRILTAG_36H11."
        remedy = f"{did_you_mean(dictionary, DICTIONARIES)}{names}"
        raise InputError(f"unknown dictionary {parts[1]!r}", "--charuco", remedy)
    side = _square(square)
    try:
        marker = float(parts[2])
    except ValueError:
        marker = float("nan")
    if not 0.2 * side < marker < side:
        what = f"a marker of {parts[2]} m does not fit into a square of {side:g} m"
        remedy = "Measure the black side of a marker and the side of a square, in metres."
        raise InputError(what, "--charuco", remedy)
    return Board(*inner, side, dictionary, marker)


def _counts(text: str, where: str, example: str, squares: int = 0) -> tuple[int, int]:
    """Inner corners along both sides; `squares`: how many squares more than corners are counted."""
    match = _SIZE.fullmatch(text.strip().lower())
    if match is None:
        raise InputError(f"{text!r} is not the size of a board", where, f"Write it as {example}.")
    columns, rows = int(match[1]) - squares, int(match[2]) - squares
    for count in (columns, rows):
        if not 3 <= count <= 100:
            what = f"a board with {count} inner corners along a side cannot be used"
            remedy = "Use a board with 3 to 100 inner corners along each side."
            raise InputError(what, where, remedy)
    return columns, rows


def _square(square: float) -> float:
    if not _SQUARE_M[0] <= square <= _SQUARE_M[1]:
        millimetres = np.isfinite(square) and _SQUARE_M[0] <= square / 1000 <= _SQUARE_M[1]
        remedy = "Measure the side of a square over the whole board and give it in metres."
        if millimetres:
            remedy = f"Give metres: {square / 1000:g} for {square:g} mm."
        raise InputError(f"a square of {square:g} m cannot be meant", "--square", remedy)
    return square

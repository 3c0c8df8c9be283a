"""First places of cameras and boards: who saw the board together, and what most frames agree on."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.calibrate.board import Board
from stereotrack_core.calibrate.detection import board_poses
from stereotrack_core.calibrate.lens import Lens, projected
from stereotrack_core.calibrate.pictures import Sightings
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.transform import RigidTransform

_SAME_TURN = np.radians(5.0)
_SAME_SHARE, _SAME_M = 0.1, 0.03  # share of the distance, or metres, to which places agree
_MOST_CANDIDATES = 400

_NEARLY = 0.7
"""Share of the most votes from which a place is compared by the pictures, too: with few frames, of
which each allows several places, votes alone say little."""

_COMPARED, _FRAMES_COMPARED = 12, 12  # places, and frames in which they are compared
_FAR_PX = 50.0  # median error of a picture that says no more than that the place does not fit it


@dataclass(frozen=True, eq=False)
class Connected:
    """Cameras (camera_from_first), boards (first_from_board), common frames (C, C), sightings."""

    cameras: tuple[RigidTransform, ...]
    boards: dict[int, RigidTransform]
    sightings: tuple[Sightings, ...]
    shared: IntArray


def connected(sightings: Sequence[Sightings], lenses: Sequence[Lens], board: Board) -> Connected:
    """Place all cameras relative to the first one, perhaps over others. Raises InputError.

    Corners of a board that looks the same after half a turn are renumbered so that all agree.
    """
    seen = [_Seen(one, lens, board) for one, lens in zip(sightings, lenses, strict=True)]
    count = len(sightings)
    shared, agreeing = np.zeros((count, count), dtype=np.int64), np.zeros((count, count), dtype=int)
    relative: dict[tuple[int, int], RigidTransform] = {}
    for a, b in combinations(range(count), 2):
        common = sorted(seen[a].poses.keys() & seen[b].poses.keys())
        shared[a, b] = shared[b, a] = len(common)
        if common:
            one, votes = _most_agreed(seen[a], seen[b], common)
            relative[a, b], relative[b, a] = one, one.inverse()
            agreeing[a, b] = agreeing[b, a] = votes
    cameras = _spanned(agreeing, relative, [one.camera for one in sightings])
    boards = _boards(seen, cameras)
    numbered = []
    for own, lens, pose in zip(sightings, lenses, cameras, strict=True):
        rows = [i for i, frame in enumerate(own.frames.tolist()) if frame not in boards]
        placed = own.without(rows, ["the board cannot be placed"] * len(rows))
        if board.ambiguous:
            pixels = placed.pixels.copy()
            for i, frame in enumerate(placed.frames.tolist()):
                expected = projected(lens, (pose @ boards[frame]).apply(board.corners))[0]
                away = np.linalg.norm([pixels[i] - expected, pixels[i, ::-1] - expected], axis=-1)
                as_is, turned = np.nanmedian(away, axis=1)
                if turned < as_is:
                    pixels[i] = pixels[i, ::-1].copy()
            placed = replace(placed, pixels=pixels)
        numbered.append(placed)
    return Connected(tuple(cameras), boards, tuple(numbered), shared)


class _Seen:
    """The boards that one camera saw, and where they may be."""

    def __init__(self, sightings: Sightings, lens: Lens, board: Board) -> None:
        self._lens, self._board = lens, board
        self._pixels = dict(zip(sightings.frames.tolist(), sightings.pixels, strict=True))
        self.poses: dict[int, list[RigidTransform]] = {}  # camera_from_board that may be, by frame
        for frame, pixels in self._pixels.items():
            own = board_poses(lens, board.corners, pixels)
            if board.ambiguous:  # the same after half a turn about its middle
                middle = board.corners.mean(axis=0)
                half_turn = RigidTransform(np.diag([-1.0, -1.0, 1.0]), 2 * middle)
                own += [pose @ half_turn for pose in own]
            if own:
                self.poses[frame] = own

    def off(self, camera_from_board: RigidTransform, frame: int) -> float:
        """Median error of the frame's corners in pixels, for a pose of the board."""
        pixels = self._pixels[frame]
        errors = corner_errors(self._lens, camera_from_board, pixels, self._board)
        return float(np.nanmedian(errors))

    def __contains__(self, frame: int) -> bool:
        return frame in self._pixels


def _most_agreed(a: _Seen, b: _Seen, common: list[int]) -> tuple[RigidTransform, int]:
    """The pose a_from_b that most common frames agree on and fits best, and their number."""
    step = max(1, 4 * len(common) // _MOST_CANDIDATES)
    candidates, owner = [], []
    for frame in common[::step]:
        for one in a.poses[frame]:
            for other in b.poses[frame]:
                candidates.append(one @ other.inverse())
                owner.append(frame)
    turns = np.array([one.rotation for one in candidates])
    places = np.array([one.translation for one in candidates])
    cosine = 0.5 * (np.einsum("aij,bij->ab", turns, turns) - 1.0)
    apart = np.linalg.norm(places[:, None] - places, axis=-1)
    near = np.maximum(_SAME_SHARE * np.linalg.norm(places, axis=-1), _SAME_M)
    same = (cosine > np.cos(_SAME_TURN)) & (apart < near[:, None])
    frames, number = np.unique(owner, return_inverse=True)
    votes = np.zeros((len(candidates), len(frames)), dtype=bool)
    for i, own in enumerate(same.T):
        votes[:, number[i]] |= own
    total = votes.sum(axis=1)
    # Of equally many votes the one in the middle of those that agree.
    spread = np.where(same, apart, 0.0).sum(axis=1) / np.maximum(same.sum(axis=1), 1)
    leading: list[int] = []
    for i in np.lexsort((spread, -total)).tolist():
        if total[i] >= _NEARLY * total.max() and not same[i, leading].any():
            leading.append(i)
    asked = common[:: -(-len(common) // _FRAMES_COMPARED)]
    off = [
        sum(_misfit(a, b, candidates[i], frame) for frame in asked) if len(leading) > 1 else 0.0
        for i in leading[:_COMPARED]
    ]
    best = leading[int(np.argmin(off))]
    return candidates[best], int(total[best]) * step


def _misfit(a: _Seen, b: _Seen, a_from_b: RigidTransform, frame: int) -> float:
    """Pixels by which both pictures of a frame miss one board, at the best."""
    in_a = [*a.poses[frame], *(a_from_b @ pose for pose in b.poses[frame])]
    b_from_a = a_from_b.inverse()
    costs = ((a.off(pose, frame), b.off(b_from_a @ pose, frame)) for pose in in_a)
    return min(min(one, _FAR_PX) + min(two, _FAR_PX) for one, two in costs)


def _spanned(
    agreeing: IntArray, relative: dict[tuple[int, int], RigidTransform], names: Sequence[str]
) -> list[RigidTransform]:
    """Poses camera_from_first along the pairs that agree in most frames (Prim's tree)."""
    placed: dict[int, RigidTransform] = {0: RigidTransform.identity()}
    while len(placed) < len(names):
        free = [i for i in range(len(names)) if i not in placed]
        votes, old, new = max((int(agreeing[i, j]), i, j) for i in placed for j in free)
        if votes == 0:
            together = ", ".join(names[i] for i in sorted(placed))
            apart = ", ".join(names[i] for i in free)
            raise InputError(
                f"{together} and {apart} never saw the board at the same time",
                "cameras",
                "Film again with the board where one camera of each group sees it at the "
                "same instant, and check that frame k of all cameras is the same instant.",
            )
        placed[new] = relative[new, old] @ placed[old]
    return [placed[i] for i in range(len(names))]


def _boards(seen: Sequence[_Seen], cameras: Sequence[RigidTransform]) -> dict[int, RigidTransform]:
    """first_from_board of every frame: the possible pose that fits all cameras best."""
    found = {}
    for frame in sorted(set().union(*(one.poses for one in seen))):
        seeing = [(one, pose) for one, pose in zip(seen, cameras, strict=True) if frame in one]
        candidates = [c.inverse() @ pose for one, c in seeing for pose in one.poses.get(frame, [])]
        costs = [sum(one.off(c @ it, frame) for one, c in seeing) for it in candidates]
        found[frame] = candidates[int(np.argmin(costs)) if len(seeing) > 1 else 0]
    return found


def corner_errors(
    lens: Lens, camera_from_board: RigidTransform, pixels: FloatArray, board: Board
) -> FloatArray:
    """Distances (n,) in pixels of corners from their places, better numbered; NaN if unseen."""
    points = camera_from_board.apply(board.corners)
    ahead = points[:, 2] > 1e-3
    if not ahead.all():
        return np.full(len(points), 1e4)
    expected = projected(lens, points)[0]
    found = [np.linalg.norm(pixels - expected, axis=-1)]
    if board.ambiguous:
        found.append(np.linalg.norm(pixels[::-1] - expected, axis=-1))
    return min(found, key=lambda one: float(np.nanmedian(one)))

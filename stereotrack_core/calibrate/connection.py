"""First places of cameras and boards: who saw the board together, and what most frames agree on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.calibrate.board import Board
from stereotrack_core.calibrate.board_pose import board_poses
from stereotrack_core.calibrate.lens import Lens, projected
from stereotrack_core.calibrate.sightings import Sightings
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.transform import RigidTransform

_SAME_TURN = np.radians(5.0)
_SAME_SHARE, _SAME_M = 0.1, 0.03
"""Two frames agree on a camera's place up to this share of its distance, or these metres."""

_MOST_CANDIDATES = 400


@dataclass(frozen=True, eq=False)
class Connected:
    """Cameras (camera_from_first) and boards (first_from_board by frame), and the sightings.

    `shared` (C, C) counts the frames in which two cameras saw the board together.
    """

    cameras: tuple[RigidTransform, ...]
    boards: dict[int, RigidTransform]
    sightings: tuple[Sightings, ...]
    shared: IntArray


def connected(sightings: Sequence[Sightings], lenses: Sequence[Lens], board: Board) -> Connected:
    """Place all cameras relative to the first one, over others where they saw no board together.

    Corners of a board that looks the same after half a turn are renumbered so that all cameras
    agree.

    Raises InputError, which names the groups, where cameras are not connected.
    """
    poses = [_poses(one, lens, board) for one, lens in zip(sightings, lenses, strict=True)]
    count = len(sightings)
    shared, agreeing = np.zeros((count, count), dtype=np.int64), np.zeros((count, count), dtype=int)
    relative: dict[tuple[int, int], RigidTransform] = {}
    for a, b in combinations(range(count), 2):
        common = sorted(set(poses[a]) & set(poses[b]))
        shared[a, b] = shared[b, a] = len(common)
        if common:
            one, votes = _most_agreed(poses[a], poses[b], common)
            relative[a, b], relative[b, a] = one, one.inverse()
            agreeing[a, b] = agreeing[b, a] = votes
    cameras = _spanned(agreeing, relative, [one.camera for one in sightings])
    boards = _boards(poses, sightings, lenses, cameras, board)
    placed = [_placed(one, boards) for one in sightings]
    numbered = tuple(
        _renumbered(one, lens, pose, boards, board) if board.ambiguous else one
        for one, lens, pose in zip(placed, lenses, cameras, strict=True)
    )
    return Connected(tuple(cameras), boards, numbered, shared)


def _poses(sightings: Sightings, lens: Lens, board: Board) -> dict[int, list[RigidTransform]]:
    """Possible poses camera_from_board by frame."""
    found = {}
    for frame, pixels in zip(sightings.frames.tolist(), sightings.pixels, strict=True):
        own = board_poses(lens, board.corners, pixels)
        if board.ambiguous:
            own += [pose @ _half_turn(board) for pose in own]
        if own:
            found[frame] = own
    return found


def _placed(sightings: Sightings, boards: dict[int, RigidTransform]) -> Sightings:
    rows = [i for i, frame in enumerate(sightings.frames.tolist()) if frame not in boards]
    return sightings.without(rows, ["the board cannot be placed"] * len(rows))


def _half_turn(board: Board) -> RigidTransform:
    """The board's frame turned by 180 degrees about its middle."""
    middle = board.corners.mean(axis=0)
    return RigidTransform(np.diag([-1.0, -1.0, 1.0]), 2 * middle)


def _most_agreed(
    of_a: dict[int, list[RigidTransform]], of_b: dict[int, list[RigidTransform]], common: list[int]
) -> tuple[RigidTransform, int]:
    """The pose a_from_b that most common frames agree on, and how many these are."""
    step = max(1, 4 * len(common) // _MOST_CANDIDATES)
    candidates, owner = [], []
    for frame in common[::step]:
        for one in of_a[frame]:
            for other in of_b[frame]:
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
    best = int(np.lexsort((spread, -total))[0])
    return candidates[best], int(total[best]) * step


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
                where="cameras",
                remedy="Film again with the board where one camera of each group sees it at the "
                "same instant, and check that frame k of all cameras is the same instant.",
            )
        placed[new] = relative[new, old] @ placed[old]
    return [placed[i] for i in range(len(names))]


def _boards(
    poses: Sequence[dict[int, list[RigidTransform]]],
    sightings: Sequence[Sightings],
    lenses: Sequence[Lens],
    cameras: Sequence[RigidTransform],
    board: Board,
) -> dict[int, RigidTransform]:
    """first_from_board of every frame: the possible pose that fits all cameras best."""
    found = {}
    rows = [{int(f): i for i, f in enumerate(one.frames)} for one in sightings]
    for frame in sorted(set().union(*poses)):
        seeing = [c for c in range(len(cameras)) if frame in rows[c]]
        candidates = [
            cameras[c].inverse() @ pose for c in seeing for pose in poses[c].get(frame, [])
        ]
        if len(seeing) == 1:
            found[frame] = candidates[0]
            continue
        costs = []
        for candidate in candidates:
            off = [
                corner_errors(
                    lenses[c], cameras[c] @ candidate, sightings[c].pixels[rows[c][frame]], board
                )
                for c in seeing
            ]
            costs.append(sum(float(np.nanmedian(one)) for one in off))
        found[frame] = candidates[int(np.argmin(costs))]
    return found


def corner_errors(
    lens: Lens, camera_from_board: RigidTransform, pixels: FloatArray, board: Board
) -> FloatArray:
    """Distances (n,) in pixels of corners from where they should be; NaN where unseen.

    For a board that looks the same after half a turn those of the numbering that fits better.
    """
    points = camera_from_board.apply(board.corners)
    ahead = points[:, 2] > 1e-3
    if not ahead.all():
        return np.full(len(points), 1e4)
    expected = projected(lens, points)[0]
    found = [np.linalg.norm(pixels - expected, axis=-1)]
    if board.ambiguous:
        found.append(np.linalg.norm(pixels[::-1] - expected, axis=-1))
    return min(found, key=lambda one: float(np.nanmedian(one)))


def _renumbered(
    sightings: Sightings,
    lens: Lens,
    camera: RigidTransform,
    boards: dict[int, RigidTransform],
    board: Board,
) -> Sightings:
    pixels = sightings.pixels.copy()
    for i, frame in enumerate(sightings.frames.tolist()):
        expected = projected(lens, (camera @ boards[frame]).apply(board.corners))[0]
        as_is, turned = (
            float(np.nanmedian(np.linalg.norm(one - expected, axis=-1)))
            for one in (pixels[i], pixels[i, ::-1])
        )
        if turned < as_is:
            pixels[i] = pixels[i, ::-1].copy()
    return replace(sightings, pixels=pixels)

"""Every two cameras that saw the board together, placed by themselves: which pair is wrong?"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from stereotrack_core.calibrate.board import Board
from stereotrack_core.calibrate.sightings import Sightings
from stereotrack_core.calibrate.stereo import pair_of
from stereotrack_core.calibrate.world import calibrate_world
from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera

_LEAST_SHARED = 3  # pictures of the same instant, to place one camera relative to the other
_SIDES = (("_left", "_right"), ("_l", "_r"))


@dataclass(frozen=True)
class PairFit:
    """Two cameras placed by the boards that both saw; NaN for what is not known.

    `row_error_px` is that of a stereo camera, see :class:`Pair`. `problem` says why the pair could
    not be placed, and `remedy` what to do.
    """

    first: str
    second: str
    shared: int
    """Pictures of the same instant in which both saw the board."""
    rms_px: float = float("nan")
    held_out_px: float = float("nan")
    distance_m: float = float("nan")
    angle_deg: float = float("nan")
    """Between the optical axes."""
    row_error_px: float = float("nan")
    problem: str = ""
    remedy: str = ""


def stereo_names(names: Sequence[str]) -> tuple[tuple[str, str], ...]:
    """Left and right cameras by their names: ``N_left`` with ``N_right``, ``a_l`` with ``a_r``."""
    found = []
    for name in names:
        for left, right in _SIDES:
            other = name[: -len(left)] + right
            if name.endswith(left) and other in names:
                found.append((name, other))
    return tuple(found)


def calibrate_pairs(
    sightings: Sequence[Sightings],
    cameras: Mapping[str, Camera],
    board: Board,
    stereo: Sequence[tuple[str, str]] = (),
    on_pair: Callable[[int, int, str], None] = lambda _done, _count, _words: None,
    stop: Callable[[], bool] = lambda: False,
) -> tuple[PairFit, ...]:
    """Place every two cameras with lenses known from `cameras`, which stay as they are.

    Pairs that never saw the board together are left out, unless they are named in `stereo`.

    Raises
    ------
    Cancelled
    """
    ordered = [_ordered(a, b, stereo) for a, b in combinations(sightings, 2)]
    wanted = [(a, b) for a, b in ordered if _shared(a, b) or (a.camera, b.camera) in stereo]
    found = []
    for k, (a, b) in enumerate(wanted):
        on_pair(k, len(wanted), f"{a.camera} with {b.camera}")
        is_stereo = (a.camera, b.camera) in stereo
        try:
            found.append(_fit(a, b, cameras, board, stop, is_stereo=is_stereo))
        except InputError as error:
            found.append(
                PairFit(a.camera, b.camera, _shared(a, b), problem=error.what, remedy=error.remedy)
            )
    return tuple(found)


def _ordered(
    a: Sightings, b: Sightings, stereo: Sequence[tuple[str, str]]
) -> tuple[Sightings, Sightings]:
    return (b, a) if (b.camera, a.camera) in stereo else (a, b)


def _shared(a: Sightings, b: Sightings) -> int:
    return int(np.intersect1d(a.frames, b.frames).size)


def _fit(
    a: Sightings,
    b: Sightings,
    cameras: Mapping[str, Camera],
    board: Board,
    stop: Callable[[], bool],
    *,
    is_stereo: bool,
) -> PairFit:
    shared = _shared(a, b)
    where = f"{a.camera} and {b.camera}"
    if shared < _LEAST_SHARED:
        raise InputError(
            f"both saw the board together in {counted(shared, 'picture')} only",
            where=where,
            remedy="Film again with the board in 10 positions or more that both see at the same "
            "time.",
        )
    for one in (a, b):
        if one.camera not in cameras:
            raise InputError(
                f"the lens of {one.camera} is not calibrated",
                where=where,
                remedy="Calibrate the lenses first.",
            )
    world = calibrate_world([a, b], board, given=cameras, stop=stop)
    first, second = world.cameras
    axes = [one.camera_from_world.rotation[2] for one in world.cameras]
    row_error = float("nan")
    if is_stereo:
        row_error = pair_of(first, second, *world.sightings).row_error_px
    return PairFit(
        a.camera,
        b.camera,
        shared,
        world.rms_px,
        world.held_out_px,
        float(np.linalg.norm(first.position_world - second.position_world)),
        float(np.degrees(np.arccos(np.clip(axes[0] @ axes[1], -1.0, 1.0)))),
        row_error,
    )

"""Do the disparities that are searched reach the person? What the parameters say against that."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.seen_person import AllPictures
from stereotrack_core.depth.volume import WorkingSpace, working_space
from stereotrack_core.errors import Finding, InputError
from stereotrack_core.recording.description import Recording

_SLACK = 1.03
"""By how many times a range may be missed: disparities are whole pixels."""


def check_reach(space: WorkingSpace) -> Iterator[Finding]:
    """Findings about views that do not search the ranges at which the person is looked for."""
    for view, (near, far) in space.needed_m.items():
        nearest, farthest = space.searched_m[view]
        remedies = [
            *([_more(space, view, near)] if nearest > _SLACK * near else []),
            *([_less(space, view, far)] if farthest * _SLACK < far else []),
        ]
        if remedies:
            low, high = space.disparities_px[view]
            to = f" to {farthest:.2f} m" if math.isfinite(farthest) else " m on"
            yield Finding(
                "error" if nearest > far or farthest < near else "warning",
                f"view {view}, disparities",
                f"those of {low} to {high} px show what is {nearest:.2f}{to}, but the person is "
                f"looked for from {near:.2f} to {far:.2f} m",
                f"{' '.join(remedies)} Defaults are adapted to the recording; values that you "
                "have changed are not.",
            )


def _more(space: WorkingSpace, view: str, near: float) -> str:
    low, high = space.disparities_px[view]
    needed = math.ceil(space.searched_m[view][0] * high / near) - low + 1
    return f"Set disparity_count to {16 * math.ceil(needed / 16)} or more."


def _less(space: WorkingSpace, view: str, far: float) -> str:
    low, _ = space.disparities_px[view]
    return f"Set disparity_minimum to {math.floor(space.searched_m[view][1] * low / far)} or less."


def is_changed(parameters: DepthParameters) -> bool:
    """Whether somebody has changed which disparities are searched."""
    usual = DepthParameters()
    names = ("disparity_minimum", "disparity_count")
    return any(getattr(parameters, name) != getattr(usual, name) for name in names)


def reach_of(
    recording: Recording, parameters: DepthParameters, pictures: AllPictures, views: Sequence[str]
) -> tuple[Finding, ...]:
    """Findings with these parameters; looks for the person in some frames.

    Empty where no depth can be measured, which other checks tell.
    """
    try:
        return tuple(check_reach(working_space(recording, parameters, pictures, views)))
    except InputError:
        return ()

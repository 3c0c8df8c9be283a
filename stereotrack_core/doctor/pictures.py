"""Do the images of a view show all of it, and is its background image its own?"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import permutations

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray, ImageArray
from stereotrack_core.errors import Finding
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.importing.signals import reduced
from stereotrack_core.recording.reader import FrameReader

_FRAMES = 4
_BLACK = 3
"""Grey value up to which a pixel may show nothing."""

_LEAST_STRIPE = 0.1
"""Share of the image that is black in whole rows or columns from which it is told."""

_KNOWN = 0.03
"""Share of a row or column that a depth camera has to measure before its blackness is odd."""

_LARGE_STRIPE = 0.3
"""Share from which the image is plainly wrong."""

_OTHER, _LEAST_BETTER = 0.6, 2.0
"""Share of the difference to a view's own background, and grey levels, by which that of another
view has to fit better."""


def check_pictures(
    recording: Recording, reader: FrameReader, frames: int = _FRAMES
) -> Iterator[Finding]:
    """Findings about views whose images are partly black, or whose background is another's."""
    count = reader.frame_count
    spread = np.unique(np.linspace(0, count - 1, min(frames, count)).astype(int))
    sets = [reader.frame_set(int(k)) for k in spread]
    shown: dict[str, list[FloatArray]] = {}
    empty: dict[str, FloatArray] = {}
    for view in recording.views:
        seen = [s.views[view.name] for s in sets if view.name in s.views]
        depths = [np.isfinite(one.depth) for one in seen if one.depth is not None]
        measured = np.any(depths, axis=0) if depths else None
        where = f"view {view.name}, {'image' if view.left is None else 'right'}"
        yield from check_stripe(where, [one.image for one in seen], measured)
        lefts = [one.left for one in seen if one.left is not None]
        yield from check_stripe(f"view {view.name}, left", lefts)
        background = reader.background(view.name)
        if background is not None and seen:
            shown[view.name] = [reduced(one.image) for one in seen]
            empty[view.name] = reduced(background[1])
    yield from check_backgrounds(shown, empty)


def check_stripe(
    where: str, images: Sequence[ImageArray], measured: BoolArray | None = None
) -> Iterator[Finding]:
    """Whether whole rows or columns of grey images (H, W) are black in all of them.

    Images of depth cameras may be black where nothing was `measured` (H, W).
    """
    if not images:
        return
    brightest = np.max([image.max(axis=2) if image.ndim == 3 else image for image in images], 0)
    dark = brightest <= _BLACK
    known = np.ones_like(dark) if measured is None else measured
    share = 0.0
    for axis in (0, 1):
        shown = known.mean(axis=axis) > _KNOWN
        black = (dark | ~known).all(axis=axis) & shown
        share = max(share, float(black.sum()) / max(int(shown.sum()), 1))
    if _LEAST_STRIPE < share < 1.0:
        part = "the image" if measured is None else "the image where there is depth"
        yield Finding(
            "error" if share > _LARGE_STRIPE else "warning",
            where,
            f"{100 * share:.0f} % of {part} is black in all frames",
            "Check how the file was made: nothing is measured there.",
        )


def check_backgrounds(
    shown: Mapping[str, Sequence[FloatArray]], empty: Mapping[str, FloatArray]
) -> Iterator[Finding]:
    """Backgrounds that belong to another view, by reduced images and backgrounds (H, W).

    Where the images of that view fit it much better, or are better fitted by another background.
    """
    for view, other in permutations(shown, 2):
        own = _apart(shown[view], empty[view])
        same = float(np.abs(empty[view] - empty[other]).mean()) < 1.0
        rival = _apart(shown[other], empty[view]) if same else _apart(shown[view], empty[other])
        if own - rival > _LEAST_BETTER and rival < _OTHER * own:
            yield Finding(
                "error",
                f"view {view}, background",
                f"it is that of view {other}: it differs by {own:.0f} grey levels from the images "
                f"of view {view}, and by {rival:.0f} from those of view {other}"
                if same
                else f"that of view {other} fits the images better: they differ by {own:.0f} grey "
                f"levels from the view's own background, and by {rival:.0f} from the other one",
                "Use an image of the empty scene by this very camera.",
            )
            return


def _apart(images: Sequence[FloatArray], background: FloatArray) -> float:
    """Difference in grey levels of most pixels, which the person does not cover."""
    return float(np.median([np.median(np.abs(image - background)) for image in images]))

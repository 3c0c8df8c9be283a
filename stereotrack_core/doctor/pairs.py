"""Do the two images of a stereo view fit its calibration? By details that both show.

After rectification they have to lie in the same rows, and
farther to the right in the left image. Where they do not, usual slips are undone in turn: what
lays them into the same rows is the tested correction.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from stereotrack_core.arrays import ImageArray
from stereotrack_core.doctor.details import FEWEST, Details, Pair, details_of, row_fit
from stereotrack_core.doctor.lenses import distortions_left_out
from stereotrack_core.doctor.pair_causes import MENDED_PX, px, remedy_of, straightened
from stereotrack_core.doctor.slips import exchanged_views
from stereotrack_core.errors import Finding, Severity
from stereotrack_core.recording.description import Recording, View
from stereotrack_core.recording.reader import FrameReader

_FRAMES = 2
"""What stands still, and gives most details, is the same in all of them."""

_MANY, _SHARED = 400, 0.04
"""Details of an image from which it shows enough to be matched, and the share that has to be."""

_WIDTH = 640.0
"""Width of the images, in pixels, that the limits refer to."""

_TOLD_PX, _DOUBTFUL_PX, _WRONG_PX = 0.5, 1.0, 2.5
"""Median row offset from which it is told, from which matching suffers, and from which it fails."""


def check_pairs(recording: Recording, reader: FrameReader) -> Iterator[Finding]:
    """Findings about the stereo views of a recording."""
    count = reader.frame_count
    frames = np.unique(np.linspace(0, count - 1, min(_FRAMES, count)).astype(int))
    sets = [reader.frame_set(int(k)) for k in frames]
    matched: dict[str, Matched] = {}
    for view in recording.views:
        if view.left is None:
            continue
        seen = [s.views[view.name] for s in sets if view.name in s.views]
        pairs = [(one.left, one.image) for one in seen if one.left is not None]
        cameras = recording.cameras.get(view.left.camera), recording.cameras.get(view.image.camera)
        if cameras[0] is not None and cameras[1] is not None:
            details = details_of(pairs)
            if details.seen > _MANY and len(details.left) < _SHARED * details.seen:
                yield _unlike(view, pairs, details)
            else:
                matched[view.name] = Matched(view, (cameras[0], cameras[1]), details)
    wrong = {
        name: found
        for name, one in matched.items()
        if (found := list(check_pair(one.view, one.cameras, one.details)))
    }
    for (a, one), (b, other) in combinations(matched.items(), 2):
        if a in wrong and b in wrong and _fit(one, other.cameras) and _fit(other, one.cameras):
            del wrong[a], wrong[b]
            fit = "they are exchanged: the images of each fit the cameras of the other one"
            yield replace(exchanged_views(a, b), what=fit)
    for found in wrong.values():
        yield from found


@dataclass(frozen=True, eq=False)
class Matched:
    """A stereo view with its left and right camera, and the details that both images show."""

    view: View
    cameras: Pair
    details: Details


def _fit(one: Matched, cameras: Pair) -> bool:
    """Whether a view's details lie in the same rows with these cameras."""
    same = all(
        (a.width, a.height) == (b.width, b.height)
        for a, b in zip(one.cameras, cameras, strict=True)
    )
    return same and row_fit(cameras, one.details).misfit < MENDED_PX * _scale(cameras)


def _scale(cameras: Pair) -> float:
    """How much larger the images are than those that the limits refer to."""
    return max(cameras[1].width / _WIDTH, 0.5)


def _unlike(
    view: View, pairs: Sequence[tuple[ImageArray, ImageArray]], details: Details
) -> Finding:
    """The images of a pair share nearly nothing; whether one of them is mirrored."""
    mirrored = details_of([(np.ascontiguousarray(left[:, ::-1]), image) for left, image in pairs])
    share = 100 * len(mirrored.left) / max(mirrored.seen, 1)
    return Finding(
        "error",
        f"view {view.name}",
        f"left and right image share {100 * len(details.left) / details.seen:.0f} % of their "
        "details (more than 20 % in good pairs)",
        f"One of the two images is mirrored (tested: with the left one turned round they share "
        f"{share:.0f} %). Store both as the camera saw them."
        if share > 200 * _SHARED
        else "Check that both files belong to this view, to the same instants, and are sharp.",
    )


def check_pair(view: View, cameras: Pair, details: Details) -> Iterator[Finding]:
    """Findings about one pair, by its details."""
    where, scale = f"view {view.name}", _scale(cameras)
    if np.linalg.norm(cameras[0].position_world - cameras[1].position_world) < 1e-6:
        return  # told by the checks of the cameras
    if len(details.left) < FEWEST:
        return
    fit = row_fit(cameras, details)
    if fit.misfit < _DOUBTFUL_PX * scale:
        found = list(_check_lenses(where, cameras, details))
        if not found and fit.misfit > _TOLD_PX * scale:
            told = f"the rows of both images differ by {px(fit.row_px)} after rectification"
            taken = "The tracker measures that and takes it off (`align_rows`)."
            found = [Finding("note", where, told, taken)]
        yield from found
        return
    what = (
        f"{100 * fit.wrong_side:.0f} % of {len(details.left)} details that both images of the pair "
        "show lie on the wrong side, as if behind the cameras"
        if fit.wrong_side > 0.5
        else f"details that both images of the pair show lie {px(fit.row_px)} apart in their "
        f"rows after rectification (median of {len(details.left)}; less than 1 px in good pairs)"
    )
    severity: Severity = "error" if fit.misfit > _WRONG_PX * scale else "warning"
    remedy = remedy_of(view.name, cameras, details, fit, scale)
    yield Finding(severity, where, what, remedy.words, remedy.correction)


def _check_lenses(where: str, cameras: Pair, details: Details) -> Iterator[Finding]:
    """Whether the rows of a pair that fits differ towards the edges, as through bent lenses."""
    lenses = distortions_left_out(cameras, details)
    if lenses is not None:
        yield Finding(
            "warning",
            where,
            f"the row offsets of {len(details.left)} details that both images of the pair show "
            f"grow towards the edges of the images, where they are {px(lenses.edge_px)} and more",
            straightened(lenses),
        )

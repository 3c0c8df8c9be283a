"""Keypoints that disagree with the body that was tracked: of which view, how often, how far."""

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import Pose
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.keypoints import Keypoints
from stereotrack_core.recording.sighted_keypoints import KeypointsByFrame, keypoints_in_views
from stereotrack_core.tracking.residuals.reprojection import KeypointFit, KeypointObservation

# Metres from the body, at the person's distance, from which a keypoint disagrees with it. Guessed
# ones behind the trunk are up to 0.1 m off.
_FAR = 0.15
# Share of a view's pictures in which a keypoint that is named disagrees at least, two standard
# deviations below the share that was found; usual detectors have gross errors in less than 0.1.
_OFTEN = 0.2
_FEWEST = 5  # pictures without which nothing is said about a keypoint in a view
_MOST_FRAMES = 150  # looked at, spread over the run: the window does it at the end of a run
_NAMED = 6  # keypoints that are named; the others are counted


def keypoint_fits(
    poses: Iterable[tuple[int, Pose]], body: BodyModel, seen: KeypointsByFrame
) -> Iterator[KeypointFit]:
    """How the keypoints of frames fit their poses, with sides exchanged back as in tracking."""
    for frame, pose in poses:
        fit = KeypointObservation(seen(frame), 1.0).fitted(body, pose)
        if fit is not None:
            yield fit


def disagreeing_keypoints(
    poses: Sequence[tuple[int, Pose]],
    body: BodyModel,
    recording: Recording,
    views: Sequence[str],
    keypoints: Keypoints | None,
) -> tuple[str, ...]:
    """A clause that names the keypoints that disagree with the body; none if all agree.

    `poses` are of the tracked frames; `views` and `keypoints` were tracked with.
    """
    if keypoints is None or not poses:
        return ()
    seen = keypoints_in_views(recording, views, keypoints)
    chosen = poses[:: -(-len(poses) // _MOST_FRAMES)]
    off: dict[tuple[str, str], list[tuple[float, float]]] = {}
    for fit in keypoint_fits(chosen, body, seen):
        pixels = np.linalg.norm(fit.seen.pixel - fit.predicted, axis=2)
        for k, v in np.argwhere(np.isfinite(pixels)).tolist():
            one = off.setdefault((fit.seen.names[k], fit.seen.cameras[v]), [])
            one.append((float(pixels[k, v]), float(fit.off[k, v])))
    views_of = {view.image.camera: view.name for view in recording.views}
    found: list[tuple[float, str]] = []
    for (name, camera), distances in off.items():
        pixels, metres = np.array(distances).T
        share = float(np.mean(metres > _FAR))
        uncertain = float(np.sqrt(share * (1.0 - share) / len(pixels)))
        if len(pixels) >= _FEWEST and share - 2.0 * uncertain >= _OFTEN:
            where = views_of.get(camera, camera)
            how = f"{100 * share:.0f} %, median {np.median(pixels):.0f} px"
            found.append((-share, f"{name} in {where} ({how})"))
    if not found:
        return ()
    named = [words for _, words in sorted(found)]
    more = f" and {len(named) - _NAMED} more" if len(named) > _NAMED else ""
    return (
        f"keypoints disagree with the body in many pictures: {', '.join(named[:_NAMED])}{more}; "
        "the order of their points (--layout), the person (--person) or the calibration may be "
        "wrong",
    )

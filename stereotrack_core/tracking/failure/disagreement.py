"""How far the keypoints of a pose detector contradict the arms of a pose."""

from __future__ import annotations

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.skeleton import FOREARMS, UPPER_ARMS
from stereotrack_core.recording.sighted_keypoints import SightedKeypoints
from stereotrack_core.tracking.residuals.reprojection import KeypointObservation

UNSEEN: FloatArray = np.zeros((len(LIMBS), 2))
"""Without keypoints. Columns: disagreement times confidence, and confidence."""

_ENDS = tuple(
    (limb, f"{side}_{begin}", f"{side}_{end}")
    for limbs, begin, end in ((UPPER_ARMS, "shoulder", "elbow"), (FOREARMS, "elbow", "wrist"))
    for limb, side in zip(limbs, ("left", "right"), strict=True)
)
"""Limb and the keypoints at both of its ends."""

_HALF_LIFE = 0.3
"""Seconds after which keypoints say half as much about the limbs of a later frame."""

_MOST = 1.5
"""Disagreement above which more says nothing: a keypoint of something else may lie anywhere."""


def disagreement(seen: SightedKeypoints | None, body: BodyModel, pose: Pose) -> FloatArray | None:
    """Disagreement of keypoints with a pose (6, 2); None where no keypoint was looked for.

    A limb's keypoints span an arrow in each picture, and so do the pose's. The distance of the
    arrows' tips, over what the limb would be long across the picture, is its disagreement there:
    0 if they agree, 1 for 60 degrees of a limb parallel to the picture. The place of the body
    cancels. Sides that a picture exchanges are exchanged back before. Of arms that may be crossed
    nothing is said.
    """
    fit = KeypointObservation(seen, 1.0).fitted(body, pose)
    if fit is None:
        return None
    rows = {name: k for k, name in enumerate(fit.seen.names)}
    arrows = fit.seen.pixel - fit.predicted
    result = UNSEEN.copy()
    for limb, begin, end in _ENDS:
        if begin not in rows or end not in rows:
            continue
        a, b = rows[begin], rows[end]
        sure = np.minimum(fit.sure[a], fit.sure[b])
        if not sure.any():
            continue
        long = fit.metre[b] * body.skeleton.lengths[limb]
        off = np.nan_to_num(np.linalg.norm(arrows[b] - arrows[a], axis=1) / long)
        most = float(sure.max())
        result[limb] = most * float(sure @ np.minimum(off, _MOST)) / float(sure.sum()), most
    return result


def carried_on(
    last: FloatArray,
    seconds: float,
    seen: SightedKeypoints | None,
    body: BodyModel,
    pose: Pose,
) -> FloatArray:
    """Disagreement (6, 2) in a frame: of its own keypoints, else what the last ones said, faded.

    Parameters
    ----------
    last : (6, 2) float64
        Of the frame before.
    seconds : float
        Since the frame before.
    """
    found = disagreement(seen, body, pose)
    return last * 0.5 ** (seconds / _HALF_LIFE) if found is None else found

"""The axis of a recording's world that points up, by how its cameras are held."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stereotrack_core.geometry.upright import UP_AXES, Upright
from stereotrack_core.recording.description import Recording

_STILL_UP = 0.6
"""Cosine between up in the images and z from which the world is as it should be: a camera may look
down steeply."""

_AGREED = 0.6
"""Cosine between another axis and up in the images without which the cameras tell nothing: they
look straight down, or are turned differently."""

_APART = np.cos(np.radians(30.0))
"""Cosine of the angle between optical axes from which cameras look from different sides."""


@dataclass(frozen=True)
class LikelyUp:
    """The axis that points up in the images, and whether the cameras alone are proof of it.

    Cameras that look the same way may all have been mounted on their side.
    """

    axis: str
    sure: bool


def up_of_cameras(recording: Recording, views: Sequence[str] | None = None) -> LikelyUp:
    """The axis that points up in the images of views, turned as ``display_rotation`` says; or z."""
    names = [view.name for view in recording.views] if views is None else list(views)
    chosen = [recording.view(name) for name in names]
    chosen = [view for view in chosen if view.image.camera in recording.cameras]
    usual = LikelyUp(UP_AXES[0], True)
    if not chosen:
        return usual
    turns = np.radians([view.display_rotation for view in chosen])
    in_image = np.stack([-np.sin(turns), -np.cos(turns), np.zeros(len(turns))], axis=1)
    from_world = [recording.reference_camera(one).camera_from_world.rotation for one in chosen]
    ups = np.einsum("vji,vj->vi", from_world, in_image)  # as the images are looked at
    mean = ups.mean(axis=0)
    axis = max(UP_AXES, key=lambda name: float(Upright(name).up @ mean))
    up = Upright(axis).up
    if mean[2] > _STILL_UP or axis == usual.axis or up @ mean < _AGREED:
        return usual
    gazes = np.array(from_world)[:, 2]
    apart = float((gazes @ gazes.T).min()) < _APART
    upside_down = axis == "-z"  # cameras below a ceiling are often mounted so
    agreed = bool((ups @ up > 0.0).all())
    return LikelyUp(axis, bool(apart) and agreed and not upside_down)

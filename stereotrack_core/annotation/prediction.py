"""A prediction: a landmark that the program has placed in a camera's image."""

from __future__ import annotations

from dataclasses import dataclass

from stereotrack_core.annotation.click import ClickKey


@dataclass(frozen=True, slots=True)
class Prediction:
    """A landmark placed by the program.

    Attributes
    ----------
    frame : int
    camera, landmark : str
    source : str
        What it comes from: ``run accurate``, ``following``, ``triangulated`` ...
    position : (float, float)
        Raw-image pixels.
    sigma : float or None
        Standard deviation in pixels per axis, where the source knows it.
    """

    frame: int
    camera: str
    landmark: str
    source: str
    position: tuple[float, float]
    sigma: float | None = None

    @property
    def key(self) -> ClickKey:
        """Frame, camera and landmark."""
        return ClickKey(self.frame, self.camera, self.landmark)

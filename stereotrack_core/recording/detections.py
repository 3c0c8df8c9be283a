"""What a detector has said about head and hands, at any time."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.geometry.camera import Camera

HEAD, LEFT_HAND, RIGHT_HAND, HAND = "head", "left_hand", "right_hand", "hand"

DETECTION_KINDS: tuple[str, ...] = (HEAD, LEFT_HAND, RIGHT_HAND, HAND)
"""What can be detected; ``hand`` where the side is not known."""


@dataclass(frozen=True, eq=False)
class Detection:
    """One detected landmark, in space or in the picture of one camera.

    Attributes
    ----------
    time : float
        In frames of the recording: 12.5 is half-way between frames 12 and 13.
    kind : str
        One of ``DETECTION_KINDS``.
    position : (3,) or (2,) float64
        World, metres; or, with a camera, column and row of its raw picture.
    sigma : float
        Standard deviation of each number of `position`, in its unit.
    confidence : float
        From 0 (exclusive) to 1; the variance is divided by it.
    camera : Camera or None
    """

    time: float
    kind: str
    position: FloatArray
    sigma: float
    confidence: float = 1.0
    camera: Camera | None = None


class Detections:
    """Detections in the order of their times.

    Parameters
    ----------
    detections : iterable of Detection
        In any order; those of the same time stay in theirs.
    source : str
        File that they come from; empty where there is none.
    """

    def __init__(self, detections: Iterable[Detection] = (), source: str = "") -> None:
        self.source = source
        self._all = tuple(sorted(detections, key=lambda detection: detection.time))
        self._times = np.array([detection.time for detection in self._all])

    def __len__(self) -> int:
        return len(self._all)

    def fingerprint(self) -> str:
        """Hash (32 hexadecimal digits) of all that they say."""
        digest = hashlib.blake2b(digest_size=16)
        for d in self._all:
            camera = "" if d.camera is None else d.camera.name
            numbers = [d.time, d.sigma, d.confidence, *d.position.tolist()]
            digest.update(f"{d.kind} {camera} {numbers!r}\n".encode())
        return digest.hexdigest()

    def until(self, frame: int) -> tuple[Detection, ...]:
        """All that came after frame `frame` - 1, up to and with frame `frame`."""
        first, end = np.searchsorted(self._times, [frame - 1, frame], side="right")
        return self._all[first:end]

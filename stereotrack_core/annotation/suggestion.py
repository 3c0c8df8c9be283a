"""What the program asks a person to click next, and when it asks for nothing more."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from stereotrack_core.annotation.click import ClickKey


@dataclass(frozen=True, slots=True)
class Suggestion:
    """A place where a click would help.

    Attributes
    ----------
    frame : int
    camera, landmark : str
    gain_deg : float
        By how much the click is expected to bring down the angle by which the limbs of this frame
        may be off (root mean square), summed up over the limbs and the torso's cross axis; degrees.
    reason : str
        Why, in words for a person; most important first.
    click_there : bool
        Whether there is a click already that should be looked at again.
    over_frames_deg : float
        The same summed up over the frames around that profit; suggestions are ranked by it.
    """

    frame: int
    camera: str
    landmark: str
    gain_deg: float
    reason: str
    click_there: bool = False
    over_frames_deg: float = 0.0

    @property
    def key(self) -> ClickKey:
        """Frame, camera and landmark."""
        return ClickKey(self.frame, self.camera, self.landmark)


@dataclass(frozen=True)
class StopSign:
    """Whether the wanted accuracy is reached.

    Attributes
    ----------
    wanted_deg : float
        Angle by which a limb may be off (root mean square), degrees.
    frames : int
        Frames that count.
    frames_missing : int
        Those of them in which a limb misses the wanted accuracy.
    missing_by_limb : mapping from limb to int
        Frames in which that limb misses it; limbs that nobody misses are there with 0.
    unknown : int
        Frames that nothing is known of (gaps); they are among the missing ones.
    rms_deg : mapping from limb to float
        How good each limb is over the frames that are known; NaN where none is.
    allowed : float
        Share of the frames that may miss it.
    """

    wanted_deg: float
    frames: int
    frames_missing: int
    missing_by_limb: Mapping[str, int]
    unknown: int
    rms_deg: Mapping[str, float]
    allowed: float = 0.0

    @property
    def reached(self) -> bool:
        """Whether to stop clicking."""
        return self.frames > 0 and self.frames_missing <= self.allowed * self.frames

    def words(self) -> str:
        """``12 of 490 frames miss 3 deg, most often the left forearm (9)``."""
        if not self.frames:
            return "not fitted yet"
        if not self.frames_missing:
            return f"all {self.frames} frames are within {self.wanted_deg:g} deg: target reached"
        worst = max(self.missing_by_limb, key=lambda limb: self.missing_by_limb[limb])
        number = self.missing_by_limb[worst]
        text = f"{self.frames_missing} of {self.frames} frames exceed {self.wanted_deg:g} deg"
        if number:
            text += f", most often the {worst.replace('_', ' ')} ({number})"
        return f"{text}: target reached" if self.reached else text

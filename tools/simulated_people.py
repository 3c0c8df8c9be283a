"""Simulated recordings on which it is fitted and measured how limbs are called lost."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from exercises import EXERCISES

from stereotrack_core.simulation.make import Simulation, simulate
from stereotrack_core.simulation.motions import MOTIONS
from stereotrack_core.simulation.rig import SceneOptions

MOTIONS.update(EXERCISES)

_KINECT: Mapping[str, str | float] = {
    "kind": "depth", "width": 320, "height": 240, "focal": 286.0, "camera_distance": 2.9,
    "camera_height": 1.15, "fps": 20.0, "t_pose_first": False,
}  # fmt: skip
"""A structured-light depth camera at the height of a table, before a person with hanging arms."""


PLAIN = "plain"
"""``accurate`` without its search for arms and comparison of pictures: it loses arms alone."""

_FOUR = ("accurate", "fast", "ekf", "thesis")


@dataclass(frozen=True)
class Simulated:
    """A recording to simulate, and the choices of its views that are tracked; all when empty."""

    person: str
    motion: str
    frames: int
    views: str
    seed: int
    chosen: tuple[str, ...] = ("",)
    options: Mapping[str, str | float] = field(default_factory=dict)
    presets: tuple[str, ...] = ("accurate", "thesis", PLAIN)

    @property
    def init(self) -> str:
        """How the first pose is found."""
        return "tpose" if self.options.get("t_pose_first", True) else "auto"

    def make(self, folder: Path) -> None:
        """Simulate it, unless the folder is there."""
        if not folder.exists():
            simulate(
                folder,
                Simulation(
                    person=self.person,
                    motion=self.motion,
                    frames=self.frames,
                    views=self.views,
                    seed=self.seed,
                    options=SceneOptions().replaced(**self.options),
                ),
            )


def _depth(
    person: str, motion: str, views: str, seed: int, stature: float, **more: float
) -> Simulated:
    return Simulated(
        person,
        motion,
        90,
        views,
        seed,
        options={**_KINECT, "stature": stature, **more},
    )


def _stereo(
    person: str, motion: str, views: str, seed: int, stature: float, *chosen: str
) -> Simulated:
    options = {"stature": stature, "camera_height": 1.6}
    return Simulated(person, motion, 60, views, seed, chosen or ("",), options)


SEVERAL: Mapping[str, Simulated] = {
    "A": Simulated(
        "P1", "whip+cross-arms+arms-at-sides", 140, "NOSW", 3, ("", "NO"), presets=_FOUR
    ),
    "B": Simulated(
        "P3", "tie-shoes+travolta+cross-arms", 140, "NOSW", 4, ("", "OW"), presets=_FOUR
    ),
    "C": Simulated("P2", "cross-arms+point+travolta", 60, "NOSW", 11, ("", "NS"), presets=_FOUR),
    "D": Simulated("P4", "whip+tie-shoes+arms-at-sides", 80, "NO", 12, presets=_FOUR),
    "E": Simulated("P3", "cross-arms+whip+travolta", 80, "OW", 13, presets=_FOUR),
    "F": Simulated(
        "P1", "walk+cross-arms+tie-shoes+point", 90, "NOSW", 14, ("", "NS"), presets=_FOUR
    ),
}
"""What coefficients for several views are fitted on."""

ONE: Mapping[str, Simulated] = {
    "one-A": _stereo("P4", "box+sit", "N", 15, 1.5),
    "one-B": _stereo("P2", "cross-arms+jog+wave", "N", 16, 1.8),
    "one-C": _stereo("P1", "cross-arms+throw", "O", 17, 1.65),
    "depth-A": _depth("P2", "box+sit", "N", 21, 1.6),
    "depth-B": _depth("P1", "cross-arms+squat", "N", 22, 1.85),
    "depth-C": _depth("P4", "throw+wave+jog", "N", 23, 1.5),
    "depth-D": _depth("P3", "sit+cross-arms", "N", 24, 2.0),
    "depth-E": _depth("P1", "jog+clap+box", "N", 25, 1.75, pace=1.5),
    "depth-F": _depth("P4", "cross-arms+throw+point", "N", 26, 1.7),
    "depth-G": _depth("P2", "box+cross-arms", "O", 27, 1.9),
}
"""What coefficients for one view are fitted on."""

HELD_OUT: Mapping[str, Simulated] = {
    "held-four": _stereo("P4", "cross-arms+box", "NOSW", 51, 1.6, "", "NS"),
    "held-one": _stereo("P3", "cross-arms+throw", "N", 52, 1.95),
    "held-depth-A": _depth("P3", "cross-arms+box", "N", 53, 1.7),
    "held-depth-B": _depth("P1", "sit+throw", "N", 54, 1.55),
    "held-depth-C": _depth("P4", "squat+clap+jog", "N", 55, 1.95),
}
"""Other people, seeds and sequences, to measure on."""

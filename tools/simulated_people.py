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


TRACKED: Mapping[str, tuple[str, tuple[str, ...]]] = {
    "fast": ("fast", ()),
    "unheeded": ("fast", ("keypoint_sigma=1", "keypoint_cost=0")),
    "thesis": ("thesis", ()),
}
"""Preset and changes by name. ``unheeded`` sees the detector's keypoints and hardly measures them,
so that limbs are lost that would not be with them."""


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
    presets: tuple[str, ...] = ("unheeded", "thesis")
    """Names in :data:`TRACKED`."""

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


RECORDINGS: Mapping[str, Simulated] = {
    "four-A": Simulated(
        "P2", "cross-arms+point+travolta", 60, "NOSW", 11, ("", "NS"),
        presets=("fast", "unheeded", "thesis"),
    ),
    "four-B": Simulated("P1", "walk+cross-arms+tie-shoes+point", 50, "NOSW", 14, ("", "NS")),
    "two-A": Simulated("P4", "whip+tie-shoes+arms-at-sides", 80, "NO", 12),
    "two-B": Simulated("P3", "cross-arms+whip+travolta", 80, "OW", 13),
    "one-A": _stereo("P4", "box+sit", "N", 15, 1.5),
    "depth-A": _depth("P2", "box+sit", "N", 21, 1.6),
    "depth-B": _depth("P1", "cross-arms+squat", "N", 22, 1.85),
    "depth-C": _depth("P4", "throw+wave+jog", "N", 23, 1.5),
}  # fmt: skip
"""What coefficients are fitted on."""

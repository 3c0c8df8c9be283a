"""Simulated recordings on which it is fitted and measured how limbs are called lost."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from depth_camera import simulate_depth
from exercises import EXERCISES

from stereotrack_core.simulation.make import Simulation, simulate
from stereotrack_core.simulation.motions import MOTIONS
from stereotrack_core.simulation.rig import SceneOptions

MOTIONS.update(EXERCISES)

# A structured-light depth camera at the height of a table, before a person with hanging arms.
_KINECT = SceneOptions(
    width=320, height=240, focal=286.0, camera_distance=2.9,
    camera_height=1.15, fps=20.0, t_pose_first=False,
)  # fmt: skip

# Preset and changes by name. ``unheeded`` sees the detector's keypoints and hardly measures them,
# so that limbs are lost that would not be with them.
TRACKED: Mapping[str, tuple[str, tuple[str, ...]]] = {
    "fast": ("fast", ()),
    "unheeded": ("fast", ("keypoint_sigma=1", "keypoint_cost=0")),
    "thesis": ("thesis", ()),
}


@dataclass(frozen=True)
class Simulated:
    """A recording to simulate, and the choices of its views that are tracked; all when empty."""

    simulation: Simulation
    chosen: tuple[str, ...] = ("",)
    presets: tuple[str, ...] = ("unheeded", "thesis")  # names in :data:`TRACKED`
    make: Callable[[Path, Simulation], None] = simulate

    @property
    def init(self) -> str:
        """How the first pose is found."""
        return "tpose" if self.simulation.options.t_pose_first else "auto"


def _depth(person: str, motion: str, seed: int, stature: float) -> Simulated:
    options = _KINECT.replaced(stature=stature)
    return Simulated(Simulation(person, motion, 90, "N", seed, options), make=simulate_depth)


# What coefficients are fitted on.
RECORDINGS: Mapping[str, Simulated] = {
    "four-A": Simulated(
        Simulation("P2", "cross-arms+point+travolta", 60, "NOSW", 11), ("", "NS"),
        ("fast", "unheeded", "thesis"),
    ),
    "four-B": Simulated(
        Simulation("P1", "walk+cross-arms+tie-shoes+point", 50, "NOSW", 14), ("", "NS")
    ),
    "two-A": Simulated(Simulation("P4", "whip+tie-shoes+arms-at-sides", 80, "NO", 12)),
    "two-B": Simulated(Simulation("P3", "cross-arms+whip+travolta", 80, "OW", 13)),
    "one-A": Simulated(
        Simulation("P4", "box+sit", 60, "N", 15, SceneOptions(stature=1.5, camera_height=1.6))
    ),
    "depth-A": _depth("P2", "box+sit", 21, 1.6),
    "depth-B": _depth("P1", "cross-arms+squat", 22, 1.85),
    "depth-C": _depth("P4", "throw+wave+jog", 23, 1.5),
}  # fmt: skip

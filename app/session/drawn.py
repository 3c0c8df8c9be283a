"""Values that views and scene draw of one frame; no widget is among them."""

from dataclasses import dataclass

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.mesh import PartMesh
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import Pose
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.keypoints import Keypoints
from stereotrack_core.recording.reader import FrameSet
from stereotrack_core.tracking.estimate import Correspondences

from .runs import RunStyle


@dataclass(frozen=True, eq=False)
class Marked:
    """Ghosts, lines or dots of one colour."""

    name: str  # #rrggbb; of ghosts the limb
    places: FloatArray
    """Ghosts: the vertices (S, V, 3) of one cone of the model in several poses; lines: their ends
    (K, 2, 3); dots: (K, 3)."""


@dataclass(frozen=True, eq=False)
class InsideScene:
    """Marks of a step inside a frame.

    In the world, metres; or in a picture, where all places are pixels, with two numbers for three,
    and ghosts are silhouettes (K, 2).
    """

    ghosts: tuple[Marked, ...] = ()
    lines: tuple[Marked, ...] = ()
    dots: tuple[Marked, ...] = ()


@dataclass(frozen=True, eq=False)
class GhostBody:
    """The model of a run that is drawn beside the active one, as lines, dots or both."""

    name: str
    style: RunStyle  # that of its lines in the plots: `dash` becomes lines, `dot` dots
    meshes: tuple[PartMesh, ...]


@dataclass(frozen=True, eq=False)
class Instant:
    """Everything known about the frame that is shown."""

    recording: Recording
    frame_set: FrameSet
    cloud: Cloud | None = None
    meshes: tuple[PartMesh, ...] = ()
    reference: FloatArray | None = None  # (9, 3), world, metres
    reference_is_old: bool = False  # whether it was fitted before the last click
    ghosts: tuple[GhostBody, ...] = ()
    runs: tuple[tuple[str, RunStyle], ...] = ()  # all runs that are shown, the active one first
    correspondences: Correspondences | None = None
    inside: InsideScene | None = None
    keypoints: Keypoints | None = None


@dataclass(frozen=True, eq=False)
class StepDrawing:
    """One step as it is drawn."""

    frame: int
    words: str
    body: BodyModel
    pose: Pose  # of the model that is drawn as a whole
    scene: InsideScene
    cloud: Cloud


@dataclass(frozen=True, eq=False)
class FittedBody:
    """A body that was fitted to the clicks of a frame."""

    frame: int
    meshes: tuple[PartMesh, ...]

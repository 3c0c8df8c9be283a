"""What a recording folder says about itself, as frozen facts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, TypeAlias

from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.landmarks import LandmarkTrajectory

ViewKind: TypeAlias = Literal["stereo", "depth", "mono"]


@dataclass(frozen=True)
class Stream:
    """One video, or one set of numbered images.

    Attributes
    ----------
    camera : str
        Name of the camera in the calibration (empty for a mask).
    frames : str
        Video file or printf pattern, relative to the folder.
    background : str or None
        Image or video of the empty scene.
    first_frame : int
        The stream's own frame that is frame 0 of the recording.
    time_offset : float
        Seconds by which the stream shows the scene later.
    """

    camera: str
    frames: str
    background: str | None = None
    first_frame: int = 0
    time_offset: float = 0.0


@dataclass(frozen=True)
class View:
    """A viewpoint: one mono, depth or stereo camera.

    `image` is the reference image: the right image of a stereo camera, the image of a depth
    or mono view. `left` is there for stereo views; `depth`, `depth_unit` (metres per count)
    and perhaps `mask` for depth views.
    """

    name: str
    kind: ViewKind
    image: Stream
    left: Stream | None = None
    depth: Stream | None = None
    depth_unit: float = 0.001
    mask: Stream | None = None
    display_rotation: int = 0

    def streams(self) -> dict[str, Stream]:
        """The view's streams by their key in ``recording.toml``."""
        named = {
            "left": self.left,
            "right" if self.kind == "stereo" else "image": self.image,
            "depth": self.depth,
            "mask": self.mask,
        }
        return {key: stream for key, stream in named.items() if stream is not None}


@dataclass(frozen=True)
class Segment:
    """A named stretch of frames, half-open."""

    name: str
    first: int
    end: int


@dataclass(frozen=True)
class Subject:
    """Measured lengths in metres between joint centres; None where not measured."""

    name: str = ""
    shoulder_width: float | None = None
    hip_width: float | None = None
    torso_length: float | None = None
    upper_arm_length: float | None = None
    forearm_length: float | None = None
    hand_length: float | None = None
    shoulder_to_head: float | None = None


@dataclass(frozen=True, eq=False)
class Recording:
    """A recording folder as described by its files; images are read by ``FrameReader``.

    Attributes
    ----------
    folder : Path
    name : str
    fps : float
        Frame sets per second.
    views : tuple of View
    cameras : mapping from camera name to Camera
    subject : Subject or None
    reference : LandmarkTrajectory or None
        Taken as truth by ``evaluate``; the tracker never sees it.
    segments : tuple of Segment
    """

    folder: Path
    name: str
    fps: float
    views: tuple[View, ...]
    cameras: Mapping[str, Camera]
    subject: Subject | None = None
    reference: LandmarkTrajectory | None = None
    segments: tuple[Segment, ...] = field(default=())

    def view(self, name: str) -> View:
        """The view of that name; KeyError where there is none."""
        for view in self.views:
            if view.name == name:
                return view
        raise KeyError(name)

    def reference_camera(self, view: View) -> Camera:
        """Camera of the view's reference image."""
        return self.cameras[view.image.camera]

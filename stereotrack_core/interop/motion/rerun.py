"""RRD, the recording of the Rerun viewer (https://rerun.io), by the optional library rerun-sdk.

Under ``world``, the recording's, right-handed, in metres: ``cameras/NAME`` with the image of each
view's reference camera, ``cloud`` with the points of all views in their colours, ``body/PART`` with
the model, and ``landmarks``. Images are raw, as JPEG: Rerun places them by the camera's matrix and
knows nothing of its distortion. Under ``measures`` the run's residual in millimetres and its
unexplained fraction. The timelines are ``frame``, the recording's, and ``time`` in seconds since
frame 0. In frames that are not tracked body and landmarks are cleared.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from stereotrack_core.arrays import ImageArray
from stereotrack_core.atomic import write_file
from stereotrack_core.body.mesh import PartMesh, body_mesh
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.skeleton import PARTS
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.geometry.upright import Upright
from stereotrack_core.interop.ply import VIEW_COLOURS
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.stored import body_of_run, pose_of_run, up_of_run
from stereotrack_core.versions import extra_library

_JPEG_QUALITY = 85
_GREY = "#b4b4b4"


@dataclass(frozen=True, eq=False)
class SeenFrame:
    """What is drawn of one frame besides the run."""

    frame: int
    """Of the recording."""
    images: Mapping[str, ImageArray]
    """By view; (H, W) or (H, W, 3) BGR, of the view's reference camera."""
    cloud: Cloud | None = None


def write_rerun(
    path: Path,
    run: Run,
    recording: Recording,
    frames: Iterable[SeenFrame],
    colours: Mapping[str, str],
) -> int:
    """Write the frames of a run in its own world, as they come; their number.

    `colours`: mapping from limb to #rrggbb.

    InputError where the run's states are not those of a body, the file cannot be written, or
    rerun-sdk is not installed.
    """
    rerun = rerun_library(path)
    body, row_of = body_of_run(run), {int(frame): i for i, frame in enumerate(run.frame)}
    # kept in memory to the end, because rerun-sdk waits forever where a drive is full
    stream = rerun.RecordingStream("stereotrack", recording_id=recording.name)
    stream.set_log_time_enabled(False)  # when it was written is of no interest
    stream.set_log_tick_enabled(False)
    memory = stream.memory_recording()
    drawing = _Drawing(rerun, stream, recording, body, colours)
    drawing.world(up_of_run(run))
    count = 0
    for seen in frames:
        i = row_of[seen.frame]
        stream.set_time("frame", sequence=seen.frame)
        stream.set_time("time", duration=seen.frame / recording.fps)
        drawing.seen(seen)
        drawing.body(pose_of_run(run, i))
        drawing.landmarks(run, i)
        stream.log("measures/residual_mm", rerun.Scalars(1000.0 * run.residual[i]))
        share = rerun.Scalars(run.unexplained_fraction[i])
        stream.log("measures/unexplained_fraction", share)
        count += 1
    write_file(path, memory.drain_as_bytes())
    return count


def rerun_library(path: Path) -> Any:
    """The library rerun-sdk; InputError where it is not installed."""
    missing = "Rerun recordings need the library rerun-sdk, which is not installed"
    return extra_library("rerun", "rerun", missing=missing, where=str(path), instead="bvh")


class _Drawing:
    """What is logged to a stream of Rerun."""

    def __init__(
        self,
        rerun: Any,
        stream: Any,
        recording: Recording,
        body: BodyModel,
        colours: Mapping[str, str],
    ) -> None:
        self._rerun, self._stream = rerun, stream
        self._recording = recording
        self._body = body
        self._colours = colours
        self._parts: tuple[str, ...] = ()  # those that are shown now

    def world(self, upright: Upright) -> None:
        """What does not change: axes and cameras."""
        rerun = self._rerun
        direction = "DOWN" if upright.axis.startswith("-") else "UP"
        axes = f"RIGHT_HAND_{upright.axis[-1].upper()}_{direction}"
        self._stream.log("world", getattr(rerun.ViewCoordinates, axes), static=True)
        for view in self._recording.views:
            camera = self._recording.reference_camera(view)
            place = f"world/cameras/{view.name}"
            self._stream.log(place, self._transform(camera.world_from_camera), static=True)
            lens = rerun.Pinhole(
                image_from_camera=camera.matrix,
                resolution=[camera.width, camera.height],
                camera_xyz=rerun.ViewCoordinates.RDF,
            )
            self._stream.log(place, lens, static=True)

    def seen(self, seen: SeenFrame) -> None:
        """Images and cloud."""
        rerun = self._rerun
        for name, image in seen.images.items():
            done, data = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY])
            if done:
                encoded = rerun.EncodedImage(contents=data.tobytes(), media_type="image/jpeg")
                self._stream.log(f"world/cameras/{name}/image", encoded)
        if seen.cloud is not None:
            colour = VIEW_COLOURS[seen.cloud.view % len(VIEW_COLOURS)]
            self._stream.log("world/cloud", rerun.Points3D(seen.cloud.points, colors=colour))

    def body(self, pose: Pose | None) -> None:
        """The model in its pose; nothing where there is none."""
        rerun = self._rerun
        if pose is None:
            if self._parts:
                self._stream.log("world/body", rerun.Clear(recursive=True))
                self._parts = ()
            return
        frames = self._body.frames(pose)
        if not self._parts:
            self._show_meshes(pose)
        for part in self._parts:
            k = PARTS.index(part)
            moved = RigidTransform(frames.rotations[k], frames.origins[k])
            self._stream.log(f"world/body/{part}", self._transform(moved))

    def _show_meshes(self, pose: Pose) -> None:
        frames = self._body.frames(pose)
        meshes: dict[str, list[PartMesh]] = {}
        for mesh in body_mesh(self._body, pose):
            meshes.setdefault(PARTS[mesh.part], []).append(mesh)
        for part, own in meshes.items():
            k = PARTS.index(part)
            for number, mesh in enumerate(own):
                local = (mesh.vertices - frames.origins[k]) @ frames.rotations[k]
                colour = self._colours.get(mesh.limb, _GREY).removeprefix("#")
                surface = self._rerun.Mesh3D(
                    vertex_positions=local,
                    triangle_indices=mesh.triangles,
                    albedo_factor=[*bytes.fromhex(colour), 255],
                )
                self._stream.log(f"world/body/{part}/{number}", surface)
        self._parts = tuple(meshes)

    def landmarks(self, run: Run, i: int) -> None:
        """The landmarks that are known."""
        known = np.flatnonzero(np.isfinite(run.landmarks[i]).all(axis=1)).tolist()
        points = self._rerun.Points3D(
            run.landmarks[i, known], radii=0.015, labels=[LANDMARKS[k] for k in known]
        )
        self._stream.log("world/landmarks", points)

    def _transform(self, transform: RigidTransform) -> Any:
        return self._rerun.Transform3D(translation=transform.translation, mat3x3=transform.rotation)

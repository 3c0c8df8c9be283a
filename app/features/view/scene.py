"""Facts about one instant become the content of the 3-D scene."""

from collections.abc import Iterable, Mapping, Sequence

import cv2
import numpy as np
import scipy

from stereotrack_core.arrays import FloatArray, ImageArray, IntArray
from stereotrack_core.body.angles import THESIS_JOINTS, pose_of_state
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.manifold import displaced
from stereotrack_core.body.mesh import PartMesh
from stereotrack_core.body.model import landmarks
from stereotrack_core.body.pose import Pose
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.tracking.frame import TrackedFrame

from ...session.runs import RunEntry
from ...session.view_state import Instant, PointColour
from ...widgets.scene.content import Ellipsoid, PointLegend, SceneContent
from ...widgets.style.colours import LANDMARK_LIMBS, LIMB_COLOURS, limb_words

POINT_COLOURS: dict[PointColour, str] = {
    "view": "Points by view",
    "limb": "Points by nearest limb",
    "distance": "Points by distance to the model",
}
_VIEW_COLOURS = np.array(
    [[245, 214, 88], [126, 196, 255], [190, 150, 255], [140, 222, 150], [255, 160, 140]], np.uint8
)
_VIEW_COLOURS_ON_LIGHT = np.array(
    [[158, 128, 0], [28, 110, 190], [122, 70, 200], [30, 130, 60], [196, 70, 50]], np.uint8
)
_FULL_DISTANCE = 0.1
_IMAGE_WIDTH = 160


def scene_of(
    instant: Instant,
    meshes: Sequence[PartMesh],
    colour: PointColour,
    highlighted: str,
    ellipsoids: Sequence[Ellipsoid] = (),
    *,
    dark: bool = True,
) -> SceneContent:
    """Cloud, model, reference and cameras with their images, for a dark or light background."""
    cloud = instant.cloud
    points, colours, legend = np.empty((0, 3)), np.empty((0, 3), np.uint8), None
    if cloud is not None:
        points = cloud.points
        colours, legend = coloured_points(cloud, meshes, colour, dark=dark)
    recording = instant.recording
    cameras = tuple(recording.reference_camera(view) for view in recording.views)
    return SceneContent(
        cloud_points=points, cloud_colours=colours, point_legend=legend, meshes=tuple(meshes),
        reference=instant.reference, reference_is_old=instant.reference_is_old, cameras=cameras,
        camera_images=_small_images(instant), highlighted=highlighted, ellipsoids=tuple(ellipsoids),
        inside=instant.inside, ghosts=instant.ghosts,
    )  # fmt: skip


def coloured_points(
    cloud: Cloud, meshes: Sequence[PartMesh], colour: PointColour, *, dark: bool = True
) -> tuple[ImageArray, PointLegend]:
    """Colours (N, 3) of a cloud and what they mean; without a model they go by view."""
    if colour == "view" or not meshes:
        of_views = _by_view(np.arange(len(cloud.view_names)), dark=dark)
        legend = _legend("Points by view:", cloud.view_names, of_views)
        return _by_view(cloud.view, dark=dark), legend
    distance, limb = _nearest(cloud.points, meshes)
    if colour == "limb":
        by_limb = np.array([[*bytes.fromhex(LIMB_COLOURS[name][1:])] for name in LIMBS], np.uint8)
        return by_limb[limb], _legend("Points by nearest limb:", map(limb_words, LIMBS), by_limb)
    metres = np.linspace(0.0, _FULL_DISTANCE, 5)
    words = [f"{1000.0 * one:.0f}" for one in metres[:-1]]
    words.append(f"{1000.0 * _FULL_DISTANCE:.0f} mm and more")
    legend = _legend("Points by distance to the model:", words, _by_distance(metres))
    return _by_distance(distance), legend


def _legend(title: str, names: Iterable[str], colours: ImageArray) -> PointLegend:
    rows = zip(names, colours.tolist(), strict=True)
    return PointLegend(title, tuple((name, (r, g, b)) for name, (r, g, b) in rows))


def _by_view(view: IntArray, *, dark: bool) -> ImageArray:
    palette = _VIEW_COLOURS if dark else _VIEW_COLOURS_ON_LIGHT
    result: ImageArray = palette[view % len(palette)]
    return result


def _by_distance(distance: FloatArray) -> ImageArray:
    """Colours (N, 3) of distances in metres."""
    share = np.clip(distance / _FULL_DISTANCE, 0.0, 1.0)
    grey = (255.0 * share).astype(np.uint8)[:, None]
    mapped = cv2.applyColorMap(grey, cv2.COLORMAP_VIRIDIS)[:, 0, ::-1]
    return np.ascontiguousarray(mapped, dtype=np.uint8)


def _nearest(points: FloatArray, meshes: Sequence[PartMesh]) -> tuple[FloatArray, IntArray]:
    """Distance to the nearest corner of the model, and the limb it belongs to."""
    corners = np.concatenate([mesh.vertices for mesh in meshes])
    limbs = np.repeat(
        [LIMBS.index(mesh.limb) for mesh in meshes], [len(mesh.vertices) for mesh in meshes]
    )
    distance, index = scipy.spatial.cKDTree(corners).query(points)
    return distance, limbs[index]


def _small_images(instant: Instant) -> Mapping[str, ImageArray]:
    """Reference images, small, RGB, by camera."""
    small = {}
    for view in instant.recording.views:
        images = instant.frame_set.views.get(view.name)
        if images is None:
            continue
        height = max(1, round(_IMAGE_WIDTH * images.image.shape[0] / images.image.shape[1]))
        shrunk = cv2.resize(images.image, (_IMAGE_WIDTH, height), interpolation=cv2.INTER_AREA)
        code = cv2.COLOR_GRAY2RGB if shrunk.ndim == 2 else cv2.COLOR_BGR2RGB
        small[view.image.camera] = np.asarray(cv2.cvtColor(shrunk, code), dtype=np.uint8)
    return small


SHOWN = ("left_elbow", "right_elbow", "left_hand", "right_hand")
_STEP = 1e-4


def ellipsoids_of(entry: RunEntry, tracked: TrackedFrame) -> tuple[Ellipsoid, ...]:
    """Covariances of the landmarks in :data:`SHOWN`, to first order.

    Nothing where the frame has no pose or its covariance is not known.
    """
    pose, covariance = tracked.pose, tracked.P
    if pose is None or not np.isfinite(covariance).all():
        return ()
    steps = _STEP * np.eye(len(covariance))
    ahead = landmarks(entry.body, _moved(entry, tracked, pose, steps))
    behind = landmarks(entry.body, _moved(entry, tracked, pose, -steps))
    slopes = (ahead - behind) / (2.0 * _STEP)
    places = landmarks(entry.body, pose)
    result = []
    for name in SHOWN:
        at = LANDMARKS.index(name)
        J = slopes[:, at].T
        result.append(Ellipsoid(LANDMARK_LIMBS[name], places[at], J @ covariance @ J.T))
    return tuple(result)


def _moved(entry: RunEntry, tracked: TrackedFrame, pose: Pose, delta: FloatArray) -> Pose:
    """Poses after errors (k, n), which the thesis's state adds to its angles."""
    if delta.shape[-1] == 6 + 2 * len(THESIS_JOINTS):
        return pose_of_state(tracked.x + delta, THESIS_JOINTS)
    return displaced(pose, delta, entry.body.joints)

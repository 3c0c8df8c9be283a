"""Facts about one instant become the pictures of the views."""

from collections.abc import Iterator, Mapping
from functools import partial

import cv2
import numpy as np

from stereotrack_core.arrays import BoolArray, Float32Array, FloatArray, ImageArray
from stereotrack_core.depth.cloud import DepthGeometry, ViewDepth
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.description import View
from stereotrack_core.recording.keypoint_names import LANDMARK_OF
from stereotrack_core.recording.keypoints import Keypoints

from ...session.view_state import InsideScene, Instant, Marked, PictureKind
from ...widgets.camera.overlays import Overlay, Projection, limb_paths, part_shapes, projected
from ...widgets.camera.picture import Picture
from ...widgets.style.colours import LANDMARK_LIMBS, LIMB_COLOURS

_OTHER = "#b8b8b8"
_SIDED = (
    ("shoulder", "elbow", "upper_arm"),
    ("elbow", "wrist", "forearm"),
    ("shoulder", "hip", "torso"),
    ("hip", "knee", ""),
    ("knee", "ankle", ""),
)
_BONES: Mapping[tuple[str, str], str] = {
    **{
        (f"{side}_{a}", f"{side}_{b}"): f"{side}_{limb}" if limb[-3:] == "arm" else limb
        for side in ("left", "right")
        for a, b, limb in _SIDED
    },
    ("left_shoulder", "right_shoulder"): "torso",
    ("left_hip", "right_hip"): "torso",
}
"""Keypoints that a line is drawn between, and the limb in whose colour."""


def keypoint_drawing(keypoints: Keypoints, camera: str) -> InsideScene | None:
    """Keypoints of a frame in the picture of a camera; None where it has none."""
    own = keypoints[keypoints.camera == camera]
    if not len(own):
        return None
    lines: dict[str, list[FloatArray]] = {}
    for places in _people(own):
        for (a, b), limb in _BONES.items():
            if a in places and b in places:
                bone = np.stack([places[a], places[b]])
                lines.setdefault(LIMB_COLOURS.get(limb, _OTHER), []).append(bone)
    dots: dict[str, list[FloatArray]] = {}
    for name, place in zip(own.keypoint.tolist(), own.place, strict=True):
        limb = LANDMARK_LIMBS.get(LANDMARK_OF.get(name, ""), "")
        dots.setdefault(LIMB_COLOURS.get(limb, _OTHER), []).append(place)
    return InsideScene(
        lines=tuple(Marked(colour, np.array(found)) for colour, found in lines.items()),
        dots=tuple(Marked(colour, np.array(found)) for colour, found in dots.items()),
    )


def _people(rows: Keypoints) -> Iterator[dict[str, FloatArray]]:
    """Places by keypoint, of each person of each detector."""
    keys = list(zip(rows.source.tolist(), rows.person.tolist(), strict=True))
    for key in dict.fromkeys(keys):
        chosen = np.array([one == key for one in keys], dtype=np.bool_)
        person = rows[chosen]
        yield dict(zip(person.keypoint.tolist(), person.place, strict=True))


_NEAR_PERCENTILE, _FAR_PERCENTILE = 1.0, 99.0


def pictures_of(
    instant: Instant, wanted: Mapping[str, PictureKind], overlays: frozenset[str]
) -> tuple[Picture, ...]:
    """Pictures of the views that are wanted, with the overlays that are switched on."""
    views = {view.name: view for view in instant.recording.views}
    return tuple(
        _picture(instant, views[name], kind, overlays)
        for name, kind in wanted.items()
        if name in views
    )


def depth_projection(geometry: DepthGeometry) -> Projection:
    """Projection into a view's rectified depth image."""
    depth_from_world = geometry.world_from_depth.inverse()

    def project(points: FloatArray) -> FloatArray:
        p = depth_from_world.apply(points)
        z = np.where(p[..., 2] > 1e-6, p[..., 2], np.nan)
        u = geometry.focal * p[..., 0] / z + geometry.c_x
        v = geometry.focal * p[..., 1] / z + geometry.c_y
        result: FloatArray = np.stack([u, v], axis=-1)
        return result

    return project


def ray_range(camera: Camera, depth: ViewDepth, x: float, y: float) -> float:
    """Distance in metres along the ray of a raw pixel, NaN where nothing was measured."""
    geometry = depth.geometry
    ray = camera.rays_world(np.array([x, y])) @ geometry.world_from_depth.rotation
    if ray[2] <= 1e-6:
        return float("nan")
    u = round(geometry.focal * ray[0] / ray[2] + geometry.c_x)
    v = round(geometry.focal * ray[1] / ray[2] + geometry.c_y)
    height, width = depth.range_z.shape
    inside = 0 <= u < width and 0 <= v < height
    return float(depth.range_z[v, u] / ray[2]) if inside else float("nan")


def _picture(instant: Instant, view: View, kind: PictureKind, overlays: frozenset[str]) -> Picture:
    made = partial(Picture, view.name, kind, instant.frame_set.index)
    images, cloud = instant.frame_set.views.get(view.name), instant.cloud
    if images is None:
        return made(None, instant.frame_set.problems.get(view.name, "No image."))
    depth = cloud.depths.get(view.name) if cloud is not None else None
    problem = cloud.problems.get(view.name, "") if cloud is not None else ""
    if kind in {"image", "left"}:
        pixels: ImageArray | None = images.image
        camera = instant.recording.reference_camera(view)
        if kind == "left" and view.left is not None:
            pixels, camera = images.left, instant.recording.cameras[view.left.camera]
        if pixels is None:
            return made(None, "The left image is missing.")
        name, eye = camera.name, camera.position_world
        overlay = partial(_overlay, instant, view.name, camera.project, eye, overlays, name)
        value = partial(_pixel_words, pixels, camera, depth if kind == "image" else None)
        turn = view.display_rotation
        return made(pixels, problem, turn, overlay, camera=name, value_at=value)
    if depth is None:
        return made(None, problem or f"View {view.name} has no depth map in this frame.")
    if kind == "foreground":
        pixels = foreground_picture(depth.range_z, depth.foreground)
    elif kind == "depth":
        pixels = coloured(-depth.range_z)
    elif depth.disparity is not None:
        pixels = coloured(depth.disparity)
    else:
        return made(None, "A depth camera has no disparity map.")
    project, eye = depth_projection(depth.geometry), depth.geometry.world_from_depth.translation
    overlay = partial(_overlay, instant, view.name, project, eye, overlays)
    value = partial(_depth_words, depth)
    return made(pixels, problem, view.display_rotation, overlay, value_at=value)


def _overlay(
    instant: Instant,
    view: str,
    project: Projection,
    eye: FloatArray,
    shown: frozenset[str],
    camera: str = "",
) -> Overlay:
    shapes = part_shapes(instant.meshes, project, eye, wire="wire" in shown)
    reference = instant.reference
    points = pairs = limbs = None
    found, cloud = instant.keypoints if camera else None, instant.cloud
    if "points" in shown and cloud is not None and view in cloud.view_names:
        points = project(cloud.points[cloud.view == cloud.view_names.index(view)])
    matched = instant.correspondences
    if "correspondences" in shown and matched is not None:
        pairs = project(np.stack([matched.data, matched.model], axis=1))
        limbs = matched.part
    return Overlay(
        shapes=shapes,
        paths=limb_paths(shapes),
        reference=project(reference) if reference is not None else None,
        reference_is_old=instant.reference_is_old,
        ghosts=tuple(  # they are not shaded: no part has to be in front
            (ghost.style, limb_paths(part_shapes(ghost.meshes, project, np.zeros(3), wire=False)))
            for ghost in (instant.ghosts if "others" in shown else ())
        ),
        points=points,
        correspondences=pairs,
        limbs=limbs,
        inside=None if instant.inside is None else projected(instant.inside, project),
        keypoints=None if found is None else keypoint_drawing(found, camera),
    )


def coloured(values: Float32Array, emphasis: BoolArray | None = None) -> ImageArray:
    """Picture (H, W, 3) BGR of a map, near bright and far dark; what is not known stays black."""
    known = np.isfinite(values)
    if not known.any():
        return np.zeros((*values.shape, 3), dtype=np.uint8)
    low, high = np.percentile(
        values[known if emphasis is None else known & emphasis], (_NEAR_PERCENTILE, _FAR_PERCENTILE)
    )
    scaled = np.clip((values - low) / max(float(high - low), 1e-9), 0.0, 1.0)
    grey = np.where(known, 30.0 + 225.0 * np.nan_to_num(scaled), 0.0).astype(np.uint8)
    result: ImageArray = np.asarray(cv2.applyColorMap(grey, cv2.COLORMAP_INFERNO), dtype=np.uint8)
    return result


def foreground_picture(range_z: Float32Array, foreground: BoolArray) -> ImageArray:
    """Picture (H, W, 3) BGR: the person in colour by depth, everything else dim."""
    seen = foreground & np.isfinite(range_z)
    dim = (coloured(-range_z) * 0.0).astype(np.uint8)
    dim[np.isfinite(range_z)] = 44
    if seen.any():
        dim[seen] = coloured(-range_z, seen)[seen]
    return dim


def _pixel_words(
    pixels: ImageArray, camera: Camera, depth: ViewDepth | None, x: float, y: float
) -> str:
    value = pixels[round(y), round(x)]
    words = f"intensity {value}" if value.ndim == 0 else "rgb {2} {1} {0}".format(*value)
    if depth is None:
        return words
    metres = ray_range(camera, depth, x, y)
    return f"{words}  distance {f'{metres:.3f} m' if np.isfinite(metres) else 'not measured'}"


def _depth_words(depth: ViewDepth, x: float, y: float) -> str:
    z = depth.range_z[round(y), round(x)]
    if not np.isfinite(z):
        return "not measured"
    words = f"z {z:.3f} m"
    if depth.disparity is not None:
        words = f"disparity {depth.disparity[round(y), round(x)]:.2f} px  {words}"
    return f"{words}  {'person' if depth.foreground[round(y), round(x)] else 'background'}"

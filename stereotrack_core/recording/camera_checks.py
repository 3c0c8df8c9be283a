"""Checks of the cameras: intrinsics, places, stereo pairs, gaze, units, and which axis is up."""

from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.errors import Correction, Finding, Severity
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.geometry.triangulation import nearest_to_rays
from stereotrack_core.geometry.upright import UP_AXES, Z_UP, Upright
from stereotrack_core.recording.description import Cameras, Recording, View

_STILL_UP = 0.6
"""Cosine between up in the images and z from which the world is as it should be: a camera may look
down steeply."""

_AGREED = 0.6
"""Cosine between another axis and up in the images without which the cameras tell nothing: they
look straight down, or are turned differently."""

_APART = np.cos(np.radians(30.0))
"""Cosine of the angle between optical axes from which cameras look from different sides."""


@dataclass(frozen=True)
class LikelyUp:
    """The axis that points up in the images, and whether the cameras alone are proof of it.

    Cameras that look the same way may all have been mounted on their side.
    """

    axis: str
    sure: bool


def up_of_cameras(recording: Recording, views: Sequence[str] | None = None) -> LikelyUp:
    """The axis that points up in the images of views, turned as ``display_rotation`` says; or z."""
    names = [view.name for view in recording.views] if views is None else list(views)
    chosen = [recording.view(name) for name in names]
    chosen = [view for view in chosen if view.image.camera in recording.cameras]
    usual = LikelyUp(UP_AXES[0], True)
    if not chosen:
        return usual
    turns = np.radians([view.display_rotation for view in chosen])
    in_image = np.stack([-np.sin(turns), -np.cos(turns), np.zeros(len(turns))], axis=1)
    from_world = [recording.reference_camera(one).camera_from_world.rotation for one in chosen]
    ups = np.einsum("vji,vj->vi", from_world, in_image)  # as the images are looked at
    mean = ups.mean(axis=0)
    axis = max(UP_AXES, key=lambda name: float(Upright(name).up @ mean))
    up = Upright(axis).up
    if mean[2] > _STILL_UP or axis == usual.axis or up @ mean < _AGREED:
        return usual
    gazes = np.array(from_world)[:, 2]
    apart = float((gazes @ gazes.T).min()) < _APART
    upside_down = axis == "-z"  # cameras below a ceiling are often mounted so
    agreed = bool((ups @ up > 0.0).all())
    return LikelyUp(axis, bool(apart) and agreed and not upside_down)


CALIBRATION = "calibration.toml"
_BASELINE_M = (0.01, 2.0)
_FARTHEST_CAMERA_M = 100.0
_LEAST_SPAN_M = 0.05
_USUAL_DISTANCE_M, _USUAL_DISTANCES_M = 3.0, (0.3, 30.0)
_WIDEST_STEREO_TURN = np.radians(20.0)
_MOST_FOLDED = 0.1  # share of the border; polynomials of good calibrations may turn in the corners
IMAGE_SIZES = (0.5, 2.0, 2.0 / 3.0, 1.5, 0.75, 4.0 / 3.0)
"""Factors between image sizes that cameras are calibrated and used with."""
_NEAR_MIDDLE = 0.06  # of the width, by which a principal point misses the middle of its image
_FIELD_OF_VIEW_DEG = (5.0, 170.0)


def check_cameras(recording: Recording) -> Iterator[Finding]:
    """All findings about the cameras that the views use."""
    for _, camera in sorted(cameras_of_views(recording).items()):
        yield from _check_intrinsics(camera)
    for view in recording.views:
        if view.left is not None:
            yield from _check_pair(recording, view)
    own = world_camera(cameras_of_views(recording).values())
    likely, where = up_of_cameras(recording), CALIBRATION
    what = f"the world's {likely.axis} axis points up in the images, not z"
    if own is not None:
        where = f"{CALIBRATION}, camera {own.name}"
        what = f"the world is the frame of camera {own.name}: z is its viewing direction, not up"
    if own is not None or likely.axis != UP_AXES[0]:
        severity: Severity = "note" if likely.axis != UP_AXES[0] else "warning"
        yield Finding(severity, where, what, _assumed(recording, likely))
    whole_rig = yield from _check_gaze(recording, upright=own is None)
    if not whole_rig:
        yield from _check_distances(recording)


def _check_intrinsics(camera: Camera) -> Iterator[Finding]:
    where = f"{CALIBRATION}, camera {camera.name}, matrix"
    yield from _check_principal_point(camera, where)
    width = camera.width
    fx, fy = camera.matrix[0, 0], camera.matrix[1, 1]
    if not 0.8 < fx / fy < 1.25:
        what = f"the focal lengths {fx:.0f} and {fy:.0f} px differ by more than a fifth"
        remedy = "This is correct only for non-square pixels; otherwise calibrate again."
        yield Finding("warning", where, what, remedy)
    angle = np.degrees(2 * np.arctan2(width / 2, fx))
    if not camera.fisheye and not _FIELD_OF_VIEW_DEG[0] < angle < _FIELD_OF_VIEW_DEG[1]:
        what = f"a focal length of {fx:.0f} px gives a field of view of {angle:.1f} degrees"
        remedy = "The focal length must be in pixels, not in millimetres."
        yield Finding("warning", where, what, remedy)
    if (folded := _folded_share(camera)) > _MOST_FOLDED:
        share = f"{100 * folded:.0f} % of the image border"
        what = f"they fold {share} back into the image, which no real lens does"
        remedy = "Calibrate this camera again, with the board reaching the corners of the image."
        yield Finding("warning", f"{CALIBRATION}, camera {camera.name}, distortions", what, remedy)


def _check_principal_point(camera: Camera, where: str) -> Iterator[Finding]:
    width, height = camera.width, camera.height
    cx, cy = camera.matrix[0, 2], camera.matrix[1, 2]
    middle = np.array([width, height]) / 2
    aside, near = np.abs([cx, cy] - middle), _NEAR_MIDDLE * width
    exchanged = np.all(np.abs([cy, cx] - middle) < near) and np.all(aside > near)
    resized = ""  # what to do if it is the middle of a larger or smaller image
    for factor in IMAGE_SIZES:
        if not resized and np.all(np.abs(factor * camera.matrix[:2, 2] - middle) < near):
            rows = f"multiply its first two rows by {factor:.3g}"
            resized = f"The matrix belongs to another image size: {rows}."
    centre = f"the principal point ({cx:.1f}, {cy:.1f})"
    image = f"the image of {width} x {height} pixels"
    if not (0 <= cx <= width - 1 and 0 <= cy <= height - 1):
        turned = 0 <= cx <= height - 1 and 0 <= cy <= width - 1
        what = f"{centre} lies outside {image}"
        remedy = resized or "Use the calibration for this image size."
        if turned:
            fits = "It fits the image rotated by 90 degrees."
            remedy = f"{fits} Calibrate with the images as they are stored."
        yield Finding("error", where, what, remedy)
    elif exchanged:
        there = f"({cy:.1f}, {cx:.1f}) is near the centre of {image}"
        what = f"c_x and c_y are exchanged: {there}, {centre} is not"
        remedy = "Exchange c_x and c_y, or check that the matrix belongs to these images."
        yield Finding("warning", where, what, remedy)
    elif (aside > middle / 2).any():
        what = f"{centre} is far from the centre of {image}"
        remedy = resized or "This is correct only for cropped images; otherwise calibrate again."
        yield Finding("warning", where, what, remedy)


def _folded_share(camera: Camera) -> float:
    """Share of the image's border at which the distortion cannot be undone."""
    x = np.linspace(0.0, camera.width - 1.0, 33)
    y = np.linspace(0.0, camera.height - 1.0, 25)
    sides = [(x, np.full_like(x, end)) for end in (0.0, camera.height - 1.0)]
    sides += [(np.full_like(y, end), y) for end in (0.0, camera.width - 1.0)]
    border = np.concatenate([np.column_stack(side) for side in sides])
    back = camera.project(camera.position_world + camera.rays_world(border))
    return float(1.0 - (np.linalg.norm(back - border, axis=1) < 1.0).mean())


def _check_distances(recording: Recording) -> Iterator[Finding]:
    """The size of the rig: nobody builds one of kilometres or of millimetres."""
    places = [camera.position_world for camera in view_cameras(recording).values()]
    if not places:
        return
    where = f"{CALIBRATION}, [metadata] units"
    farthest = max(float(np.linalg.norm(place)) for place in places)
    cameras = cameras_of_views(recording)
    if farthest > _FARTHEST_CAMERA_M:
        low, high = _USUAL_DISTANCES_M
        away = {name: float(np.linalg.norm(one.position_world)) for name, one in cameras.items()}
        some_usual = any(low < distance < high for distance in away.values())
        wrong = tuple(name for name in away if not some_usual or away[name] >= high)
        tall = f"a person {1.7 * farthest / _USUAL_DISTANCE_M / 1000:.1f} km tall"
        what = f"a camera is {farthest:,.0f} m from the world origin, which corresponds to {tall}"
        remedy = 'If the translations are in millimetres, state units = "mm".'
        correction = Correction("scale_translation", wrong, 0.001)
        yield Finding("error", where, what, remedy, correction)
    spans = [float(np.linalg.norm(a - b)) for a, b in combinations(places, 2)]
    if spans and max(spans) < _LEAST_SPAN_M:
        tall = f"a person {1700 * max(spans) / _USUAL_DISTANCE_M:.1f} mm tall"
        what = f"all views are within {1000 * max(spans):.1f} mm, which corresponds to {tall}"
        remedy = 'If the translations are in metres, state units = "m".'
        correction = Correction("scale_translation", tuple(cameras), 1000.0)
        yield Finding("error", where, what, remedy, correction)


def _check_pair(recording: Recording, view: View) -> Iterator[Finding]:
    assert view.left is not None  # noqa: S101 - the caller chose stereo views
    left, right = (recording.cameras.get(s.camera) for s in (view.left, view.image))
    if left is None or right is None:
        return
    where = f"recording.toml, view {view.name}"
    right_from_left = right.camera_from_world @ left.world_from_camera
    offset = right_from_left.translation
    baseline = float(np.linalg.norm(offset))
    if not _BASELINE_M[0] < baseline < _BASELINE_M[1]:
        apart = f"{1000 * baseline:.1f} mm" if baseline < 1 else f"{baseline:.2f} m"
        severity: Severity = "error" if baseline < 1e-6 or baseline > 20 else "warning"
        what = f"the two cameras of the stereo pair are {apart} apart"
        units = "State the correct units in calibration.toml"
        yield Finding(severity, where, what, f"{units}, and use two cameras that belong together.")
    if baseline < 1e-6:
        return
    if offset[0] > 0.5 * baseline:
        what = f"left and right are swapped: camera {left.name} is to the right of {right.name}"
        yield Finding("error", where, what, "Swap left and right of this view in recording.toml.")
    elif abs(offset[0]) < 0.8 * baseline:
        what = "the two cameras are not side by side as seen in the images"
        remedy = "Check which cameras belong to this view, and their rotations."
        yield Finding("warning", where, what, remedy)
    turn = np.arccos(np.clip((np.trace(right_from_left.rotation) - 1) / 2, -1, 1))
    if turn > _WIDEST_STEREO_TURN:
        what = f"the viewing directions of the stereo pair differ by {np.degrees(turn):.0f} degrees"
        remedy = "Check which cameras belong to this view, and their rotations."
        yield Finding("warning", where, what, remedy)


_LEAST_VIEWS = 3  # with fewer nobody can tell which one is wrong
_STEEP = 0.85  # cosine to the vertical above which a camera has no upright
_LEAST_UPRIGHT = 0.5  # cosine between up in the image and the world's z, seen in the image
_AT_ORIGIN = 0.01  # of the rig's size, by which the world's own camera may miss the origin
_AS_THE_WORLD = 0.95  # cosine to the world's axes within which a camera has them
_NOT_UPRIGHT = "is not upright: the world's {axis} does not point up in its image"
_CHECK_PLACE = (
    "Check its rotation and translation (x_camera = R x_world + t) and its display_rotation."
)
_MARGIN = 0.5  # of the image size, by which the common centre may miss the image


def view_cameras(recording: Recording) -> dict[str, Camera]:
    """Reference camera by view name, for views whose camera is known."""
    known = (view for view in recording.views if view.image.camera in recording.cameras)
    return {view.name: recording.cameras[view.image.camera] for view in known}


def cameras_of_views(recording: Recording) -> dict[str, Camera]:
    """All cameras that the views use, those of left images included, by name."""
    names = [s.camera for view in recording.views for s in view.streams().values()]
    return {name: recording.cameras[name] for name in names if name in recording.cameras}


def world_camera(cameras: Iterable[Camera]) -> Camera | None:
    """The camera whose own frame is the world's; None where there is none.

    Many tools leave the world where their first camera is. A camera whose centre is the origin and
    that looks along the world's z would look straight up, if the world were as it should be.
    Some tools turn that camera a little, so that the boards stand upright.
    """
    placed = list(cameras)
    size = max((float(np.linalg.norm(one.position_world)) for one in placed), default=0.0)
    for one in placed:
        along = one.camera_from_world.rotation[2, 2]
        aside = one.camera_from_world.rotation[0, 0]
        near = float(np.linalg.norm(one.position_world)) <= _AT_ORIGIN * size
        if near and min(along, aside) > _AS_THE_WORLD:
            return one
    return None


def _assumed(recording: Recording, likely: LikelyUp) -> str:
    """Consequences of a z axis that does not point up, and the remedy."""
    folder = recording.folder
    align = f"`stereotrack calibrate align {folder / CALIBRATION} --floor {folder} -o FILE.toml`"
    if likely.axis == UP_AXES[0]:
        return f"Tracking assumes that z points up: make such a world with {align}."
    seen = "" if likely.sure else ", unless the person's shape speaks for z"
    return (
        f"Tracking takes {likely.axis} as up{seen} (parameter up_axis); results stay in this "
        f"world. The 3-D view, fits to clicks and references count on z up: for that, run {align}."
    )


def _check_gaze(recording: Recording, *, upright: bool) -> Generator[Finding, None, bool]:
    """Findings about rotations; whether the rig is wrong. `upright`: z should point up."""
    cameras = view_cameras(recording)
    turns = {view.name: view.display_rotation for view in recording.views if upright}
    likely = up_of_cameras(recording)
    world = Upright(likely.axis if likely.sure else UP_AXES[0])
    if len(cameras) < _LEAST_VIEWS:
        for name, turn in turns.items():
            camera = cameras.get(name)
            if camera is None or _is_upright(camera, turn, world):
                continue
            fits = [way for way, to in _WAYS.items() if _is_upright(to(camera), turn, world)]
            if fits:  # a mistake of conversion that is seen often
                what = f"view {name} {_NOT_UPRIGHT.format(axis=world.axis)}"
                way = f"It would be if it were {fits[0]}: x_camera = R x_world + t."
                where = f"{CALIBRATION}, camera {camera.name}, rotation"
                yield Finding("warning", where, what, f"{way} Check its display_rotation, too.")
        return False
    misfits = _misfits(cameras, turns)
    if len(misfits) > len(cameras) // 2 or at_one_place(cameras):
        for way, change in _WAYS.items():
            changed = {name: change(camera) for name, camera in cameras.items()}
            if not at_one_place(changed) and not _misfits(changed, turns):
                what = f"the cameras only look at a common place, upright, if they are {way}"
                remedy = "They must map the world to the camera: x_camera = R x_world + t."
                correction = _transposition(way, tuple(cameras_of_views(recording)))
                where = f"{CALIBRATION}, rotation and translation"
                yield Finding("error", where, what, remedy, correction)
                return True
    misfits = _misfits(cameras, turns, world)
    for name, fault in misfits.items():
        camera = cameras[name]
        others = {way: {**cameras, name: change(camera)} for way, change in _WAYS.items()}
        fits = [way for way, those in others.items() if not _misfits(those, turns, world)]
        remedy, correction = _CHECK_PLACE, None
        if fits:
            remedy = f"It would fit if it were {fits[0]}: x_camera = R x_world + t."
            correction = _transposition(fits[0], recording.view(name).cameras())
        where = f"{CALIBRATION}, camera {camera.name}, rotation"
        yield Finding("warning", where, f"view {name} {fault}", remedy, correction)
    return False


def transposed(camera: Camera) -> Camera:
    """The camera with its rotation transposed."""
    old = camera.camera_from_world
    return replace(camera, camera_from_world=RigidTransform(old.rotation.T, old.translation))


def inverted(camera: Camera) -> Camera:
    """The camera with rotation and translation inverted."""
    return replace(camera, camera_from_world=camera.camera_from_world.inverse())


_TRANSPOSED = "transposed (rotations only)"
_WAYS: dict[str, Callable[[Camera], Camera]] = {_TRANSPOSED: transposed, "inverted": inverted}
"""Mistakes of conversion that are seen often."""


def _transposition(way: str, cameras: tuple[str, ...]) -> Correction | None:
    return Correction("transpose", cameras) if way == _TRANSPOSED else None


def at_one_place(cameras: Cameras) -> bool:
    """Whether cameras stand nearly at one point, seen from the origin."""
    places = np.array([camera.position_world for camera in cameras.values()])
    size = float(np.linalg.norm(places, axis=1).max())
    return bool(np.ptp(places, axis=0).max() < 0.02 * max(size, 1e-9))


def _misfits(cameras: Cameras, turns: Mapping[str, int], world: Upright = Z_UP) -> dict[str, str]:
    """Faults of views that do not fit the others, by view name.

    `turns` are the display rotations of those in which what is up in the `world` should be up.
    """
    found = {}
    for name, camera in cameras.items():
        others = {other: c for other, c in cameras.items() if other != name}
        if not _shows(camera, common_centre(cameras)) and not _shows(camera, common_centre(others)):
            found[name] = "does not look towards the place that the other views look at"
        elif name in turns and not _is_upright(camera, turns[name], world):
            found[name] = _NOT_UPRIGHT.format(axis=world.axis)
    return found


def common_centre(cameras: Cameras) -> FloatArray:
    """Place (3,) that the optical axes of most pairs of cameras come near; NaN where none."""
    meetings = []
    for a, b in combinations(cameras.values(), 2):
        origins = np.array([a.position_world, b.position_world])
        axes = np.array([a.camera_from_world.rotation[2], b.camera_from_world.rotation[2]])
        if abs(axes[0] @ axes[1]) > np.cos(np.radians(10)):
            # Cameras opposite each other look at what is half way between them.
            meetings.append(origins.mean(axis=0))
        else:
            meetings.append(nearest_to_rays(origins, axes))
    return np.asarray(np.median(meetings, axis=0), dtype=np.float64)


def _shows(camera: Camera, point: FloatArray) -> bool:
    ideal = replace(camera, distortions=np.zeros(4), fisheye=False)
    place = ideal.project(point) / (camera.width, camera.height)
    return bool(np.all((place > -_MARGIN) & (place < 1 + _MARGIN)))


def _is_upright(camera: Camera, turn: int, world: Upright) -> bool:
    """Whether up in the world is up in the image turned by `turn` degrees, or seen end on."""
    x, y, z = camera.camera_from_world.rotation @ world.up
    if abs(z) > _STEEP:
        return True
    angle = np.radians(turn)
    down = x * np.sin(angle) + y * np.cos(angle)
    return bool(-down > _LEAST_UPRIGHT * np.hypot(x, y))

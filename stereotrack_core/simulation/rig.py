"""Options of a simulated recording, its cameras and their sensors."""

from dataclasses import dataclass

import cv2
import numpy as np

from stereotrack_core.arrays import Float32Array, FloatArray, ImageArray
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.parameters import ParameterGroup, parameter

_SCENE, _RIG, _SENSOR = "Scene", "Cameras", "Sensor"


@dataclass(frozen=True)
class SceneOptions(ParameterGroup):
    """Choices for ``simulate``, each declared once."""

    fps: float = parameter(10.0, _SCENE, (1.0, 120.0), unit="1/s")("Frame sets per second.")
    pace: float = parameter(1.0, _SCENE, (0.05, 3.0))(
        "Speed of the motions; 1 is fast, 0.3 is close to the thesis's recordings."
    )
    t_pose_first: bool = parameter(True, _SCENE)("Start with a T pose facing north.")
    clothes: str = parameter("strong", _SCENE, choices=("strong", "striped", "plain"))(
        "Texture contrast of the clothes."
    )
    furnished: bool = parameter(True, _SCENE)("Furniture in the room.")
    stature: float = parameter(0.0, _SCENE, (0.0, 2.3), unit="m")(
        "Height of the person, who is scaled to it; 0 is the named person's own."
    )
    second_person: bool = parameter(False, _SCENE)(
        "A second person occasionally walks through the background."
    )
    shadow: float = parameter(0.0, _SCENE, (0.0, 1.0))(
        "Share of the light that people keep from floor, walls and themselves."
    )
    background_images: bool = parameter(True, _SCENE)(
        "Provide a background image for every camera."
    )
    width: int = parameter(640, _RIG, (64, 4096), unit="px")("Width of the images.")
    height: int = parameter(480, _RIG, (48, 4096), unit="px")("Height of the images.")
    focal: float = parameter(400.0, _RIG, (50.0, 5000.0), unit="px")(
        "Focal length; 267 is the 2 mm lens of the thesis."
    )
    camera_distance: float = parameter(3.0, _RIG, (1.0, 4.2), unit="m")(
        "Horizontal distance of the cameras from the centre of the room."
    )
    camera_height: float = parameter(2.1, _RIG, (0.3, 2.9), unit="m")("Height of the cameras.")
    colour: bool = parameter(False, _SENSOR)(
        "Colour images, with slightly different colours in each camera."
    )
    exposure: float = parameter(0.0, _SENSOR, (0.0, 0.9))(
        "Swing of each camera's exposure within ten seconds, as a share of it."
    )
    blur: float = parameter(0.6, _SENSOR, (0.0, 5.0), unit="px")("Lens blur, standard deviation.")
    noise: float = parameter(2.5, _SENSOR, (0.0, 50.0))(
        "Sensor noise, standard deviation in grey levels."
    )
    lossless: bool = parameter(False, _SENSOR)("Lossless videos, several times larger.")


COMPASS = {"N": (0.0, 1.0), "O": (1.0, 0.0), "S": (0.0, -1.0), "W": (-1.0, 0.0)}
"""Where each view stands: east, north."""

_LOOK_AT_HEIGHT = 1.02
_BASELINE = np.array([0.12, 0.0, 0.0])  # metres from the right lens to the left one


def view_names(views: str) -> tuple[str, ...]:
    """Names in ``NOSW``, ``NS`` or ``N+S``; raises :class:`InputError` for others."""
    names = tuple(views.replace("+", ""))
    if not names or len(set(names)) < len(names) or not set(names) <= set(COMPASS):
        remedy = "Use some of N, O, S and W, each at most once, for example NS."
        raise InputError(f"the views {views!r} are not possible", "--views", remedy)
    return names


def rig(views: tuple[str, ...], options: SceneOptions, seed: int) -> dict[str, Camera]:
    """The cameras ``N_left``, ``N_right`` ... by name.

    The right camera of a pair stands at the view's place and looks at the middle of the
    room; the left one is beside it. Places vary by some centimetres with the seed, for each
    view the same whichever others there are.
    """
    cameras, f, size = {}, options.focal, (options.width, options.height)
    c_x, c_y = (np.array(size) - 1) / 2
    matrix = np.array([[f, 0, c_x], [0, f, c_y], [0, 0, 1.0]])
    for view in views:
        right = _placed(view, options, np.random.default_rng([seed, 1, ord(view)]))
        left = RigidTransform(right.rotation, right.translation + _BASELINE)
        for name, pose in ((f"{view}_left", left), (f"{view}_right", right)):
            cameras[name] = Camera(name, *size, matrix, np.zeros(5), False, pose)
    return cameras


def _placed(view: str, options: SceneOptions, rng: np.random.Generator) -> RigidTransform:
    east, north = COMPASS[view]
    distance = options.camera_distance + rng.uniform(-0.12, 0.12)
    aside = rng.uniform(-0.15, 0.15)
    ground = east * distance + north * aside, north * distance - east * aside
    place = np.array([*ground, options.camera_height + rng.uniform(-0.08, 0.08)])
    target = np.array([*rng.uniform(-0.06, 0.06, 2), _LOOK_AT_HEIGHT])
    rotation = looking_at(place, target)
    return RigidTransform(rotation, -rotation @ place)


def looking_at(place: FloatArray, target: FloatArray) -> FloatArray:
    """Rotation (3, 3) from the world to a level camera that looks from a place to a target."""
    forward = target - place
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(forward, right), forward])


_LUMINANCE = np.array([[0.299, 0.587, 0.114]])
_SWING_SECONDS = 10.0
_OUT_OF_STEP = 2.4  # radians between the exposures of two cameras


@dataclass(frozen=True, eq=False)
class Sensor:
    """One camera's sensor."""

    response: FloatArray
    """(c, 3) makes channels (grey, or blue, green, red) of red, green and blue light; `blur` and
    `noise` are standard deviations in pixels and grey levels. The noise of a frame depends on
    nothing but `stream`, the seed and the number of the camera."""
    gain: float
    blur: float
    noise: float
    stream: tuple[int, int]
    swing: float = 0.0  # share of the gain
    turn: float = 0.0  # radians of the swing in a frame

    def exposed(self, light: Float32Array, frame: int) -> ImageArray:
        """Picture (H, W) or (H, W, 3) of light (H, W, c); frame -1 is the empty scene."""
        phase = self.turn * frame + _OUT_OF_STEP * self.stream[1]
        swing = 0.0 if frame < 0 else self.swing * np.sin(phase)
        values: Float32Array = light * np.float32(self.gain * (1.0 + swing))
        if self.blur > 0:
            blurred = cv2.GaussianBlur(values, (0, 0), self.blur)
            values = np.asarray(blurred, np.float32).reshape(light.shape)
        rng = np.random.default_rng([*self.stream, frame + 1])
        values = values + np.float32(self.noise) * rng.standard_normal(light.shape, np.float32)
        picture: ImageArray = np.clip(np.rint(values), 0, 255).astype(np.uint8)
        return picture[..., 0] if picture.shape[2] == 1 else picture


def sensor(options: SceneOptions, seed: int, camera: str) -> Sensor:
    """The sensor of the camera of that name; left ones are brighter."""
    number = int.from_bytes(camera.encode()[:1], "big") * 2 + camera.endswith("left")
    rng = np.random.default_rng([seed, 2, number])
    response = _LUMINANCE
    if options.colour:
        mixing = np.eye(3) * (1 + 0.06 * rng.normal(size=3)) + rng.uniform(0, 0.06, (3, 3))
        # White balance takes most of the cast: without it one view was pink and another green.
        response = (mixing / mixing.sum(axis=1, keepdims=True) ** 0.8)[::-1]
    gain = 1.04 if camera.endswith("left") else 1.0
    turn = 2 * np.pi / (_SWING_SECONDS * options.fps)
    own = options.blur, options.noise, (seed, number), options.exposure, turn
    return Sensor(response, gain, *own)

"""What can be chosen about a simulated recording, its stereo cameras, sensors, disturbances."""

import zlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import cv2
import numpy as np

from stereotrack_core.arrays import Float32Array, FloatArray, ImageArray
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.parameters import ParameterGroup, parameter
from stereotrack_core.recording.description import Cameras

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
    background_images: bool = parameter(True, _SCENE)(
        "Provide a background image for every camera."
    )
    kind: str = parameter("stereo", _RIG, choices=("stereo", "depth"))(
        "Stereo cameras, or structured-light depth cameras with a mask of the person."
    )
    width: int = parameter(640, _RIG, (64, 4096), unit="px")("Width of the images.")
    height: int = parameter(480, _RIG, (48, 4096), unit="px")("Height of the images.")
    focal: float = parameter(400.0, _RIG, (50.0, 5000.0), unit="px")(
        "Focal length; 267 is the 2 mm lens of the thesis."
    )
    baseline: float = parameter(0.12, _RIG, (0.01, 1.0), unit="m")(
        "Distance between the lenses of a stereo camera."
    )
    camera_distance: float = parameter(3.0, _RIG, (1.0, 4.2), unit="m")(
        "Horizontal distance of the cameras from the centre of the room."
    )
    camera_height: float = parameter(2.1, _RIG, (0.3, 2.9), unit="m")("Height of the cameras.")
    distorted: bool = parameter(False, _RIG)("Lens distortion, slightly different for each lens.")
    askew: bool = parameter(False, _RIG)(
        "Stereo cameras whose lenses are neither parallel nor identical."
    )
    colour: bool = parameter(False, _SENSOR)(
        "Colour images, with slightly different colours in each camera."
    )
    blur: float = parameter(0.6, _SENSOR, (0.0, 5.0), unit="px")("Lens blur, standard deviation.")
    noise: float = parameter(2.5, _SENSOR, (0.0, 50.0))(
        "Sensor noise, standard deviation in grey levels."
    )
    lossless: bool = parameter(False, _SENSOR)("Lossless videos, several times larger.")


COMPASS = {"N": (0.0, 1.0), "O": (1.0, 0.0), "S": (0.0, -1.0), "W": (-1.0, 0.0)}
"""Where each view stands: east, north."""

_LOOK_AT_HEIGHT = 1.02
_DISTORTION = np.array([-0.12, 0.03, 0.0006, -0.0004, 0.0])


def view_names(views: str) -> tuple[str, ...]:
    """Names in ``NOSW``, ``NS`` or ``N+S``; raises :class:`InputError` for others."""
    names = tuple(views.replace("+", ""))
    if not names or len(set(names)) < len(names) or not set(names) <= set(COMPASS):
        remedy = "Use some of N, O, S and W, each at most once, for example NS."
        raise InputError(f"the views {views!r} are not possible", "--views", remedy)
    return names


def rig(views: tuple[str, ...], options: SceneOptions, seed: int) -> dict[str, Camera]:
    """The cameras of the kind that the options say; depth cameras have their view's name."""
    cameras = stereo_rig(views, options, seed)
    if options.kind == "stereo":
        return cameras
    return {view: replace(cameras[f"{view}_right"], name=view) for view in views}


def stereo_rig(views: tuple[str, ...], options: SceneOptions, seed: int) -> dict[str, Camera]:
    """The cameras ``N_left``, ``N_right`` ... by name.

    The right camera of a pair stands at the view's place and looks at the middle of the
    room; the left one is beside it. Places vary by some centimetres with the seed, for each
    view the same whichever others there are.
    """
    cameras = {}
    for view in views:
        rng = np.random.default_rng([seed, 1, ord(view)])
        right = _placed(view, options, rng)
        shift = np.array([options.baseline, 0.0, 0.0])
        left = RigidTransform(right.rotation, right.translation + shift)
        if options.askew:
            turn = rotation_from_vector(np.radians(rng.normal(0, [0.5, 1.4, 0.7])))
            left = RigidTransform(turn @ left.rotation, turn @ left.translation)
        for side, pose in (("left", left), ("right", right)):
            name, matrix = f"{view}_{side}", _matrix(options, rng)
            bent = _DISTORTION * (1 + 0.1 * rng.normal(size=5))
            distortions = bent if options.distorted else np.zeros(5)
            size = options.width, options.height
            cameras[name] = Camera(name, *size, matrix, distortions, False, pose)
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


def _matrix(options: SceneOptions, rng: np.random.Generator) -> FloatArray:
    middle = np.array([(options.width - 1) / 2, (options.height - 1) / 2])
    focal = np.full(2, options.focal)
    deviation = rng.normal(size=4)
    if options.askew or options.distorted:
        focal = focal * (1 + 0.006 * deviation[:2])
        middle = middle + 0.008 * options.width * deviation[2:]
    return np.array([[focal[0], 0, middle[0]], [0, focal[1], middle[1]], [0, 0, 1.0]])


_LUMINANCE = np.array([[0.299, 0.587, 0.114]])


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

    def exposed(self, light: Float32Array, frame: int) -> ImageArray:
        """Picture (H, W) or (H, W, 3) of light (H, W, c); frame -1 is the empty scene."""
        values: Float32Array = light * np.float32(self.gain)
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
    return Sensor(response, gain, options.blur, options.noise, (seed, number))


@dataclass(frozen=True)
class Kind:
    """A kind of disturbance: default, least and greatest strength, and what the strength means."""

    default: float
    least: float
    most: float
    description: str
    whole: bool = False  # only whole numbers are possible


KINDS: dict[str, Kind] = {
    "gain": Kind(1.1, 0.05, 5.0, "factor of the light against the picture of the empty scene"),
    "exposure": Kind(0.15, 0.0, 0.9, "swing of each camera's exposure within ten seconds"),
    "gamma": Kind(0.8, 0.2, 5.0, "exponent of the brightness"),
    "noise": Kind(8.0, 0.0, 50.0, "grey levels of noise added in the video"),
    "flicker": Kind(0.08, 0.0, 0.9, "greatest random change of brightness from frame to frame"),
    "shadow": Kind(0.3, 0.0, 1.0, "share of the light that people keep from floor and walls"),
    "shade": Kind(0.25, 0.0, 1.0, "darkness of a shade with a soft edge that wanders"),
    "passer": Kind(3.6, 1.5, 4.0, "metres from the middle of the room where another walks past"),
    "shake": Kind(1.0, 0.0, 20.0, "pixels by which each stereo pair vibrates"),
    "bump": Kind(1.0, 0.0, 20.0, "degrees by which the first view is turned from half time on"),
    "rows": Kind(0.7, -20.0, 20.0, "pixels by which the left images are too low"),
    "blur": Kind(1.5, 0.0, 10.0, "pixels of blur added in the video"),
    "compress": Kind(35, 0, 51, "crf of the H.264 videos", whole=True),
    "late": Kind(1, 1, 10, "frames by which the last view is late", whole=True),
}
"""All kinds by name, in the order in which messages list them."""


def kinds_text() -> str:
    """One clause per kind: name, default and meaning."""
    return "; ".join(
        f"{name}={kind.default:g} ({kind.description})" for name, kind in KINDS.items()
    )


def check_strengths(strengths: Mapping[str, float]) -> None:
    """Raise InputError for an unknown kind or an impossible strength."""
    for name, strength in strengths.items():
        if name not in KINDS:
            raise _refusal(f"there is no disturbance {name!r}")
        kind = KINDS[name]
        fits = kind.least <= strength <= kind.most  # false for NaN
        if not fits or (kind.whole and strength != round(strength)):
            raise _refusal(f"the strength {strength:g} of {name!r} is not possible")


def _refusal(what: str) -> InputError:
    possible = ", ".join(
        f"{name} ({kind.least:g} to {kind.most:g}{', whole' if kind.whole else ''})"
        for name, kind in KINDS.items()
    )
    return InputError(what, "--disturb", f"There are, with strengths: {possible}.")


def parsed_disturbances(text: str) -> dict[str, float]:
    """Read ``exposure=0.3,shadow``; without a strength the kind's default is meant.

    Raises InputError for an unknown kind, an impossible strength, or a kind given twice.
    """
    result: dict[str, float] = {}
    for part in filter(None, (part.strip() for part in text.split(","))):
        name, equals, strength = (word.strip() for word in part.partition("="))
        if name in result:
            raise _refusal(f"{text!r} names a disturbance twice")
        try:
            result[name] = float(strength) if equals else KINDS[name].default
        except KeyError:
            raise _refusal(f"there is no disturbance {name!r}") from None
        except ValueError:
            raise _refusal(f"{strength!r} is no strength of {name!r}") from None
    check_strengths(result)
    return result


_SWING_SECONDS = 10.0


@dataclass(frozen=True, eq=False)
class Disturber:
    """The disturbances of one recording; pictures depend on nothing but them and the seed."""

    strengths: Mapping[str, float]  # strength by kind, of the chosen kinds
    seed: int
    fps: float
    frames: int

    def instant(self, camera: str, cameras: Iterable[str], frame: int) -> int:
        """Frame whose scene the camera shows; an earlier one if its view is late."""
        last = _view(camera) == _view(list(cameras)[-1])
        return max(0, frame - int(self.strengths.get("late", 0)) * last)

    def turned(self, cameras: Cameras) -> dict[str, Camera]:
        """Cameras of the view that is bumped, as they stand afterwards; the pair stays rigid."""
        if "bump" not in self.strengths:
            return {}
        view = _view(next(iter(cameras)))
        pair = {name: camera for name, camera in cameras.items() if _view(name) == view}
        base = pair[f"{view}_right"].camera_from_world
        angle = self.rng("bump").uniform(0, 2 * np.pi)
        axis = np.array([np.sin(angle), np.cos(angle), 0.0])
        turn = rotation_from_vector(np.radians(self.strengths["bump"]) * axis)
        moved = base.inverse() @ RigidTransform(turn, np.zeros(3)) @ base
        places = {name: one.camera_from_world @ moved for name, one in pair.items()}
        return {name: replace(pair[name], camera_from_world=at) for name, at in places.items()}

    def sensor(self, sensor: Sensor) -> Sensor:
        """The sensor as it takes the video; that of the empty scene's picture is undisturbed."""
        blur = float(np.hypot(sensor.blur, self.strengths.get("blur", 0.0)))
        noise = float(np.hypot(sensor.noise, self.strengths.get("noise", 0.0)))
        return replace(sensor, blur=blur, noise=noise)

    def on_sensor(self, camera: str, light: Float32Array, frame: int) -> Float32Array:
        """The light (H, W, c) that the sensor is to record; frame -1 is the empty scene."""
        light = self._shifted(camera, light, frame)
        if frame < 0:
            return light
        light = light * self._brightness(camera, frame)
        if "gamma" in self.strengths:
            bent = 255 * (np.maximum(light, 0) / 255) ** self.strengths["gamma"]
            light = bent.astype(np.float32)
        return light

    def _brightness(self, camera: str, frame: int) -> np.float32:
        given, seconds = self.strengths, frame / self.fps
        factor = given.get("gain", 1.0)
        if "exposure" in given:
            phase = self.rng("exposure", camera).uniform(0, 2 * np.pi)
            factor *= 1 + given["exposure"] * np.sin(2 * np.pi * seconds / _SWING_SECONDS + phase)
        if "flicker" in given:
            factor *= 1 + given["flicker"] * self.rng("flicker", _view(camera), frame).uniform(
                -1, 1
            )
        return np.float32(factor)

    def _shifted(self, camera: str, light: Float32Array, frame: int) -> Float32Array:
        shift = np.zeros(2)
        if "shake" in self.strengths and frame >= 0:
            shift += self.strengths["shake"] * self.rng("shake", _view(camera), frame).normal(
                size=2
            )
        if camera.endswith("left"):
            shift[1] += self.strengths.get("rows", 0.0)
        if not shift.any():
            return light
        moved = cv2.warpAffine(
            light, np.column_stack([np.eye(2), shift]), light.shape[1::-1],
            flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE,
        )  # fmt: skip
        return np.asarray(moved, np.float32).reshape(light.shape)

    def rng(self, *key: object) -> np.random.Generator:
        """Random numbers for a purpose, the same in every program."""
        return np.random.default_rng([self.seed, zlib.crc32(repr(key).encode())])


def _view(camera: str) -> str:
    return camera.partition("_")[0]


UNDISTURBED = Disturber({}, 0, 1.0, 1)

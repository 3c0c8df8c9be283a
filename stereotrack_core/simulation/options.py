"""What can be chosen about a simulated recording."""

from __future__ import annotations

from dataclasses import dataclass

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
    second_person: bool = parameter(False, _SCENE)(
        "A second person occasionally walks through the background."
    )
    background_images: bool = parameter(True, _SCENE)(
        "Provide a background image for every camera."
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
    gain_difference: float = parameter(0.04, _SENSOR, (-0.5, 1.0))(
        "Fraction by which the left camera is brighter."
    )
    blur: float = parameter(0.6, _SENSOR, (0.0, 5.0), unit="px")("Lens blur, standard deviation.")
    noise: float = parameter(2.5, _SENSOR, (0.0, 50.0))(
        "Sensor noise, standard deviation in grey levels."
    )
    lossless: bool = parameter(False, _SENSOR)("Lossless videos, several times larger.")

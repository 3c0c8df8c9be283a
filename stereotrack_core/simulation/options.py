"""What can be chosen about a simulated recording."""

from __future__ import annotations

from dataclasses import dataclass

from stereotrack_core.parameters import ParameterGroup, parameter

_SCENE, _RIG, _SENSOR = "Scene", "Cameras", "Sensor"


@dataclass(frozen=True)
class SceneOptions(ParameterGroup):
    """Choices for ``simulate``, each declared once."""

    fps: float = parameter(
        10.0, "Frame sets per second.", group=_SCENE, unit="1/s", minimum=1.0, maximum=120.0
    )
    pace: float = parameter(
        1.0, "Speed of the motions; 1 is fast, 0.3 is close to the thesis's recordings.",
        group=_SCENE, minimum=0.05, maximum=3.0,
    )  # fmt: skip
    t_pose_first: bool = parameter(True, "Start with a T pose facing north.", group=_SCENE)
    clothes: str = parameter(
        "strong",
        "Texture contrast of the clothes.",
        group=_SCENE,
        choices=("strong", "striped", "plain"),
    )
    furnished: bool = parameter(True, "Furniture in the room.", group=_SCENE)
    second_person: bool = parameter(
        False, "A second person occasionally walks through the background.", group=_SCENE
    )
    background_images: bool = parameter(
        True, "Provide a background image for every camera.", group=_SCENE
    )
    width: int = parameter(
        640, "Width of the images.", group=_RIG, unit="px", minimum=64, maximum=4096
    )
    height: int = parameter(
        480, "Height of the images.", group=_RIG, unit="px", minimum=48, maximum=4096
    )
    focal: float = parameter(
        400.0, "Focal length; 267 is the 2 mm lens of the thesis.", group=_RIG, unit="px",
        minimum=50.0, maximum=5000.0,
    )  # fmt: skip
    baseline: float = parameter(
        0.12, "Distance between the lenses of a stereo camera.", group=_RIG, unit="m",
        minimum=0.01, maximum=1.0,
    )  # fmt: skip
    camera_distance: float = parameter(
        3.0, "Horizontal distance of the cameras from the centre of the room.", group=_RIG,
        unit="m", minimum=1.0, maximum=4.2,
    )  # fmt: skip
    camera_height: float = parameter(
        2.1, "Height of the cameras.", group=_RIG, unit="m", minimum=0.3, maximum=2.9
    )
    distorted: bool = parameter(
        False, "Lens distortion, slightly different for each lens.", group=_RIG
    )
    askew: bool = parameter(
        False, "Stereo cameras whose lenses are neither parallel nor identical.", group=_RIG
    )
    colour: bool = parameter(
        False, "Colour images, with slightly different colours in each camera.", group=_SENSOR
    )
    gain_difference: float = parameter(
        0.04,
        "Fraction by which the left camera is brighter.",
        group=_SENSOR,
        minimum=-0.5,
        maximum=1.0,
    )
    blur: float = parameter(
        0.6, "Lens blur, standard deviation.", group=_SENSOR, unit="px",
        minimum=0.0, maximum=5.0,
    )  # fmt: skip
    noise: float = parameter(
        2.5, "Sensor noise, standard deviation in grey levels.", group=_SENSOR,
        minimum=0.0, maximum=50.0,
    )  # fmt: skip
    lossless: bool = parameter(False, "Lossless videos, several times larger.", group=_SENSOR)

"""What can be tuned on the way from images to the cloud."""

from __future__ import annotations

from dataclasses import dataclass

from stereotrack_core.parameters import ParameterGroup, parameter

_MATCH = "Stereo matching"
_BACKGROUND = "Background"
_VOLUME = "Working volume"
_CLOUD = "Cloud"


@dataclass(frozen=True)
class DepthParameters(ParameterGroup):
    """Rectified matching, background, working volume and outliers (2.1, 3.1).

    Disparities in pixels are parallaxes f b / z: those of a pair with equal principal points.
    The thesis gives no values for this part of the chain beyond the kind of each stage.
    """

    matcher: str = parameter(
        "bm",
        "Block matching, or semi-global matching. The latter finds more points on clothes with "
        "little texture, but on strong texture is biased towards whole-pixel disparities (by up "
        "to 0.2 px).",
        group=_MATCH,
        choices=("bm", "sgbm"),
        thesis="bm",
    )
    disparity_minimum: int = parameter(
        1, "Smallest disparity searched.", group=_MATCH, unit="px", minimum=0, maximum=512
    )
    disparity_count: int = parameter(
        64,
        "Number of disparities searched, rounded up to a multiple of 16.",
        group=_MATCH,
        unit="px",
        minimum=16,
        maximum=512,
    )
    disparity_from_volume: bool = parameter(
        True,
        "Discard disparities closer to the camera than the working volume.",
        group=_MATCH,
        thesis=False,
    )
    match_window: int = parameter(
        11, "Side of the correlation window (odd).", group=_MATCH, unit="px", minimum=5, maximum=51
    )
    least_focal: float = parameter(
        400.0,
        "Images of clearly wider lenses are upsampled to this focal length before matching, at "
        "most to twice their size, because the matching window is too coarse for arms otherwise.",
        group=_MATCH,
        unit="px",
        minimum=0.0,
        maximum=4000.0,
        thesis=0.0,
    )
    low_pass: float = parameter(
        0.0,
        "Standard deviation of the low-pass filter before rectification; 0 disables it.",
        group=_MATCH,
        unit="px",
        minimum=0.0,
        maximum=5.0,
        thesis=0.8,
    )
    edge_images: bool = parameter(
        True,
        "Match horizontal derivatives, which are insensitive to differences in gain.",
        group=_MATCH,
        thesis=False,
    )
    match_texture: int = parameter(
        10,
        "Minimum texture in the window, as a sum over prefiltered pixels; 0 accepts all.",
        group=_MATCH,
        minimum=0,
        maximum=100000,
    )
    match_uniqueness: int = parameter(
        10,
        "Percentage by which the best match must beat the second best that is not its neighbour.",
        group=_MATCH,
        unit="%",
        minimum=0,
        maximum=100,
    )
    match_left_right: int = parameter(
        1,
        "Largest difference between right-to-left and left-to-right matching; -1 disables the "
        "check.",
        group=_MATCH,
        unit="px",
        minimum=-1,
        maximum=64,
        thesis=-1,
    )
    match_region: str = parameter(
        "changed",
        "Match the whole image, or only regions that differ from the background image (faster; "
        "elsewhere the disparity of the empty scene is used).",
        group=_MATCH,
        choices=("whole", "changed"),
        thesis="whole",
    )
    subpixel: str = parameter(
        "aligned",
        "Source of subpixel disparities: the matcher's parabola, which is biased towards whole "
        "pixels; or image alignment around every pixel that becomes a point, using only the "
        "person's pixels (needs the silhouette to exclude the background).",
        group=_MATCH,
        choices=("matcher", "aligned"),
        thesis="matcher",
    )
    speckle_size: int = parameter(
        60,
        "Remove foreground patches of up to this many pixels; 0 keeps all.",
        group=_MATCH,
        unit="px",
        minimum=0,
        maximum=100000,
    )
    speckle_range: float = parameter(
        1.0,
        "Neighbouring pixels whose disparities differ by more than this belong to different "
        "patches.",
        group=_MATCH,
        unit="px",
        minimum=0.0625,
        maximum=64.0,
    )
    background_mode: str = parameter(
        "percentile",
        "How the background is learned where the recording has no background images: running "
        "average as in the thesis, low percentile over the recording, or none.",
        group=_BACKGROUND,
        choices=("average", "percentile", "none"),
        thesis="average",
    )
    background_empty_scene: bool = parameter(
        True, "Use background images where the recording has them.", group=_BACKGROUND
    )
    background_threshold: float = parameter(
        1.0,
        "Foreground is nearer than the background by more than s (3.3).",
        group=_BACKGROUND,
        unit="px",
        minimum=0.0,
        maximum=64.0,
    )
    background_rate: float = parameter(
        0.05,
        "Learning rate alpha_d of the average disparity.",
        group=_BACKGROUND,
        minimum=0.0,
        maximum=1.0,
    )
    background_validity_rate: float = parameter(
        0.05,
        "Learning rate alpha_g of the frequency of valid disparities.",
        group=_BACKGROUND,
        minimum=0.0,
        maximum=1.0,
    )
    background_valid_above: float = parameter(
        0.5,
        "The background of a pixel is known if its disparity was valid more often than this.",
        group=_BACKGROUND,
        minimum=0.0,
        maximum=1.0,
    )
    background_percentile: float = parameter(
        5.0,
        "Percentile of a pixel's disparities used as background.",
        group=_BACKGROUND,
        unit="%",
        minimum=0.0,
        maximum=100.0,
    )
    background_samples: int = parameter(
        40,
        "Number of frames, spread over the recording, from which the background is learned in "
        "advance.",
        group=_BACKGROUND,
        minimum=1,
        maximum=1000,
    )
    background_doubt: bool = parameter(
        True,
        "Use the silhouette (difference from the background image) as evidence: background "
        "disparities inside it are discarded.",
        group=_BACKGROUND,
        thesis=False,
    )
    outlines: bool = parameter(
        True,
        "Find the sharp silhouette contour of the person in the images as a measurement for the "
        "tracker. Needs a background image or a mask.",
        group=_BACKGROUND,
        thesis=False,
    )
    halo_trim: str = parameter(
        "outline",
        "Remove the border that block matching adds around the person: never; where the image "
        "looks like the background image; or outside the sharp silhouette (border points remain "
        "available for the arm search, but are not measurements).",
        group=_BACKGROUND,
        choices=("none", "picture", "outline"),
        thesis="none",
    )
    halo_contrast: int = parameter(
        6,
        "Intensity difference above which a pixel differs from the background image.",
        group=_BACKGROUND,
        minimum=1,
        maximum=255,
    )
    volume_centre_x: float = parameter(0.0, "Centre of the volume, east.", group=_VOLUME, unit="m")
    volume_centre_y: float = parameter(0.0, "Centre of the volume, north.", group=_VOLUME, unit="m")
    volume_bottom: float = parameter(0.0, "Lower end of the volume.", group=_VOLUME, unit="m")
    volume_x: float = parameter(
        3.6, "Extent of the volume, west to east.", group=_VOLUME, unit="m", minimum=0.1
    )
    volume_y: float = parameter(
        3.6, "Extent of the volume, south to north.", group=_VOLUME, unit="m", minimum=0.1
    )
    volume_z: float = parameter(2.4, "Height of the volume.", group=_VOLUME, unit="m", minimum=0.1)
    pixel_step: int = parameter(
        2,
        "Use every n-th row and column of pixels as points.",
        group=_CLOUD,
        unit="px",
        minimum=1,
        maximum=16,
    )
    outlier_neighbours: int = parameter(
        8,
        "Number k of nearest neighbours that must be close; 0 keeps all points.",
        group=_CLOUD,
        minimum=0,
        maximum=200,
    )
    outlier_distance: float = parameter(
        60.0,
        "A point is removed if any of its k nearest neighbours is farther away than this.",
        group=_CLOUD,
        unit="mm",
        minimum=0.1,
        maximum=10000.0,
    )
    outlier_repeat: bool = parameter(
        False,
        "Repeat the outlier removal until nothing changes.",
        group=_CLOUD,
        thesis=True,
    )

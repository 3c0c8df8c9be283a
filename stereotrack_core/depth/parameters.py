"""What can be tuned on the way from images to the cloud."""

from dataclasses import dataclass

from stereotrack_core.geometry.upright import UP_AXES, Upright
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

    matcher: str = parameter("bm", _MATCH, choices=("bm", "sgbm"), thesis="bm")(
        "Block matching, or semi-global matching. The latter finds more points on clothes with "
        "little texture, but on strong texture is biased towards whole-pixel disparities (by up "
        "to 0.2 px)."
    )
    disparity_minimum: int = parameter(1, _MATCH, (0, 512), unit="px")(
        "Smallest disparity searched."
    )
    disparity_count: int = parameter(64, _MATCH, (16, 512), unit="px")(
        "Number of disparities searched, rounded up to a multiple of 16."
    )
    match_wide: str = parameter(
        "coarse_to_fine", _MATCH, choices=("full", "coarse_to_fine"), thesis="full"
    )(
        "How 192 and more disparities are searched: all of them everywhere, or only those that "
        "reduced images show around each part of the image, which is several times as fast."
    )
    disparity_from_volume: bool = parameter(True, _MATCH, thesis=False)(
        "Discard disparities closer to the camera than the working volume."
    )
    match_window: int = parameter(11, _MATCH, (5, 51), unit="px")(
        "Side of the correlation window (odd)."
    )
    least_focal: float = parameter(400.0, _MATCH, (0.0, 4000.0), unit="px", thesis=0.0)(
        "Images of clearly wider lenses are upsampled to this focal length before matching, at "
        "most to twice their size, because the matching window is too coarse for arms otherwise. "
        "Stated for people at 3 m; the default grows with the distance of people beyond 4 m."
    )
    low_pass: float = parameter(0.0, _MATCH, (0.0, 5.0), unit="px", thesis=0.8)(
        "Standard deviation of the low-pass filter before rectification. 0: 1 px where noise of "
        "more than 3 grey levels is measured, else none."
    )
    align_rows: bool = parameter(True, _MATCH, thesis=False)(
        "Measure by how much of a pixel left images lie too low, and take that off."
    )
    edge_images: bool = parameter(True, _MATCH, thesis=False)(
        "Match horizontal derivatives, which are insensitive to differences in gain."
    )
    match_uniqueness: int = parameter(10, _MATCH, (0, 100), unit="%")(
        "Percentage by which the best match must beat the second best that is not its neighbour."
    )
    match_left_right: int = parameter(1, _MATCH, (-1, 64), unit="px", thesis=-1)(
        "Largest difference between right-to-left and left-to-right matching; -1 disables the "
        "check."
    )
    match_region: str = parameter("changed", _MATCH, choices=("whole", "changed"), thesis="whole")(
        "Match the whole image, or only regions that differ from the background image (faster; "
        "elsewhere the disparity of the empty scene is used)."
    )
    subpixel: str = parameter("aligned", _MATCH, choices=("matcher", "aligned"), thesis="matcher")(
        "Source of subpixel disparities: the matcher's parabola, which is biased towards whole "
        "pixels; or image alignment around every pixel that becomes a point, using only the "
        "person's pixels (needs the silhouette to exclude the background)."
    )
    speckle_size: int = parameter(60, _MATCH, (0, 100000), unit="px")(
        "Remove foreground patches of up to this many pixels; 0 keeps all."
    )
    background_mode: str = parameter(
        "percentile", _BACKGROUND, choices=("average", "percentile", "none"), thesis="average"
    )(
        "How the background is learned where the recording has no background images: running "
        "average as in the thesis, low percentile over the recording, or none."
    )
    background_empty_scene: bool = parameter(True, _BACKGROUND)(
        "Use background images where the recording has them."
    )
    background_threshold: float = parameter(1.0, _BACKGROUND, (0.0, 64.0), unit="px")(
        "Foreground is nearer than the background by more than s (3.3)."
    )
    background_rate: float = parameter(0.05, _BACKGROUND, (0.0, 1.0))(
        "Learning rate alpha_d of the average disparity."
    )
    background_validity_rate: float = parameter(0.05, _BACKGROUND, (0.0, 1.0))(
        "Learning rate alpha_g of the frequency of valid disparities."
    )
    background_percentile: float = parameter(5.0, _BACKGROUND, (0.0, 100.0), unit="%")(
        "Percentile of a pixel's disparities used as background."
    )
    silhouettes: bool = parameter(True, _BACKGROUND, thesis=False)(
        "Find the silhouette of the person in the images: its sharp contour is a measurement for "
        "the tracker, and background disparities inside it are discarded. Needs a background "
        "image or a mask."
    )
    halo_trim: str = parameter(
        "silhouette", _BACKGROUND, choices=("none", "picture", "silhouette"), thesis="none"
    )(
        "Remove the border that block matching adds around the person: never; where the image "
        "looks like the background image; or outside the sharp silhouette. Points there remain "
        "available for the arm search, but are not measurements."
    )
    volume_from_recording: bool = parameter(True, _VOLUME, thesis=False)(
        "If the cameras do not stand around the origin, place the volume around the person, and "
        "search as many disparities as this requires. Values that differ from the defaults are "
        "kept."
    )
    up_axis: str = parameter("auto", _VOLUME, choices=("auto", *UP_AXES), thesis="z")(
        "Axis of the world that points up: found from the cameras and the person (auto), or given. "
        "Results stay in the recording's world. The volume's east, north and height are counted in "
        "a world turned so that z points up."
    )
    volume_centre_x: float = parameter(0.0, _VOLUME, unit="m")("Centre of the volume, east.")
    volume_centre_y: float = parameter(0.0, _VOLUME, unit="m")("Centre of the volume, north.")
    volume_bottom: float = parameter(0.0, _VOLUME, unit="m")("Lower end of the volume.")
    volume_x: float = parameter(3.6, _VOLUME, (0.1, None), unit="m")(
        "Extent of the volume, west to east."
    )
    volume_y: float = parameter(3.6, _VOLUME, (0.1, None), unit="m")(
        "Extent of the volume, south to north."
    )
    volume_z: float = parameter(2.4, _VOLUME, (0.1, None), unit="m")("Height of the volume.")
    pixel_step: int = parameter(2, _CLOUD, (1, 16), unit="px")(
        "Use every n-th row and column of pixels as points."
    )
    outlier_neighbours: int = parameter(8, _CLOUD, (0, 200))(
        "Number k of nearest neighbours that must be close; 0 keeps all points."
    )
    outlier_distance: float = parameter(60.0, _CLOUD, (0.1, 10000.0), unit="mm")(
        "A point is removed if any of its k nearest neighbours is farther away than this."
    )
    outlier_repeat: bool = parameter(False, _CLOUD, thesis=True)(
        "Repeat the outlier removal until nothing changes."
    )

    @property
    def upright(self) -> Upright:
        """Which way is up; z where that was not looked for."""
        return Upright(UP_AXES[0] if self.up_axis == "auto" else self.up_axis)

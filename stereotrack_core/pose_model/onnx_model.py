"""A top-down pose model as an ONNX file: the picture of one person in, keypoints out.

Two layouts of the output are understood. SimCC (RTMPose, DOI 10.48550/arXiv.2303.07399): two
arrays, (N, K, W s) and (N, K, H s), the scores of columns and rows, s the subdivision of a pixel.
Heat maps: one array (N, K, h, w). The input is (N, 3, H, W), RGB, normalised as for ImageNet.
"""

from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from stereotrack_core.arrays import Float32Array, FloatArray, ImageArray
from stereotrack_core.errors import InputError
from stereotrack_core.pose_model.crops import Crop, as_rgb
from stereotrack_core.reading import check_file, decoding
from stereotrack_core.versions import extra_library

_MEAN = np.array([123.675, 116.28, 103.53], dtype=np.float32)
_SPREAD = np.array([58.395, 57.12, 57.375], dtype=np.float32)
_USUAL_SIZE = (192, 256)  # width and height of models whose input may have any size

_QUARTER = 0.25  # part of a pixel of a heat map by which a peak is moved to the higher neighbour
_REMEDY = (
    "Use a top-down pose model with SimCC or heat-map outputs, such as RTMPose's end2end.onnx."
)


def _speaking(runtime: ModuleType, do: Callable[..., Any], *given: Any) -> Any:
    """Call onnxruntime; its own exceptions, which have no common base, become a ValueError."""
    state = runtime.capi.onnxruntime_pybind11_state
    own = tuple(
        one for one in vars(state).values() if isinstance(one, type) and issubclass(one, Exception)
    )
    try:
        return do(*given)
    except own as error:
        raise ValueError(str(error)) from error


class PoseModel:
    """A pose model of an ONNX file, ready to be asked.

    `layout` names in ``LAYOUTS`` the order of its points, if it is not told by their number.
    Raises InputError where the file is none, or onnxruntime is not installed.
    """

    def __init__(self, path: Path, layout: str | None = None) -> None:
        missing = "pose models need the library onnxruntime, which is not installed"
        runtime = extra_library(
            "onnxruntime", "detect", missing=missing, where=str(path), instead="another detector"
        )
        check_file(path)
        self.path, self.layout = path, layout
        options = runtime.SessionOptions()
        options.log_severity_level = 3
        given = str(path), options, ["CPUExecutionProvider"]
        with decoding(path, "this is not an ONNX model that can be run", _REMEDY):
            self._session: Any = _speaking(runtime, runtime.InferenceSession, *given)
        self._runtime = runtime
        (self._input, *_others) = self._session.get_inputs()
        shape = list(self._input.shape)
        if len(shape) != 4 or shape[1] != 3:
            raise self._refusal(f"its input has the shape {shape}, not N, 3, height, width")
        height, width = (n if isinstance(n, int) else None for n in shape[2:])
        self.size = (width or _USUAL_SIZE[0], height or _USUAL_SIZE[1])
        """Width and height of what it sees."""

    def keypoints(self, picture: ImageArray, crop: Crop) -> tuple[FloatArray, FloatArray]:
        """Places (K, 2), pixels of the picture, and confidences (K,), 0 to 1, of one person.

        `picture` is (H, W) or (H, W, 3), BGR.
        """
        seen = as_rgb(crop.seen(picture, self.size)).astype(np.float32)
        given = ((seen - _MEAN) / _SPREAD).transpose(2, 0, 1)[None]
        asked = {self._input.name: np.ascontiguousarray(given)}
        with decoding(self.path, "the model cannot be run", _REMEDY):
            answer = _speaking(self._runtime, self._session.run, None, asked)
        found = [np.asarray(one) for one in answer]
        if len(found) >= 2 and found[0].ndim == found[1].ndim == 3:
            places, score = self._of_simcc(found[0][0], found[1][0])
        elif found[0].ndim == 4:
            places, score = self._of_heat_maps(found[0][0])
        else:
            shapes = ", ".join(str(one.shape) for one in found)
            raise self._refusal(f"its outputs have the shapes {shapes}")
        return crop.in_picture(places, self.size), np.clip(score, 0.0, 1.0)

    def _of_simcc(self, x: Float32Array, y: Float32Array) -> tuple[FloatArray, FloatArray]:
        """Highest scores of columns (K, W s) and rows (K, H s)."""
        columns, rows = x.argmax(axis=1), y.argmax(axis=1)
        split = x.shape[1] / self.size[0], y.shape[1] / self.size[1]
        places = np.stack([columns / split[0], rows / split[1]], axis=1)
        return places, np.minimum(x.max(axis=1), y.max(axis=1)).astype(np.float64)

    def _of_heat_maps(self, maps: Float32Array) -> tuple[FloatArray, FloatArray]:
        """Highest pixels of heat maps (K, h, w), moved a quarter towards the higher neighbour."""
        count, height, width = maps.shape
        flat = maps.reshape(count, -1).argmax(axis=1)
        rows, columns = np.divmod(flat, width)
        own, k = np.pad(maps, ((0, 0), (1, 1), (1, 1)), mode="edge"), np.arange(count)
        right, left = own[k, rows + 1, columns + 2], own[k, rows + 1, columns]
        below, above = own[k, rows + 2, columns + 1], own[k, rows, columns + 1]
        x = columns + _QUARTER * np.sign(right - left)
        y = rows + _QUARTER * np.sign(below - above)
        scale = np.array([self.size[0] / width, self.size[1] / height])
        places = (np.stack([x, y], axis=1) + 0.5) * scale - 0.5
        return places, maps.reshape(count, -1).max(axis=1).astype(np.float64)

    def _refusal(self, what: str) -> InputError:
        return InputError(f"this is no pose model: {what}", where=str(self.path), remedy=_REMEDY)

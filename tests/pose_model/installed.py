"""The pretrained detector where it is installed."""

import os
from functools import cache
from unittest.mock import patch

import pytest

from stereotrack_core.pose_model.detector import PoseDetector, load_detector
from stereotrack_core.pose_model.installation import FOLDER_VARIABLE


@cache
def _loaded() -> PoseDetector | None:
    with patch.dict(os.environ, {FOLDER_VARIABLE: os.environ["STEREOTRACK_TEST_DETECTOR"]}):
        return load_detector()


def installed_detector() -> PoseDetector:
    """The detector; skips where it is not installed."""
    detector = _loaded()
    if detector is None:
        pytest.skip("the pose detector is not installed (stereotrack detector install)")
    return detector

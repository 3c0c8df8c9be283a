"""The pretrained detector where it is installed."""

from __future__ import annotations

from functools import cache

import pytest

from stereotrack_core.pose_model.detector import PoseDetector, load_detector


@cache
def _loaded() -> PoseDetector | None:
    return load_detector()


def installed_detector() -> PoseDetector:
    """The detector; skips where it is not installed."""
    detector = _loaded()
    if detector is None:
        pytest.skip("the pose detector is not installed (stereotrack detector install)")
    return detector

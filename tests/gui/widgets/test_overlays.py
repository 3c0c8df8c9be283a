"""What is drawn over pictures is equally thick at every zoom and every scaling of the screen."""

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QImage, QPainter, QTransform

from app.widgets.camera.overlays import Overlay, PartShape, limb_paths, paint_overlay
from stereotrack_core.recording.landmarks import LANDMARKS

SIDE = 200


def painted(overlay, shown, ratio, zoom):
    """Alpha (rows, columns) of an overlay painted at a scaling of the screen, on nothing."""
    side = round(SIDE * ratio)
    image = QImage(side, side, QImage.Format.Format_ARGB32_Premultiplied)
    image.setDevicePixelRatio(ratio)
    image.fill(Qt.GlobalColor.transparent)
    painter = QPainter(image)
    paint_overlay(painter, overlay, frozenset(shown), "", QTransform.fromScale(zoom, zoom))
    painter.end()
    data = np.frombuffer(image.constBits(), np.uint8).reshape(side, image.bytesPerLine() // 4, 4)
    return data[:, :side, 3].astype(float) / 255.0


def box(zoom):
    corners = np.array([[40.0, 40.0], [160.0, 40.0], [160.0, 160.0], [40.0, 160.0]]) / zoom
    wire = corners[[[0, 1]]]
    shapes = (PartShape("torso", corners, corners[:2], wire, 1.0),)
    return Overlay(shapes=shapes, paths=limb_paths(shapes))


def skeleton(zoom):
    """Shoulders far apart on one level, everything else unknown."""
    landmarks = np.full((len(LANDMARKS), 2), np.nan)
    landmarks[LANDMARKS.index("left_shoulder")] = (20.0 / zoom, 100.0 / zoom)
    landmarks[LANDMARKS.index("right_shoulder")] = (180.0 / zoom, 100.0 / zoom)
    return Overlay(reference=landmarks)


def thickness(alpha, ratio, column=100):
    """How thick what crosses a column in its upper part is, in the widget's pixels."""
    return alpha[: round(130 * ratio), round(column * ratio)].max(initial=0.0), (
        alpha[: round(130 * ratio), round(column * ratio)].sum() / ratio
    )


@pytest.mark.parametrize("zoom", [0.5, 1.0, 3.0])
@pytest.mark.parametrize(
    ("make", "shown"), [(box, {"outline"}), (box, {"wire"}), (skeleton, {"reference"})]
)
def test_lines_are_as_thick_at_every_scaling(qapp, make, shown, zoom):
    overlay = make(zoom)
    peak, usual = thickness(painted(overlay, shown, 1.0, zoom), 1.0)
    assert usual > 0.5
    assert peak > 0.4
    for ratio in (1.5, 2.0):
        _, there = thickness(painted(overlay, shown, ratio, zoom), ratio)
        assert there == pytest.approx(usual, rel=0.2), f"at {ratio}x"

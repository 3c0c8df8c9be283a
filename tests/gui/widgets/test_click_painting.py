"""Names of clicks are written where they hide no other click."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QColor, QImage, QPainter, QTransform

from app.widgets.camera.click_marks import ClickMark, ClickMarks
from app.widgets.camera.click_painting import paint_marks

BLUE, ORANGE = "#0072B2", "#D55E00"


def painted(*marks):
    image = QImage(400, 200, QImage.Format.Format_RGB32)
    image.fill(Qt.GlobalColor.gray)
    painter = QPainter(image)
    clicks = ClickMarks(0, "N_right", clicks=marks)
    paint_marks(painter, clicks, QTransform(), frozenset({"clicks"}), QRectF(image.rect()))
    painter.end()
    return image


def mark(landmark, x, y, colour, *, chosen=False):
    return ClickMark(landmark, landmark.replace("_", " "), colour, x, y, chosen=chosen)


@pytest.mark.parametrize(("x", "y"), [(228.0, 100.0), (245.0, 96.0), (172.0, 100.0)])
@pytest.mark.parametrize("chosen", [False, True])
def test_a_name_hides_no_other_dot(qapp, x, y, chosen):
    image = painted(
        mark("left_elbow", 200.0, 100.0, BLUE, chosen=chosen), mark("head", x, y, ORANGE)
    )
    assert image.pixelColor(round(x), round(y)) == QColor(ORANGE)
    assert image.pixelColor(200, 100) == QColor(BLUE)


def test_names_are_written_beside_their_dots(qapp):
    alone = painted(mark("left_elbow", 200.0, 100.0, BLUE))
    right = {alone.pixelColor(x, 100).name() for x in range(212, 240)}
    left = {alone.pixelColor(x, 100).name() for x in range(150, 188)}
    assert len(right) > 1
    assert len(left) == 1

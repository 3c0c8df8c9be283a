"""Names of clicks are written where they hide no other click."""

import numpy as np
import pytest
from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QColor, QImage, QPainter, QPainterPath, QTransform

from app.widgets.camera.click_marks import ClickMark, ClickMarks, LimbMark
from app.widgets.camera.click_painting import paint_marks, paint_notes

BLUE, ORANGE = "#0072B2", "#D55E00"


def model_pixels(opacity=1.0, *, old=False, box=(40.0, 40.0, 320.0, 100.0)):
    """How far painting a limb of the model changes the picture; what stands in the corner too."""
    path = QPainterPath()
    path.addRect(QRectF(*box))
    image = QImage(400, 200, QImage.Format.Format_RGB32)
    image.fill(Qt.GlobalColor.gray)
    before = image.copy()
    painter = QPainter(image)
    limb = LimbMark("left_forearm", path, opacity)
    marks = ClickMarks(0, "N_right", model=(limb,), model_is_old=old)
    area = QRectF(image.rect())
    paint_marks(painter, marks, QTransform(), frozenset({"fit"}), area)
    paint_notes(painter, marks, frozenset({"fit"}), area)
    painter.end()
    grey = [one.convertToFormat(QImage.Format.Format_Grayscale8) for one in (before, image)]
    a, b = (np.frombuffer(one.constBits(), np.uint8).reshape(200, -1)[:, :400] for one in grey)
    changed = np.abs(a.astype(int) - b)
    return changed[:160].sum(), changed[160:].sum()


def test_a_model_fades_with_its_uncertainty_and_while_it_is_old(qapp):
    sure, unsure, old = model_pixels(), model_pixels(0.3), model_pixels(old=True)
    assert 0 < unsure[0] < 0.5 * sure[0]
    assert 0 < old[0] < 0.7 * sure[0]
    assert sure[1] == unsure[1] == 0
    assert old[1] > 0, "and it is said"


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


def test_a_name_that_would_stand_beside_another_dot_stands_above_or_below(qapp):
    image = painted(*(mark("left_elbow", x, 100.0, BLUE) for x in (60.0, 130.0, 200.0, 270.0)))
    between = {image.pixelColor(x, 100).name() for x in range(140, 190)}
    assert len(between) == 1, "a name between two dots would be either's"
    above = {image.pixelColor(130, y).name() for y in range(70, 93)}
    below = {image.pixelColor(130, y).name() for y in range(107, 130)}
    assert len(above) > 1 or len(below) > 1

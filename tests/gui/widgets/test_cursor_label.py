"""The name at the cursor can be read over any picture."""

import pytest
from PySide6.QtCore import QPointF, Qt
from PySide6.QtGui import QColor
from PySide6.QtWidgets import QWidget

from app.widgets.camera.cursor import CursorLabel
from stereotrack_core.annotation.landmark_set import NINE


@pytest.mark.parametrize("picture", ["white", "black", "#808080", "#D55E00"])
@pytest.mark.parametrize("colour", sorted({one.colour for one in NINE.landmarks} | {"#000000"}))
def test_the_name_is_readable_over_any_picture(shown, colour, picture):
    ground = QWidget()
    ground.setAutoFillBackground(True)
    palette = ground.palette()
    palette.setColor(ground.backgroundRole(), QColor(picture))
    ground.setPalette(palette)
    ground.setStyleSheet(f"background: {picture};")
    label = CursorLabel(ground)
    shown(ground, 300, 100)
    label.say("left elbow", colour, QPointF(40.0, 20.0))
    image = label.grab().toImage()
    image = ground.grab(label.geometry()).toImage()
    back = image.pixelColor(3, image.height() // 2)
    assert back.lightness() < 70, "white can be read on it"
    seen = {
        image.pixelColor(x, y).name() for x in range(image.width()) for y in range(image.height())
    }
    assert "#ffffff" in seen, "the writing itself"
    assert QColor(colour).name() in seen, "and the dot in the limb's own colour"


def test_long_words_are_wrapped_in_a_narrow_view(shown):
    ground = QWidget()
    label = CursorLabel(ground)
    shown(ground, 130, 120)
    words = "all nine are clicked here: drag to move, 1-9 to select one"
    label.say(words, "", QPointF(65.0, 20.0))
    assert ground.rect().contains(label.geometry())
    assert label.height() > 2 * label.fontMetrics().height()
    assert label.testAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)

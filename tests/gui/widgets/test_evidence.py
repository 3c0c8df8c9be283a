"""The picture below the evidence for a failure is as wide as there is room, at any size."""

import numpy as np
import pytest

from app.widgets.tables.failures_panel import EvidenceView

WIDTH, HEIGHT = 900, 300
GREY = np.full((HEIGHT, WIDTH, 3), 90, np.uint8)


@pytest.mark.parametrize("width", [300, 700, 1400])
def test_the_picture_keeps_its_proportions_and_is_not_enlarged(shown, qapp, width):
    view = shown(EvidenceView(str), 300, 200)
    view.show_picture(GREY)
    view.resize(width, 900)
    qapp.processEvents()
    image = view.viewport().grab().toImage()
    grey = np.array(
        [
            [image.pixelColor(x, y).red() == 90 for x in range(0, image.width(), 2)]
            for y in range(0, image.height(), 2)
        ]
    )
    across, down = 2 * grey.any(axis=0).sum(), 2 * (grey.sum(axis=1) > 50).sum()
    assert across == pytest.approx(min(view.viewport().width() - 8, WIDTH), abs=6)
    assert down == pytest.approx(across * HEIGHT / WIDTH, abs=6)

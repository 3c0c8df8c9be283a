"""A window in which landmarks are clicked without end; says which clicks it has painted.

It is given a recording and a folder for its project, and works until it is killed.
"""

import sys
from itertools import cycle
from pathlib import Path

from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest

from stereotrack_core.annotation.landmark_set import NINE
from tests.gui.window_process import until, window_on


def _shows(window, frame: int) -> bool:
    marks = window.context.docks.views.tiles["N"].camera.marks
    return marks is not None and marks.frame == frame


def annotate(recording: Path, folder: Path) -> None:
    app, window = window_on(recording, folder, "annotate")
    for step in cycle(range(window.context.session.document.frame_count)):
        window.context.session.document.go_to(step)
        until(app, lambda step=step: _shows(window, step))
        for name, place in zip(NINE.names, range(9), strict=True):
            window.features.annotate.clicking.annotating.choose(name)
            camera = window.context.docks.views.tiles["N"].camera
            spot = camera.rect().center() + QPoint(9 * place - 40, 5 * step - 20)
            modifier = Qt.KeyboardModifier.ControlModifier
            QTest.mouseClick(camera, Qt.MouseButton.LeftButton, modifier, spot)
            camera.repaint()
            mark = next(one for one in camera.marks.clicks if one.landmark == name)
            words = (step, camera.picture.camera, name, repr(mark.x), repr(mark.y))
            sys.stdout.write(" ".join(map(str, words)) + "\n")
            sys.stdout.flush()


if __name__ == "__main__":
    annotate(Path(sys.argv[1]), Path(sys.argv[2]))

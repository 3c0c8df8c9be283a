"""A recording opens zoomed to a person who stands still too, and is searched only once."""

from __future__ import annotations

import numpy as np
import pytest

from app.features.view import first_zoom
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.recording.description import Recording, Stream, View
from stereotrack_core.recording.writing import write_png, write_recording_description
from tests.gui.hands import click, view
from tests.gui.kept_window import close_window, open_recording, show_window

pytestmark = pytest.mark.window

WIDTH, HEIGHT, COUNT = 480, 320, 10
PLACES = [(200.0, 125.0), (190.0, 150.0), (215.0, 210.0)]


@pytest.fixture
def still(tmp_path):
    """A person who stands quite still, before a scene that nobody knows."""
    folder = tmp_path / "recording"
    (folder / "N").mkdir(parents=True)
    image = np.full((HEIGHT, WIDTH), 100, dtype=np.uint8)
    image[110:230, 180:230] = 190
    for k in range(COUNT):
        write_png(folder / "N" / f"{k}.png", image)
    matrix = np.array([[400.0, 0, 240], [0, 400, 160], [0, 0, 1]])
    camera = Camera("N", WIDTH, HEIGHT, matrix, np.zeros(5), False, RigidTransform.identity())
    views = (View("N", "mono", Stream("N", "N/%d.png")),)
    write_recording_description(Recording(folder, "still", 10.0, views, {"N": camera}))
    return folder


def test_who_stands_still_is_found_by_the_clicks_and_kept(
    qtbot, settings, failures, processes, kept, still, monkeypatch
):
    kept.close()
    settings.setValue("open_zoomed", True)
    window = show_window(qtbot, settings, processes)
    qtbot.addWidget(window)

    def open_again():
        window.context.actions.action("close").trigger()
        open_recording(window, qtbot, still)
        window.context.docks.show_named("annotate")
        qtbot.waitUntil(window.context.tasks.settled, timeout=60_000)
        return view(window, "N").zoom

    assert open_again() == 1.0, "nothing tells of a person yet"
    for x, y in PLACES:
        click(window, x, y)
    zoom = open_again()
    assert zoom > 1.2
    assert all(view(window, "N").rect().contains(view(window, "N").place_of(*at).toPoint())
               for at in PLACES)  # fmt: skip
    searched = []
    monkeypatch.setattr(first_zoom, "person_boxes", lambda *_: searched.append(1) or {})
    assert open_again() == zoom
    assert not searched, "the project keeps where the person was found"
    window.context.session.project.project.view_settings.set("person_boxes", {"N": [1, "x", 3, 4]})
    assert open_again() == 1.0, "what is kept there makes no sense"
    assert searched
    close_window(window)
    assert not failures

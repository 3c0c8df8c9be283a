"""Where the person is in each view: whole, over all frames that are looked at, and nowhere else."""

import numpy as np
import pytest

from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.recording.description import Recording, Stream, View
from stereotrack_core.recording.person_boxes import person_boxes
from stereotrack_core.recording.writing import write_png

WIDTH, HEIGHT, COUNT = 480, 320, 12


def walker(k):
    """A body with an arm that is a few pixels thin, and a clock in a corner that ticks."""
    image = np.random.default_rng(k).integers(96, 104, (HEIGHT, WIDTH), dtype=np.uint8)
    x = 150 + 8 * k
    image[80:280, x : x + 40] = 190
    image[110:118, x + 40 : x + 100] = 190
    image[5:15, 440:450] = 255 if k % 2 else 0
    return image


def sways(k):
    """A person who stands still, but for a third of a pixel to and fro."""
    image = np.full((HEIGHT, WIDTH), 100.0)
    edges = 0.5 + 0.3 * np.sin(k)
    image[80:280, 150:191] = 190.0
    image[80:280, 150] = image[80, 150:191] = 190.0 - 90.0 * edges
    image[80:280, 190] = image[279, 150:191] = 100.0 + 90.0 * edges
    image += np.random.default_rng(k).normal(0.0, 2.0, image.shape)
    return image.round().astype(np.uint8)


SCENES = {
    "sways": sways,
    "walks": walker,
    "stands": lambda k: walker(0),
    "empty": lambda k: np.random.default_rng(k).integers(96, 104, (HEIGHT, WIDTH), dtype=np.uint8),
    "flickers": lambda k: np.full((HEIGHT, WIDTH), 60 + 90 * (k % 2), dtype=np.uint8),
}


@pytest.fixture
def recording(tmp_path):
    """One view for each scene, and one that stands before a known empty scene."""
    matrix = np.array([[400.0, 0, 240], [0, 400, 160], [0, 0, 1]])
    views, cameras = [], {}
    for name, draw in {**SCENES, "known": SCENES["stands"]}.items():
        (tmp_path / name).mkdir()
        for k in range(COUNT):
            write_png(tmp_path / name / f"{k}.png", draw(k))
        camera = Camera(name, WIDTH, HEIGHT, matrix, np.zeros(5), False, RigidTransform.identity())
        cameras[name] = camera
        background = "scene.png" if name == "known" else None
        views.append(View(name, "mono", Stream(name, f"{name}/%d.png", background)))
    write_png(tmp_path / "scene.png", SCENES["empty"](99))
    return Recording(tmp_path, "scenes", 10.0, tuple(views), cameras)


def test_the_whole_person_is_in_the_box_and_nothing_else(recording):
    boxes = person_boxes(recording)
    assert boxes.keys() == {"walks", "known", "sways"}
    assert boxes["sways"] == pytest.approx((150, 80, 190, 280), abs=12), "nobody stands quite still"
    last = 150 + 8 * (COUNT - 1)
    assert boxes["walks"] == pytest.approx((150, 80, last + 100, 280), abs=8)
    assert boxes["known"] == pytest.approx((150, 80, 250, 280), abs=8), "also one who stands still"

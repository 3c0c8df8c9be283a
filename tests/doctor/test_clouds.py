from dataclasses import replace

import numpy as np

from stereotrack_core.doctor.diagnose import check_clouds
from tests.depth.recordings import MemoryReader, depth_recording, frame_set

RECORDING = depth_recording()


def found(change=lambda images: images, *, box=True, doubtful=()):
    sets = [
        frame_set(RECORDING, k, box=box, shift=s) for k, s in enumerate(np.linspace(-0.6, 0.6, 6))
    ]
    for one in sets:
        one.views["K"] = change(one.views["K"])
    return tuple(check_clouds(RECORDING, MemoryReader(RECORDING, sets, empty=False), doubtful))


def test_where_somebody_moves_there_is_nothing_to_say():
    assert found() == ()


def test_the_step_that_took_all_points_is_named():
    (finding,) = found(box=False)
    assert (finding.severity, finding.where) == ("error", "view K")
    assert "in front of the background" in finding.what
    assert "background_mode=none" in finding.remedy
    (finding,) = found(lambda images: replace(images, depth=np.zeros_like(images.depth)))
    assert "nothing to track: " in finding.what
    assert "depth images" in finding.remedy
    assert found(box=False, doubtful=("K",)) == ()

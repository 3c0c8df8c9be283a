"""The demo recording that is shipped, and the copy that a person gets."""

import numpy as np

from stereotrack_core.demo import SHIPPED, copied_demo
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.reader import FrameReader

_MOST_BYTES = 4_000_000
"""Of the shipped files, which are part of every download."""


def test_the_shipped_recording_is_small_and_complete():
    assert sum(file.stat().st_size for file in SHIPPED.iterdir()) <= _MOST_BYTES
    recording = open_recording(SHIPPED)
    assert [view.name for view in recording.views] == ["N", "O", "S", "W"]
    assert {one.name for one in recording.segments} == {"t-pose", "cross-arms", "point"}
    assert recording.reference is not None
    assert np.isfinite(recording.reference.points).all()
    with FrameReader(recording, read_ahead=0) as reader:
        assert reader.frame_count == len(recording.reference.frame) == 100
        assert reader.background("W") is not None


def test_a_copy_is_made_once(tmp_path):
    places = copied_demo(tmp_path / "new" / "demo")
    for file in SHIPPED.iterdir():
        assert (places.recording / file.name).read_bytes() == file.read_bytes()
    (places.recording / "subject.toml").write_text("mine")
    assert copied_demo(tmp_path / "new" / "demo") == places
    assert (places.recording / "subject.toml").read_text() == "mine"

import numpy as np
import pytest

from stereotrack_core.errors import Cancelled, InputError
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.simulation.make import Simulation, simulate
from stereotrack_core.simulation.rig import SceneOptions
from stereotrack_core.work import Work

SMALL = SceneOptions(width=160, height=120, focal=100.0)
TINY = {"frames": 3, "views": "NO", "options": SMALL}


def digest(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    folder = tmp_path_factory.mktemp("made") / "tiny"
    simulate(folder, Simulation(person="P4", motion="point", **TINY))
    return folder


def test_what_is_made_opens_as_a_recording(recording):
    opened = open_recording(recording)
    assert opened.name == "tiny"
    assert [view.name for view in opened.views] == ["N", "O"]
    assert {view.kind for view in opened.views} == {"stereo"}
    assert opened.subject.name == "P4"
    assert opened.segments[0].name == "t-pose"
    with FrameReader(opened, colour=False) as reader:
        assert reader.frame_count == 3
        images = reader.frame_set(2).views["O"]
        assert images.image.shape == images.left.shape == (120, 160)
        assert reader.background("N")[1].shape == (120, 160)


def test_same_seed_gives_the_same_files_and_another_seed_others(recording, tmp_path):
    simulate(tmp_path / "tiny", Simulation(person="P4", motion="point", **TINY))
    assert digest(tmp_path / "tiny") == digest(recording)
    simulate(tmp_path / "other" / "tiny", Simulation(person="P4", motion="point", seed=1, **TINY))
    other = digest(tmp_path / "other" / "tiny")
    assert other["N_left.mp4"] != digest(recording)["N_left.mp4"]
    assert other["calibration.toml"] != digest(recording)["calibration.toml"]


def test_colour_recording_without_backgrounds(tmp_path):
    options = SMALL.replaced(colour=True, background_images=False, clothes="striped")
    simulate(tmp_path / "c", Simulation(frames=1, views="W", options=options))
    with FrameReader(open_recording(tmp_path / "c")) as reader:
        image = reader.frame_set(0).views["W"].image
        assert image.shape == (120, 160, 3)
        assert np.ptp(image.astype(int), axis=2).max() > 20
        assert reader.background("W") is None
    assert not list((tmp_path / "c").glob("*.png"))


def test_stopping_leaves_nothing_behind(tmp_path):
    told = []
    work = Work(lambda _share, words: told.append(words), lambda: len(told) == 2)
    with pytest.raises(Cancelled):
        simulate(tmp_path / "r", Simulation(**TINY), work)
    assert told == ["frame 0", "frame 1"]
    assert list(tmp_path.iterdir()) == []


def test_an_empty_folder_is_filled_and_a_full_one_refused(tmp_path):
    (tmp_path / "empty").mkdir()
    simulate(tmp_path / "empty", Simulation(frames=1, views="N", options=SMALL))
    assert open_recording(tmp_path / "empty").name == "empty"
    with pytest.raises(InputError, match="not empty"):
        simulate(tmp_path / "empty", Simulation(frames=1, views="N", options=SMALL))


@pytest.mark.parametrize(
    ("wrong", "where"),
    [
        ({"frames": 0}, "--frames"),
        ({"seed": -1}, "--seed"),
        ({"person": "P7"}, "--person"),
        ({"motion": "swim"}, "--motion"),
        ({"views": "NX"}, "--views"),
    ],
)
def test_wrong_wishes_are_refused_and_leave_nothing(tmp_path, wrong, where):
    with pytest.raises(InputError, match=where):
        simulate(tmp_path / "r", Simulation(**wrong))
    assert list(tmp_path.iterdir()) == []

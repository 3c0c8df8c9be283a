"""Sources at other, uneven or stamped rates: frame k of the recording is the same instant."""

from fractions import Fraction

import av
import numpy as np
import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.recording.importing.choices import doubts_about
from stereotrack_core.recording.importing.making import make_recording
from stereotrack_core.recording.importing.sources import look_at
from stereotrack_core.recording.importing.synchronise import at_one_rate
from stereotrack_core.recording.writing import write_png
from tests.recording.importing.clips import HEIGHT, WIDTH, chosen, clip, frames_of, images

SECONDS_PER_LEVEL = 0.0125


def level(seconds):
    """A picture whose brightness tells the instant at which it was taken."""
    return np.full((HEIGHT, WIDTH), 30 + round(seconds / SECONDS_PER_LEVEL), np.uint8)


def taken(picture):
    return (float(picture.mean()) - 30) * SECONDS_PER_LEVEL


def uneven_clip(path, times):
    """A video whose frames were taken at these seconds, as telephones write them."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=30, options={"crf": "0", "bf": "0"})
        stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, "yuvj420p"
        stream.codec_context.time_base = Fraction(1, 90000)
        for seconds in times:
            frame = av.VideoFrame.from_ndarray(level(seconds), format="gray")
            frame = frame.reformat(format="yuvj420p")
            frame.pts, frame.time_base = round(seconds * 90000), Fraction(1, 90000)
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    return path


def made(folder, out, **changes):
    choices = at_one_rate(chosen(folder, **changes))
    shown = frames_of(make_recording(choices, out))
    return choices, [{name: taken(one.image) for name, one in views.items()} for views in shown]


def test_an_uneven_video_and_one_of_another_rate_are_brought_to_one(tmp_path):
    clip(tmp_path / "in" / "A.mp4", lambda k: level(k / 25), frames=50)
    clip(tmp_path / "in" / "B.mp4", lambda k: level(k / 50), frames=100, fps=50.0)
    steps = np.where(np.arange(46) % 9 == 8, 0.12, 0.034)
    uneven_clip(tmp_path / "in" / "C.mp4", np.concatenate([[0.0], np.cumsum(steps)]))
    choices, shown = made(tmp_path / "in", tmp_path / "out", fps=25.0)
    assert [use.source.rate for use in choices.uses] == [None, 25.0, 25.0]
    for k, views in enumerate(shown):
        assert views["A"] == pytest.approx(k / 25, abs=0.021)
        assert views["B"] == pytest.approx(k / 25, abs=0.021)
        assert views["C"] == pytest.approx(k / 25, abs=0.06 + 0.021)
    words = " ".join(doubts_about(choices))
    assert "The frames of B are at 50 frames per second." in words
    assert "from even" in words


def test_the_rate_of_an_uneven_video_is_that_of_its_usual_step(tmp_path):
    uneven_clip(tmp_path / "A.mp4", [k / 30 for k in range(40)] + [2.0 + k / 30 for k in range(20)])
    (source,) = look_at([tmp_path]).sources
    assert source.fps == 30.0
    assert source.uneven > 10
    choices = at_one_rate(chosen(tmp_path))
    assert choices.fps == choices.uses[0].source.rate == 30.0
    assert "has no frame for up to 0.70 s" in " ".join(doubts_about(choices))


@pytest.mark.parametrize("name", ["{:.6f}.png", "{:.0f}"])
def test_images_named_by_time_stamps_begin_at_the_same_instant(tmp_path, name):
    begin = 1305031102.175304
    for view, late in (("A", 0.0), ("B", 0.5)):
        (tmp_path / "in" / view).mkdir(parents=True)
        for k in range(40):
            seconds = late + k / 20 + (0.004 if k % 3 else 0.0)
            stamp = begin + seconds
            file = name.format(stamp) if "6f" in name else f"{round(stamp * 1e9)}.png"
            write_png(tmp_path / "in" / view / file, level(seconds))
    found = look_at([tmp_path / "in"])
    assert [(one.name, one.fps) for one in found.sources] == [("A", 20.0), ("B", 20.0)]
    _, shown = made(tmp_path / "in", tmp_path / "out")
    assert len(shown) == 30
    for k, views in enumerate(shown):
        assert views["A"] == pytest.approx(0.5 + k / 20, abs=0.035)
        assert views["B"] == pytest.approx(0.5 + k / 20, abs=0.035)


def test_stamped_sources_of_other_times_are_refused(tmp_path):
    for view, begin in (("A", 1305031102), ("B", 1305031202)):
        images(tmp_path / view, lambda k, begin=begin: f"{(begin * 1000 + 50 * k)}.png")
    with pytest.raises(InputError, match=r"A ends 99\.\d s before B begins"):
        at_one_rate(chosen(tmp_path))


def test_a_number_that_is_missing_stays_a_frame_without_an_image(tmp_path):
    images(tmp_path / "in" / "A")
    images(tmp_path / "in" / "B", "{:04d}.png".format)
    (tmp_path / "in" / "B" / "0005.png").unlink()
    choices = chosen(tmp_path / "in", fps=10.0)
    assert "B lacks 1 of 12 numbers" in " ".join(doubts_about(choices))
    for out in (tmp_path / "copied", tmp_path / "in"):
        shown = frames_of(make_recording(choices, out))
        assert "B" not in shown[5]
        assert np.array_equal(shown[6]["A"].image, shown[6]["B"].image)

"""Offsets between sources that are known: found to a fraction of a frame, or refused."""

from dataclasses import replace
from fractions import Fraction

import av
import numpy as np
import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.recording.importing.sources import look_at
from stereotrack_core.recording.importing.synchronise import leads_of
from tests.recording.importing.clips import HEIGHT, WIDTH, clip, flashing

FPS, COUNT = 25.0, 80
RNG = np.random.default_rng(4)
STEPS = np.abs(RNG.normal(0.0, 1.5, 400)) * (RNG.random(400) > 0.6) + 0.02
PLACES = np.cumsum(STEPS)
SCENE = RNG.integers(40, 200, (HEIGHT, 1024)).astype(np.uint8)


def moving(begin, mirrored=False):
    """Frames of a scene that shifts by bounds, the first at the instant `begin` in frames."""

    def picture(k):
        place = int(np.interp(k + begin, np.arange(len(PLACES)), PLACES) * 2)
        view = SCENE[:, place : place + WIDTH]
        return view[:, ::-1] if mirrored else view

    return picture


def sources(folder, *pictures, count=COUNT):
    for name, picture in zip("ABC", pictures, strict=False):
        clip(folder / f"{name}.mp4", picture, frames=count, fps=FPS)
    return look_at([folder]).sources


def with_sound(path, clap_s, late_s=0.0, seconds=3.0, rate=16000):
    """A dark video with a clap at some time after its first frame; its sound begins late."""
    rng = np.random.default_rng(int(clap_s * 1000))
    sound = rng.normal(0.0, 0.002, int(seconds * rate)).astype(np.float32)
    start = int((clap_s - late_s) * rate)
    fade = np.exp(-np.arange(2400) / 300.0)
    clap = np.random.default_rng(1).normal(0.0, 0.5, 2400) * fade
    sound[start : start + 2400] += clap.astype(np.float32)
    with av.open(str(path), "w") as container:
        video = container.add_stream("libx264", rate=25)
        video.width, video.height, video.pix_fmt = WIDTH, HEIGHT, "yuv420p"
        audio = container.add_stream("pcm_s16le", rate=rate, layout="mono")
        for k in range(int(seconds * 25)):
            picture = np.full((HEIGHT, WIDTH), 90, np.uint8)
            frame = av.VideoFrame.from_ndarray(picture, format="gray").reformat(format="yuv420p")
            frame.pts, frame.time_base = k, Fraction(1, 25)
            container.mux(video.encode(frame))
        samples = (sound * 32000).clip(-32768, 32767).astype(np.int16)[None]
        heard = av.AudioFrame.from_ndarray(samples, format="s16", layout="mono")
        heard.sample_rate, heard.time_base = rate, Fraction(1, rate)
        heard.pts = int(late_s * rate)
        container.mux(audio.encode(heard))
        container.mux(video.encode(None))
        container.mux(audio.encode(None))


def frames(leads):
    return [lead.frames for lead in leads]


def test_motion_tells_whole_frames(tmp_path):
    found = sources(tmp_path, moving(20), moving(13), moving(26, mirrored=True))
    leads = leads_of(found, "motion", FPS)
    assert frames(leads) == pytest.approx([0, 7, -6], abs=0.3)
    assert all(lead.correlation > 0.6 for lead in leads)


def test_a_scene_that_repeats_itself_is_refused(tmp_path):
    def swinging(k):
        place = 100 + round(20 * np.sin(k * np.pi / 5))
        return SCENE[:, place : place + WIDTH]

    found = sources(tmp_path, swinging, lambda k: swinging(k + 3))
    with pytest.raises(InputError, match="in two places almost equally"):
        leads_of(found, "motion", FPS)


def test_scenes_that_have_nothing_in_common_are_refused(tmp_path):
    found = sources(tmp_path, moving(20), moving(300))
    with pytest.raises(InputError, match="cannot be synchronised"):
        leads_of(found, "motion", FPS)


def test_a_light_that_is_switched_on_tells_fractions_of_a_frame(tmp_path):
    found = sources(tmp_path, flashing(42.0), flashing(30.25))
    leads = leads_of(found, "flash", FPS)
    assert frames(leads) == pytest.approx([0, -11.75], abs=0.1)


def test_without_a_flash_it_is_said_so(tmp_path):
    found = sources(tmp_path, flashing(42.0), moving(5))
    with pytest.raises(InputError, match="no flash of light stands out in B"):
        leads_of(found, "flash", FPS)


def test_a_clap_tells_fractions_of_a_frame(tmp_path):
    for name, clap, late in (("A", 1.0, 0.2), ("B", 1.51, 0.0), ("C", 0.93, 0.5)):
        with_sound(tmp_path / f"{name}.mkv", clap, late)
    found = look_at([tmp_path]).sources
    leads = leads_of(found, "clap", FPS)
    assert frames(leads) == pytest.approx([0, 0.51 * FPS, -0.07 * FPS], abs=0.1)


def test_start_times_come_from_a_table_or_the_file(tmp_path):
    found = sources(tmp_path, flashing(3.0), flashing(3.0), count=4)
    with pytest.raises(InputError, match="does not state its start time"):
        leads_of(found, "start", FPS)
    first, second = found
    stated = (replace(first, start=100.5), replace(second, start=100.3))
    assert frames(leads_of(stated, "start", FPS)) == pytest.approx([0, 5])
    late = (stated[0], replace(stated[1], begin=0.12))
    assert frames(leads_of(late, "start", FPS)) == pytest.approx([0, 2])
    (tmp_path / "timestamps.csv").write_text("frame,view,seconds\n0,A,0.10\n0,B,0.02\n1,A,0.14\n")
    assert frames(leads_of(found, "start", FPS)) == pytest.approx([0, 2])
    assert frames(leads_of((first, late[1]), "start", FPS)) == pytest.approx([0, -1])

"""Forward, backward and random access give the same pictures for every codec and container."""

import gc
import random
import weakref

import av
import numpy as np
import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.recording.findings import check_times
from stereotrack_core.recording.images import DamagedFrame
from stereotrack_core.recording.stream_files import open_stream, picture_size
from stereotrack_core.recording.video import FrameTimes, VideoStream

FRAMES = 60


def forget(number, picture):
    """For readers that do not want the pictures on the way."""


@pytest.fixture
def opened(tmp_path, numbered_videos):
    streams = []

    def open_kind(kind):
        streams.append(VideoStream(numbered_videos.of_kind(tmp_path, kind), "grey"))
        return streams[-1]

    yield open_kind
    for stream in streams:
        stream.close()


def test_every_order_of_access_gives_the_frame_of_that_number(video_kind, opened, numbered_videos):
    stream = opened(video_kind)
    on_the_way = {}
    shuffled = random.Random(3).sample(range(FRAMES), FRAMES)
    pictures = {}
    for k in [*range(FRAMES), *reversed(range(FRAMES)), *shuffled, 0, FRAMES - 1, 0]:
        picture = stream.read(k, on_the_way.__setitem__)
        assert numbered_videos.shown(picture) == k
        assert np.array_equal(picture, pictures.setdefault(k, picture))
    assert stream.count() == FRAMES
    assert stream.count_so_far() == (FRAMES, True)
    for k, picture in on_the_way.items():
        assert np.array_equal(picture, pictures[k])


def test_a_closed_video_leaves_no_decoder_behind(video_kind, tmp_path, numbered_videos):
    stream = VideoStream(numbered_videos.of_kind(tmp_path, video_kind), "grey")
    stream.read(3, forget)
    gone = weakref.ref(stream)
    stream.close()
    gc.disable()
    try:
        del stream
        assert gone() is None, "without waiting for garbage to be looked for"
    finally:
        gc.enable()


def test_a_frame_behind_the_end_is_refused(video_kind, opened):
    with pytest.raises(DamagedFrame, match="ends before frame 60"):
        opened(video_kind).read(FRAMES, forget)


@pytest.mark.parametrize("kind", ["h264-b.mp4", "ffv1.mkv", "mpeg4.avi"])
def test_metadata_in_an_old_encoding_do_not_keep_a_video_shut(kind, tmp_path, numbered_videos):
    path = numbered_videos.of_kind(tmp_path, kind)
    content = path.read_bytes()
    assert b"Lavf" in content  # the program that wrote the file, one of its metadata
    path.write_bytes(content.replace(b"Lavf", "Lävf".encode("latin-1")))
    stream = VideoStream(path, "grey")
    assert numbered_videos.shown(stream.read(7, forget)) == 7
    stream.close()


@pytest.fixture
def times_of():
    opened = []

    def index(path):
        opened.append(FrameTimes(path))
        return opened[-1]

    yield index
    for times in opened:
        times.close()


def test_the_times_are_those_that_were_written(tmp_path, numbered_videos, times_of):
    written = [500 + 33 * i + 7 * (i % 3) for i in range(60)]
    kind = {"times": written.__getitem__, "options": {"g": "12", "bf": "3", "b-adapt": "0"}}
    path = numbered_videos.write(tmp_path / "v.mkv", "libx264", **kind)
    times = times_of(path)
    assert times.time_of(0) == 500
    assert times.times() == written
    assert times.time_of(60) is None
    assert times.frame_at(written[17]) == 17
    assert times.frame_at(written[17] + 1) is None
    assert times.key_times(written[13]) == [written[0], written[12]]
    assert times.next_key_time(written[12]) == written[24]
    assert times.next_key_time(written[59]) is None


def test_irregular_times_are_found():
    regular = np.arange(100) / 25
    assert not list(check_times("v", regular, 25.0))
    jump = regular + (np.arange(100) > 40) * 0.12
    (finding,) = check_times("v", jump, 25.0)
    assert finding.severity == "warning"
    assert "1 of 99 steps: frame 41 comes 160 ms after frame 40 instead of 40 ms" in finding.what
    (finding,) = check_times("v", regular, 10.0)
    assert "the video states 25.00 frames per second, the recording 10" in finding.what


DAMAGEABLE = ("ffv1.mkv", "h264-b.mp4", "h264-vfr.mkv", "mjpeg.avi")


def overwrite_packet(path, number):
    """Fill most of the packet that is decoded as `number` with 255s."""
    with av.open(str(path)) as container:
        packets = [p for p in container.demux(video=0) if p.size]
        place, size = packets[number].pos, packets[number].size
    content = bytearray(path.read_bytes())
    start = content.index(bytes(packets[number]), place)
    content[start + 4 : start + size] = b"\xff" * (size - 4)
    path.write_bytes(content)


@pytest.mark.parametrize("damaged_kind", DAMAGEABLE)
def test_a_damaged_packet_costs_at_most_its_group(damaged_kind, tmp_path, numbered_videos):
    path = numbered_videos.of_kind(tmp_path, damaged_kind)
    overwrite_packet(path, 30)
    stream = VideoStream(path, "grey")
    read_at_once = {}
    for order in (range(FRAMES), reversed(range(FRAMES))):
        read = {}
        for k in order:
            try:
                read[k] = numbered_videos.shown(stream.read(k, forget))
            except DamagedFrame:
                continue
        assert all(k == shown for k, shown in read.items())
        read_at_once = read_at_once or read
        assert read.keys() == read_at_once.keys()
    stream.close()
    lost = set(range(FRAMES)) - set(read)
    assert 1 <= len(lost) <= 24
    assert {0, 5, 10, 57, 58, 59} <= set(read)


@pytest.mark.parametrize("damaged_kind", ["h264.ts", "mpeg4.avi"])
def test_a_video_that_breaks_off_gives_what_there_is(damaged_kind, tmp_path, numbered_videos):
    path = numbered_videos.of_kind(tmp_path, damaged_kind)
    with av.open(str(path)) as container:
        end = [packet.pos for packet in container.demux(video=0) if packet.size][30]
    path.write_bytes(path.read_bytes()[:end])
    stream = VideoStream(path, "grey")
    count = stream.count()
    assert 25 <= count <= 31
    for k in range(0, count - 4, 3):
        assert numbered_videos.shown(stream.read(k, forget)) == k
    with pytest.raises(DamagedFrame):
        stream.read(FRAMES - 1, forget)
    stream.close()


@pytest.mark.parametrize("content", [b"", b"no video at all"])
@pytest.mark.parametrize("name", ["v.mp4", "image.png"])
def test_what_is_no_video_is_refused_in_one_sentence(content, name, tmp_path):
    (tmp_path / name).write_bytes(content)
    for attempt in (
        lambda: picture_size(tmp_path, name, "recording.toml, view N, image.frames"),
        lambda: open_stream(tmp_path, name, "grey", "recording.toml, view N, image.frames"),
    )[: 1 if name == "image.png" else 2]:
        with pytest.raises(InputError) as error:
            attempt()
        assert str(error.value).startswith("recording.toml, view N, image.frames: ")
        assert name in str(error.value)
        assert error.value.remedy

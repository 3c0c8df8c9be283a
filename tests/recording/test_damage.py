"""A damaged frame is told and the rest goes on; no picture is ever another frame's."""

from __future__ import annotations

import av
import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.recording.images import DamagedFrame
from stereotrack_core.recording.stream_files import open_stream, picture_size
from stereotrack_core.recording.video import VideoStream

FRAMES = 60
DAMAGEABLE = ("ffv1.mkv", "h264-b.mp4", "h264-vfr.mkv", "mjpeg.avi")


def forget(number, picture):
    """For readers that do not want the pictures on the way."""


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

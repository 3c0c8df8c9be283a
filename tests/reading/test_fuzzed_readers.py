"""Whatever a file holds: a sentence or what was read, never a traceback."""

import os
import shutil
import sys
import time
from pathlib import Path

import pytest

from stereotrack_core.errors import InputError
from tests.reading.catalogue import damaged
from tests.reading.more_files import NEEDED, OF_HDF5, Reader

# Damaged files for each reader in the fast tests, and in the slow ones.
FEW, MANY = 12, int(os.environ.get("STEREOTRACK_FUZZ", "10000"))
# The same for readers in a process of their own, whose start takes most of a second.
FEW_APART, MANY_APART = 2, 20
# A reader's time on the processor for one of these small files, and its memory for all of them, in
# this process: readers of HDF5 and MAT files are in others, within limits of their own.
MOST_SECONDS, MOST_MB = 5.0, 256
NAMES = (
    *("recording.toml", "calibration.toml"),
    *("subject.toml", "reference.csv", "segments.csv", "detections.csv", "board_corners_2d.csv"),
    *("landmark set", "preset", "run.npz", "run.npz, meta", "reference.npz", "reference.npz, meta"),
    *("TRC", "C3D", "clicks", "COCO", "DeepLabCut", "SLEAP"),
    *("foreign TOML", "OpenCV YAML", "OpenCV XML", "ROS", "Qualisys"),
    *("ZED", "MATLAB JSON", "MATLAB MAT", "Argus", *OF_HDF5),
    *("sweep journal", "study"),
    *(f"keypoints, {kind}" for kind in ("MMPose", "COCO results", "COCO", "table")),
    *(f"keypoints, {kind}" for kind in ("DeepLabCut", "OpenPose")),
    *("PNG", "depth PNG", "JPEG", "TIFF", "BMP", "MP4", "Matroska", "AVI"),
)
READ_APART = ("SLEAP", "MATLAB MAT", *OF_HDF5)


def unhandled(reader: Reader, name: str, numbers: range, folder: Path) -> dict[int, str]:
    """What went wrong with the damaged files of these numbers."""
    wrong = {}
    for number in numbers:
        path = folder / reader.file
        path.write_bytes(damaged(reader, name, number))
        begun = time.thread_time()
        try:
            reader.read(path)
        except InputError as refusal:
            if not refusal.remedy:
                wrong[number] = f"no remedy: {refusal}"
        except Exception as error:  # noqa: BLE001 - every other one is what is looked for
            wrong[number] = f"{type(error).__name__}: {error}"[:300]
        if (seconds := time.thread_time() - begun) > MOST_SECONDS:
            wrong[number] = f"it took {seconds:.1f} s"
    shutil.rmtree(folder)
    return wrong


def most_bytes() -> int:
    """The most memory that this process has had so far."""
    resource = pytest.importorskip("resource")
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (
        1 if sys.platform == "darwin" else 1024
    )


def test_every_reader_is_here(catalogue):
    assert set(NAMES) - set(NEEDED) <= set(catalogue) <= set(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_a_sound_file_is_read(name, reader, tmp_path):
    (tmp_path / reader.file).write_bytes(reader.content)
    reader.read(tmp_path / reader.file)


@pytest.mark.parametrize("name", NAMES)
def test_a_damaged_file_gives_a_sentence(name, reader, tmp_path):
    assert unhandled(reader, name, range(FEW_APART if name in READ_APART else FEW), tmp_path) == {}


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_thousands_of_damaged_files_give_sentences(name, reader, tmp_path):
    before, apart = most_bytes(), name in READ_APART
    numbers = range(FEW_APART, MANY_APART) if apart else range(FEW, MANY)
    assert unhandled(reader, name, numbers, tmp_path) == {}
    assert most_bytes() - before < MOST_MB << 20

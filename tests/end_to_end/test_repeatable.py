"""A run depends on images, parameters and seed: not on the truth, the hour, or the threads."""

import functools
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stereotrack_core.interop.run_file import read_run
from stereotrack_core.program import main
from stereotrack_core.recording.landmarks import read_landmarks, write_landmarks
from stereotrack_core.tracking.presets import PRESETS
from tests.end_to_end.conftest import DENSE
from tests.end_to_end.damage import substitute

EACH = pytest.mark.parametrize(
    "preset",
    [pytest.param(name, marks=() if name == "fast" else pytest.mark.slow) for name in PRESETS],
)
NUMBERS = (
    *("frame", "landmarks", "x", "P", "tracked", "unexplained_fraction", "residual", "innovation"),
    "limb_sigma_deg",
)
# Few proposals and points: how long it takes depends on their number, not what it depends on.
CHOSEN = (*DENSE, "--frames", "0:2", "--set", "search_proposals=60", "--set", "data_points=300")
SEED = ("--seed", "2")
ROOT = Path(__file__).resolve().parents[2]


def tracked(folder, place, preset, *options):
    place = place.with_suffix(".npz")
    words = ("track", folder, "-o", place, "--preset", preset, *CHOSEN, *options)
    assert main([*map(str, words)]) == 0
    return read_run(place)


@pytest.fixture(scope="module")
def first_run(sound, tmp_path_factory):
    """Function from a preset to its run on the sound recording, tracked once."""
    folder = tmp_path_factory.mktemp("first")
    return functools.cache(lambda preset: tracked(sound, folder / preset, preset, *SEED))


def assert_same(a, b, tolerance=0.0):
    for name in NUMBERS:
        one, other = getattr(a, name), getattr(b, name)
        assert one.shape == other.shape
        np.testing.assert_allclose(one, other, rtol=0.0, atol=tolerance, err_msg=name)


def without_reference(folder):
    (folder / "reference.csv").unlink()
    substitute(folder / "recording.toml", r"(?m)^reference = .*\n", "")


def with_wrong_reference(folder):
    """Somebody else, elsewhere, upside down."""
    truth = read_landmarks(folder / "reference.csv")
    write_landmarks(folder / "reference.csv", replace(truth, points=0.7 - 2.0 * truth.points))


@EACH
def test_the_same_seed_gives_the_same_run_to_the_last_bit_whatever_the_truth(
    preset, first_run, copy, tmp_path
):
    knowing = first_run(preset)
    assert knowing.tracked.any()
    with_wrong_reference(copy)
    misled = tracked(copy, tmp_path / "run", preset, *SEED)
    assert misled.meta["fingerprint"] != "" != knowing.meta["fingerprint"]
    assert_same(knowing, misled)
    without_reference(copy)
    assert_same(knowing, tracked(copy, tmp_path / "run", preset, *SEED))


@EACH
def test_another_seed_gives_another_run(preset, first_run, sound, tmp_path):
    once, other = first_run(preset), tracked(sound, tmp_path / "run", preset, "--seed", "3")
    assert (other.x[other.tracked & once.tracked] != once.x[other.tracked & once.tracked]).any()


_WITH_THREADS = """
import os, sys
threads = int(sys.argv[1])
os.cpu_count = lambda: threads
import cv2
cv2.setNumThreads(threads)
from stereotrack_core.program import main
sys.exit(main(sys.argv[2:]))
"""


def tracked_with_threads(folder, place, preset, threads):
    variables = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
    arguments = ("track", folder, "-o", place, "--preset", preset, *CHOSEN, *SEED)
    done = subprocess.run(
        [sys.executable, "-c", _WITH_THREADS, str(threads), *map(str, arguments)],
        env=os.environ | dict.fromkeys(variables, str(threads)),
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return read_run(place)


@EACH
def test_the_number_of_threads_changes_nothing(preset, first_run, sound, tmp_path):
    many = tracked_with_threads(sound, tmp_path / "many.npz", preset, os.cpu_count() + 3)
    assert many.tracked.any()
    assert_same(first_run(preset), many, tolerance=1e-9)

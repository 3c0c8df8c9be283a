"""A run depends on images, parameters and seed: not on the truth, the hour, or the threads."""

from __future__ import annotations

import functools
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from stereotrack_core.interop.run_file import read_run
from stereotrack_core.program import main
from stereotrack_core.tracking.presets import PRESETS

EACH = pytest.mark.parametrize(
    "preset",
    [pytest.param(name, marks=() if name == "fast" else pytest.mark.slow) for name in PRESETS],
)
NUMBERS = (
    "frame",
    "landmarks",
    "x",
    "P",
    "tracked",
    "unexplained_fraction",
    "residual",
    "innovation",
)
DENSE = ("--set", "speckle_size=10", "--set", "pixel_step=1", "--set", "match_window=9")
"""With which small pictures give enough points for every preset."""

FEW = ("--set", "search_proposals=60", "--set", "data_points=300")
"""Proposals and points; their number changes how long it takes, not what it depends on."""

CHOSEN = ("--frames", "0:3", *DENSE, *FEW)
SEED = ("--seed", "2")
ROOT = Path(__file__).resolve().parents[2]


def tracked(run, folder, place, preset, *options):
    ended = run("track", folder, "-o", place, "--preset", preset, *CHOSEN, *options)
    assert ended.status == 0, ended.err
    return read_run(place)


@pytest.fixture(scope="module")
def first_run(sound, tmp_path_factory):
    """Function from a preset to its run on the sound recording, tracked once."""

    @functools.cache
    def of(preset):
        place = tmp_path_factory.mktemp("first") / "run.npz"
        arguments = ("track", sound, "-o", place, "--preset", preset, *CHOSEN, *SEED)
        assert main([str(argument) for argument in arguments]) == 0
        return read_run(place)

    return of


def assert_same(a, b, tolerance=0.0):
    for name in (*NUMBERS, "limb_sigma_deg"):
        one, other = getattr(a, name), getattr(b, name)
        assert one.shape == other.shape
        np.testing.assert_allclose(one, other, rtol=0.0, atol=tolerance, err_msg=name)


def without_reference(folder):
    (folder / "reference.csv").unlink()
    text = (folder / "recording.toml").read_text().splitlines()
    kept = [line for line in text if not line.startswith("reference")]
    assert len(kept) == len(text) - 1
    (folder / "recording.toml").write_text("\n".join(kept))


def with_wrong_reference(folder):
    """Somebody else, elsewhere, upside down."""
    header, *lines = (folder / "reference.csv").read_text().splitlines()
    assert len(lines) > 10
    wrong = [header]
    for line in lines:
        cells = line.split(",")
        numbers = [i for i, cell in enumerate(cells) if "." in cell]
        for i in numbers:
            cells[i] = f"{0.7 - 2.0 * float(cells[i]):.6f}"
        assert numbers
        wrong.append(",".join(cells))
    (folder / "reference.csv").write_text("\n".join(wrong) + "\n")


@EACH
def test_the_same_seed_gives_the_same_run_to_the_last_bit_whatever_the_truth(
    preset, first_run, copy, tmp_path, run
):
    place = tmp_path / "run.npz"
    knowing = first_run(preset)
    assert knowing.tracked.any()
    with_wrong_reference(copy)
    misled = tracked(run, copy, place, preset, *SEED)
    assert misled.meta["fingerprint"] != "" != knowing.meta["fingerprint"]
    assert_same(knowing, misled)
    without_reference(copy)
    assert_same(knowing, tracked(run, copy, place, preset, *SEED))


@EACH
def test_another_seed_gives_another_run(preset, first_run, sound, tmp_path, run):
    once = first_run(preset)
    other = tracked(run, sound, tmp_path / "run.npz", preset, "--seed", "3")
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
def test_the_number_of_threads_changes_nothing(preset, sound, tmp_path):
    alone = tracked_with_threads(sound, tmp_path / "1.npz", preset, 1)
    many = tracked_with_threads(sound, tmp_path / "5.npz", preset, 5)
    assert alone.tracked.any()
    assert_same(alone, many, tolerance=1e-9)

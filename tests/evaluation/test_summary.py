"""Pooled errors, also against figures that were computed independently."""

import csv
import importlib.util
from pathlib import Path

import numpy as np
import pytest

from stereotrack_core.evaluation.errors import errors_against
from stereotrack_core.evaluation.summary import summarise, summarise_segments
from stereotrack_core.recording.description import Segment
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory

SCORE = Path(__file__).resolve().parents[3] / "shared" / "tools" / "score.py"


@pytest.fixture(scope="module")
def score():
    if not SCORE.is_file():
        pytest.skip("score.py is not beside this checkout")
    spec = importlib.util.spec_from_file_location("score", SCORE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.score


def random_trajectory(random, frames):
    """Landmarks with whole frames, landmarks and single coordinates missing."""
    points = random.normal(0.0, 0.5, (len(frames), 9, 3))
    points[random.random(points.shape[:2]) < 0.08] = np.nan
    points[random.random(points.shape) < 0.01] = np.nan
    points[random.random(len(frames)) < 0.08] = np.nan
    return LandmarkTrajectory(np.asarray(frames), points)


def write_csv(path, trajectory):
    with path.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(["frame", "landmark", "x", "y", "z"])
        for frame, points in zip(trajectory.frame, trajectory.points, strict=True):
            for name, point in zip(LANDMARKS, points, strict=True):
                rows.writerow([frame, name, *(repr(float(v)) for v in point)])


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.filterwarnings("ignore::ResourceWarning")  # score.py leaves its files open
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_same_figures_as_the_independent_score(score, tmp_path, seed):
    random = np.random.default_rng(seed)
    reference = random_trajectory(random, np.arange(3, 90))
    # the independent score adds 1e-12 to a denominator, so equal points are 5e-4 deg apart there
    noise = random.normal(0.0, 0.02 * (seed + 1), reference.points.shape)
    noisy = LandmarkTrajectory(reference.frame[::2], (reference.points + noise)[::2])
    stranger = random_trajectory(random, np.sort(random.permutation(120)[:70]))
    for run in (noisy, stranger):
        write_csv(tmp_path / "run.csv", run)
        write_csv(tmp_path / "reference.csv", reference)
        for frames in (None, (10, 40)):
            theirs, details = score(tmp_path / "run.csv", tmp_path / "reference.csv", frames)
            errors = errors_against(run, reference)
            ours = summarise(errors if frames is None else errors.between(*frames))
            compare(ours, theirs, details)


def compare(ours, theirs, details):
    def figure(name, what="mean"):
        return getattr(ours.measure(name).statistics, what)

    pairs = [
        (figure("torso_position"), theirs["pos_mm"]),
        (figure("torso_long"), theirs["long"]),
        (figure("torso_cross"), theirs["cross"]),
        (figure("upper_arms"), theirs["ua"]),
        (figure("forearms"), theirs["fa"]),
        (figure("upper_arms", "median"), theirs["ua_med"]),
        (figure("forearms", "median"), theirs["fa_med"]),
        (figure("upper_arms", "p95"), theirs["ua_p95"]),
        (figure("forearms", "p95"), theirs["fa_p95"]),
        (100 * ours.lost, theirs["lost"]),
        (figure("left_upper_arm"), details["left_ua"].mean()),
        (figure("right_forearm", "p95"), np.percentile(details["right_fa"], 95)),
    ]
    np.testing.assert_allclose(*zip(*pairs, strict=True), rtol=0, atol=1e-6)
    assert ours.measure("torso_position").statistics.count == theirs["frames"]


def test_segments_and_empty_stretches():
    random = np.random.default_rng(0)
    reference = LandmarkTrajectory(np.arange(20), random.normal(0.0, 0.5, (20, 9, 3)))
    run = LandmarkTrajectory(np.arange(10), reference.points[:10])
    segments = [Segment("good", 0, 10), Segment("lost", 10, 20), Segment("outside", 50, 60)]
    good, lost, outside = summarise_segments(errors_against(run, reference), segments)
    assert good.lost == 0.0
    assert good.not_tracked == 0
    assert good.measure("forearms").statistics.p95 == pytest.approx(0.0, abs=1e-6)
    assert lost.lost == 1.0
    assert lost.not_tracked == 10
    assert lost.measure("torso_position").statistics.mean == pytest.approx(500.0)
    assert outside.frames == 0
    assert np.isnan(outside.lost)
    assert np.isnan(outside.measure("upper_arms").statistics.mean)
    with pytest.raises(KeyError):
        good.measure("tail")
